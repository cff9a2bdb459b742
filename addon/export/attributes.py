# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders look up by name: attributes of meshes, properties of objects and view layers, and what Cycles derives.

A layer is known by a name: an attribute's or UV map's own ('' = the active render UV map), or one made here, which
begins with a character that no name of Blender's has.
"""

from __future__ import annotations

import re

import bpy
import numpy as np
from numpy.typing import NDArray

from .buffers import F32, I32, U32, Attribute

POINTINESS = '\x01pointiness'
RANDOM_PER_ISLAND = '\x01random_per_island'
ACTIVE_COLOR = '\x01active_color'
INSTANCER_UV = '\x01instancer_uv'
INSTANCER_GENERATED = '\x01instancer_generated'
# Of the particle that made the instance, four numbers each: index, random, age, lifetime; location, size; velocity;
# angular velocity.
PARTICLE_NUMBERS = '\x01particle_numbers'
PARTICLE_PLACE = '\x01particle_place'
PARTICLE_VELOCITY = '\x01particle_velocity'
PARTICLE_SPIN = '\x01particle_spin'
PARTICLE_LAYERS = (PARTICLE_NUMBERS, PARTICLE_PLACE, PARTICLE_VELOCITY, PARTICLE_SPIN)
OBJECT_PREFIX = '\x01object:'
INSTANCER_PREFIX = '\x01instancer:'

# Names by which the node Attribute finds what Cycles derives, and the active render UV map.
STANDARD = {'uv': '', 'pointiness': POINTINESS, 'random_per_island': RANDOM_PER_ISLAND}

# Types of attributes that Cycles reads: their property, its type and number of components.
TYPES: dict[str, tuple[str, type, int]] = {
    'FLOAT': ('value', np.float32, 1),
    'INT': ('value', np.int32, 1),
    'INT8': ('value', np.int32, 1),
    'BOOLEAN': ('value', bool, 1),
    'FLOAT2': ('vector', np.float32, 2),
    'FLOAT_VECTOR': ('vector', np.float32, 3),
    'FLOAT_COLOR': ('color', np.float32, 4),
    'BYTE_COLOR': ('color', np.float32, 4),  # linear already
    'QUATERNION': ('value', np.float32, 4),
}
OF_INSTANCERS = frozenset((INSTANCER_UV, INSTANCER_GENERATED, *PARTICLE_LAYERS))
DOMAINS = ('POINT', 'EDGE', 'CORNER', 'FACE')

Rgba = tuple[float, float, float, float]
NOTHING: Rgba = (0.0, 0.0, 0.0, 0.0)


def object_layer(name: str) -> str:
    """A property of the object, or of its data."""
    return OBJECT_PREFIX + name


def instancer_layer(name: str) -> str:
    """A property of what made the instance."""
    return INSTANCER_PREFIX + name


def is_of_instance(layer: str) -> bool:
    """Whether a layer has one value for each instance; others belong to meshes."""
    return layer.startswith((OBJECT_PREFIX, INSTANCER_PREFIX)) or layer in OF_INSTANCERS


# ---- Properties.


def property_value(owner: object, name: str) -> Rgba | None:
    """A custom property or another one of a Blender object as four numbers; None where there is none such."""
    if owner is None or not name:
        return None
    value = None
    escaped = name.replace('\\', '\\\\').replace('"', '\\"')
    # One number of several has no path to Cycles.
    for path in (f'["{escaped}"]', *([] if re.search(r'\[\d+\]$', name) else [name])):
        try:
            value = owner.path_resolve(path)
        except ValueError:
            continue
        break
    if isinstance(value, (int, float)):
        return (float(value),) * 3 + (1.0,)
    if value is None or isinstance(value, str) or not 0 < getattr(value, '__len__', lambda: 0)() <= 4:
        return None
    try:
        parts = [float(part) for part in value]
    except (TypeError, ValueError):
        return None
    return tuple((parts + [0.0, 0.0, 0.0, 1.0][len(parts) :])[:4])


def first_value(owners: tuple, name: str) -> Rgba:
    """The first of several owners' that has such a property; 0 where none has."""
    for owner in owners:
        found = property_value(owner, name)
        if found is not None:
            return found if np.isfinite(found).all() else NOTHING
    return NOTHING


def view_layer_value(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, name: str) -> Rgba:
    return first_value((view_layer, scene, scene.world, scene.camera), name)


