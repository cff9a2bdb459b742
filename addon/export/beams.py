# SPDX-License-Identifier: GPL-3.0-or-later
"""`light.cotorra` to arrays: how lamps fall off with distance and end at the edge of their cone.

Strength, size and place of a lamp are lights.py's; the formulas are kernels/light/light_shape.h's.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from .. import choices
from ..log import Log
from . import bounds

FALLOFFS = {identifier: index for index, (identifier, _, _) in enumerate(choices.FALLOFFS)}
EDGES = {identifier: index for index, (identifier, _, _) in enumerate(choices.SPOT_EDGES)}

# Settings that leave no light where they are 0, and the words for it.
NOTHING_AT_0 = {
    'range': 'the range of its falloff is',
    'polynomial': 'c0, c1 and c2 of its falloff are',
    'outer_angle': 'its outer angle is',
}


@dataclass(frozen=True, slots=True)
class Beam:
    """One entry of the arrays in Lights that tell of falloff and edge; the default is Blender's way."""

    falloff: int = 0
    range: float = 0.0
    polynomial: tuple[float, float, float] = (0.0, 0.0, 1.0)
    spot_edge: int = 0
    inner_angle: float = 0.0
    outer_angle: float = 0.0


BLENDERS_OWN = Beam()


def read_beam(light: bpy.types.Light, name: str, log: Log) -> Beam | None:
    """How the lamp falls off and ends; None, with a warning, where that leaves nothing of its light."""
    own = light.cotorra
    falloff = own.falloff if light.type in {'POINT', 'SPOT'} else 'PHYSICAL'
    edge = own.spot_edge if light.type == 'SPOT' else 'BLENDER'
    # What it does not use may be anything.
    used = {'falloff': FALLOFFS[falloff], 'spot_edge': EDGES[edge]}
    if falloff == 'RANGED':
        used['range'] = own.range
    elif falloff == 'POLYNOMIAL':
        used['polynomial'] = (own.c0, own.c1, own.c2)
    if edge != 'BLENDER':
        used |= {'inner_angle': min(own.inner_angle, own.outer_angle), 'outer_angle': own.outer_angle}
        if own.inner_angle > own.outer_angle:
            log.warning(f'Light "{name}": its inner angle is beyond the outer one: the outer one is used for both')
    for field, value in list(used.items()):
        words = field.replace('_', ' ')
        if not np.isfinite(value).all():
            log.warning(f'Light "{name}": {words} is not a finite number: Blender\'s falloff and edge are used')
            return BLENDERS_OWN
        if np.max(value) > bounds.LARGEST:
            log.warning(f'Light "{name}": {words} is beyond what can be rendered; {bounds.LARGEST:g} is used')
            used[field] = value = (
                tuple(np.minimum(value, bounds.LARGEST)) if isinstance(value, tuple) else bounds.LARGEST
            )
        if field in NOTHING_AT_0 and not np.any(value):
            log.warning(f'Light "{name}": {NOTHING_AT_0[field]} 0: it lights nothing')
            return None
    return Beam(**used)


def beam_arrays(beams: list[Beam]) -> dict[str, np.ndarray]:
    """The arrays of Lights that tell of beams; none where all are Blender's own."""
    if all(beam == BLENDERS_OWN for beam in beams):
        return {}
    columns = {
        'falloff': ([beam.falloff for beam in beams], np.uint32),
        'range': ([beam.range for beam in beams], np.float32),
        'polynomial': ([beam.polynomial for beam in beams], np.float32),
        'spot_edge': ([beam.spot_edge for beam in beams], np.uint32),
        'inner_angle': ([beam.inner_angle for beam in beams], np.float32),
        'outer_angle': ([beam.outer_angle for beam in beams], np.float32),
    }
    return {name: np.array(values, dtype) for name, (values, dtype) in columns.items()}
