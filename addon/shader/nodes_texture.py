# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes: their coordinates, their own mapping, and how their outputs come from ops.

What a texture computes is in the kernels; how images are loaded is told in export/images.py.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

from ..export.buffers import EXTENSION_REPEAT, INTERPOLATION_CLOSEST, INTERPOLATION_CUBIC, INTERPOLATION_LINEAR
from . import ies, tables
from .nodes_input import NORMAL_TO_OBJECT, affine, generated, object_normal, uv
from .reader import TRUNCATE, Node, value
from .tree import COMPARE, MULTIPLY, VECTOR_NORMALIZE, VECTOR_SUBTRACT, Ref

INTERPOLATIONS = {
    'Closest': INTERPOLATION_CLOSEST,
    'Linear': INTERPOLATION_LINEAR,
    'Cubic': INTERPOLATION_CUBIC,
    'Smart': INTERPOLATION_CUBIC,
}
UNASSOCIATE = 64

FIRST_TILE = 1001  # of UDIM

# More numbers of operations of the node Math.
ROUND, LESS, GREATER, MULTIPLY_ADD = 14, 15, 16, 36

# What Cycles shows where an image cannot be read; its alpha is 1.
MISSING_IMAGE = (1.0, 0.0, 1.0)

# NOISE_* of kernels/program/noise_fractal.h.
NOISE_TYPES = ('MULTIFRACTAL', 'RIDGED_MULTIFRACTAL', 'HYBRID_MULTIFRACTAL', 'FBM', 'HETERO_TERRAIN')

SMALLEST_SCALE = 1e-5  # of a node's own mapping, which Cycles keeps invertible


# ---- Coordinates.


def coordinates(node: Node, default: str = 'generated') -> Ref:
    """The Vector of a texture through the node's own mapping; `default`: what it stands for where nothing is linked."""
    vector = node.linked('Vector')
    if vector is None:
        match default:
            case 'uv':
                vector = uv(node)
            case 'position':
                vector = node.at_point('position')
            case 'incoming':
                vector = node.emit('incoming')
            case _:
                vector = generated(node)
    return _mapped(node, vector)


def _mapped(node: Node, vector: Ref) -> Ref:
    """The node's own mapping, which is older than the node Mapping and hidden in scripts and old files."""
    mappings = node.reader.mappings
    if node.node not in mappings:
        mappings[node.node] = _own_mapping(node)
    matrix = mappings[node.node]
    if matrix is None:
        return vector
    vector = affine(node, vector, matrix)
    if node.node.texture_mapping.vector_type != 'NORMAL':
        return vector
    zero = node.constant(0.0)
    return node.emit('vector_math_v', vector, zero, zero, zero, mode=VECTOR_NORMALIZE)


def _own_mapping(node: Node) -> np.ndarray | None:
    """The matrix of the node's own mapping, None where it changes nothing."""
    own = node.node.texture_mapping
    location, rotation, scale = own.translation[:], own.rotation[:], own.scale[:]
    axes = (own.mapping_x, own.mapping_y, own.mapping_z)
    if location == (0.0, 0.0, 0.0) == rotation and scale == (1.0, 1.0, 1.0) and axes == ('X', 'Y', 'Z'):
        return None
    matrix = mapping_matrix(own.vector_type, location, rotation, scale, axes)
    if not np.isfinite(matrix).all():
        node.warn('its own texture mapping is not finite: left out')
        return None
    return matrix


def mapping_matrix(kind: str, location: tuple, rotation: tuple, scale: tuple, axes: tuple[str, str, str]) -> np.ndarray:
    """The (3, 4) matrix of a texture mapping, as Cycles makes it: choice of axes, scale, rotation, translation."""
    choice = np.zeros((4, 4))
    choice[3, 3] = 1.0
    for row, axis in enumerate(axes):
        if axis != 'NONE':
            choice['XYZ'.index(axis), row] = 1.0
    if kind in ('TEXTURE', 'NORMAL'):
        scale = tuple(part if abs(part) >= SMALLEST_SCALE else math.copysign(SMALLEST_SCALE, part) for part in scale)
    scaling = np.diag((*scale, 1.0))
    turning = np.eye(4)
    turning[:3, :3] = np.array(Euler(rotation, 'XYZ').to_matrix()) if np.isfinite(rotation).all() else np.nan
    moving = np.eye(4)
    moving[:3, 3] = location
    match kind:
        case 'TEXTURE':
            matrix = np.linalg.inv(moving @ turning @ scaling)
        case 'POINT':
            matrix = moving @ turning @ scaling
        case 'VECTOR':
            matrix = turning @ scaling
        case _:
            matrix = np.linalg.inv(turning @ scaling).T
    return (matrix @ choice)[:3]


# ---- Procedural textures.


