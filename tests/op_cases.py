# SPDX-License-Identifier: GPL-3.0-or-later
"""Which node each pure op stands for, in each of its modes, with inputs to try: the table of test_ops_cycles.py.

What a mode means is said in kernels/program/ops.inc.
"""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from cycles_ops import Node
from program_ops import ops

COUNT = 128  # inputs a case
Range = tuple[float, ...] | Callable[[np.random.Generator, int], np.ndarray]

DIMENSIONS = ('1D', '2D', '3D', '4D')
NOISE_TYPES = ('MULTIFRACTAL', 'RIDGED_MULTIFRACTAL', 'HYBRID_MULTIFRACTAL', 'FBM', 'HETERO_TERRAIN')


@dataclass(frozen=True)
class Case:
    """An op in one mode and the node that it stands for.

    ranges: from the argument's place to its bounds (drawn uniformly), to one value, or to how to draw it.
    steps:  the share of inputs that may fall on the other side of a step (a border of cells, a rounding up), or where
            a rounding that each compiler does its own way is enlarged.
    label:  tells cases of the same mode apart.
    fold:   what of the op's result the node's output is.
    """

    op: str
    mode: int
    node: Node
    ranges: dict[int, Range] = field(default_factory=dict)
    steps: float = 0.0
    fold: Callable[[np.ndarray], np.ndarray] = lambda result: result
    label: str = ''

    @property
    def name(self) -> str:
        return '-'.join(filter(None, (self.op, str(self.mode), '+'.join(self.node.outputs), self.label)))

    def draw(self) -> np.ndarray:
        """Arguments one after the other, (COUNT, k), of 22 binary digits each, which cycles_ops.render hands on."""
        rng = np.random.default_rng(zlib.crc32(self.name.encode()))
        columns = []
        for place, kind in enumerate(ops()[self.op].arguments):
            size = COUNT * (3 if kind == 'v' else 1)
            drawn = self._draw(self.ranges.get(place), rng, size)
            columns.append(np.asarray(drawn, np.float32).reshape(COUNT, -1))
        return (np.concatenate(columns, 1).view(np.uint32) & np.uint32(0xFFFFFFFC)).view(np.float32)

    def _draw(self, bounds: Range | None, rng: np.random.Generator, size: int) -> np.ndarray:
        if callable(bounds):
            return bounds(rng, size)
        if bounds is not None:
            return np.full(size, bounds[0]) if len(bounds) == 1 else rng.uniform(bounds[0], bounds[1], size)
        special = rng.choice([0, 1, -1, 0.5, 2, -3, 1e-3, 100.3, -57.7], size)
        return np.where(rng.random(size) < 0.25, special, rng.uniform(-2, 2, size))


def items(node: str, prop: str) -> list[tuple[str, int]]:
    """A property's enumeration with Blender's numbers."""
    return [(item.identifier, item.value) for item in getattr(bpy.types, node).bl_rna.properties[prop].enum_items]


def make_node(op: str, kind: str, sockets: str, output: str | Sequence[str], **properties: Any) -> Node:
    """The node of an op, its sockets by the op's arguments, divided by |."""
    names = tuple(sockets.split('|')) if sockets else ()
    outputs = (output,) if isinstance(output, str) else tuple(output)
    return Node(kind, ops()[op].arguments, names, outputs, properties)


