# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the nodes between an image and a shader: what they do to its values, and with which coordinates it is read.

Only affine maps and one comparison are followed; whatever else is met is handed back as Unread, for the caller to name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Euler

from .buffers import (
    CHANNEL_A,
    CHANNEL_RGB,
    COORDINATES_GENERATED,
    COORDINATES_OBJECT,
    COORDINATES_UV,
    COORDINATES_WORLD,
    EXTENSION_CLIP,
    EXTENSION_EXTEND,
    EXTENSION_MIRROR,
    EXTENSION_REPEAT,
    INTERPOLATION_CLOSEST,
    INTERPOLATION_CUBIC,
    INTERPOLATION_LINEAR,
    NORMAL_OBJECT,
    NORMAL_TANGENT,
    NORMAL_WORLD,
)
from .images import ImageTable
from .nodes import Constant, Input, Source, Trees, source
from .readings import Readings, UnreadError
from .sockets import converted, own_value
from .textures import (
    BLACK,
    WHITE,
    Lookup,
    NormalMap,
    NotAffineError,
    Texture,
    add,
    affine,
    clamp,
    combine,
    constant,
    greater,
    less,
    luminance,
    mix,
    multiply,
    separate,
)

# What Cycles shows where an image cannot be read; its alpha is 1.
MISSING_IMAGE = (1.0, 0.0, 1.0)

INTERPOLATIONS = {
    'Closest': INTERPOLATION_CLOSEST,
    'Linear': INTERPOLATION_LINEAR,
    'Cubic': INTERPOLATION_CUBIC,
    'Smart': INTERPOLATION_CUBIC,  # as in Cycles
}
EXTENSIONS = {
    'REPEAT': EXTENSION_REPEAT,
    'EXTEND': EXTENSION_EXTEND,
    'CLIP': EXTENSION_CLIP,
    'MIRROR': EXTENSION_MIRROR,
}
NORMAL_SPACES = {
    'TANGENT': NORMAL_TANGENT,
    'OBJECT': NORMAL_OBJECT,
    'WORLD': NORMAL_WORLD,
    'BLENDER_OBJECT': NORMAL_OBJECT,
    'BLENDER_WORLD': NORMAL_WORLD,
}


@dataclass(slots=True)
class TextureReader:
    """Reads values that may be images. warn: takes texts about this owner's nodes; images: None = none are read."""

    trees: Trees
    images: ImageTable | None
    warn: Callable[[str], None]
    readings: Readings = field(init=False)

    def __post_init__(self) -> None:
        ways = {'value': (VALUES, self._value), 'coordinates': (VECTORS, self._coordinates)}
        self.readings = Readings(self.trees, ways)

    def value(self, target: Input) -> Texture:
        """What `target` takes, as an affine value; numbers have three like components. Raises UnreadError."""
        found = source(self.trees, target)
        if isinstance(found, Input):
            return constant(own_value(found.socket))
        if isinstance(found, Constant):
            return constant(found.value)
        read = self.readings.read('value', found)
        if read.lookup is None:
            value = read.offset if found.through[0] in ('RGBA', 'VECTOR') else read.offset[0]
            return constant(converted(value, (*found.through, target.socket.type)))
        try:
            return luminance(read) if target.socket.type == 'VALUE' else read
        except NotAffineError:
            raise UnreadError(found) from None

    def _value(self, found: Source) -> Texture:
        if found.node.type not in VALUES:
            raise UnreadError(found)
        try:
            return VALUES[found.node.type](self, found, found.inputs())
        except NotAffineError:
            raise UnreadError(found) from None

    def _coordinates(self, found: Source) -> Coordinates:
        return VECTORS[found.node.type](self, found, found.inputs())

    def number(self, target: Input, found: Source) -> float:
        """A constant; if it is none, the node that asks for it is not understood."""
        read = self.value(target)
        if read.lookup is not None:
            raise UnreadError(found)
        return read.offset[0]

    def triple(self, target: Input, found: Source) -> np.ndarray:
        read = self.value(target)
        if read.lookup is not None:
            raise UnreadError(found)
        return np.array(read.offset, np.float64)


# ---- Values: one function per node, named after its type.


