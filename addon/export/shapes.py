# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh objects to arrays: which mesh each instance shows, where, with which materials and for which rays.

The meshes' own arrays are geometry.py's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..log import Log
from . import bounds, geometry
from .buffers import F32, I32, Instances, Mesh
from .instances import Group
from .layers import Layers
from .materials import MaterialTable, slot_materials

if TYPE_CHECKING:
    from ..sync.kept import Kept


@dataclass(frozen=True, slots=True)
class Shape:
    """A group of instances of a mesh, without their transforms. materials: row of the material of each slot."""

    obj: bpy.types.Object
    data: bpy.types.Mesh
    materials: tuple[int, ...]
    pass_index: int
    visibility: int
    light_group: int
    terminator: float


@dataclass(frozen=True, slots=True)
class Meshes:
    """The distinct meshes of all shapes. index: position in `arrays` by Blender's mesh, -1 where it has no faces."""

    arrays: list[Mesh]
    index: dict[bpy.types.Mesh, int]


def read_shape(
    group: Group, visibility: int, light_group: int, override: bpy.types.Material | None, table: MaterialTable
) -> Shape:
    found = slot_materials(group.obj, group.data, override)
    return Shape(
        obj=group.obj,
        data=group.data,
        materials=tuple(table.index(material) for material in found),
        pass_index=group.obj.pass_index,
        visibility=visibility,
        light_group=light_group,
        terminator=min(max(0.0, group.obj.shadow_terminator_geometry_offset), 1.0),  # 0 for NaN
    )


def read_meshes(shapes: list[Shape], layers: Layers, log: Log, kept: Kept) -> Meshes:
    """Each mesh once, however many objects and instances show it; those that are kept are not read."""
    slot_counts: dict[bpy.types.Mesh, int] = {}
    for shape in shapes:
        slot_counts[shape.data] = max(slot_counts.get(shape.data, 0), len(shape.materials))
    meshes = Meshes([], {})
    for shape in shapes:
        if shape.data in meshes.index:
            continue
        log.checkpoint()
        arrays = _read(shape, slot_counts[shape.data], layers, log, kept)
        meshes.index[shape.data] = len(meshes.arrays) if arrays is not None else -1
        if arrays is not None:
            meshes.arrays.append(arrays)
    return meshes


def instance_arrays(
    shapes: list[Shape], meshes: Meshes, shape_of: I32, transforms: F32, table: MaterialTable, log: Log
) -> tuple[Instances, I32]:
    """One entry for each transform (N, 3, 4), whose shape `shape_of` (N,) tells; what shows nothing is left out.

    Returns with it which of the transforms these are.
    """
    mesh_of = np.array([meshes.index[shape.data] for shape in shapes], np.int32)
    keep = mesh_of[shape_of] >= 0
    for index, text in _unusable(transforms, keep, shape_of):
        log.warning(f'Object "{shapes[index].obj.name}": {text}')
    shape_of = shape_of[keep]

    # A run of slots must reach as far as the mesh's triangles do; the last slot stands for those behind it.
    used = [1 if mesh.slots is None else int(mesh.slots.max()) + 1 for mesh in meshes.arrays]
    bases, counts = np.zeros(len(shapes), np.uint32), np.zeros(len(shapes), np.uint32)
    for index, (shape, mesh) in enumerate(zip(shapes, mesh_of, strict=True)):
        if mesh >= 0:
            run = shape.materials + shape.materials[-1:] * (used[mesh] - len(shape.materials))
            bases[index], counts[index] = table.run(run), len(run)

    def column(values: list, dtype: type) -> NDArray:
        return np.array(values, dtype)[shape_of]

    instances = Instances(
        mesh=mesh_of[shape_of].view(np.uint32),
        transform=np.ascontiguousarray(transforms[keep]),
        material_base=bases[shape_of],
        material_count=counts[shape_of],
        pass_index=column([shape.pass_index for shape in shapes], np.int32),
        visibility=column([shape.visibility for shape in shapes], np.uint32),
        light_group=column([shape.light_group for shape in shapes], np.int32),
        terminator=column([shape.terminator for shape in shapes], np.float32),
        names=tuple(map([shape.obj.name for shape in shapes].__getitem__, shape_of.tolist())),
    )
    return instances, np.flatnonzero(keep).astype(np.int32)


def _read(shape: Shape, slot_count: int, layers: Layers, log: Log, kept: Kept) -> Mesh | None:
    needs = layers.needs[shape.data]
    if not (shape.data.is_editmode and shape.data == shape.obj.data):

        def read() -> Mesh | None:
            return geometry.read_mesh(shape.data, shape.obj, slot_count, layers, needs, log)

        # Blender numbers each evaluation of a mesh anew, where anything of it may have changed.
        number = shape.data.session_uid
        return kept.mesh((number, slot_count, needs.key, layers.key), read, log) if number else read()
    # The arrays of a mesh in edit mode are those from before: ask for a copy of what is being edited.
    copy = shape.obj.to_mesh()
    try:
        return geometry.read_mesh(copy, shape.obj, slot_count, layers, needs, log)
    finally:
        shape.obj.to_mesh_clear()


def _unusable(transforms: F32, keep: NDArray[np.bool_], shape_of: I32) -> list[tuple[int, str]]:
    """Drop from `keep` what no transform can show; returns (shape, reason).

    A scale of 0 along one axis makes a flat object, which can be seen; along two axes nothing is left.
    """
    broken = keep & ~(np.abs(transforms) <= bounds.LARGEST).all(axis=(1, 2))
    keep &= ~broken
    x, y, z = (transforms[:, :, axis] for axis in range(3))
    with np.errstate(all='ignore'):
        singular = np.flatnonzero(keep & (np.einsum('ij,ij->i', x, np.cross(y, z)) == 0.0))
    axes = transforms[singular, :, :3].astype(np.float64)
    areas = [np.linalg.norm(np.cross(axes[:, :, i], axes[:, :, j]), axis=1) for i, j in ((0, 1), (1, 2), (2, 0))]
    vanished = singular[np.max(areas, axis=0) == 0.0]
    keep[vanished] = False
    found = [
        (index, 'its transform holds NaN, infinity or numbers near it: left out')
        for index in sorted(set(shape_of[broken].tolist()))
    ]
    found += [
        (index, 'its scale is zero along two axes: left out') for index in sorted(set(shape_of[vanished].tolist()))
    ]
    return found
