# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one scene with one engine in a Blender of its own and writes down seconds and memory. `runner.py` starts it.

It judges nothing: images go to files, numbers to a JSON file.   usage: python worker.py TASK.json RESULT.json
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import pickle
import platform
import resource
import sys
import time
from pathlib import Path
from typing import Any, ClassVar

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from benchmark import fair, scenes


class BenchNull(bpy.types.RenderEngine):
    """Renders nothing: what Blender itself takes for a render, the evaluation of meshes included."""

    bl_idname = 'BENCH_NULL'
    bl_label = 'Nothing (benchmark)'

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        for instance in depsgraph.object_instances:
            _ = instance.object.data  # Blender puts a subdivision off until somebody asks for its mesh
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))


class BenchDump(bpy.types.RenderEngine):
    """Writes what Cotorra exports into a file, for engines outside Blender; renders nothing."""

    bl_idname = 'BENCH_DUMP'
    bl_label = 'Export (benchmark)'
    path = ''

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        buffers, camera = exported(depsgraph)
        surfaces = [plain(bpy.data.materials.get(name)) for name in buffers.materials.names]
        dump = {'scene': dataclasses.asdict(buffers), 'surfaces': surfaces, 'camera': dataclasses.asdict(camera)}
        Path(self.path).write_bytes(pickle.dumps(dump))
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))


class BenchTrace(bpy.types.RenderEngine):
    """Renders with Cotorra and lets Embree alone trace every ray once more; the picture is thrown away."""

    bl_idname = 'BENCH_TRACE'
    bl_label = 'Rays (benchmark)'
    stats: ClassVar[dict[str, Any]] = {}

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        from cotorra import native
        from cotorra.log import Log
        from cotorra.settings import render_settings

        buffers, camera = exported(depsgraph)
        settings = render_settings(depsgraph.scene_eval, depsgraph.view_layer_eval, ('combined',), Log())
        module = native.load()
        scene = module.Scene(buffers, threads=settings.threads, embree=native.embree_library())
        session = module.Session(scene, camera, dataclasses.replace(settings, measure_tracing=True))
        session.start()
        while not session.wait(0.5):
            pass
        self.stats.update(session.stats())
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))


class BenchShares(bpy.types.RenderEngine):
    """Renders with Cotorra again and again, to find of what the variance is made; the pictures are thrown away."""

    bl_idname = 'BENCH_SHARES'
    bl_label = 'Shares of the variance (benchmark)'
    found: ClassVar[dict[str, float]] = {}

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        from cotorra import native
        from cotorra.log import Log
        from cotorra.settings import render_settings

        from benchmark import shares

        buffers, camera = exported(depsgraph)
        settings = render_settings(depsgraph.scene_eval, depsgraph.view_layer_eval, ('combined',), Log())
        self.found.update(shares.measure(native.load(), buffers, camera, settings, native.embree_library()))
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))


def plain(material: bpy.types.Material | None) -> dict[str, Any]:
    """A material without textures: the unlinked inputs of its Principled BSDF, a new one's where it has none."""
    nodes = material.node_tree.nodes if material is not None else ()
    node = next((node for node in nodes if node.type == 'BSDF_PRINCIPLED'), None)
    if node is None:
        return {'base_color': [0.8] * 3, 'metallic': 0.0, 'roughness': 0.5, 'specular': 0.5, 'emission': [0.0] * 3}

    def value(name: str) -> Any:
        return node.inputs[name].default_value

    strength = value('Emission Strength')
    return {
        'base_color': list(value('Base Color'))[:3],
        'metallic': value('Metallic'),
        'roughness': value('Roughness'),
        'specular': value('Specular IOR Level'),
        'emission': [strength * channel for channel in value('Emission Color')[:3]],
    }


def exported(depsgraph: bpy.types.Depsgraph) -> tuple[Any, Any]:
    """What Cotorra's native module is given: the scene's arrays and the camera."""
    from cotorra import export
    from cotorra.log import Log

    scene, layer, log = depsgraph.scene_eval, depsgraph.view_layer_eval, Log()
    camera = export.export_camera(scene, scene.camera.evaluated_get(depsgraph), log)
    return export.export_scene(depsgraph, scene, layer, log), camera


def memory(field: str) -> int:
    """Bytes; VmRSS: now, VmHWM: the peak since `forget_peak`. 0 where the system does not tell."""
    with contextlib.suppress(OSError):
        for line in Path('/proc/self/status').read_text().splitlines():
            if line.startswith(field + ':'):
                return int(line.split()[1]) * 1024
    return 0