def instance_value(layer: str, obj: bpy.types.Object, parent: bpy.types.Object) -> Rgba:
    """The value of a layer that has one for each instance; what stands on its own is its own instancer."""
    if layer.startswith(OBJECT_PREFIX):
        name = layer.removeprefix(OBJECT_PREFIX)
        if name == 'color':  # which Blender gives an instance from what made it
            return first_value((parent,), name)
        return first_value((obj, obj.data), name)
    return first_value((parent, obj, obj.data), layer.removeprefix(INSTANCER_PREFIX))


# ---- Meshes.


def mesh_attribute(mesh: bpy.types.Mesh, layer: int, name: str) -> Attribute | None:
    """A layer of a mesh; None where it has none of that name."""
    if name == POINTINESS:
        return Attribute(layer, 'POINT', 1, _widened(pointiness(mesh)[:, None]))
    if name == RANDOM_PER_ISLAND:
        return Attribute(layer, 'FACE', 1, _widened(random_per_island(mesh)[:, None]))
    if name == ACTIVE_COLOR:
        index = mesh.color_attributes.render_color_index
        found = mesh.color_attributes[index] if 0 <= index < len(mesh.color_attributes) else None
    else:
        found = mesh.attributes.get(name)
    values = None if found is None or found.domain not in DOMAINS else _own_values(found)
    if values is None:
        return None
    domain, width = found.domain, values.shape[1]
    if domain == 'FACE':
        values = values.take(_faces(mesh), axis=0, mode='clip')
    elif domain == 'EDGE':
        domain, values = 'POINT', _at_vertices(mesh, found, values)
    return Attribute(layer, domain, width, _widened(values))


def vertex_group(mesh: bpy.types.Mesh, obj: bpy.types.Object, layer: int, name: str) -> Attribute | None:
    """A vertex group of an object as a layer of its mesh: to Cycles its weights are an attribute of that name.

    Blender has no way to read the weights of all vertices at once: a million take a second.
    """
    group = obj.vertex_groups.get(name)
    if group is None:
        return None
    index = group.index
    weights = np.zeros((len(mesh.vertices), 1), np.float32)
    for vertex in mesh.vertices:
        for member in vertex.groups:
            if member.group == index:
                weights[vertex.index] = member.weight
    return Attribute(layer, 'POINT', 1, _widened(weights))


def attribute_values(found: bpy.types.Attribute) -> F32 | None:
    """All values of an attribute as four numbers each; None where it has none that shaders can read."""
    values = _own_values(found)
    return None if values is None else _widened(values)


def _own_values(found: bpy.types.Attribute) -> F32 | None:
    """(n, width): as many numbers each as its type has."""
    if found.data_type not in TYPES or not len(found.data):
        return None
    member, dtype, width = TYPES[found.data_type]
    values = np.empty(len(found.data) * width, dtype)
    found.data.foreach_get(member, values)
    return np.nan_to_num(values.astype(np.float32).reshape(-1, width), posinf=0.0, neginf=0.0)