@value('ShaderNodeTexNoise')
def _noise(node: Node, output: str) -> Ref:
    own = node.node
    mode = node.enum('noise_dimensions') - 1 | NOISE_TYPES.index(own.noise_type) << 2 | own.normalize << 5
    names = ('Scale', 'Detail', 'Roughness', 'Lacunarity', 'Offset', 'Gain', 'Distortion')
    numbers = [*map(node.used, names)]
    op = 'noise_v' if output == 'Color' else 'noise_f'
    return node.emit(op, _space(node), node.used('W'), *numbers, mode=mode)


VORONOI_OUTPUTS = {'Distance': 0, 'W': 1, 'Radius': 2, 'Color': 0, 'Position': 1}


@value('ShaderNodeTexVoronoi')
def _voronoi(node: Node, output: str) -> Ref:
    own = node.node
    mode = node.enum('voronoi_dimensions') - 1 | node.enum('feature') << 2 | node.enum('distance') << 5
    mode |= VORONOI_OUTPUTS[output] << 8 | own.normalize << 11
    names = ('Scale', 'Detail', 'Roughness', 'Lacunarity', 'Smoothness', 'Exponent', 'Randomness')
    numbers = [*map(node.used, names)]
    op = 'voronoi_v' if output in ('Color', 'Position') else 'voronoi_f'
    return node.emit(op, _space(node), node.used('W'), *numbers, mode=mode)


@value('ShaderNodeTexWhiteNoise')
def _white_noise(node: Node, output: str) -> Ref:
    op = 'white_noise_v' if output == 'Color' else 'white_noise_f'
    vector = node.used('Vector', True)
    return node.emit(op, vector, node.used('W'), mode=node.enum('noise_dimensions') - 1)


def _space(node: Node) -> Ref:
    """Coordinates, or 0 where there are none in one dimension."""
    return coordinates(node) if node.has('Vector') else node.constant(0.0)


@value('ShaderNodeTexWave')
def _wave(node: Node, output: str) -> Ref:
    mode = node.enum('wave_type') | node.enum('bands_direction') << 1 | node.enum('rings_direction') << 3
    names = ('Scale', 'Distortion', 'Detail', 'Detail Scale', 'Detail Roughness', 'Phase Offset')
    shown = node.emit('wave_f', coordinates(node), *map(node.f, names), mode=mode | node.enum('wave_profile') << 5)
    return node.builder.splat(shown) if output == 'Color' else shown


@value('ShaderNodeTexMagic')
def _magic(node: Node, output: str) -> Ref:
    args = (coordinates(node), node.f('Scale'), node.f('Distortion'))
    shown = node.emit('magic_v', *args, mode=node.node.turbulence_depth)
    return shown if output == 'Color' else node.reader.average(shown)


@value('ShaderNodeTexGradient')
def _gradient(node: Node, output: str) -> Ref:
    shown = node.emit('gradient_f', coordinates(node), mode=node.enum('gradient_type'))
    return node.builder.splat(shown) if output == 'Color' else shown


@value('ShaderNodeTexChecker')
def _checker(node: Node, output: str) -> Ref:
    first = node.emit('checker_f', coordinates(node), node.f('Scale'))
    return node.emit('mix_color', first, node.v('Color2'), node.v('Color1')) if output == 'Color' else first


@value('ShaderNodeTexBrick')
def _brick(node: Node, output: str) -> Ref:
    own = node.node
    names = ('Scale', 'Mortar Size', 'Mortar Smooth', 'Bias', 'Brick Width', 'Row Height')
    numbers = [*map(node.f, names), node.constant(own.offset), node.constant(own.squash)]
    shown = node.emit('brick_f', coordinates(node), *numbers, mode=own.offset_frequency | own.squash_frequency << 8)
    mortar = node.emit('component', shown, mode=0)
    if output != 'Color':
        return mortar
    tint = node.emit('component', shown, mode=1)
    brick = node.emit('mix_color', tint, node.v('Color1'), node.v('Color2'))
    return node.emit('mix_color', mortar, brick, node.v('Mortar'))


GABOR_OUTPUTS = ('Value', 'Phase', 'Intensity')


@value('ShaderNodeTexGabor')
def _gabor(node: Node, output: str) -> Ref:
    mode = node.enum('gabor_type') | GABOR_OUTPUTS.index(output) << 1
    numbers = [node.f('Scale'), node.f('Frequency'), node.f('Anisotropy'), node.used('Orientation 2D')]
    direction = node.used('Orientation 3D', True)
    return node.emit('gabor_f', coordinates(node), *numbers, direction, mode=mode)


# ---- Images.


@value('ShaderNodeTexImage')
def _image(node: Node, output: str) -> Ref:
    own = node.node
    if own.image is not None and own.image.source == 'TILED' and own.projection == 'FLAT':
        return _tiled(node, output)
    loaded = _loaded(node)
    if loaded is None:
        return node.constant(1.0) if output == 'Alpha' else node.constant(MISSING_IMAGE)
    return _looked_up(node, output, coordinates(node, 'uv'), node.constant(float(loaded.index)), loaded.associated)


