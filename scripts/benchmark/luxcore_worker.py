# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders an exported scene with LuxCore and writes down seconds. `peers.py` starts it; it needs the pyluxcore wheel.

It is no converter: materials are approximated, there are no textures. Geometry, lights and rays are alike.
usage: python luxcore_worker.py TASK.json RESULT.json
"""

from __future__ import annotations

import json
import math
import os
import pickle
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np  # before LuxCore, which brings an allocator of its own
import pyluxcore

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from benchmark.flattened import LIGHT_POINT, LIGHT_SUN, flattened

FAR = 10.0  # metres from a lamp to the plane by which its brightness is found
WHITE = 0.5  # of that plane


def properties(values: dict[str, Any]) -> pyluxcore.Properties:
    made = pyluxcore.Properties()
    for name, value in values.items():
        made.Set(pyluxcore.Property(name, value))
    return made


def floats(values: np.ndarray) -> list[float]:
    return [float(value) for value in values]


def define(scene: pyluxcore.Scene, name: str, positions, triangles, normals, material: str) -> None:
    points = [tuple(row) for row in np.asarray(positions, float).tolist()]
    corners = [tuple(row) for row in np.asarray(triangles).tolist()]
    sides = None if normals is None else [tuple(row) for row in np.asarray(normals, float).tolist()]
    scene.DefineMesh(name, points, corners, sides, None, None, None)
    scene.Parse(properties({f'scene.objects.{name}.shape': name, f'scene.objects.{name}.material': material}))


def fill(scene: pyluxcore.Scene, dump: dict[str, Any]) -> None:
    for index, surface in enumerate(dump['surfaces']):
        name = f'scene.materials.m{index}'
        values = {f'{name}.type': 'disney', f'{name}.basecolor': floats(surface['base_color'])}
        values |= {f'{name}.{key}': float(surface[key]) for key in ('metallic', 'roughness', 'specular')}
        if any(surface['emission']):
            values[f'{name}.emission'] = floats(surface['emission'])
        scene.Parse(properties(values))
    for flat in flattened(dump['scene']):
        define(scene, f's{flat.name}', flat.positions, flat.triangles, flat.normals, f'm{flat.material}')


def lamps(scene: dict[str, Any]) -> list[dict[str, Any]]:
    """Each as LuxCore's properties without a prefix, with the irradiance it gives FAR away on its axis."""
    table, found = scene['lights'], []
    for i, kind in enumerate(table['type']):
        matrix, strength, size = table['transform'][i].astype(float), table['strength'][i], float(table['size'][i])
        position, axis = matrix[:, 3], -matrix[:, 2] / np.linalg.norm(matrix[:, 2])
        color = np.asarray(strength, float)
        lamp: dict[str, Any] = {'color': floats(color / color.max())}
        bright = color.max() / (4 * np.pi * FAR**2)
        if kind == LIGHT_SUN:
            lamp |= {'type': 'distant' if size > 0 else 'sharpdistant', 'direction': floats(axis)}
            bright = color.max()
            if size > 0:
                lamp['theta'] = math.degrees(size / 2)
        elif kind == LIGHT_POINT:
            lamp |= {'type': 'sphere' if size > 0 else 'point', 'position': floats(position)}
            if size > 0:
                lamp['radius'] = size
        else:
            half = math.degrees(float(table['spot_size'][i]) / 2)
            lamp |= {'type': 'spot', 'position': floats(position), 'target': floats(position + axis)}
            lamp |= {'coneangle': half, 'conedeltaangle': half * 0.5 * float(table['spot_blend'][i])}
        found.append({'lamp': lamp, 'position': position, 'axis': axis, 'irradiance': bright})
    return found