def _math() -> list[Case]:
    cases = []
    for name, number in items('ShaderNodeMath', 'operation'):
        for clamped in (False, True) if number in (0, 10) else (False,):
            node = make_node('math', 'ShaderNodeMath', 'Value|Value_001|Value_002', 'Value', operation=name)
            node.properties['use_clamp'] = clamped
            # Of powers the base is drawn small, that their result stays near the others; sinh and its like grow, too.
            ranges: dict[int, Range] = {0: (-8.0, 8.0)} if number in (26, 29, 30) else {}
            if number == 10:
                ranges = {1: lambda rng, n: rng.choice([0, 1, 2, 3, -2, 0.5, -0.5, 2.4], n)}
            cases.append(Case('math', number | clamped << 16, node, ranges))
    for name, number in items('ShaderNodeVectorMath', 'operation'):
        scalar = name in ('DOT_PRODUCT', 'DISTANCE', 'LENGTH')
        op = 'vector_math_f' if scalar else 'vector_math_v'
        sockets = 'Vector|Vector_001|Vector_002|Scale'
        node = make_node(op, 'ShaderNodeVectorMath', sockets, 'Value' if scalar else 'Vector', operation=name)
        bounds: dict[int, Range] = {}
        if name == 'POWER':
            bounds = {1: lambda rng, n: rng.choice([0, 1, 2, 3, -2, 0.5, -0.5, 2.4], n)}
        cases.append(Case(op, number, node, bounds))
    return cases


def _numbers() -> list[Case]:
    cases = [
        Case('clamp_f', number, make_node('clamp_f', 'ShaderNodeClamp', 'Value|Min|Max', 'Result', clamp_type=name))
        for name, number in items('ShaderNodeClamp', 'clamp_type')
    ]
    float_sockets = 'Value|From Min|From Max|To Min|To Max|Steps'
    vector_sockets = 'Vector|From_Min_FLOAT3|From_Max_FLOAT3|To_Min_FLOAT3|To_Max_FLOAT3|Steps_FLOAT3'
    for (name, number), clamped in itertools.product(items('ShaderNodeMapRange', 'interpolation_type'), (False, True)):
        values = {'interpolation_type': name, 'clamp': clamped}
        for op, kind, sockets, output in (
            ('map_range_f', 'FLOAT', float_sockets, 'Result'),
            ('map_range_v', 'FLOAT_VECTOR', vector_sockets, 'Vector'),
        ):
            node = make_node(op, 'ShaderNodeMapRange', sockets, output, data_type=kind, **values)
            cases.append(Case(op, number | clamped << 8, node, {5: (0.0, 6.0)}))
    for clamped in (False, True):
        values = {'clamp_factor': clamped}
        floats = make_node('mix_f', 'ShaderNodeMix', 'Factor_Float|A_Float|B_Float', 'Result_Float', **values)
        vectors = 'Factor_Vector|A_Vector|B_Vector'
        mixed = {'data_type': 'VECTOR', 'factor_mode': 'NON_UNIFORM', **values}
        cases.append(Case('mix_f', int(clamped), floats))
        cases.append(
            Case('mix_v', int(clamped), make_node('mix_v', 'ShaderNodeMix', vectors, 'Result_Vector', **mixed))
        )
    cases.append(Case('luminance', 0, make_node('luminance', 'ShaderNodeRGBToBW', 'Color', 'Val')))
    return cases


def _mapping() -> list[Case]:
    sockets = 'Vector|Location|Rotation|Scale'
    cases = [
        Case('mapping', number, make_node('mapping', 'ShaderNodeMapping', sockets, 'Vector', vector_type=name))
        for name, number in items('ShaderNodeMapping', 'vector_type')
    ]
    for (name, number), inverted in itertools.product(items('ShaderNodeVectorRotate', 'rotation_type'), (False, True)):
        values = {'rotation_type': name, 'invert': inverted}
        node = make_node(
            'vector_rotate', 'ShaderNodeVectorRotate', 'Vector|Center|Axis|Angle|Rotation', 'Vector', **values
        )
        cases.append(Case('vector_rotate', number | inverted << 8, node))
    outputs = ('Segment ID', 'Segment Width', 'Segment Rotation')

    def sides(rng: np.random.Generator, n: int) -> np.ndarray:
        return np.where(rng.random(n) < 0.5, rng.integers(2, 9, n), rng.uniform(1.5, 9, n))

    def roundness(rng: np.random.Generator, n: int) -> np.ndarray:
        return rng.choice([0, 1, 0.3, 0.8, rng.random()], n)

    for normalized in (False, True):
        ranges = {0: (-2.0, 2.0), 1: sides, 2: roundness}
        values = {'normalize': normalized}
        node = make_node('radial_tiling_v', 'ShaderNodeRadialTiling', 'Vector|Sides|Roundness', 'Segment Coordinates')
        node.properties.update(values)
        cases.append(Case('radial_tiling_v', int(normalized), node, ranges))
        for place, output in enumerate(outputs):
            node = make_node('radial_tiling_f', 'ShaderNodeRadialTiling', 'Vector|Sides|Roundness', output, **values)
            cases.append(Case('radial_tiling_f', normalized | place << 1, node, ranges))
    return cases