def _looked_up(node: Node, output: str, vector: Ref, image: Ref, is_associated: bool) -> Ref:
    own = node.node
    mode = INTERPOLATIONS[own.interpolation] | node.enum('extension') << 2 | node.enum('projection') << 4
    # Cycles divides by alpha only where the node's Alpha is used as well.
    if is_associated and own.outputs['Alpha'].is_linked:
        mode |= UNASSOCIATE
    is_box = own.projection == 'BOX'
    blend = node.constant(own.projection_blend if is_box else 0.0)
    normal = object_normal(node) if is_box else node.constant(0.0)
    return node.emit('image_f' if output == 'Alpha' else 'image_v', vector, image, blend, normal, mode=mode)


def _tiled(node: Node, output: str) -> Ref:
    """UDIM tiles, ten in a row: a table tells the image of each; coordinates are cut towards 0, as in Cycles."""
    builder, images = node.builder, node.reader.scene.images
    zero, half, last = node.constant(0.0), node.constant(-0.5), node.constant(float(tables.SIZE - 1))
    table = np.full(tables.SIZE, images.missing(), np.float32)
    is_associated = False
    for tile in node.node.image.tiles:
        loaded = images.load(node.node.image, node.node.image_user, tile.number)
        if not 0 <= tile.number - FIRST_TILE < tables.SIZE - 1:
            node.warn(f'tile {tile.number} is out of the range that is supported')
        elif isinstance(loaded, str):
            node.warn(f'tile {tile.number}: {loaded}')
        else:
            table[tile.number - FIRST_TILE] = loaded.index
            is_associated |= loaded.associated
    vector = coordinates(node, 'uv')
    cut = [builder.math(TRUNCATE, node.emit('component', vector, mode=axis), zero) for axis in range(2)]
    tile = node.emit('math', cut[1], node.constant(10.0), cut[0], mode=MULTIPLY_ADD)
    # The last entry is what lies outside.
    right = builder.math(GREATER, cut[0], half)
    left = builder.math(LESS, cut[0], node.constant(9.5))
    inside = builder.math(MULTIPLY, builder.math(MULTIPLY, left, right), builder.math(GREATER, cut[1], half))
    tile = node.emit('mix_f', inside, last, tile)
    image = node.emit('curve_f', tile, builder.table(table), zero, last, node.constant(1.0))
    image = builder.math(ROUND, image, zero)
    corner = node.emit('combine', cut[0], cut[1], zero)
    vector = node.emit('vector_math_v', vector, corner, zero, zero, mode=VECTOR_SUBTRACT)
    shown = _looked_up(node, output, vector, image, is_associated)
    if node.node.extension != 'CLIP':
        return shown
    # What stands for tiles that are not there has an edge, which is not to be seen.
    missing = node.emit('math', image, node.constant(float(images.missing())), node.constant(0.5), mode=COMPARE)
    if output == 'Alpha':
        return node.emit('mix_f', missing, shown, node.constant(1.0))
    return node.emit('mix_v', builder.splat(missing), shown, node.constant(MISSING_IMAGE))


@value('ShaderNodeTexEnvironment')
def _environment(node: Node, output: str) -> Ref:
    loaded = _loaded(node)
    if loaded is None:
        return node.constant(MISSING_IMAGE)
    mode = INTERPOLATIONS[node.node.interpolation] | EXTENSION_REPEAT << 2 | node.enum('projection') << 4
    return node.emit('environment_v', coordinates(node, 'position'), node.constant(float(loaded.index)), mode=mode)


def _loaded(node: Node) -> object | None:
    """The image of a node in the table; None, with a message, where it cannot be read."""
    own: bpy.types.ShaderNodeTexImage = node.node
    loaded = node.reader.scene.images.load(own.image, own.image_user)
    if isinstance(loaded, str):
        node.warn(loaded)
        return None
    return loaded


@value('ShaderNodeTexIES')
def _ies(node: Node, output: str) -> Ref:
    """A measured luminaire; where none can be read, 100, as in Cycles."""
    strength = node.f('Strength')
    try:
        light = ies.read(_ies_text(node.node))
    except ies.IesError as error:
        node.warn(f'{error}: 100 is used')
        return node.builder.math(MULTIPLY, strength, node.constant(100.0))
    if node.is_fed('Vector'):
        direction = node.v('Vector')
    else:  # toward the point that is lit, in the light's own space
        direction = node.emit('object_transform', node.emit('incoming'), mode=NORMAL_TO_OBJECT)
    sizes = (node.constant(float(size)) for size in (light.horizontal, light.vertical))
    found = node.emit('ies_f', direction, node.builder.table(light.table), *sizes)
    return node.builder.math(MULTIPLY, strength, found)


def _ies_text(own: bpy.types.ShaderNodeTexIES) -> str:
    if own.mode == 'INTERNAL':
        if own.ies is None:
            raise ies.IesError('it has no text')
        return own.ies.as_string()
    path = bpy.path.abspath(own.filepath, library=own.id_data.library)
    if not own.filepath:
        raise ies.IesError('it has no file')
    try:
        return Path(path).read_text(encoding='latin-1')
    except OSError as error:
        raise ies.IesError(f'"{path}" cannot be read: {error.strerror}') from error
