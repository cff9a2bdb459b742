# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of fuzzed scenes: meshes in and out of order, curves, text and what is not rendered; modifiers, instances."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from scenes import build

Description = dict[str, Any]
CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
CUBE_FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
QUAD_FACE = [(0, 1, 2, 3)]


def apply(owner: Any, settings: Description | None) -> None:
    """Sets what Blender takes of it; the rest stays as it was."""
    for name, value in (settings or {}).items():
        try:
            setattr(owner, name, value)
        except (AttributeError, TypeError, ValueError, OverflowError):
            continue


def place(thing: bpy.types.Object, wanted: Description) -> None:
    for name in ('location', 'rotation_euler', 'scale'):
        if name in wanted:
            setattr(thing, name, wanted[name])
    if 'matrix_parent_inverse' in wanted and thing.parent is not None:
        rows = wanted['matrix_parent_inverse']
        thing.matrix_parent_inverse = Matrix([rows[4 * row : 4 * row + 4] for row in range(4)])


def add(scene: bpy.types.Scene, name: str, wanted: Description, materials: list[bpy.types.Material | None]) -> None:
    """An object as descriptions.objects tells of it."""
    kind = wanted['mesh']['kind']
    data = other(kind) if kind.isupper() else mesh(wanted['mesh'])
    thing = build.link(scene, name, data)
    place(thing, wanted['place'])
    if hasattr(data, 'materials'):
        for material in materials:
            data.materials.append(material)
    if kind == 'many':
        for _ in range(300):
            data.materials.append(materials[0] if materials else None)
    apply(thing, wanted.get('settings'))
    for modifier in wanted.get('modifiers', ()):
        made = thing.modifiers.new('', modifier['kind'])
        if made is not None:  # not for this kind of object
            apply(made, modifier['settings'])
    if 'instances' in wanted:
        instances(scene, thing, wanted['instances'])


def instances(scene: bpy.types.Scene, thing: bpy.types.Object, wanted: Description) -> None:
    points = np.array(wanted['points'], np.float64).astype(np.float32)
    if wanted['kind'] == 'collection':
        parent = build.collection_instance(scene, 'Instances', [thing])
    else:
        parent = build.vertex_instances(scene, thing, points)
        if wanted['kind'] == 'faces':
            parent.instance_type = 'FACES'
            parent.use_instance_faces_scale = True
            parent.data.clear_geometry()
            parent.data.from_pydata([*points, *points, *points], [], [(i, i + 1, i + 2) for i in range(len(points))])
    place(parent, wanted['place'])


def mesh(wanted: Description) -> bpy.types.Mesh:
    made = shape(wanted)
    if wanted.get('smooth') and len(made.polygons):
        made.shade_smooth()
    if wanted.get('slots') is not None:
        for index, face in enumerate(made.polygons):
            face.material_index = max(min(wanted['slots'] * (index % 2), 32767), 0)
        if len(made.polygons):
            values = np.full(len(made.polygons), wanted['slots'], np.int32)
            attribute = made.attributes.get('material_index') or made.attributes.new('material_index', 'INT', 'FACE')
            attribute.data.foreach_set('value', values)
    if wanted.get('uv') is not None and len(made.loops):
        made.uv_layers.new(name='UVMap').uv.foreach_set('vector', np.resize(wild(wanted['uv']), 2 * len(made.loops)))
    if wanted.get('paint') is not None and len(made.vertices):
        paint = made.color_attributes.new('Paint', 'FLOAT_COLOR', 'POINT')
        paint.data.foreach_set('color', np.resize(wild(wanted['paint']), 4 * len(made.vertices)))
    if wanted.get('normals') is not None and len(made.loops):
        made.normals_split_custom_set([wanted['normals']] * len(made.loops))
    return made


def wild(values: list[float]) -> np.ndarray:
    with np.errstate(over='ignore'):
        return np.array(values, np.float64).astype(np.float32)


def shape(wanted: Description) -> bpy.types.Mesh:
    match wanted['kind']:
        case 'own':
            count = len(wanted['vertices'])
            faces = [face for face in (distinct(face, count) for face in wanted['faces']) if len(face) > 2]
            return build.mesh('Own', wanted['vertices'], faces)
        case 'quad':
            return build.mesh('Quad', [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], QUAD_FACE)
        case 'sphere':
            return sphere(12, 8)
        case 'line':
            return build.mesh('Line', [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])
        case 'point':
            return build.mesh('Point', [(0, 0, 0)] * 3, [(0, 1, 2)])
        case 'loose':
            made = bpy.data.meshes.new('Loose')
            made.from_pydata(CUBE, [(0, 1), (2, 3)], [(0, 1, 3)])
            return made
        case 'empty':
            return build.mesh('Empty', [], [])
        case 'many':
            return build.grid(24)
        case kind:
            factor = {'cube': 1.0, 'huge': 1e18, 'tiny': 1e-18, 'far': 1.0}[kind]
            moved = 1e7 if kind == 'far' else 0.0
            return build.mesh('Cube', [tuple(factor * c + moved for c in corner) for corner in CUBE], CUBE_FACES)


def distinct(face: list[int], count: int) -> list[int]:
    return list(dict.fromkeys(index % count for index in face))


def sphere(segments: int, rings: int) -> bpy.types.Mesh:
    theta = np.pi * np.arange(rings + 1) / rings
    phi = 2.0 * np.pi * np.arange(segments) / segments
    points = [(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)) for t in theta for p in phi]
    first = [(r * segments, s, (s + 1) % segments) for r in range(rings) for s in range(segments)]
    faces = [(r + s, r + segments + s, r + segments + n, r + n) for r, s, n in first]
    return build.mesh('Sphere', points, faces)


def other(kind: str) -> bpy.types.ID | None:
    """What Blender makes meshes of, and what is no mesh."""
    match kind:
        case 'CURVE':
            made = bpy.data.curves.new('Curve', 'CURVE')
            made.dimensions, made.bevel_depth, made.resolution_u = '3D', 0.2, 2
            spline = made.splines.new('BEZIER')
            spline.bezier_points.add(2)
            for index, point in enumerate(spline.bezier_points):
                point.co = (index, 0.5 * index * index, 0.0)
            return made
        case 'FONT':
            made = bpy.data.curves.new('Text', 'FONT')
            made.body = 'Ab'
            return made
        case 'META':
            made = bpy.data.metaballs.new('Ball')
            made.resolution = made.render_resolution = 0.6
            made.elements.new()
            return made
        case 'SURFACE':
            made = bpy.data.curves.new('Surface', 'SURFACE')
            made.splines.new('NURBS').points.add(3)
            return made
        case 'VOLUME':
            return bpy.data.volumes.new('Smoke')
        case 'POINTCLOUD':
            return bpy.data.pointclouds.new('Points')
        case 'CURVES':
            return bpy.data.hair_curves.new('Hair')
        case 'LATTICE':
            return bpy.data.lattices.new('Lattice')
        case _:
            return None
