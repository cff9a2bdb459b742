# SPDX-License-Identifier: GPL-3.0-or-later
"""Which node each op that reads tables or images stands for: the table of test_ops_cycles.py, continued.

Tables are baked here as Cycles bakes them; the add-on's own baking is compared elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import bpy
import numpy as np
from cotorra.shader import ies

from ies_files import ROUND, STREET
from op_cases import COUNT, Case, Range, make_node

ENTRIES = 257
PLACES = np.arange(ENTRIES) / (ENTRIES - 1)
INTERPOLATIONS = ('Closest', 'Linear', 'Cubic')
EXTENSIONS = ('REPEAT', 'EXTEND', 'CLIP', 'MIRROR')
PROJECTIONS = ('FLAT', 'BOX', 'SPHERE', 'TUBE')


@dataclass(frozen=True)
class TableCase:
    """A case whose op reads the table that `bake` makes of the node, or the image."""

    case: Case
    bake: Callable[[Any], np.ndarray] | None = None


@cache
def image() -> np.ndarray:
    """Colours and alpha of 9 x 7 texels, bottom row first; some texels are clear, some opaque."""
    rng = np.random.default_rng(21)
    texels = rng.random((7, 9, 4), np.float32)
    texels[..., 3] = rng.choice(np.array([0.25, 0.5, 1.0, 1.0], np.float32), (7, 9))
    return texels


def _set_image(node: Any) -> None:
    height, width, _ = image().shape
    made = bpy.data.images.new('texels', width, height, alpha=True, float_buffer=True)
    made.colorspace_settings.name = 'Non-Color'
    made.alpha_mode = 'CHANNEL_PACKED'
    made.pixels.foreach_set(image().ravel())
    node.image = made


def _set_ramp(node: Any) -> None:
    elements = node.color_ramp.elements
    elements[0].color, elements[1].position = (0.1, 0.9, 0.3, 0.2), 0.8
    elements.new(0.35).color = (0.7, -0.2, 2.0, 0.6)


def _set_curves(node: Any) -> None:
    mapping = node.mapping
    for place, curve in enumerate(mapping.curves):
        curve.points.new(0.4 + 0.1 * place, 0.7 - 0.15 * place)
    mapping.update()


def _bake_ramp(node: Any) -> np.ndarray:
    return np.array([node.color_ramp.evaluate(x) for x in PLACES])


def _bake_curves(node: Any) -> np.ndarray:
    mapping = node.mapping
    mapping.initialize()
    low, high = curve_bounds(mapping)
    curves = list(mapping.curves)
    if len(curves) == 4:  # of RGB curves the last one is applied to all channels first
        inner = [mapping.evaluate(curves[3], low + x * (high - low)) for x in PLACES]
        return np.array([[mapping.evaluate(curve, x) for curve in curves[:3]] for x in inner])
    return np.array([[mapping.evaluate(curve, low + x * (high - low)) for curve in curves] for x in PLACES])


def curve_bounds(mapping: Any) -> tuple[float, float]:
    """From the leftmost to the rightmost point of all curves."""
    places = [point.location[0] for curve in mapping.curves for point in curve.points]
    return min(places), max(places)


def _ramps() -> list[TableCase]:
    cases = []
    for op, output in (('ramp_v', 'Color'), ('ramp_alpha', 'Alpha')):
        for mode, interpolation in ((0, 'LINEAR'), (0, 'EASE'), (1, 'CONSTANT')):

            def prepare(node: Any, interpolation: str = interpolation) -> None:
                _set_ramp(node)
                node.color_ramp.interpolation = interpolation

            node = replace(make_node(op, 'ShaderNodeValToRGB', 'Fac||', output), prepare=prepare)
            case = Case(op, mode, node, {0: (-0.3, 1.3), 1: (0,), 2: (ENTRIES,)}, label=interpolation)
            cases.append(TableCase(case, _bake_ramp))
    return cases


def _curves() -> list[TableCase]:
    cases = []
    for op, kind, sockets, output, low in (
        ('curve_f', 'ShaderNodeFloatCurve', 'Value||||Factor', 'Value', 0.0),
        ('rgb_curve_v', 'ShaderNodeRGBCurve', 'Color||||Fac', 'Color', 0.0),
        ('vector_curve_v', 'ShaderNodeVectorCurve', 'Vector||||Fac', 'Vector', -1.0),
    ):
        for mode, extend in enumerate(('HORIZONTAL', 'EXTRAPOLATED')):

            def prepare(node: Any, extend: str = extend) -> None:
                node.mapping.extend = extend
                _set_curves(node)

            node = replace(make_node(op, kind, sockets, output), prepare=prepare)
            ranges: dict[int, Range] = {0: (-1.6, 1.6), 1: (0,), 2: (low,), 3: (1.0,), 4: (-0.2, 1.2)}
            cases.append(TableCase(Case(op, mode, node, ranges), _bake_curves))
    return cases


def _images() -> list[TableCase]:
    cases = []
    for p, projection in enumerate(PROJECTIONS):
        for i, interpolation in enumerate(INTERPOLATIONS):
            extension = EXTENSIONS[(p + i) % 4]
            for op, output in (('image_v', 'Color'), ('image_f', 'Alpha')):
                values = {'projection': projection, 'interpolation': interpolation, 'extension': extension}
                blend = (0.0, 0.3, 1.0)[i]
                node = make_node(op, 'ShaderNodeTexImage', 'Vector|||', output, projection_blend=blend, **values)
                node = replace(node, prepare=_set_image)
                mode = i | EXTENSIONS.index(extension) << 2 | p << 4
                ranges: dict[int, Range] = {0: (-0.7, 1.7), 1: (0,), 2: (blend,), 3: facing}
                cases.append(TableCase(Case(op, mode, node, ranges, 0.02)))
    for p, projection in enumerate(('EQUIRECTANGULAR', 'MIRROR_BALL')):
        node = make_node('environment_v', 'ShaderNodeTexEnvironment', 'Vector|', 'Color', projection=projection)
        cases.append(TableCase(Case('environment_v', 1 | p << 4, replace(node, prepare=_set_image), {1: (0,)})))
    return cases


def _luminaire(text: str, label: str) -> TableCase:
    def load(node: Any) -> None:
        node.mode, node.ies = 'INTERNAL', bpy.data.texts.new('Luminaire')
        node.ies.write(text)

    found = ies.read(text)
    node = replace(make_node('ies_f', 'ShaderNodeTexIES', 'Vector|||', 'Fac'), prepare=load)
    ranges: dict[int, Range] = {0: (-1.0, 1.0), 1: (0,), 2: (found.horizontal,), 3: (found.vertical,)}
    return TableCase(Case('ies_f', 0, node, ranges, label=label), lambda _: found.table)


def _luminaires() -> list[TableCase]:
    return [_luminaire(STREET, 'half a turn'), _luminaire(ROUND, 'a full turn')]


def facing(rng: np.random.Generator, size: int) -> np.ndarray:
    """Unit vectors toward the viewer."""
    normals = rng.normal(size=(size // 3, 3))
    normals[:, 2] = np.abs(normals[:, 2]) + 0.1
    return (normals / np.linalg.norm(normals, axis=1, keepdims=True)).ravel()


def baked(entry: TableCase) -> np.ndarray | None:
    """The table of a case, of a node as it was rendered."""
    if entry.bake is None:
        return None
    made = bpy.data.materials.new('bake').node_tree.nodes.new(entry.case.node.type)
    assert entry.case.node.prepare is not None
    entry.case.node.prepare(made)
    return entry.bake(made)


def every_case() -> list[TableCase]:
    return [*_ramps(), *_curves(), *_luminaires(), *_images()]


def normals_of(case: Case, inputs: np.ndarray) -> np.ndarray:
    """Normals of the facets of a case, as its inputs say, or toward the viewer."""
    if case.op in ('image_v', 'image_f'):
        return inputs[:, 5:8].astype(np.float64)
    return np.tile((0.0, 0.0, 1.0), (COUNT, 1))
