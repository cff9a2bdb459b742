# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials with reflection models for tests, and the kernels' functions over them.

What is demanded of the models stands in test_models.py, test_models_sampling.py and test_models_failures.py.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import cotorra_native
import numpy as np
from cotorra.export.buffers import F32, U32, MaterialModels
from numpy.typing import NDArray

PRINCIPLED, LAMBERT, OREN_NAYAR, PHONG, BLINN_PHONG, COOK_TORRANCE, TOON = range(7)
GGX, BECKMANN, BLINN = range(3)
SMITH_CORRELATED, SMITH, CAVITY, SCHLICK_GGX = range(4)
SCHLICK, DIELECTRIC, CONDUCTOR, F82 = range(4)
COLOR, METALLIC, IOR = range(3)
ENERGY, MIX = range(2)
DIFFUSE, SPECULAR, SINGULAR, SHARP = 1, 2, 4, 8

Z = np.array([[0.0, 0.0, 1.0]], np.float32)
_MODEL: dict[str, object] = {
    'toon_steps': 2,
    'kd': 1 / np.pi,
    'ks': 0.5,
    'shininess': 32.0,
    'oren_nayar_sigma': 0.5,
    'specular_color': 1.0,
    'f0': 0.04,
    'f82_tint': 1.0,
    'conductor_n': 0.2,
    'conductor_k': 3.0,
    'toon_lit': 0.8,
    'toon_shade': 0.2,
}
_MATERIAL: dict[str, object] = {
    'base_color': 0.8,
    'roughness': 0.5,
    'ior': 1.5,
    'specular_level': 0.5,
    'specular_tint': 1.0,
    'multi_ggx': 1,
}
_COLORS = {'base_color', 'specular_tint', 'specular_color', 'f0', 'f82_tint', 'conductor_n', 'conductor_k'}
_COLORS |= {'toon_lit', 'toon_shade', 'absorption'}


@dataclass(frozen=True, slots=True)
class Materials:
    """Constants of Principled materials and their models, as the native module's laboratory takes them."""

    base_color: F32
    metallic: F32
    roughness: F32
    ior: F32
    specular_level: F32
    specular_tint: F32
    multi_ggx: U32
    models: MaterialModels


def _arrays(record: type, defaults: dict[str, object], count: int, values: dict[str, object]) -> dict[str, np.ndarray]:
    result = {}
    for f in fields(record):
        if f.name == 'models':
            continue
        kind = np.uint32 if f.type == 'U32' else np.float32
        value = np.asarray(values.get(f.name, defaults.get(f.name, 0)), kind)
        if f.name in _COLORS and value.ndim == 1 and len(value) == count:
            value = value[:, None]
        shape = (count, 3) if f.name in _COLORS else (count,)
        result[f.name] = np.ascontiguousarray(np.broadcast_to(value, shape))
    return result


def materials(count: int = 1, **values: object) -> Materials:
    """Materials with the add-on's defaults where nothing else is said; a value is one for all, or one for each."""
    models = MaterialModels(**_arrays(MaterialModels, _MODEL, count, values))
    return Materials(**_arrays(Materials, _MATERIAL, count, values), models=models)


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def viewer(mu: float | np.ndarray) -> NDArray[np.float32]:
    """Directions at cosine mu to z, in the plane of x."""
    mu = np.atleast_1d(np.asarray(mu, float))
    return np.stack([np.sqrt(np.maximum(1 - mu * mu, 0)), 0 * mu, mu], -1).astype(np.float32)


def lattice(count: int) -> NDArray[np.float32]:
    """Points of the unit cube, more evenly spread than random ones: rank-1 with the plastic number's cubic cousin."""
    phi = 1.2207440846057596
    return (
        ((0.5 + np.arange(count)[:, None] * phi ** -np.arange(1.0, 4.0)) % 1.0).astype(np.float32).clip(0, 1 - 2**-24)
    )


def evaluate(m: Materials, wo: np.ndarray, wi: np.ndarray, n: np.ndarray = Z) -> tuple[np.ndarray, ...]:
    """f cos of the diffuse lobe and of the highlight, and the pdf."""
    return cotorra_native.evaluate_model(m, *(np.ascontiguousarray(v, np.float32) for v in (n, wo, wi)))


def sample(m: Materials, wo: np.ndarray, u: np.ndarray, n: np.ndarray = Z) -> tuple[np.ndarray, ...]:
    """wi, weight, pdf and lobe."""
    return cotorra_native.sample_model(m, *(np.ascontiguousarray(v, np.float32) for v in (n, wo, u)))


def terms(m: Materials, wo: np.ndarray, wi: np.ndarray, n: np.ndarray = Z) -> tuple[np.ndarray, ...]:
    """D, G and F."""
    return cotorra_native.model_terms(m, *(np.ascontiguousarray(v, np.float32) for v in (n, wo, wi)))


def albedo(m: Materials, mu: float, count: int = 1 << 15) -> float:
    """Share of uniform light that goes to a viewer at cosine mu, the first channel."""
    _, weight, pdf, _ = sample(m, viewer(mu), lattice(count))
    return float((weight[:, 0] * (pdf > 0)).mean(dtype=float))
