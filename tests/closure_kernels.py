# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of kernels/closure as NumPy functions, compiled from the kernels themselves.

What is demanded of them stands in test_closures.py and test_closures_cycles.py.
"""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass

import numpy as np

import bsdf_kernels as bsdf
import kernel_source as kernels
from native_build import build

GGX, MULTI_GGX, BECKMANN, ASHIKHMIN_SHIRLEY = range(4)
METALLIC, CONDUCTOR = 100, 101
SINGULAR, TRANSMIT = 4, 16

CASE = np.dtype(
    [
        ('kind', 'u4'),
        ('distribution', 'u4'),
        ('color', 'f4', 3),
        ('edge', 'f4', 3),
        *((name, 'f4') for name in ('roughness', 'ior', 'anisotropy', 'rotation', 'film', 'film_ior', 'size')),
        ('smooth_rim', 'f4'),
        ('inside', 'u4'),
        ('tangent', 'f4', 3),
    ]
)


def kind(name: str) -> int:
    return {'METALLIC': METALLIC, 'CONDUCTOR': CONDUCTOR}.get(name) or kernels.constants()[f'LOBE_{name}']


def cases(name: str, count: int = 1, **values: object) -> np.ndarray:
    """Closures of one kind with Blender's defaults where nothing else is said."""
    defaults: dict[str, object] = {
        'color': 0.8,
        'edge': 0.7,
        'roughness': 0.5,
        'ior': 1.5,
        'film_ior': 1.33,
        'size': 0.5,
        'tangent': (1, 0, 0),
    }
    result = np.zeros(count, CASE)
    result['kind'] = kind(name)
    for field, value in {**defaults, **values}.items():
        result[field] = value
    return result


def inputs(count: int = 1, **values: object) -> np.ndarray:
    """Inputs of Principled with Blender's defaults where nothing else is said."""
    defaults: dict[str, object] = {
        'base_color': 0.8,
        'specular_tint': 1.0,
        'roughness': 0.5,
        'tangent': (1, 0, 0),
        'ior': 1.5,
        'specular_level': 0.5,
        'coat_tint': 1.0,
        'coat_roughness': 0.03,
        'coat_ior': 1.5,
        'sheen_tint': 1.0,
        'sheen_roughness': 0.5,
        'film_ior': 1.33,
        'multiscatter': 1,
    }
    result = np.zeros(count, kernels.dtype_of('PrincipledInputs'))
    for field, value in {**defaults, **values}.items():
        result[field] = value
    return result


@functools.cache
def library() -> ctypes.CDLL:
    return build('lobe_test', ['tests/native/lobe_test.cpp'])


def _pointers(*arrays: np.ndarray) -> list[ctypes.c_void_p]:
    return [ctypes.c_void_p(array.ctypes.data) for array in arrays]


def _sizes(*numbers: int) -> list[ctypes.c_size_t]:
    return [ctypes.c_size_t(number) for number in numbers]


@dataclass
class Lobes:
    """Closures seen from one direction each, at normals on the viewer's side."""

    case: np.ndarray
    n: np.ndarray
    wo: np.ndarray

    def __post_init__(self) -> None:
        count = len(self.case)
        self.n, self.wo = bsdf.vectors(self.n, count), bsdf.vectors(self.wo, count)
        self.lobe = np.zeros(count, kernels.dtype_of('Lobe'))
        library().test_lobes(
            *_pointers(bsdf.tables()), *_sizes(count), *_pointers(self.case, self.n, self.wo, self.lobe)
        )

    def evaluate(self, wi: object, count: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """f cos, and the density with which it is sampled."""
        count = count or max(len(self.lobe), np.size(wi) // 3)
        wi = bsdf.vectors(wi, count)
        f, pdf = np.empty((count, 3), 'f4'), np.empty(count, 'f4')
        library().test_lobe_eval(
            *_pointers(bsdf.tables()),
            *_sizes(len(self.lobe), count),
            *_pointers(self.lobe, self.wo, wi, f, pdf),
        )
        return f, pdf

    def sample(self, u: np.ndarray) -> np.ndarray:
        u = np.ascontiguousarray(u, np.float32)
        samples = np.empty(len(u), kernels.dtype_of('BsdfSample'))
        library().test_lobe_sample(
            *_pointers(bsdf.tables()),
            *_sizes(len(self.lobe), len(u)),
            *_pointers(self.lobe, self.wo, u, samples),
        )
        return samples

    def albedo(self) -> np.ndarray:
        albedo = np.empty((len(self.lobe), 3), 'f4')
        library().test_lobe_albedo(
            *_pointers(bsdf.tables()), *_sizes(len(self.lobe)), *_pointers(self.lobe, self.wo, albedo)
        )
        return albedo


@dataclass
class Principled:
    """Principled surfaces seen from one direction each."""

    inputs: np.ndarray
    n: np.ndarray
    wo: np.ndarray

    def __post_init__(self) -> None:
        count = len(self.inputs)
        self.n, self.wo = bsdf.vectors(self.n, count), bsdf.vectors(self.wo, count)
        self.inputs = self.inputs.copy()
        self.inputs['n'] = self.inputs['coat_n'] = self.n

    def draw(self, u: np.ndarray, wi: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """By (count, 4) random numbers: f cos toward wi and pdf of what is picked, a sample of it, and what it is."""
        u, wi = np.ascontiguousarray(u, np.float32), bsdf.vectors(wi, len(u))
        f, pdf, picked = np.empty((len(u), 3), 'f4'), np.empty(len(u), 'f4'), np.empty(len(u), 'u4')
        samples = np.empty(len(u), kernels.dtype_of('BsdfSample'))
        library().test_principled(
            *_pointers(bsdf.tables()),
            *_sizes(len(self.inputs), len(u)),
            *_pointers(self.inputs, self.n, self.wo, u, wi, f, pdf, samples, picked),
        )
        return f, pdf, samples, picked

    def sums(self) -> tuple[np.ndarray, np.ndarray]:
        """What is emitted, and the albedo."""
        emission, albedo = np.empty((2, len(self.inputs), 3), 'f4')
        library().test_principled_sums(
            *_pointers(bsdf.tables()),
            *_sizes(len(self.inputs)),
            *_pointers(self.inputs, self.n, self.wo, emission, albedo),
        )
        return emission, albedo
