# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels' reflection models at chosen directions, by names and values as a user knows them.

Computes nothing itself: cotorra_native does. The surface's normal is +z.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import cotorra_native
import numpy as np
from cotorra import choices
from cotorra.export.buffers import MaterialModels
from numpy.typing import NDArray

F64 = NDArray[np.float64]

# What material.cotorra and the Principled node hold where a chart says nothing else.
DEFAULTS: dict[str, Any] = {
    'base_color': (0.8, 0.8, 0.8),
    'metallic': 0.0,
    'roughness': 0.5,
    'ior': 1.5,
    'model': 'PRINCIPLED',
    'normalized': False,
    'distribution': 'GGX',
    'masking': 'SMITH_CORRELATED',
    'fresnel': 'SCHLICK',
    'f0_mode': 'METALLIC',
    'split': 'ENERGY',
    'oren_nayar_form': 'QUALITATIVE',
    'oren_nayar_sigma': 0.5,
    'toon_steps': 2,
    'kd': 1.0 / math.pi,
    'ks': 0.5,
    'shininess': 32.0,
    'ka': 1.0,
    'kr': 0.0,
    'kt': 0.0,
    'specular_color': (1.0, 1.0, 1.0),
    'f0': (0.04, 0.04, 0.04),
    'f82_tint': (1.0, 1.0, 1.0),
    'conductor_n': (0.064, 0.496, 1.46),
    'conductor_k': (3.6, 2.33, 1.818),
    'toon_lit': (0.8, 0.8, 0.8),
    'toon_shade': (0.2, 0.2, 0.2),
    'absorption': (0.0, 0.0, 0.0),
}
LISTS = {
    'model': choices.MODELS,
    'distribution': choices.DISTRIBUTIONS,
    'masking': choices.MASKINGS,
    'fresnel': choices.FRESNELS,
    'f0_mode': choices.F0_MODES,
    'split': choices.SPLITS,
    'oren_nayar_form': choices.OREN_NAYAR_FORMS,
}
PRINCIPLED = ('base_color', 'metallic', 'roughness', 'ior')
WHOLE = {*LISTS, 'normalized', 'toon_steps'}


def material(settings: dict[str, Any]) -> SimpleNamespace:
    """One material, with its model, as the native module's laboratory takes it."""
    values = DEFAULTS | settings
    if len(values) > len(DEFAULTS):
        raise KeyError(f'no such setting: {sorted(values.keys() - DEFAULTS.keys())}')

    def column(name: str) -> np.ndarray:
        value = values[name]
        if name in LISTS:
            value = [identifier for identifier, _, _ in LISTS[name]].index(value)
        return np.array([value], np.uint32 if name in WHOLE else np.float32)

    return SimpleNamespace(
        **{name: column(name) for name in PRINCIPLED},
        specular_level=np.full(1, 0.5, np.float32),
        specular_tint=np.ones((1, 3), np.float32),
        multi_ggx=np.ones(1, np.uint32),
        models=MaterialModels(**{name: column(name) for name in DEFAULTS if name not in PRINCIPLED}),
    )


def directions(vectors: F64) -> np.ndarray:
    """As the kernels take them: (N, 3) in single precision."""
    return np.ascontiguousarray(np.atleast_2d(vectors), np.float32)


def evaluate(settings: dict[str, Any], wo: F64, wi: F64) -> tuple[F64, F64]:
    """f cos of the diffuse and of the specular lobe, (N, 3), toward viewers wo and lights wi; wo may be one for all."""
    up = np.array([[0.0, 0.0, 1.0]], np.float32)
    diffuse, specular, _ = cotorra_native.evaluate_model(material(settings), up, directions(wo), directions(wi))
    return diffuse.astype(np.float64), specular.astype(np.float64)


def terms(settings: dict[str, Any], wo: F64, wi: F64) -> tuple[F64, F64, F64]:
    """D (N,), G (N,) and F (N, 3) of the highlight."""
    up = np.array([[0.0, 0.0, 1.0]], np.float32)
    found = cotorra_native.model_terms(material(settings), up, directions(wo), directions(wi))
    return tuple(term.astype(np.float64) for term in found)
