# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read the shading point, the object, the ray: geometry, coordinates, attributes, info, and constants.

Nodes that only compute are told in nodes_math.py, textures in nodes_texture.py.
"""

from __future__ import annotations

import numpy as np

from ..export.attributes import (
    ACTIVE_COLOR,
    INSTANCER_GENERATED,
    INSTANCER_UV,
    PARTICLE_NUMBERS,
    PARTICLE_PLACE,
    PARTICLE_SPIN,
    PARTICLE_VELOCITY,
    POINTINESS,
    RANDOM_PER_ISLAND,
    STANDARD,
    instancer_layer,
    object_layer,
    unit_hash,
)
from .reader import Node, UnreadError, value
from .tree import VECTOR_DOT, VECTOR_NORMALIZE, VECTOR_REFLECT, VECTOR_SCALE, Ref

# Outputs of Light Path in the order of 5.2, which is the mode of the op.
LIGHT_PATH = (
    'Is Camera Ray',
    'Is Shadow Ray',
    'Is Diffuse Ray',
    'Is Glossy Ray',
    'Is Singular Ray',
    'Is Reflection Ray',
    'Is Transmission Ray',
    'Is Volume Scatter Ray',
    'Ray Length',
    'Ray Depth',
    'Diffuse Depth',
    'Glossy Depth',
    'Transparent Depth',
    'Transmission Depth',
    'Portal Depth',
)
PARTICLE_V = {'Location': PARTICLE_PLACE, 'Velocity': PARTICLE_VELOCITY, 'Angular Velocity': PARTICLE_SPIN}
NO_PARTICLE = float(unit_hash(np.zeros(1, np.uint32), 0)[0])  # the random number of what no particle made
OBJECT_F = ('Alpha', 'Object Index', 'Material Index', 'Random')
FALLOFF = ('Quadratic', 'Linear', 'Constant')
VOLUME_ATTRIBUTES = {'Color': 'color', 'Density': 'density', 'Flame': 'flame', 'Temperature': 'temperature'}

# Modes of object_transform: a normal and a vector, from world to object.
NORMAL_TO_OBJECT = 2 | 0 << 2 | 1 << 4
VECTOR_TO_OBJECT = 0 | 0 << 2 | 1 << 4


# ---- Constants.


@value('ShaderNodeValue', 'ShaderNodeRGB')
def _own(node: Node, output: str) -> Ref:
    socket = node.node.outputs[0]
    return node.reader.typed(socket.default_value, socket.type, socket.type == 'RGBA', socket)


@value('FunctionNodeInputInt', 'FunctionNodeInputBool', 'FunctionNodeInputVector')
def _typed(node: Node, output: str) -> Ref:
    names = {'FunctionNodeInputInt': 'integer', 'FunctionNodeInputBool': 'boolean', 'FunctionNodeInputVector': 'vector'}
    own = getattr(node.node, names[node.node.bl_idname])
    return node.constant(float(own) if isinstance(own, (int, bool)) else tuple(own)[:3])


# ---- The shading point.


@value('ShaderNodeNewGeometry')
def _geometry(node: Node, output: str) -> Ref:
    match output:
        case 'Position':
            return node.at_point('position')
        case 'Normal':
            return node.surface_normal()
        case 'Tangent':
            return node.emit('geometry_tangent')
        case 'True Normal':
            return node.emit('true_normal')
        case 'Incoming':
            return node.emit('incoming')
        case 'Parametric':
            return node.at_point('parametric')
        case 'Backfacing':
            return node.emit('backfacing')
        case 'Pointiness':
            return layer_f(node, POINTINESS)
        case 'Random Per Island':
            return layer_f(node, RANDOM_PER_ISLAND)
    raise UnreadError(f'its output "{output}" is not supported yet')


def generated(node: Node) -> Ref:
    """Generated coordinates; in the world they are the direction, as positions are there."""
    return node.at_point('position' if node.reader.kind == 'world' else 'generated')


def uv(node: Node, name: str = '') -> Ref:
    """A UV map, '' = the active render one. Lamps have one, which Cycles makes up."""
    if node.reader.kind == 'light':
        return node.constant(0.0) if name else node.emit('parametric')
    return layer_v(node, name)


def layer_v(node: Node, name: str) -> Ref:
    return node.at_point('attribute', node.builder.named('layer', name))


def layer_f(node: Node, name: str, op: str = 'attribute_fac') -> Ref:
    return node.at_point(op, node.builder.named('layer', name))


@value('ShaderNodeTexCoord')
def _coordinates(node: Node, output: str) -> Ref:
    if node.node.from_instancer and output in ('Generated', 'UV'):
        return layer_v(node, INSTANCER_GENERATED if output == 'Generated' else INSTANCER_UV)
    match output:
        case 'Generated':
            return generated(node)
        case 'Normal':
            return object_normal(node)
        case 'UV':
            return uv(node)
        case 'Object':
            return _object_coordinates(node)
        case 'Camera':
            return node.at_point('camera_position')
        case 'Window':
            return node.at_point('window')
        case 'Reflection':
            return _reflection(node)
    raise UnreadError(f'its output "{output}" is not supported yet')


def object_normal(node: Node) -> Ref:
    """The normal in object space."""
    return node.emit('object_transform', node.surface_normal(), mode=NORMAL_TO_OBJECT)


def _object_coordinates(node: Node) -> Ref:
    """Coordinates of the object itself, or of another one, whose matrix is a constant."""
    other = node.node.object
    if other is None:
        return node.at_point('position' if node.reader.kind == 'world' else 'object_position')
    matrix = np.array(other.matrix_world, np.float64)
    if not np.isfinite(matrix).all():
        node.warn(f'the transform of object "{other.name}" is not finite: world coordinates are used')
        return node.at_point('position')
    inverse = np.linalg.pinv(matrix[:3, :3], rcond=1e-12)
    return affine(node, node.at_point('position'), np.column_stack([inverse, -inverse @ matrix[:3, 3]]))


def affine(node: Node, vector: Ref, matrix: np.ndarray) -> Ref:
    """A vector through a (3, 4) matrix."""
    rows = [node.constant(tuple(map(float, row[:3]))) for row in matrix]
    return node.emit('affine', vector, *rows, node.constant(tuple(map(float, matrix[:, 3]))))


def _reflection(node: Node) -> Ref:
    incoming, zero = node.emit('incoming'), node.constant(0.0)
    if node.reader.kind == 'world':
        return incoming
    toward = node.emit('vector_math_v', incoming, zero, zero, node.constant(-1.0), mode=VECTOR_SCALE)
    return node.emit('vector_math_v', toward, node.surface_normal(), zero, zero, mode=VECTOR_REFLECT)


@value('ShaderNodeUVMap')
def _uv_map(node: Node, output: str) -> Ref:
    if node.node.from_instancer:
        return layer_v(node, INSTANCER_UV)
    return uv(node, node.node.uv_map)


@value('ShaderNodeCameraData')
def _camera(node: Node, output: str) -> Ref:
    if output == 'View Z Depth':
        return node.emit('camera_z')
    if output == 'View Distance':
        return node.emit('camera_distance')
    zero = node.constant(0.0)
    return node.emit('vector_math_v', node.emit('camera_position'), zero, zero, zero, mode=VECTOR_NORMALIZE)


@value('ShaderNodeTangent')
def _tangent(node: Node, output: str) -> Ref:
    if node.node.direction_type == 'RADIAL':
        return node.emit('tangent', mode='XYZ'.index(node.node.axis))
    return node.emit('uv_tangent', node.builder.named('tangent', node.node.uv_map))


@value('ShaderNodeWireframe')
def _wireframe(node: Node, output: str) -> Ref:
    return node.emit('wireframe', node.f('Size'), mode=int(node.node.use_pixel_size))


@value('ShaderNodeFresnel')
def _fresnel(node: Node, output: str) -> Ref:
    return node.emit('fresnel', node.f('IOR'), node.normal())


@value('ShaderNodeLayerWeight')
def _layer_weight(node: Node, output: str) -> Ref:
    return node.emit('layer_weight', node.f('Blend'), node.normal(), mode=('Fresnel', 'Facing').index(output))


@value('ShaderNodeNormal')
def _normal(node: Node, output: str) -> Ref:
    """A direction that was dialled in, and what a normal has in common with it."""
    zero = node.constant(0.0)
    dialled = node.constant(tuple(node.node.outputs['Normal'].default_value)[:3])
    direction = node.emit('vector_math_v', dialled, zero, zero, zero, mode=VECTOR_NORMALIZE)
    if output == 'Normal':
        return direction
    normal = node.emit('vector_math_v', node.v('Normal'), zero, zero, zero, mode=VECTOR_NORMALIZE)
    return node.emit('vector_math_f', direction, normal, zero, zero, mode=VECTOR_DOT)


# ---- Attributes.


@value('ShaderNodeAttribute')
def _attribute(node: Node, output: str) -> Ref:
    name = node.node.attribute_name
    match node.node.attribute_type:
        case 'VIEW_LAYER':
            found = node.reader.scene.view_layer(name)
            if output == 'Alpha':
                return node.constant(found[3])
            return node.constant(sum(found[:3]) / 3.0 if output == 'Fac' else found[:3])
        case 'OBJECT' | 'INSTANCER' if node.reader.kind == 'light':
            raise UnreadError('attributes of objects are not supported for lights yet')
        case 'OBJECT':
            layer = object_layer(name)
        case 'INSTANCER':
            layer = instancer_layer(name)
        case _:
            if not name:
                return node.constant(1.0 if output == 'Alpha' else 0.0)
            if name in DERIVED:
                return _derived_attribute(node, output, DERIVED[name](node))
            if name in ('N', 'tangent_sign'):
                raise UnreadError(f'attribute "{name}" is not supported yet')
            layer = STANDARD.get(name, name)
    if output == 'Alpha':
        return layer_f(node, layer, 'attribute_alpha')
    return layer_f(node, layer) if output == 'Fac' else layer_v(node, layer)


def _derived_attribute(node: Node, output: str, found: Ref) -> Ref:
    """What Cycles derives of every mesh: a vector."""
    if output == 'Alpha':
        return node.constant(1.0)
    return node.reader.average(found) if output == 'Fac' else found


def _object_tangent(node: Node) -> Ref:
    """Along the active UV map, in object space."""
    zero, tangent = node.constant(0.0), node.emit('uv_tangent', node.builder.named('tangent', ''))
    tangent = node.emit('object_transform', tangent, mode=VECTOR_TO_OBJECT)
    return node.emit('vector_math_v', tangent, zero, zero, zero, mode=VECTOR_NORMALIZE)


# Names of the node Attribute that stand for what Cycles derives of a mesh.
DERIVED = {'generated': generated, 'tangent': _object_tangent}


@value('ShaderNodeVertexColor')
def _vertex_color(node: Node, output: str) -> Ref:
    layer = node.node.layer_name or ACTIVE_COLOR
    return layer_f(node, layer, 'attribute_alpha') if output == 'Alpha' else layer_v(node, layer)


@value('ShaderNodeVolumeInfo')
def _volume_info(node: Node, output: str) -> Ref:
    """On surfaces these are the attributes of these names."""
    layer = VOLUME_ATTRIBUTES[output]
    return layer_v(node, layer) if output == 'Color' else layer_f(node, layer)


@value('ShaderNodeHairInfo', 'ShaderNodePointInfo')
def _no_curve(node: Node, output: str) -> Ref:
    """On surfaces that are no curves and no points, all of it is 0."""
    return node.constant(0.0)


# ---- Objects, particles, rays.


@value('ShaderNodeObjectInfo')
def _object(node: Node, output: str) -> Ref:
    if node.reader.kind == 'light' and output != 'Location':
        raise UnreadError(f'its output "{output}" is not supported for lights yet')
    if output in OBJECT_F:
        return node.emit('object_info_f', mode=OBJECT_F.index(output))
    return node.emit('object_info_v', mode=('Location', 'Color').index(output))


@value('ShaderNodeParticleInfo')
def _particle(node: Node, output: str) -> Ref:
    if node.reader.kind != 'material':
        return node.constant(NO_PARTICLE if output == 'Random' else 0.0)
    if output in PARTICLE_V:
        return layer_v(node, PARTICLE_V[output])
    if output in ('Lifetime', 'Size'):
        return layer_f(node, PARTICLE_NUMBERS if output == 'Lifetime' else PARTICLE_PLACE, 'attribute_alpha')
    numbers = layer_v(node, PARTICLE_NUMBERS)
    return node.emit('component', numbers, mode=('Index', 'Random', 'Age').index(output))


@value('ShaderNodeLightPath')
def _light_path(node: Node, output: str) -> Ref:
    if output not in LIGHT_PATH:
        raise UnreadError(f'its output "{output}" is not supported yet')
    return node.emit('light_path', mode=LIGHT_PATH.index(output))


@value('ShaderNodeLightFalloff')
def _falloff(node: Node, output: str) -> Ref:
    return node.emit('light_falloff', node.f('Strength'), node.f('Smooth'), mode=FALLOFF.index(output))
