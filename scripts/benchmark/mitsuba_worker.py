# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders an exported scene with Mitsuba 3 and writes down seconds. `peers.py` starts it; it needs the mitsuba wheel.

It is no converter: materials are approximated, there are no textures. Geometry, lights and rays are alike.
usage: python mitsuba_worker.py TASK.json RESULT.json
"""

from __future__ import annotations

import json
import pickle
import sys
import time
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from benchmark.flattened import LIGHT_POINT, LIGHT_SUN, flattened

# A soft sun becomes a disk this many times farther away than the scene is large.
SUN_DISTANCE = 1000.0


def homogeneous(rows: np.ndarray) -> np.ndarray:
    return np.vstack((rows.astype(np.float64), (0, 0, 0, 1)))


def material(surface: dict[str, Any]) -> dict[str, Any]:
    numbers = {name: surface[name] for name in ('metallic', 'roughness', 'specular')}
    color = {'type': 'rgb', 'value': surface['base_color']}
    return {'type': 'twosided', 'bsdf': {'type': 'principled', 'base_color': color, **numbers}}


def shape(
    name: str, vertices: np.ndarray, normals: np.ndarray | None, faces: np.ndarray, props: mi.Properties
) -> mi.Mesh:
    mesh = mi.Mesh(name, len(vertices), len(faces), has_vertex_normals=normals is not None, props=props)
    parameters = mi.traverse(mesh)
    parameters['vertex_positions'] = vertices.astype(np.float32).ravel()
    parameters['faces'] = faces.astype(np.uint32).ravel()
    if normals is not None:
        parameters['vertex_normals'] = normals.astype(np.float32).ravel()
    parameters.update()
    return mesh


def shapes(scene: dict[str, Any], surfaces: list[dict[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    bsdfs = {index: mi.load_dict(material(surfaces[index])) for index in np.unique(scene['material_slots'])}
    for flat in flattened(scene):
        props = mi.Properties()
        props['bsdf'] = bsdfs[flat.material]
        if flat.normals is None:
            props['face_normals'] = True
        emission = surfaces[flat.material]['emission']
        if any(emission):
            radiance = {'type': 'rgb', 'value': emission}
            props['emitter'] = mi.load_dict({'type': 'area', 'radiance': radiance})
        result[f'shape{flat.name}'] = shape(flat.name, flat.positions, flat.normals, flat.triangles, props)
    return result


def lights(scene: dict[str, Any], centre: np.ndarray, extent: float) -> dict[str, Any]:
    """Point lights with a radius are spheres, a sun with an angle is a far disk; spots are hard, as in Mitsuba."""
    result: dict[str, Any] = {}
    table = scene['lights']

    def rgb(values: np.ndarray) -> dict[str, Any]:
        return {'type': 'rgb', 'value': [float(value) for value in values]}

    for i, kind in enumerate(table['type']):
        matrix, strength, size = table['transform'][i].astype(np.float64), table['strength'][i], float(table['size'][i])
        position, axis = matrix[:, 3], -matrix[:, 2] / np.linalg.norm(matrix[:, 2])
        if kind == LIGHT_SUN and size > 0:
            distance = SUN_DISTANCE * extent
            away = centre - axis * distance
            side = np.cross(axis, (1, 0, 0) if abs(axis[0]) < 0.9 else (0, 1, 0))
            to_world = mi.ScalarTransform4f().look_at(list(away), list(centre), list(side))
            to_world = to_world @ mi.ScalarTransform4f().scale([distance * float(np.tan(size / 2))] * 3)
            area = {'type': 'area', 'radiance': rgb(strength / (np.pi * np.sin(size / 2) ** 2))}
            result[f'light{i}'] = {'type': 'disk', 'to_world': to_world, 'emitter': area}
        elif kind == LIGHT_SUN:
            result[f'light{i}'] = {'type': 'directional', 'direction': list(axis), 'irradiance': rgb(strength)}
        elif kind == LIGHT_POINT and size > 0:
            area = {'type': 'area', 'radiance': rgb(strength / (4 * np.pi**2 * size**2))}
            result[f'light{i}'] = {'type': 'sphere', 'center': list(position), 'radius': size, 'emitter': area}
        elif kind == LIGHT_POINT:
            result[f'light{i}'] = {
                'type': 'point',
                'position': list(position),
                'intensity': rgb(strength / (4 * np.pi)),
            }
        else:
            half = np.degrees(float(table['spot_size'][i]) / 2)
            result[f'light{i}'] = {
                'type': 'spot',
                'to_world': mi.ScalarTransform4f(homogeneous(matrix)) @ mi.ScalarTransform4f().rotate([0, 1, 0], 180),
                'intensity': rgb(strength / (4 * np.pi)),
                'cutoff_angle': half,
                'beam_width': half * (1 - 0.5 * float(table['spot_blend'][i])),
            }
    world = np.array(scene['world']['color'])
    if world.any():
        result['world'] = {'type': 'constant', 'radiance': rgb(world)}
    return result


def sensor(camera: dict[str, Any], size: tuple[int, int], sampler: str) -> dict[str, Any]:
    """The window of a centred perspective camera; Mitsuba looks along +Z, Blender along −Z."""
    left, right, bottom, top = camera['window']
    if camera['kind'] != 'PERSP' or abs(left + right) + abs(bottom + top) > 1e-5:
        raise ValueError('the comparison with Mitsuba is made for perspective cameras without shift')
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {
        'type': 'perspective',
        'fov': float(np.degrees(2 * np.arctan(right))),
        'fov_axis': 'x',
        'to_world': mi.ScalarTransform4f(homogeneous(camera['transform'])) @ turn,
        'near_clip': float(camera['clip'][0]),
        'far_clip': float(camera['clip'][1]),
        'film': {
            'type': 'hdrfilm',
            'width': size[0],
            'height': size[1],
            'rfilter': {'type': 'box'},
            'pixel_format': 'rgb',
            'component_format': 'float32',
        },
        'sampler': {'type': sampler},
    }


def main() -> None:
    task = json.loads(Path(sys.argv[1]).read_text())
    mi.set_variant(task['variant'])
    dr.set_thread_count(task['threads'])
    mi.set_log_level(mi.LogLevel.Error)
    dump = pickle.loads(Path(task['dump']).read_bytes())
    began = time.perf_counter()
    description: dict[str, Any] = {'type': 'scene', **shapes(dump['scene'], dump['surfaces'])}
    bounds = mi.load_dict(description).bbox()
    centre, extent = np.array(bounds.center()), float(np.linalg.norm(bounds.extents()))
    lamps = lights(dump['scene'], centre, extent)
    description |= lamps
    description['sensor'] = sensor(dump['camera'], task['size'], task['sampler'])
    if task['bounces'] == 0:
        every = {'emitter_samples': max(1, len(lamps)), 'bsdf_samples': 1}
        one = {'emitter_samples': 1, 'bsdf_samples': 0}
        description['integrator'] = {'type': 'direct', **(every if task['every_light'] else one)}
    else:
        # A path of depth 1 sees a light, of depth 2 is direct light.
        description['integrator'] = {'type': 'path', 'max_depth': task['bounces'] + 2}
    scene = mi.load_dict(description)
    build = time.perf_counter() - began

    renders = []
    for index, job in enumerate([{'samples': 1, 'seed': 0}, *task['jobs']]):
        began = time.perf_counter()
        cpu = time.process_time()
        pixels = np.array(mi.render(scene, spp=job['samples'], seed=job['seed']))
        seconds = time.perf_counter() - began
        if index == 0:  # LLVM compiles its kernel once; that is not rendering
            compile_seconds = seconds
            continue
        np.save(job['output'], pixels)
        renders.append(
            {**job, 'render': seconds, 'whole': build + compile_seconds + seconds, 'cpu': time.process_time() - cpu}
        )
    Path(sys.argv[2]).write_text(json.dumps({'version': mi.__version__, 'build': build, 'renders': renders}))


if __name__ == '__main__':
    main()