def _colors() -> list[Case]:
    cases = []
    for name, number in items('ShaderNodeMix', 'blend_type'):
        for clamps in (0, 3) if number in (0, 10, 13) else (1,):
            values = {'data_type': 'RGBA', 'blend_type': name}
            values |= {'clamp_factor': bool(clamps & 1), 'clamp_result': bool(clamps & 2)}
            node = make_node('mix_color', 'ShaderNodeMix', 'Factor_Float|A_Color|B_Color', 'Result_Color', **values)
            cases.append(Case('mix_color', number | clamps << 8, node, {1: (-0.2, 1.5), 2: (-0.2, 1.5)}))
    for name, number in items('ShaderNodeCombineColor', 'mode'):
        node = make_node('combine_color', 'ShaderNodeCombineColor', 'Red|Green|Blue', 'Color', mode=name)
        cases.append(Case('combine_color', number, node))
        parts = ('Red', 'Green', 'Blue')
        node = make_node('separate_color', 'ShaderNodeSeparateColor', 'Color', parts, mode=name)
        cases.append(Case('separate_color', number, node))
    simple = {
        'hsv': ('ShaderNodeHueSaturation', 'Hue|Saturation|Value|Fac|Color'),
        'gamma': ('ShaderNodeGamma', 'Color|Gamma'),
        'bright_contrast': ('ShaderNodeBrightContrast', 'Color|Bright|Contrast'),
        'invert': ('ShaderNodeInvert', 'Color|Fac'),
        'blackbody': ('ShaderNodeBlackbody', 'Temperature'),
        'wavelength': ('ShaderNodeWavelength', 'Wavelength'),
    }
    ranges: dict[str, dict[int, Range]] = {
        'gamma': {0: (-0.5, 2.0)},
        'blackbody': {0: lambda rng, n: np.concatenate([np.geomspace(500, 20000, n - 4), [0, -5, 800, 12000]])},
        'wavelength': {0: (370.0, 790.0)},
    }
    for op, (kind, sockets) in simple.items():
        cases.append(Case(op, 0, make_node(op, kind, sockets, 'Color'), ranges.get(op, {})))
    return cases


def _noise() -> list[Case]:
    cases = []
    sockets = 'Vector|W|Scale|Detail|Roughness|Lacunarity|Offset|Gain|Distortion'

    def spread(rng: np.random.Generator, n: int) -> np.ndarray:
        return rng.uniform(-1, 1, n) * rng.choice([3, 100, 3e4], n, p=[0.9, 0.08, 0.02])

    def detail(rng: np.random.Generator, n: int) -> np.ndarray:
        octaves = np.where(rng.random(n) < 0.4, rng.integers(0, 6, n), rng.uniform(-1, 5, n))
        return np.where(rng.random(n) < 0.03, rng.uniform(5, 17, n), octaves)

    for (d, dimensions), (t, name) in itertools.product(enumerate(DIMENSIONS), enumerate(NOISE_TYPES)):
        for normalized, op in itertools.product((False, True) if name == 'FBM' else (False,), ('noise_f', 'noise_v')):
            values = {'noise_dimensions': dimensions, 'noise_type': name}
            used = sockets if dimensions in ('1D', '4D') else sockets.replace('|W|', '||')
            used = used.replace('Vector', '') if dimensions == '1D' else used
            node = make_node(op, 'ShaderNodeTexNoise', used, 'Fac' if op == 'noise_f' else 'Color', **values)
            node.properties['normalize'] = normalized
            ranges: dict[int, Range] = {
                0: spread, 1: spread, 2: (-3.0, 3.0), 3: detail, 4: (-0.1, 1.0), 5: (0.5, 3.0), 6: (-0.5, 1.5),
                7: (-0.5, 3.0), 8: lambda rng, n: rng.choice([0, 0, 0.5, 2.3], n),
            }  # fmt: skip
            # Cycles fuses products and sums; the last bit of a coordinate is as large as an octave's frequency.
            cases.append(Case(op, d | t << 2 | normalized << 5, node, ranges, 0.06))
    return cases


