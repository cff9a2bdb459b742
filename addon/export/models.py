# SPDX-License-Identifier: GPL-3.0-or-later
"""`material.cotorra`, or the scene's override of it, to arrays: by which model each material reflects.

What the material's nodes say is told in addon/shader/; the formulas are the kernels'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import bpy
import numpy as np

from .. import choices
from ..log import Log
from ..material_settings import CotorraMaterialSettings
from .buffers import MaterialModels

# Lists that the numbers of an enumeration count.
LISTS = {
    'model': choices.MODELS,
    'distribution': choices.DISTRIBUTIONS,
    'masking': choices.MASKINGS,
    'fresnel': choices.FRESNELS,
    'f0_mode': choices.F0_MODES,
    'split': choices.SPLITS,
    'oren_nayar_form': choices.OREN_NAYAR_FORMS,
}
WHOLE = {*LISTS, 'normalized', 'toon_steps'}
NAMES = tuple(field.name for field in fields(MaterialModels))

# Integrators that read parameters of materials whose model is Principled, too.
READERS = {'WHITTED', 'TOON'}

# Beyond it, squares and products leave the range of single precision; no published value comes near.
LARGEST = 1e6


def model_arrays(
    materials: Sequence[bpy.types.Material | None], scene: bpy.types.Scene, log: Log
) -> MaterialModels | None:
    """The models of the materials, in their order; None stands for a material that an object lacks.

    None where all are Principled and the scene's integrator asks for nothing else.
    """
    own = scene.cotorra
    override = own.model_override if own.use_model_override else None
    settings = [override or (material and material.cotorra) for material in materials]
    if own.integrator not in READERS and all(entry is None or entry.model == 'PRINCIPLED' for entry in settings):
        return None
    owners = [f'Material "{material.name}"' if material else '' for material in materials]
    if override is not None:
        owners = [f'Scene "{scene.name}", model override'] * len(materials)
    defaults = default_values()
    rows = [defaults if entry is None else values(entry) for entry in settings]
    return MaterialModels(**{name: _array(name, rows, defaults, owners, log) for name in NAMES})


def default_values() -> dict[str, object]:
    """What the properties of a new material hold."""
    properties = CotorraMaterialSettings.bl_rna.properties

    def default(name: str) -> object:
        found = properties[name]
        return tuple(found.default_array) if getattr(found, 'is_array', False) else found.default

    return {name: default(name) for name in NAMES}


def values(settings: bpy.types.PropertyGroup) -> dict[str, object]:
    def value(name: str) -> object:
        found = getattr(settings, name)
        return found if isinstance(found, (str, bool, int, float)) else tuple(found)

    return {name: value(name) for name in NAMES}


def _array(
    name: str, rows: list[dict[str, object]], defaults: dict[str, object], owners: list[str], log: Log
) -> np.ndarray:
    """One column. A driver can set a property to anything: what no formula can take is replaced, with a warning."""
    if name in LISTS:
        order = {identifier: index for index, (identifier, _, _) in enumerate(LISTS[name])}
        return np.array([order[row[name]] for row in rows], np.uint32)
    column = np.array([row[name] for row in rows], np.uint32 if name in WHOLE else np.float32)
    flat = column.reshape(len(rows), -1)
    finite = np.isfinite(flat).all(axis=1)
    for index in np.flatnonzero(~finite):
        log.warning(f'{owners[index]}: {name} is not a finite number; the default is used')
    flat[~finite] = defaults[name]
    beyond = ((flat > LARGEST) | (flat < 0)).any(axis=1)
    for index in np.flatnonzero(beyond):
        log.warning(f'{owners[index]}: {name} is not from 0 to {LARGEST:g}; the nearest of them is used')
    return np.clip(column, 0, LARGEST).astype(column.dtype)
