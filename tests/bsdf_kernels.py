# SPDX-License-Identifier: GPL-3.0-or-later
"""The BSDF kernels as NumPy functions: compiled from kernels/bsdf.h, with albedo tables made by the project's own tool.

What is demanded of them stands in test_bsdf.py and test_bsdf_cycles.py.
"""

from __future__ import annotations

import ctypes
import functools
import re
import subprocess
from dataclasses import dataclass

import numpy as np

import kernel_source as kernels
from native_build import BUILD, build, build_program

DIFFUSE, GLOSSY, SINGULAR = 1, 2, 4
SPECULAR_FLAG, DIFFUSE_FLAG, MULTI_GGX_FLAG = 2, 4, 16


def materials(count: int = 1, **values: object) -> np.ndarray:
    """Materials with Blender's defaults where nothing else is said."""
    defaults: dict[str, object] = {
        'base_color': 0.8,
        'metallic': 0.0,
        'specular_tint': 1.0,
        'roughness': 0.5,
        'ior': 1.5,
        'specular_level': 0.5,
        'alpha': 1.0,
        'flags': SPECULAR_FLAG | DIFFUSE_FLAG | MULTI_GGX_FLAG,
    }
    result = np.zeros(count, kernels.dtype_of('Material'))
    for name, value in {**defaults, **values}.items():
        result[name] = value
    return result


@functools.cache
def tables() -> np.ndarray:
    """The albedo tables, as the build makes them."""
    header = BUILD / 'albedo_tables.h'
    subprocess.run([build_program('make_albedo_tables', ['native/tools/make_albedo_tables.cpp']), header], check=True)
    values = np.array(re.findall(r'^(\S+)f,$', header.read_text(), re.MULTILINE), np.float32)
    assert len(values) == kernels.constants()['TABLE_SIZE']
    return values


@functools.cache
def library() -> ctypes.CDLL:
    return build('bsdf_test', ['tests/native/bsdf_test.cpp'])


class _Inputs(ctypes.Structure):
    _fields_ = (
        ('tables', ctypes.c_void_p),
        ('count', ctypes.c_size_t),
        ('materials', ctypes.c_size_t),
        ('material', ctypes.c_void_p),
        ('n', ctypes.c_void_p),
        ('wo', ctypes.c_void_p),
    )


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def vectors(a: object, count: int) -> np.ndarray:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(a, np.float32), (count, 3)))


@dataclass
class Lobes:
    """Materials seen from one direction each; every call takes as many directions or random numbers as it likes."""

    material: np.ndarray
    n: np.ndarray
    wo: np.ndarray

    def __post_init__(self) -> None:
        self.material = np.ascontiguousarray(self.material)
        self.n = vectors(self.n, len(self.material))
        self.wo = vectors(self.wo, len(self.material))

    def _inputs(self, count: int) -> ctypes.c_void_p:
        self._kept = _Inputs(
            tables().ctypes.data,
            count,
            len(self.material),
            self.material.ctypes.data,
            self.n.ctypes.data,
            self.wo.ctypes.data,
        )
        return ctypes.byref(self._kept)  # type: ignore[return-value]

    def evaluate(self, wi: object, count: int | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """f cos of the diffuse and of the glossy lobe, and the pdf."""
        count = count or max(len(self.material), np.size(wi) // 3)
        wi = vectors(wi, count)
        diffuse, glossy, pdf = np.empty((count, 3), 'f4'), np.empty((count, 3), 'f4'), np.empty(count, 'f4')
        library().test_eval(self._inputs(count), _pointer(wi), _pointer(diffuse), _pointer(glossy), _pointer(pdf))
        return diffuse, glossy, pdf

    def sample(self, u: np.ndarray) -> np.ndarray:
        u = np.ascontiguousarray(u, np.float32)
        samples = np.empty(len(u), kernels.dtype_of('BsdfSample'))
        library().test_sample(self._inputs(len(u)), _pointer(u), _pointer(samples))
        return samples

    def albedo(self) -> tuple[np.ndarray, np.ndarray]:
        """What the lobes reflect of uniform light, diffuse and glossy, as passes show it."""
        diffuse, glossy = np.empty((2, len(self.material), 3), 'f4')
        library().test_albedo(self._inputs(len(self.material)), _pointer(diffuse), _pointer(glossy))
        return diffuse, glossy


def lanes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(3, n): exp(-x), log(x) and the angle of (x - 1, y) as loops over lanes compute them; x above 0, float32."""
    result = np.zeros((3, len(x)), np.float32)
    library().test_lanes(_pointer(x), _pointer(y), ctypes.c_size_t(len(x)), *(_pointer(row) for row in result))
    return result


def flags(material: np.ndarray) -> np.ndarray:
    """MATERIAL_SPECULAR and MATERIAL_DIFFUSE as the kernel derives them."""
    result = np.empty(len(material), np.uint32)
    library().test_flags(_pointer(material), ctypes.c_size_t(len(material)), _pointer(result))
    return result