def _voronoi() -> list[Case]:
    cases = []
    sockets = 'Vector|W|Scale|Detail|Roughness|Lacunarity|Smoothness|Exponent|Randomness'
    features, metrics = items('ShaderNodeTexVoronoi', 'feature'), items('ShaderNodeTexVoronoi', 'distance')
    ranges: dict[int, Range] = {
        0: (-6.0, 6.0), 1: (-6.0, 6.0), 2: lambda rng, n: rng.choice([1, 5, 0, -2], n, p=[0.4, 0.4, 0.05, 0.15]),
        3: lambda rng, n: rng.choice([0, 0, 1, 0.5, 2.5], n), 4: lambda rng, n: rng.choice([0.5, 0, 1, 0.7], n),
        5: (1.5, 2.5), 6: lambda rng, n: rng.choice([0, 1, 0.3], n),
        7: lambda rng, n: rng.choice([0.5, 1, 2, 0.8, 4], n), 8: lambda rng, n: rng.choice([1, 1, 0, 0.6], n),
    }  # fmt: skip
    for (d, dimensions), (feature, f) in itertools.product(enumerate(DIMENSIONS), features):
        used = metrics if d and f < 3 else metrics[:1]
        for metric, m in used:
            if f == 3:
                outputs = [('voronoi_f', 0, 'Distance')]
            elif f == 4:
                outputs = [('voronoi_f', 2, 'Radius')]
            elif m:
                outputs = [('voronoi_f', 0, 'Distance')]
            else:
                outputs = [('voronoi_f', 0, 'Distance'), ('voronoi_v', 0, 'Color')]
                outputs += [('voronoi_v', 1, 'Position')] if d else []
                outputs += [('voronoi_f', 1, 'W')] if d in (0, 3) else []
            for (op, place, output), normalized in itertools.product(outputs, (False, True)):
                if normalized and (f == 4 or output in ('Position', 'W')):
                    continue
                names = sockets if d in (0, 3) else sockets.replace('|W|', '||')
                names = names.replace('Vector', '') if d == 0 else names
                names = names if f == 2 else names.replace('|Smoothness', '|')
                names = names if m == 3 else names.replace('|Exponent', '|')
                if f == 4:
                    names = names.replace('Detail|Roughness|Lacunarity', '||')
                values = {'voronoi_dimensions': dimensions, 'feature': feature, 'distance': metric}
                node = make_node(op, 'ShaderNodeTexVoronoi', names, output, normalize=normalized, **values)
                mode = d | f << 2 | m << 5 | place << 8 | normalized << 11
                cases.append(Case(op, mode, node, ranges, 0.03))
    return cases


