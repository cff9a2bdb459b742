# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that only compute: numbers, vectors, colours, ramps and curves.

What they compute is in the kernels, with Blender's numbers of operations as modes.
"""

from __future__ import annotations

from . import tables
from .reader import Node, UnreadError, value
from .tree import Ref

CLAMP_MATH = 1 << 16
CLAMP_RANGE = 1 << 8
CLAMP_FACTOR, CLAMP_RESULT = 1 << 8, 1 << 9
INVERT_ROTATION = 1 << 8
FLOAT_OPERATIONS = frozenset(('DOT_PRODUCT', 'DISTANCE', 'LENGTH'))


# ---- Numbers and vectors.


@value('ShaderNodeMath')
def _math(node: Node, output: str) -> Ref:
    mode = node.enum('operation') | (CLAMP_MATH if node.node.use_clamp else 0)
    used = node.used
    return node.emit('math', used('Value'), used('Value_001'), used('Value_002'), mode=mode)


@value('ShaderNodeVectorMath')
def _vector_math(node: Node, output: str) -> Ref:
    vectors = [node.used(name, True) for name in ('Vector', 'Vector_001', 'Vector_002')]
    op = 'vector_math_f' if node.node.operation in FLOAT_OPERATIONS else 'vector_math_v'
    return node.emit(op, *vectors, node.used('Scale'), mode=node.enum('operation'))


@value('ShaderNodeClamp')
def _clamp(node: Node, output: str) -> Ref:
    return node.emit('clamp_f', node.f('Value'), node.f('Min'), node.f('Max'), mode=node.enum('clamp_type'))


@value('ShaderNodeMapRange')
def _map_range(node: Node, output: str) -> Ref:
    mode = node.enum('interpolation_type') | (CLAMP_RANGE if node.node.clamp else 0)
    names = ('From Min', 'From Max', 'To Min', 'To Max', 'Steps')
    if node.node.data_type == 'FLOAT':
        return node.emit('map_range_f', node.f('Value'), *(node.used(name) for name in names), mode=mode)
    found = [node.used(f'{name.replace(" ", "_")}_FLOAT3', True) for name in names]
    return node.emit('map_range_v', node.v('Vector'), *found, mode=mode)


@value('ShaderNodeMix')
def _mix(node: Node, output: str) -> Ref:
    shown, clamp = node.node.data_type, int(node.node.clamp_factor)
    match shown:
        case 'FLOAT':
            return node.emit('mix_f', node.f('Factor_Float'), node.f('A_Float'), node.f('B_Float'), mode=clamp)
        case 'VECTOR':
            uniform = node.node.factor_mode == 'UNIFORM'
            factor = node.builder.splat(node.f('Factor_Float')) if uniform else node.v('Factor_Vector')
            return node.emit('mix_v', factor, node.v('A_Vector'), node.v('B_Vector'), mode=clamp)
        case 'RGBA':
            mode = node.enum('blend_type') | clamp * CLAMP_FACTOR | node.node.clamp_result * CLAMP_RESULT
            return node.emit('mix_color', node.f('Factor_Float'), node.v('A_Color'), node.v('B_Color'), mode=mode)
    raise UnreadError(f'a mix of type {shown.lower()} is not supported')


@value('ShaderNodeMixRGB')
def _mix_rgb(node: Node, output: str) -> Ref:
    mode = node.enum('blend_type') | CLAMP_FACTOR | node.node.use_clamp * CLAMP_RESULT
    return node.emit('mix_color', node.f('Fac'), node.v('Color1'), node.v('Color2'), mode=mode)


@value('ShaderNodeMapping')
def _mapping(node: Node, output: str) -> Ref:
    scale, rotation = node.v('Scale'), node.v('Rotation')
    # Directions have no location.
    location = node.used('Location', True)
    return node.emit('mapping', node.v('Vector'), location, rotation, scale, mode=node.enum('vector_type'))


@value('ShaderNodeVectorRotate')
def _rotate(node: Node, output: str) -> Ref:
    mode = node.enum('rotation_type') | (INVERT_ROTATION if node.node.invert else 0)
    vector, center = node.v('Vector'), node.v('Center')
    axis, rotation = node.used('Axis', True), node.used('Rotation', True)
    return node.emit('vector_rotate', vector, center, axis, node.used('Angle'), rotation, mode=mode)


@value('ShaderNodeVectorTransform')
def _transform(node: Node, output: str) -> Ref:
    mode = node.enum('vector_type') | node.enum('convert_from') << 2 | node.enum('convert_to') << 4
    return node.emit('object_transform', node.v('Vector'), mode=mode)


@value('ShaderNodeCombineXYZ')
def _combine(node: Node, output: str) -> Ref:
    return node.emit('combine', node.f('X'), node.f('Y'), node.f('Z'))


@value('ShaderNodeSeparateXYZ')
def _separate(node: Node, output: str) -> Ref:
    return node.emit('component', node.v('Vector'), mode='XYZ'.index(output))


RADIAL = {'Segment ID': 0, 'Segment Width': 1, 'Segment Rotation': 2}


@value('ShaderNodeRadialTiling')
def _radial(node: Node, output: str) -> Ref:
    args = (node.v('Vector'), node.f('Sides'), node.f('Roundness'))
    mode = int(node.node.normalize)
    if output in RADIAL:
        return node.emit('radial_tiling_f', *args, mode=mode | RADIAL[output] << 1)
    return node.emit('radial_tiling_v', *args, mode=mode)


# ---- Colours.

# The nodes of Blender 4.5 that are modes of one node since: their inputs, and the mode.
COMBINE = {'ShaderNodeCombineRGB': ('RGB', 0), 'ShaderNodeCombineHSV': ('HSV', 1)}
SEPARATE = {'ShaderNodeSeparateRGB': ('Image', 'RGB', 0), 'ShaderNodeSeparateHSV': ('Color', 'HSV', 1)}
PARTS = ('Red', 'Green', 'Blue')


@value('ShaderNodeCombineColor', *COMBINE)
def _combine_color(node: Node, output: str) -> Ref:
    names, mode = COMBINE.get(node.node.bl_idname, (PARTS, None))
    return node.emit('combine_color', *map(node.f, names), mode=node.enum('mode') if mode is None else mode)


@value('ShaderNodeSeparateColor', *SEPARATE)
def _separate_color(node: Node, output: str) -> Ref:
    source, names, mode = SEPARATE.get(node.node.bl_idname, ('Color', PARTS, None))
    mode = node.enum('mode') if mode is None else mode
    color = node.v(source)
    if mode != 0:
        color = node.emit('separate_color', color, mode=mode)
    return node.emit('component', color, mode=names.index(output))


@value('ShaderNodeHueSaturation')
def _hue(node: Node, output: str) -> Ref:
    return node.emit('hsv', *map(node.f, ('Hue', 'Saturation', 'Value', 'Fac')), node.v('Color'))


@value('ShaderNodeGamma')
def _gamma(node: Node, output: str) -> Ref:
    return node.emit('gamma', node.v('Color'), node.f('Gamma'))


@value('ShaderNodeBrightContrast')
def _bright(node: Node, output: str) -> Ref:
    return node.emit('bright_contrast', node.v('Color'), node.f('Bright'), node.f('Contrast'))


@value('ShaderNodeInvert')
def _invert(node: Node, output: str) -> Ref:
    return node.emit('invert', node.v('Color'), node.f('Fac'))


@value('ShaderNodeRGBToBW')
def _bw(node: Node, output: str) -> Ref:
    return node.reader.luminance(node.v('Color'))


@value('ShaderNodeBlackbody')
def _blackbody(node: Node, output: str) -> Ref:
    return node.emit('blackbody', node.f('Temperature'))


@value('ShaderNodeWavelength')
def _wavelength(node: Node, output: str) -> Ref:
    return node.emit('wavelength', node.f('Wavelength'))


# ---- Ramps and curves.


@value('ShaderNodeValToRGB')
def _ramp(node: Node, output: str) -> Ref:
    ramp = tables.ramp(node.node.color_ramp)
    args = (node.f('Fac'), node.builder.table(ramp.table), node.constant(float(len(ramp.table))))
    return node.emit('ramp_alpha' if output == 'Alpha' else 'ramp_v', *args, mode=int(ramp.is_constant))


@value('ShaderNodeFloatCurve')
def _float_curve(node: Node, output: str) -> Ref:
    curve = tables.curves(node.node.mapping, 1, False)
    return node.emit('curve_f', node.f('Value'), *_curve(node, curve), node.f('Factor'), mode=int(curve.extrapolates))


@value('ShaderNodeRGBCurve')
def _rgb_curve(node: Node, output: str) -> Ref:
    curve = tables.curves(node.node.mapping, 4, True)
    return node.emit('rgb_curve_v', node.v('Color'), *_curve(node, curve), node.f('Fac'), mode=int(curve.extrapolates))


@value('ShaderNodeVectorCurve')
def _vector_curve(node: Node, output: str) -> Ref:
    curve = tables.curves(node.node.mapping, 3, False)
    mode = int(curve.extrapolates)
    return node.emit('vector_curve_v', node.v('Vector'), *_curve(node, curve), node.f('Fac'), mode=mode)


def _curve(node: Node, curve: tables.Curves) -> tuple[Ref, Ref, Ref]:
    return node.builder.table(curve.table), node.constant(curve.first), node.constant(curve.last)