def _at_vertices(mesh: bpy.types.Mesh, found: bpy.types.Attribute, values: F32) -> F32:
    """The mean of the edges at each vertex, as Cycles reads attributes of edges.

    As Blender mixes their type: a boolean is set where any edge's is, integers are rounded, colours of bytes are mixed
    as bytes and rounded down.
    """
    kind = found.data_type
    if kind == 'BYTE_COLOR':
        found.data.foreach_get('color_srgb', values.ravel())
    ends = _edges(mesh).ravel()
    count = np.maximum(np.bincount(ends, minlength=len(mesh.vertices)), 1)
    both = np.repeat(values, 2, axis=0)
    sums = [np.bincount(ends, column, len(mesh.vertices)) for column in both.T]
    means = np.stack(sums, axis=1) / count[:, None]
    if kind == 'BOOLEAN':
        means = np.ceil(means)
    elif kind in ('INT', 'INT8'):
        means = np.floor(means + 0.5)
    elif kind == 'BYTE_COLOR':
        means = np.floor(means * 255.0 + 1e-3) / 255.0
        colors = means[:, :3]
        means[:, :3] = np.where(colors < 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return means.astype(np.float32)


def _faces(mesh: bpy.types.Mesh) -> I32:
    """The face of each triangle."""
    faces = np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangle_polygons.foreach_get('value', faces)
    return faces


def _widened(values: F32) -> F32:
    """To four components: a number is grey, what is missing of a vector is 0, alpha is 1."""
    count, width = values.shape
    if width == 4:
        return np.ascontiguousarray(values)
    wide = np.zeros((count, 4), np.float32)
    wide[:, : 3 if width == 1 else width] = values
    wide[:, 3] = 1.0
    return wide


def pointiness(mesh: bpy.types.Mesh) -> F32:
    """How far each vertex sticks out, (V,): 0.5 where it is flat, as Cycles computes it.

    The angle between a vertex' normal and the mean direction of its edges, over pi, averaged with its neighbours';
    vertices in one place count as one.
    """
    count = len(mesh.vertices)
    positions, normals = np.empty(count * 3, np.float32), np.empty(count * 3, np.float32)
    mesh.attributes['position'].data.foreach_get('vector', positions)
    mesh.vertex_normals.foreach_get('vector', normals)
    places, index = np.unique(positions.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.ravel()
    welded = np.zeros((len(places), 3))
    np.add.at(welded, index, np.nan_to_num(normals.reshape(-1, 3)))
    welded = _unit(welded)

    edges = np.sort(index[_edges(mesh)], axis=1)
    edges = np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)
    first, second = edges[:, 0], edges[:, 1]
    degree = np.bincount(edges.ravel(), minlength=len(places))
    along = _unit(np.nan_to_num(places[second].astype(np.float64) - places[first]))
    mean = np.zeros((len(places), 3))
    np.add.at(mean, first, along)
    np.add.at(mean, second, -along)
    mean /= np.maximum(degree, 1)[:, None]
    angle = np.arccos(np.clip(np.einsum('ij,ij->i', welded, mean), -1.0, 1.0)) / np.pi
    raw = np.where(degree > 0, angle, 0.0)
    blurred = raw.copy()
    np.add.at(blurred, first, raw[second])
    np.add.at(blurred, second, raw[first])
    return (blurred / (degree + 1))[index].astype(np.float32)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)


def _edges(mesh: bpy.types.Mesh) -> I32:
    edges = np.empty(len(mesh.edges) * 2, np.int32)
    mesh.edges.foreach_get('vertices', edges)
    return edges.reshape(-1, 2)


def random_per_island(mesh: bpy.types.Mesh) -> F32:
    """A random number of each triangle's island, (T,): the hash of the vertex that stands for it, as in Cycles.

    Which vertex that is follows from the order of edges: islands are joined by rank.
    """
    parents = list(range(len(mesh.vertices)))
    ranks = [0] * len(parents)

    def root(vertex: int) -> int:
        while parents[vertex] != vertex:
            parents[vertex] = vertex = parents[parents[vertex]]
        return vertex

    for start, end in _edges(mesh).tolist():
        a, b = root(start), root(end)
        if a == b:
            continue
        if ranks[a] < ranks[b]:
            a, b = b, a
        parents[b] = a
        if ranks[a] == ranks[b]:
            ranks[a] += 1
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.attributes['.corner_vert'].data.foreach_get('value', vertices)
    firsts = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get('loops', firsts)
    roots = [root(vertex) for vertex in vertices[firsts[::3]].tolist()]
    return unit_hash(np.array(roots, np.uint32))


def object_random(name: str) -> int:
    """The random number of an object that stands on its own, 0 to 2^32 - 1: a hash of its name, as in Cycles."""
    total = 0
    for byte in name.encode():
        total = (total * 37 + byte) & 0xFFFFFFFF
    return int(hashed(np.array([total], np.uint32), 0)[0])


def unit_hash(values: U32, second: int | None = None) -> F32:
    """The hash of one or two numbers, as one from 0 to 1."""
    return (hashed(values, second) / np.float64(0xFFFFFFFF)).astype(np.float32)


def hashed(values: U32, second: int | None = None) -> U32:
    """Jenkins' hash (lookup3) of one or two numbers."""
    words = 1 if second is None else 2
    start = np.uint32((0xDEADBEEF + (words << 2) + 13) & 0xFFFFFFFF)
    a, b, c = start + values, np.full_like(values, start), np.full_like(values, start)
    if second is not None:
        b = b + np.uint32(second)

    def turned(x: U32, bits: int) -> U32:
        return (x << np.uint32(bits)) | (x >> np.uint32(32 - bits))

    c = (c ^ b) - turned(b, 14)
    a = (a ^ c) - turned(c, 11)
    b = (b ^ a) - turned(a, 25)
    c = (c ^ b) - turned(b, 16)
    a = (a ^ c) - turned(c, 4)
    b = (b ^ a) - turned(a, 14)
    c = (c ^ b) - turned(b, 24)
    return c