def _patterns() -> list[Case]:
    cases = []
    for d, dimensions in enumerate(DIMENSIONS):
        names = ('|W', 'Vector|', 'Vector|', 'Vector|W')[d]
        for op, output in (('white_noise_f', 'Value'), ('white_noise_v', 'Color')):
            node = make_node(op, 'ShaderNodeTexWhiteNoise', names, output, noise_dimensions=dimensions)
            cases.append(Case(op, d, node))
    sockets = 'Vector|Scale|Distortion|Detail|Detail Scale|Detail Roughness|Phase Offset'
    ranges: dict[int, Range] = {0: (-3.0, 3.0), 1: (-3.0, 6.0), 3: (0.0, 6.0), 5: (0.0, 1.0)}
    for (name, p), t, direction in itertools.product(items('ShaderNodeTexWave', 'wave_profile'), (0, 1), range(4)):
        values = {'wave_type': ('BANDS', 'RINGS')[t], 'wave_profile': name}
        which = ('bands_direction', 'rings_direction')[t]
        values[which] = items('ShaderNodeTexWave', which)[direction][0]
        node = make_node('wave_f', 'ShaderNodeTexWave', sockets, 'Fac', **values)
        cases.append(Case('wave_f', t | direction << (3 if t else 1) | p << 5, node, ranges, 0.02))
    for depth in range(11):
        node = make_node('magic_v', 'ShaderNodeTexMagic', 'Vector|Scale|Distortion', 'Color', turbulence_depth=depth)
        cases.append(Case('magic_v', depth, node, {0: (-20.0, 20.0), 1: (-3.0, 9.0), 2: (-2.0, 2.0)}, 0.03))
    for name, number in items('ShaderNodeTexGradient', 'gradient_type'):
        node = make_node('gradient_f', 'ShaderNodeTexGradient', 'Vector', 'Fac', gradient_type=name)
        cases.append(Case('gradient_f', number, node))
    cases.append(Case('checker_f', 0, make_node('checker_f', 'ShaderNodeTexChecker', 'Vector|Scale', 'Fac')))
    return cases + _bricks() + _gabor()


def _black_and_white(node: Any) -> None:
    """Colours that show the tint alone: of a brick 0 to 1, of mortar 0."""
    for name, value in (('Color1', 0.0), ('Color2', 1.0), ('Mortar', 0.0)):
        node.inputs[name].default_value = (value, value, value, 1.0)


def _bricks() -> list[Case]:
    cases = []
    sockets = 'Vector|Scale|Mortar Size|Mortar Smooth|Bias|Brick Width|Row Height||'
    for offset, every, squash, squash_every in ((0.5, 2, 1.0, 2), (0.3, 3, 0.6, 2), (0.0, 1, 1.7, 4), (0.5, 1, 0.0, 2)):
        values = {'offset': offset, 'offset_frequency': every, 'squash': squash, 'squash_frequency': squash_every}
        ranges: dict[int, Range] = {
            0: (-2.0, 2.0), 1: (1.0, 6.0), 2: lambda rng, n: rng.choice([0, 0.02, 0.1], n),
            3: lambda rng, n: rng.choice([0, 0.3, 1], n), 4: (-0.5, 0.5), 5: (0.1, 1.0), 6: (0.1, 0.8),
            7: (offset,), 8: (squash,),
        }  # fmt: skip
        for output, fold in (('Fac', lambda r: r[:, 0]), ('Color', lambda r: r[:, 1] * (1 - r[:, 0]))):
            node = make_node('brick_f', 'ShaderNodeTexBrick', sockets, output, **values)
            node = Node(node.type, node.kinds, node.sockets, node.outputs, node.properties, _black_and_white)
            cases.append(Case('brick_f', every | squash_every << 8, node, ranges, 0.01, fold))
    return cases


def _gabor() -> list[Case]:
    cases = []
    for (name, kind), (place, output) in itertools.product(
        items('ShaderNodeTexGabor', 'gabor_type'), enumerate(('Value', 'Phase', 'Intensity'))
    ):
        sockets = 'Vector|Scale|Frequency|Anisotropy|' + ('Orientation 2D|', '|Orientation 3D')[kind]
        node = make_node('gabor_f', 'ShaderNodeTexGabor', sockets, output, gabor_type=name)
        ranges: dict[int, Range] = {0: (-4.0, 4.0), 1: (0.5, 3.0), 2: (-1.0, 6.0), 5: (0.1, 1.0)}
        cases.append(Case('gabor_f', kind | place << 1, node, ranges, 0.01))
    return cases


def every_case() -> list[Case]:
    return [*_math(), *_numbers(), *_mapping(), *_colors(), *_noise(), *_voronoi(), *_patterns()]
