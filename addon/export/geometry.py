# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes to arrays: whole-array reads, one copy each, and repair of what cannot be rendered.

Which meshes there are, and where they stand, is instances.py's.
"""

from __future__ import annotations

import ctypes
from dataclasses import replace

import bpy
import numpy as np
from numpy.typing import NDArray

from .. import native
from ..log import Log
from . import bounds
from .attributes import mesh_attribute, vertex_group
from .buffers import F32, U32, Attribute, Mesh
from .layers import Layers, Needs


def read_mesh(
    mesh: bpy.types.Mesh, obj: bpy.types.Object, slot_count: int, layers: Layers, needs: Needs, log: Log
) -> Mesh | None:
    """The arrays of a mesh, or None where it has no face that can be rendered.

    obj:        the first object that shows it: its name is for messages, and it names the mesh's vertex groups.
    slot_count: slots of the objects that show it; faces with other slot indices take the nearest, as in Blender.
    needs:      what the materials on it read.
    """
    owner = obj.name
    if not mesh.loop_triangles:
        log.info(f'Object "{owner}": mesh "{mesh.name}" has no faces')
        return None
    corner_tris = _view(mesh.loop_triangles, np.uint32, 3)
    corner_vert = _read(mesh.attributes['.corner_vert'].data, 'value', np.int32, 1).view(np.uint32)
    positions = _positions(mesh)
    triangles = corner_vert.take(corner_tris.ravel(), mode='clip').reshape(-1, 3)
    domain, normals = _normals(mesh)
    uv = _uv_layers(mesh, owner, layers, needs, log)
    slots = _slots(mesh, slot_count)
    tangents = _tangents(mesh, owner, positions, triangles, corner_tris, layers, needs, log)
    generated = _generated(mesh) if needs.generated else None
    attributes = _attributes(mesh, obj, layers, needs, log)
    by_corner = domain == 'CORNER' or any(attribute.domain == 'CORNER' for attribute in attributes)
    corners = corner_tris.copy() if uv is not None or tangents is not None or by_corner else None

    # Vertices without a place take their triangles with them.
    if not _within(positions):
        lost = ~(np.abs(positions) <= bounds.LARGEST).all(axis=1)
        keep = ~lost[triangles].any(axis=1)
        log.warning(
            f'Object "{owner}": {lost.sum()} vertices of mesh "{mesh.name}" are at NaN, infinity or near it; '
            f'{(~keep).sum()} triangles that use them are left out'
        )
        positions[lost] = 0.0
        triangles = np.ascontiguousarray(triangles[keep])
        corners = None if corners is None else np.ascontiguousarray(corners[keep])
        slots = None if slots is None else np.ascontiguousarray(slots[keep])
        attributes = tuple(_of_triangles(attribute, keep) for attribute in attributes)
        if not len(triangles):
            return None
    if normals is not None:
        _repair_normals(normals, positions, triangles, corners if domain == 'CORNER' else triangles)
    return Mesh(
        mesh.name,
        positions,
        triangles,
        corners,
        normals,
        domain,
        uv,
        slots,
        tangents=tangents,
        generated=generated,
        attributes=attributes,
    )


def _view(collection: bpy.types.bpy_prop_collection, dtype: type, width: int) -> NDArray:
    """Blender's own array behind a collection that is not empty, (n, width), without a copy: read it at once."""
    count = len(collection) * width
    memory = (ctypes.c_char * (count * np.dtype(dtype).itemsize)).from_address(collection[0].as_pointer())
    return np.frombuffer(memory, dtype).reshape(-1, width)


def _read(collection: bpy.types.bpy_prop_collection, name: str, dtype: type, width: int) -> NDArray:
    flat = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, flat)
    return flat.reshape(-1, width) if width > 1 else flat


def _positions(mesh: bpy.types.Mesh) -> F32:
    """(V, 3), in a buffer that is 4 bytes longer: Embree reads 16 bytes at each vertex."""
    count = len(mesh.vertices) * 3
    padded = np.empty(count + 1, np.float32)
    padded[count] = 0.0
    mesh.attributes['position'].data.foreach_get('vector', padded[:count])
    return padded[:count].reshape(-1, 3)


def _normals(mesh: bpy.types.Mesh) -> tuple[str, F32 | None]:
    domain = mesh.normals_domain
    if domain == 'POINT':
        return domain, _read(mesh.vertex_normals, 'vector', np.float32, 3)
    if domain == 'CORNER':
        return domain, _read(mesh.corner_normals, 'vector', np.float32, 3)
    return 'FACE', None


def _uv_layers(mesh: bpy.types.Mesh, owner: str, layers: Layers, needs: Needs, log: Log) -> F32 | None:
    """The UV maps as far as the last that is needed, one after the other; the active render one even if none is."""
    found = _uv(mesh, '', owner, log)
    last = max((layers.uv_layers.index(name) for name in needs.uv_maps), default=0)
    for name in sorted(needs.uv_maps):
        if _uv_layer(mesh, name) is None:
            shown = f'UV map "{name}"' if name else 'UV map'
            log.warning(f'Object "{owner}": mesh "{mesh.name}" has no {shown}, which its material asks for: 0 is used')
    if last == 0 or found is None:
        return found
    return np.concatenate(
        [found] + [_uv_or_zero(mesh, name, needs, owner, log) for name in layers.uv_layers[1 : last + 1]]
    )


def _within(values: NDArray) -> bool:
    """Whether all of an array that is not empty are numbers and not too large. False for NaN."""
    return bool(values.min() >= -bounds.LARGEST and values.max() <= bounds.LARGEST)


