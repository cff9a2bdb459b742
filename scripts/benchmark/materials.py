# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sample costs on one material against another: reflection models against Principled, images against none.

One wavy surface that fills the picture, under a sun and a bulb, without bounces; the materials take turns in one
process, and seconds are the processors'. `surfaces` runs in Blender, `materials` anywhere.
"""

from __future__ import annotations

from statistics import median
from typing import Any

from benchmark.report import table
from benchmark.runner import Case, run_worker, task_of
from benchmark.scenes import SceneSource

SIZE = (320, 180)
SAMPLES = (16, 144)  # of a pixel; what their seconds differ by is sampling alone
IMAGE = 1024  # pixels across
PRINCIPLED = 'Principled'
MODELS = {
    'Lambert': 'LAMBERT',
    'Oren-Nayar': 'OREN_NAYAR',
    'Phong': 'PHONG',
    'Blinn-Phong': 'BLINN_PHONG',
    'Cook-Torrance': 'COOK_TORRANCE',
}
IMAGES = {'one image': 1, 'four images and a normal map': 5}
NOISE = 'five octaves of noise'
NAMES = (PRINCIPLED, *MODELS, *IMAGES, NOISE)
# By name: the most that it may cost, of Principled's.
GOALS = dict.fromkeys(MODELS, 1.15) | {'four images and a normal map': 1.6}


def surfaces() -> None:
    """Every material on an object of its own in one place; those that are not rendered are hidden."""
    import bpy
    import numpy as np
    from cotorra import compat

    from benchmark.scenes import build_grid

    build_grid(SceneSource('grid', 'grid', number=2000))
    scene = bpy.context.scene
    grid = scene.objects['Grid']
    bulb = bpy.data.objects.new('Bulb', bpy.data.lights.new('Bulb', 'POINT'))
    bulb.location = (0.5, -0.3, 1.0)
    scene.collection.objects.link(bulb)
    scene.camera.location = (0.0, 0.0, 1.5)
    rng = np.random.default_rng(1)
    for name in NAMES:
        material = bpy.data.materials.new(name)
        own = compat.principled(material)
        nodes, links = material.node_tree.nodes, material.node_tree.links
        if name in MODELS:
            material.cotorra.model = MODELS[name]
        elif name == NOISE:
            noise = nodes.new('ShaderNodeTexNoise')
            noise.inputs['Detail'].default_value = 4.0
            links.new(noise.outputs['Color'], own.inputs['Base Color'])
        for index in range(IMAGES.get(name, 0)):
            image = bpy.data.images.new(f'{name} {index}', IMAGE, IMAGE, is_data=index > 0)
            pixels = rng.uniform(0.4, 0.6, (IMAGE * IMAGE, 4)).astype(np.float32)
            pixels[:, 2] += 0.4 if index == 4 else 0.0
            image.pixels.foreach_set(pixels.reshape(-1))
            image.pack()
            texture = nodes.new('ShaderNodeTexImage')
            texture.image = image
            out = texture.outputs['Color']
            if index == 4:
                normal = nodes.new('ShaderNodeNormalMap')
                links.new(out, normal.inputs['Color'])
                out = normal.outputs['Normal']
            inputs = ('Base Color', 'Roughness', 'Metallic', 'Specular IOR Level', 'Normal')
            links.new(out, own.inputs[inputs[index]])
        shown = bpy.data.objects.new(name, grid.data.copy())
        shown.data.materials.append(material)
        shown.hide_render = True
        scene.collection.objects.link(shown)
    bpy.data.objects.remove(grid)


def materials(threads: int, engine: str, repeat: int, device: str) -> dict[str, Any]:
    """Nanoseconds of processor time a sample on each material, and what that is of Principled's."""
    repeat = max(5, repeat)
    case = Case(SceneSource('materials', 'materials'), 0, SIZE, threads, device=device)
    turns = [(name, samples) for _ in range(repeat) for name in NAMES for samples in SAMPLES]
    jobs = [
        {
            'samples': samples,
            'seed': 1,
            'output': '',
            'settings': {f'objects["{other}"].hide_render': other != name for other in NAMES},
        }
        for name, samples in turns
    ]
    renders = run_worker(task_of(case, engine, jobs))['renders']
    pixels = SIZE[0] * SIZE[1] * (SAMPLES[1] - SAMPLES[0])
    seconds: dict[str, list[float]] = {name: [] for name in NAMES}
    for index in range(0, len(renders), 2):
        few, many = renders[index : index + 2]
        seconds[turns[index][0]].append((many['cpu'] - few['cpu']) / pixels)
    # Each against the Principled of its own turn: what else the machine does comes and goes.
    lines, result = [], {'case': 'materials', 'engine': engine, 'seconds': seconds}
    for name in NAMES:
        ratios = [own / plain for own, plain in zip(seconds[name], seconds[PRINCIPLED], strict=True)]
        goal = f'{GOALS[name]:.2f}' if name in GOALS else '-'
        between = f'{min(ratios):.2f} to {max(ratios):.2f}'
        lines.append((name, f'{1e9 * median(seconds[name]):.0f}', f'{median(ratios):.2f}', between, goal))
        result[name] = median(ratios)
    print(f'materials: {engine}, direct light, {threads} threads, median of {repeat} turns')
    print(table(('material', 'ns a sample', f'of {PRINCIPLED}', 'between', 'goal'), lines) + '\n', flush=True)
    return result