def _image(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    node = found.node
    if reader.images is None:
        raise UnreadError(found)
    loaded = reader.images.load(node.image, node.image_user)
    if isinstance(loaded, str):
        reader.warn(f'node "{node.name}": {loaded}')
        return constant(WHITE if found.output.name == 'Alpha' else MISSING_IMAGE)
    if node.projection != 'FLAT':
        reader.warn(f'node "{node.name}": {node.projection.lower()} projection is not supported yet: flat is used')
    if not _is_plain(node.texture_mapping):
        reader.warn(f'node "{node.name}": its own texture mapping is not supported yet: left out')
    coordinates = read_coordinates(reader, inputs['Vector'], node)
    lookup = Lookup(
        image=loaded.index,
        coordinates=coordinates.kind,
        uv_map=coordinates.uv_map,
        mapping=tuple(tuple(row) for row in coordinates.matrix[:2].tolist()),
        interpolation=INTERPOLATIONS[node.interpolation],
        extension=EXTENSIONS[node.extension],
        # Cycles divides by alpha only where the node's Alpha is used as well.
        unassociate=loaded.associated and node.outputs['Alpha'].is_linked,
    )
    channel = CHANNEL_A if found.output.name == 'Alpha' else CHANNEL_RGB
    return Texture(lookup, channel, bounded=loaded.bounded)


def _separate(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    if getattr(found.node, 'mode', 'RGB') != 'RGB':
        raise UnreadError(found)
    index = list(found.node.outputs).index(found.output)
    return separate(reader.value(next(iter(inputs.values()))), index)


def _combine(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    if getattr(found.node, 'mode', 'RGB') != 'RGB':
        raise UnreadError(found)
    red, green, blue = (reader.value(target) for target in list(inputs.values())[:3])
    return combine((red, green, blue))


def _bw(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    return luminance(reader.value(inputs['Color']))


def _invert(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    share, color = (Input(socket, found.contexts) for socket in found.node.inputs[:2])
    shown = reader.value(color)
    return mix(shown, affine(shown, -1.0, 1.0), reader.value(share))


def _clamp(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    low, high = (reader.number(inputs[name], found) for name in ('Min', 'Max'))
    if found.node.clamp_type == 'RANGE' and low > high:
        low, high = high, low
    return clamp(reader.value(inputs['Value']), low, high)


def _map_range(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    node = found.node
    if node.data_type != 'FLOAT' or node.interpolation_type != 'LINEAR':
        raise UnreadError(found)
    names = ('From Min', 'From Max', 'To Min', 'To Max')
    a, b, c, d = (reader.number(inputs[name], found) for name in names)
    if a == b:
        return constant(0.0)
    slope = (d - c) / (b - a)
    mapped = affine(reader.value(inputs['Value']), slope, c - a * slope)
    return clamp(mapped, min(c, d), max(c, d)) if node.clamp else mapped


def _ramp(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    """A linear ramp of two colours, where its ends are not passed."""
    ramp = found.node.color_ramp
    if (
        found.output.name != 'Color'
        or len(ramp.elements) != 2
        or ramp.interpolation != 'LINEAR'
        or ramp.color_mode != 'RGB'
    ):
        raise UnreadError(found)
    first, last = ramp.elements
    if first.position == last.position:
        raise UnreadError(found)
    span = 1.0 / (last.position - first.position)
    share = clamp(affine(reader.value(inputs['Factor'] if 'Factor' in inputs else inputs['Fac']), span,
                         -first.position * span), 0.0, 1.0)  # fmt: skip
    return mix(constant(tuple(first.color)[:3]), constant(tuple(last.color)[:3]), share)


def _math(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    node = found.node
    a, b, c = (reader.value(Input(s, found.contexts)) if s.enabled else constant(0.0) for s in node.inputs[:3])
    match node.operation:
        case 'ADD':
            result = add(a, b)
        case 'SUBTRACT':
            result = add(a, affine(b, -1.0, 0.0))
        case 'MULTIPLY':
            result = multiply(a, b)
        case 'DIVIDE' if b.lookup is None:
            result = multiply(a, constant(1.0 / b.offset[0])) if b.offset[0] != 0.0 else constant(0.0)
        case 'MULTIPLY_ADD':
            result = add(multiply(a, b), c)
        case 'LESS_THAN':
            result = less(a, b.offset[0]) if b.lookup is None else greater(b, _number(a, found))
        case 'GREATER_THAN':
            result = greater(a, b.offset[0]) if b.lookup is None else less(b, _number(a, found))
        case _:
            raise UnreadError(found)
    return clamp(result, 0.0, 1.0) if node.use_clamp else result


def _number(value: Texture, found: Source) -> float:
    if value.lookup is not None:
        raise UnreadError(found)
    return value.offset[0]


def _mix(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Texture:
    """Node Mix, and the Mix of before 3.4: two colours or numbers by a factor."""
    node = found.node
    if getattr(node, 'factor_mode', 'UNIFORM') != 'UNIFORM' or getattr(node, 'data_type', 'RGBA') == 'ROTATION':
        raise UnreadError(found)
    share, first, second = list(inputs.values())[:3]
    factor = reader.value(share)
    if getattr(node, 'clamp_factor', True):
        factor = clamp(factor, 0.0, 1.0)
    kind = node.blend_type if getattr(node, 'data_type', 'RGBA') == 'RGBA' else 'MIX'
    # What has no share is not looked at: it may be a node that is not understood.
    if factor == constant(0.0):
        result = reader.value(first)
    elif kind == 'MIX' and factor == constant(1.0):
        result = reader.value(second)
    else:
        result = _blend(kind, reader.value(first), reader.value(second), factor, found)
    clamped = getattr(node, 'clamp_result', getattr(node, 'use_clamp', False))
    return clamp(result, 0.0, 1.0) if clamped else result


def _blend(kind: str, a: Texture, b: Texture, factor: Texture, found: Source) -> Texture:
    match kind:
        case 'MIX':
            return mix(a, b, factor)
        case 'MULTIPLY':
            return multiply(a, add(affine(factor, -1.0, 1.0), multiply(factor, b)))
        case 'ADD':
            return add(a, multiply(b, factor))
        case 'SUBTRACT':
            return add(a, affine(multiply(b, factor), -1.0, 0.0))
    raise UnreadError(found)


VALUES: dict[str, Callable[[TextureReader, Source, dict[str, Input]], Texture]] = {
    'TEX_IMAGE': _image,
    'SEPARATE_COLOR': _separate,
    'SEPRGB': _separate,
    'COMBINE_COLOR': _combine,
    'COMBRGB': _combine,
    'RGBTOBW': _bw,
    'INVERT': _invert,
    'CLAMP': _clamp,
    'MAP_RANGE': _map_range,
    'VALTORGB': _ramp,
    'MATH': _math,
    'MIX': _mix,
    'MIX_RGB': _mix,
}


# ---- Coordinates.


@dataclass(frozen=True, slots=True)
class Coordinates:
    """matrix: (3, 4), from the coordinates of this kind to those that the node gives."""

    kind: int
    uv_map: str
    matrix: np.ndarray


def read_coordinates(reader: TextureReader, target: Input, node: bpy.types.Node) -> Coordinates:
    """The coordinates that an image node's Vector input takes; the active render UV map if they are not understood."""
    if isinstance(source(reader.trees, target), Input):  # as Cycles: an image without link takes the UV map
        return _uv('')
    try:
        return _vector(reader, target)
    except UnreadError as unread:
        output = unread.source.output.name
        reader.warn(
            f'node "{node.name}": coordinates from node "{unread.source.node.name}" ({output}) '
            'are not supported yet: the UV map is used'
        )
        return _uv('')


def _uv(name: str) -> Coordinates:
    return Coordinates(COORDINATES_UV, name, np.eye(3, 4))


def _vector(reader: TextureReader, target: Input) -> Coordinates:
    found = source(reader.trees, target)
    if isinstance(found, (Input, Constant)):
        value = found.value if isinstance(found, Constant) else own_value(found.socket)
        return _uv_constant(np.array(constant(value).offset))
    if found.node.type in VECTORS:
        return reader.readings.read('coordinates', found)
    return _uv_constant(reader.triple(target, found))


def _uv_constant(point: np.ndarray) -> Coordinates:
    return Coordinates(COORDINATES_UV, '', np.concatenate([np.zeros((3, 3)), point[:, None]], axis=1))


def _uv_map(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    if found.node.from_instancer:
        raise UnreadError(found)
    return _uv(found.node.uv_map)


def _attribute(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    """A UV map read by its name."""
    if found.node.attribute_type != 'GEOMETRY' or found.output.name not in ('Vector', 'Color'):
        raise UnreadError(found)
    return _uv(found.node.attribute_name)


def _coordinate(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    node = found.node
    if node.from_instancer:
        raise UnreadError(found)
    match found.output.name:
        case 'UV':
            return _uv('')
        case 'Generated':
            return Coordinates(COORDINATES_GENERATED, '', np.eye(3, 4))
        case 'Object' if node.object is None:
            return Coordinates(COORDINATES_OBJECT, '', np.eye(3, 4))
        case 'Object':
            return Coordinates(COORDINATES_WORLD, '', inverse(np.array(node.object.matrix_world, np.float64)[:3]))
    raise UnreadError(found)


def _geometry(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    if found.output.name != 'Position':
        raise UnreadError(found)
    return Coordinates(COORDINATES_WORLD, '', np.eye(3, 4))


def _mapping(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    kind = found.node.vector_type
    scale = reader.triple(inputs['Scale'], found)
    rotation = np.array(Euler(reader.triple(inputs['Rotation'], found), 'XYZ').to_matrix(), np.float64)
    location = reader.triple(inputs['Location'], found) if 'Location' in inputs else np.zeros(3)
    if kind in ('POINT', 'VECTOR'):
        linear = rotation * scale
        offset = location if kind == 'POINT' else np.zeros(3)
    elif kind == 'TEXTURE':
        # The inverse of POINT; what is divided by 0 is 0.
        linear = rotation.T * np.divide(1.0, scale, out=np.zeros(3), where=scale != 0.0)[:, None]
        offset = -linear @ location
    else:  # NORMAL makes directions of its result: not affine
        raise UnreadError(found)
    return _mapped(_vector(reader, inputs['Vector']), linear, offset)


def _vector_math(reader: TextureReader, found: Source, inputs: dict[str, Input]) -> Coordinates:
    first, second = (Input(socket, found.contexts) for socket in found.node.inputs[:2])
    match found.node.operation:
        case 'ADD':
            return _mapped(_vector(reader, first), np.eye(3), reader.triple(second, found))
        case 'SUBTRACT':
            return _mapped(_vector(reader, first), np.eye(3), -reader.triple(second, found))
        case 'MULTIPLY':
            return _mapped(_vector(reader, first), np.diag(reader.triple(second, found)), np.zeros(3))
        case 'SCALE':
            return _mapped(_vector(reader, first), np.eye(3) * reader.number(inputs['Scale'], found), np.zeros(3))
    raise UnreadError(found)


def _mapped(inner: Coordinates, linear: np.ndarray, offset: np.ndarray) -> Coordinates:
    matrix = linear @ inner.matrix
    matrix[:, 3] += offset
    return Coordinates(inner.kind, inner.uv_map, matrix)


VECTORS: dict[str, Callable[[TextureReader, Source, dict[str, Input]], Coordinates]] = {
    'UVMAP': _uv_map,
    'ATTRIBUTE': _attribute,
    'TEX_COORD': _coordinate,
    'NEW_GEOMETRY': _geometry,
    'MAPPING': _mapping,
    'VECT_MATH': _vector_math,
}


def inverse(transforms: np.ndarray) -> np.ndarray:
    """Inverses of affine maps (..., 3, 4); of a flat one the nearest there is."""
    linear = np.linalg.pinv(transforms[..., :3].astype(np.float64), rcond=1e-12)
    return np.concatenate([linear, -linear @ transforms[..., 3:]], axis=-1)


def _is_plain(mapping: bpy.types.TexMapping) -> bool:
    """Whether the mapping that each texture node carries, out of sight in the user interface, does nothing."""
    return (
        tuple(mapping.translation) == BLACK
        and tuple(mapping.rotation) == BLACK
        and tuple(mapping.scale) == WHITE
        and (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z) == ('X', 'Y', 'Z')
        and not (mapping.use_min or mapping.use_max)
    )


# ---- Normals.


def read_normal(reader: TextureReader, target: Input) -> NormalMap | None:
    """The normal map that feeds a Normal input, None if nothing does. Raises UnreadError."""
    found = source(reader.trees, target)
    if isinstance(found, (Input, Constant)):  # a normal that is typed in is one of three zeros, which changes nothing
        return None
    if found.node.type != 'NORMAL_MAP':
        raise UnreadError(found)
    node, inputs = found.node, found.inputs()
    color = reader.value(inputs['Color'])
    strength = reader.number(inputs['Strength'], found)
    if node.space.startswith('BLENDER_'):
        color = _flipped(color, (False, True, True))
    elif node.space == 'TANGENT' and getattr(node, 'convention', 'OPENGL') == 'DIRECTX':
        color = _flipped(color, (False, True, False))
    space = NORMAL_SPACES[node.space]
    if color.lookup is None:
        if color.offset == BLUE and space == NORMAL_TANGENT:
            return None
        raise UnreadError(found)
    return NormalMap(color, strength, space, node.uv_map if space == NORMAL_TANGENT else '')


BLUE = (0.5, 0.5, 1.0)  # the normal itself


def _flipped(color: Texture, axes: tuple[bool, bool, bool]) -> Texture:
    signs = constant(tuple(-1.0 if axis else 1.0 for axis in axes))
    return add(multiply(color, signs), constant(tuple(float(axis) for axis in axes)))