def forget_peak() -> None:
    """Sets the peak to what is in use now (Linux)."""
    with contextlib.suppress(OSError):
        Path('/proc/self/clear_refs').write_text('5')


def cpu_seconds() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class FirstSample:
    """When the engine began to render samples, by the status text that Blender passes on."""

    def __init__(self) -> None:
        self.began = 0.0
        self.seconds: float | None = None

    def start(self) -> None:
        self.began, self.seconds = time.perf_counter(), None

    def __call__(self, status: str, *_: object) -> None:
        if self.seconds is None and ('Sample ' in status or 'Rendered ' in status):
            self.seconds = time.perf_counter() - self.began


def render(task: dict[str, Any], job: dict[str, Any], first_sample: FirstSample) -> dict[str, Any]:
    """One render; seconds as a user waits for them (`whole`), on the processors (`cpu`), and its peak of memory.

    job['settings']: properties of the scene by their paths, such as 'cotorra.integrator'; they stay for later jobs.
    """
    scene = bpy.context.scene
    fair.set_job(scene, job['samples'], job['seed'], job['output'], job.get('sharing', False))
    for path, value in job.get('settings', {}).items():
        owner, _, name = path.rpartition('.')
        setattr(scene.path_resolve(owner), name, value)
    base = memory('VmRSS')
    forget_peak()
    cpu = cpu_seconds()
    first_sample.start()
    began = time.perf_counter()
    bpy.ops.render.render(write_still=bool(job['output']))
    whole = time.perf_counter() - began
    result = {
        'samples': job['samples'],
        'seed': job['seed'],
        'output': job['output'],
        'whole': whole,
        'cpu': cpu_seconds() - cpu,
        'first_sample': first_sample.seconds,
        'memory_base': base,
        'memory_peak': memory('VmHWM') - base,
    }
    if task['engine'] == 'COTORRA':
        result['stats'] = own_stats()
    return result


def own_stats() -> dict[str, Any]:
    """What Cotorra counted in its last render."""
    from cotorra import stats

    layers = [dataclasses.asdict(layer) for layer in stats.last(bpy.context.scene.name)]
    return {
        'sync_seconds': sum(layer['sync_seconds'] for layer in layers),
        'build_seconds': sum(layer['build_seconds'] for layer in layers),
        'render_seconds': sum(layer['render_seconds'] for layer in layers),
        'rays': {kind: sum(layer['rays'].get(kind, 0) for layer in layers) for kind in layers[0]['rays']},
        'scene': layers[0]['scene'],
        'layers': layers,
    }


def main() -> None:
    task = json.loads(Path(sys.argv[1]).read_text())
    engine = task['engine']
    if engine not in ('CYCLES', 'BENCH_NULL') or task['source']['kind'] == 'demo':  # a demo is set up for Cotorra
        import cotorra

        cotorra.register()
    BenchDump.path = task.get('dump', '')
    for cls in (BenchNull, BenchDump, BenchTrace, BenchShares):
        bpy.utils.register_class(cls)
    scenes.build(scenes.SceneSource(**task['source']))
    cut = scenes.strip_textures() if task['constants'] else []
    fair.make_fair(bpy.context.scene, engine, task['bounces'], tuple(task['size']), task['threads'])
    if task.get('shipped'):
        fair.as_shipped(bpy.context.scene)
    if engine == 'COTORRA':
        own = bpy.context.scene.cotorra
        own.device, own.use_device_fallback = task['device'], False
    bpy.context.view_layer.update()

    first_sample = FirstSample()
    bpy.app.handlers.render_stats.append(first_sample)
    renders = [render(task, job, first_sample) for job in task['jobs']]
    done = {
        'BENCH_DUMP': Path(BenchDump.path).is_file(),
        'BENCH_TRACE': bool(BenchTrace.stats),
        'BENCH_SHARES': bool(BenchShares.found),
    }
    if not done.get(engine, True):  # Blender prints what an engine raises and goes on
        sys.exit(f'{engine} failed')
    result = {
        'engine': engine,
        'blender': bpy.app.version_string,
        'python': platform.python_version(),
        'cut': cut,
        'renders': renders,
        'tracing': BenchTrace.stats,
        'shares': BenchShares.found,
    }
    Path(sys.argv[2]).write_text(json.dumps(result))
    # Blender 4.5 hangs at exit while an engine written in Python is registered, and a benchmark need not clean up.
    sys.stdout.flush()
    os._exit(0)


if __name__ == '__main__':
    main()