def _uv_or_zero(mesh: bpy.types.Mesh, name: str, needs: Needs, owner: str, log: Log) -> F32:
    uv = _uv(mesh, name, owner, log) if name in needs.uv_maps else None
    return uv if uv is not None else np.zeros((len(mesh.loops), 2), np.float32)


def _uv_layer(mesh: bpy.types.Mesh, name: str) -> bpy.types.MeshUVLoopLayer | None:
    """The UV map of a name, the active render one for ''."""
    if name:
        return mesh.uv_layers.get(name)
    return next((layer for layer in mesh.uv_layers if layer.active_render), None)


def _uv(mesh: bpy.types.Mesh, name: str, owner: str, log: Log) -> F32 | None:
    layer = _uv_layer(mesh, name)
    if layer is None:
        return None
    uv = _read(layer.uv, 'vector', np.float32, 2)
    if not _within(uv):
        log.warning(
            f'Object "{owner}": UV map "{layer.name}" of mesh "{mesh.name}" holds NaN, infinity or numbers near it: '
            f'{bounds.LARGEST:g} is used, and 0 where it is not finite'
        )
        uv[~np.isfinite(uv)] = 0.0
        np.clip(uv, -bounds.LARGEST, bounds.LARGEST, out=uv)
    return uv


def _attributes(
    mesh: bpy.types.Mesh, obj: bpy.types.Object, layers: Layers, needs: Needs, log: Log
) -> tuple[Attribute, ...]:
    """The attributes that its materials ask for; 0 is used for those that it has not."""
    found = []
    for name in sorted(needs.attributes):
        layer = layers.attribute_layers.index(name)
        attribute = mesh_attribute(mesh, layer, name) or vertex_group(mesh, obj, layer, name)
        if attribute is not None:
            found.append(attribute)
        elif name.isprintable():
            log.info(f'Object "{obj.name}": mesh "{mesh.name}" has no attribute "{name}", which its material asks for')
    return tuple(found)


def _of_triangles(attribute: Attribute, keep: NDArray[np.bool_]) -> Attribute:
    """An attribute without the triangles that are left out."""
    if attribute.domain != 'FACE':
        return attribute
    return replace(attribute, values=np.ascontiguousarray(attribute.values[keep]))


def _tangents(
    mesh: bpy.types.Mesh,
    owner: str,
    positions: F32,
    triangles: U32,
    corners: U32,
    layers: Layers,
    needs: Needs,
    log: Log,
) -> F32 | None:
    """The tangents of the UV maps that normal maps use, as far as the last that is needed."""
    names = [layers.uv_layers[index] for index in layers.tangent_layers]
    last = max((names.index(name) for name in needs.tangents), default=-1)
    if last < 0:
        return None
    normals = _read(mesh.corner_normals, 'vector', np.float32, 3)
    # Normals and places that are no numbers spoil the tangents beside them only.
    normals[~np.isfinite(normals)] = 0.0
    found = []
    for name in names[: last + 1]:
        uv = _uv(mesh, name, owner, log) if name in needs.tangents else None
        if uv is None:
            found.append(np.zeros((len(mesh.loops), 4), np.float32))
        else:
            at = np.where(np.abs(positions) <= bounds.LARGEST, positions, np.float32(0.0))
            found.append(native.load().corner_tangents(at, normals, uv, triangles, corners))
    return np.concatenate(found)


def _generated(mesh: bpy.types.Mesh) -> F32:
    """The place of each vertex before deformation within the texture space, 0 to 1 where it is the bounding box.

    Blender keeps places from before deformation for renders only; the viewport shows those after it.
    """
    places = _read(mesh.vertices, 'undeformed_co', np.float32, 3)
    center = np.array(mesh.texspace_location, np.float32)
    size = np.array(mesh.texspace_size, np.float32)
    halves = np.divide(np.float32(0.5), size, out=np.zeros(3, np.float32), where=size != 0.0)
    with np.errstate(all='ignore'):
        found = np.nan_to_num((places - center) * halves + np.float32(0.5))
    return found.clip(-bounds.LARGEST, bounds.LARGEST)


def _slots(mesh: bpy.types.Mesh, slot_count: int) -> U32 | None:
    """The material slot of each triangle, or None where all are the first."""
    attribute = mesh.attributes.get('material_index')
    if attribute is None or slot_count < 2 or attribute.domain != 'FACE' or attribute.data_type != 'INT':
        return None
    of_face = _read(attribute.data, 'value', np.int32, 1).clip(0, slot_count - 1)
    if not of_face.any():
        return None
    face = _read(mesh.loop_triangle_polygons, 'value', np.int32, 1)
    return of_face.view(np.uint32).take(face, mode='clip')


def _repair_normals(normals: F32, positions: F32, triangles: U32, entries: U32) -> None:
    """Give normals that are no directions the direction of the triangles at them.

    Vertices of zero-area faces have none, and neighbours of vertices at NaN get NaN.
    entries: (T, 3) which normal each corner of each triangle uses.
    """
    if native.load().are_directions(normals):
        return
    squares = np.einsum('ij,ij->i', normals, normals)
    bad = ~((squares > 0.5) & (squares < 2.0))
    at = bad[entries]
    affected = np.flatnonzero(at.any(axis=1))
    a, b, c = (positions[triangles[affected, k]].astype(np.float64) for k in range(3))
    area_normals = np.cross(b - a, c - a)
    sums = np.zeros(normals.shape, np.float64)
    for k in range(3):
        np.add.at(sums, entries[affected, k], area_normals)
    lengths = np.linalg.norm(sums[bad], axis=1, keepdims=True)
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(lengths), 3))
    normals[bad] = np.where(lengths > 0.0, sums[bad] / np.where(lengths > 0.0, lengths, 1.0), up)