def run(scene: pyluxcore.Scene, size: tuple[int, int], samples: int, **more: Any) -> tuple[np.ndarray, float, float]:
    """The picture, the bottom row first, seconds, and the samples a pixel that it got."""
    config = {
        'renderengine.type': 'PATHCPU',
        'sampler.type': 'SOBOL',
        'sampler.sobol.adaptive.strength': 0.0,
        'film.width': size[0],
        'film.height': size[1],
        'film.filter.type': 'BLACKMANHARRIS',
        'film.filter.width': 1.5,
        'film.imagepipelines.0.0.type': 'NOP',
        'film.outputs.0.type': 'RGB',
        'film.outputs.0.filename': 'none.exr',
        'batch.haltspp': [samples],
        'path.clamping.variance.maxvalue': 0.0,
    }
    made = pyluxcore.RenderConfig(properties(config | {key.replace('__', '.'): v for key, v in more.items()}), scene)
    session = pyluxcore.RenderSession(made)
    session.Start()
    while not session.HasDone():
        time.sleep(0.002)
        session.UpdateStats()
    stats = session.GetStats()
    seconds = stats.Get('stats.renderengine.time').GetFloat()
    count = stats.Get('stats.renderengine.total.samplecount').GetFloat()
    session.Stop()
    image = np.zeros((size[1], size[0], 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, image, 0, True)
    return image, seconds, count / (size[0] * size[1])


def gain(entry: dict[str, Any], threads: int) -> float:
    """What the lamp is to be multiplied by: found by a plane that it lights, as units differ from light to light."""
    scene = pyluxcore.Scene()
    axis = entry['axis']
    sun = entry['lamp']['type'].endswith('distant')
    centre = np.zeros(3) if sun else entry['position'] + axis * FAR
    side = np.cross(axis, (1, 0, 0) if abs(axis[0]) < 0.9 else (0, 1, 0))
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    corners = [centre + 0.05 * (a * side + b * up) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    scene.Parse(properties({'scene.materials.white.type': 'matte', 'scene.materials.white.kd': [WHITE] * 3}))
    define(scene, 'plane', corners, [(0, 1, 2), (0, 2, 3)], None, 'white')
    # From aside, so that the camera is not in the light's way.
    eye = centre - axis + 0.5 * side
    look = {'scene.camera.lookat.orig': floats(eye), 'scene.camera.lookat.target': floats(centre)}
    scene.Parse(properties(look | {'scene.camera.lookat.up': floats(up), 'scene.camera.fieldofview': 1.0}))
    scene.Parse(properties({f'scene.lights.lamp.{key}': value for key, value in entry['lamp'].items()}))
    image, _, _ = run(scene, (16, 16), 256, path__pathdepth__total=1, native__threads__count=threads)
    return float(entry['irradiance']) * WHITE / math.pi / float(image[4:12, 4:12].max(axis=-1).mean())


def look(camera: dict[str, Any], size: tuple[int, int]) -> dict[str, Any]:
    left, right, bottom, top = camera['window']
    if camera['kind'] != 'PERSP' or abs(left + right) + abs(bottom + top) > 1e-5:
        raise ValueError('the comparison with LuxCore is made for perspective cameras without shift')
    matrix = camera['transform'].astype(float)
    narrow = top if size[0] >= size[1] else right
    return {
        'scene.camera.lookat.orig': floats(matrix[:, 3]),
        'scene.camera.lookat.target': floats(matrix[:, 3] - matrix[:, 2]),
        'scene.camera.lookat.up': floats(matrix[:, 1]),
        'scene.camera.fieldofview': math.degrees(2 * math.atan(narrow)),
    }


def main() -> None:
    task = json.loads(Path(sys.argv[1]).read_text())
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda *_: None)
    dump = pickle.loads(Path(task['dump']).read_bytes())
    began = time.perf_counter()
    scene = pyluxcore.Scene()
    fill(scene, dump)
    for index, entry in enumerate(lamps(dump['scene'])):
        factor = gain(entry, task['threads'])
        lamp = entry['lamp'] | {'gain': [factor] * 3}
        scene.Parse(properties({f'scene.lights.l{index}.{key}': value for key, value in lamp.items()}))
    world = np.array(dump['scene']['world']['color'], float)
    if world.any():
        sky = {'scene.lights.world.type': 'constantinfinite', 'scene.lights.world.color': floats(world)}
        scene.Parse(properties(sky))
    scene.Parse(properties(look(dump['camera'], task['size'])))
    build = time.perf_counter() - began

    bounces = task['bounces'] + 1
    limits = {f'path__pathdepth__{kind}': bounces for kind in ('total', 'diffuse', 'glossy', 'specular')}
    renders = []
    for job in task['jobs']:
        whole, cpu = time.perf_counter(), time.process_time()
        image, seconds, samples = run(
            scene, task['size'], job['samples'], native__threads__count=task['threads'],
            renderengine__seed=job['seed'] + 1, **limits
        )  # fmt: skip
        np.save(job['output'], image[::-1])
        share = job['samples'] / samples  # it ends a little later than it is asked to
        renders.append(
            {**job, 'render': seconds * share, 'whole': time.perf_counter() - whole, 'cpu': time.process_time() - cpu}
        )
    Path(sys.argv[2]).write_text(json.dumps({'version': pyluxcore.Version(), 'build': build, 'renders': renders}))
    sys.stdout.flush()
    os._exit(0)  # LuxCore's allocator and Python's do not agree at the end


if __name__ == '__main__':
    main()
