# SPDX-License-Identifier: GPL-3.0-or-later
"""What integrator AUTO chooses, states and saves, scene by scene, beside full path tracing with the same settings.

Each scene is rendered by both with two seeds each, one after the other, in a process of its own. Measured are the
difference of the converged pictures (free of noise: products of two seeds), the noise, and the seconds of processor
time, pilot included. A line of the table is printed as soon as its scene is done. Kept: the measured difference is
within the stated bound (yes), beyond it by no more than its own noise, or beyond it (NO). Pilot: its seconds as a share
of those of Path's render. At equal: the ratio of times at equal error, noise and difference together, as noise falls
with the root of the time; errors below the tolerance count as that.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from benchmark import scenes

SEEDS = (11, 12)
HEAD = (
    *('scene', 'bound %', 'measured %', 'kept', 'noise: told %', 'AUTO %', 'Path %', 'pilot %', 'faster', 'at equal'),
    'chosen',
)
WIDTHS = (18, 8, 12, 6, 14, 7, 7, 8, 7, 9)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='auto_table', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    there = ', '.join((*scenes.DEMOS, *scenes.open_names()))
    parser.add_argument('scenes', metavar='SCENE', nargs='*', help=f'{there}, or a .blend file (default: all of them)')
    parser.add_argument('--size', default='320x180', help='WxH (default: 320x180)')
    parser.add_argument('--samples', type=int, default=128, help='of both (default: 128)')
    parser.add_argument(
        '--tolerance', type=float, nargs='+', default=[1.0], help='percent of the mean (default: 1); one table each'
    )
    parser.add_argument('--json', type=Path, help='everything measured')
    parser.add_argument('--images', type=Path, help='folder for the pictures of both and their difference')
    parser.add_argument('--worker', help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    options.size = tuple(int(value) for value in options.size.lower().split('x'))
    names = options.scenes or [*scenes.DEMOS, *scenes.open_names()]
    try:
        options.sources = [scenes.find(name) for name in names]
    except ValueError as problem:
        parser.error(str(problem))
    return options


# ---- One scene, in Blender


def work(task: dict[str, Any]) -> dict[str, Any]:
    """Both integrators with each seed. Files are pictures; figures are returned."""
    import bpy
    import cotorra

    cotorra.register()
    scenes.build(scenes.SceneSource(**task['source']))
    scene = bpy.context.scene
    set_up(scene, task)
    found = {name: [] for name in ('PATH', *map(auto_name, task['tolerances']))}
    for seed in SEEDS:
        for name, entries in found.items():
            scene.cotorra.integrator, scene.cotorra.seed = name.split(' ')[0], seed
            if name != 'PATH':
                scene.cotorra.auto_tolerance = float(name.split(' ')[1])
            scene.render.filepath = str(Path(task['folder'], f'{name}-{seed}.exr'))
            entries.append(render(scene) | {'output': scene.render.filepath})
    return found


def auto_name(tolerance: float) -> str:
    return f'AUTO {tolerance:g}'


def set_up(scene: Any, task: dict[str, Any]) -> None:
    """The scene's own limits hold, samples are the task's; what would hide noise or end a render early is off."""
    from cotorra import compat

    render = scene.render
    render.engine = 'COTORRA'
    render.resolution_x, render.resolution_y = task['size']
    render.resolution_percentage = 100
    render.use_border = render.use_compositing = render.use_sequencer = render.use_persistent_data = False
    render.use_file_extension = False
    compat.set_image_format(render.image_settings, 'OPEN_EXR')
    render.image_settings.color_depth = '32'
    render.image_settings.color_mode = 'RGB'
    own = scene.cotorra
    own.samples = task['samples']
    own.use_adaptive_sampling = own.use_denoising = own.use_animated_seed = own.use_reweighting = False
    own.use_sample_sharing = False  # images are compared tile by tile, by pixels that are independent
    own.time_limit = 0.0
    for layer in scene.view_layers:
        layer.samples = 0


def render(scene: Any) -> dict[str, Any]:
    import bpy
    from cotorra import stats

    before, began = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    bpy.ops.render.render(write_still=True)
    after = resource.getrusage(resource.RUSAGE_SELF)
    layer = asdict(stats.last(scene.name)[-1])
    return {
        'cpu': after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        'wall': time.perf_counter() - began,
        'rays': sum(layer['rays'].values()),
        'auto': layer['auto'],
        **{key: layer[key] for key in ('pilot_seconds', 'render_seconds', 'samples', 'error')},
    }


# ---- The table


def measure(found: dict[str, Any], images: dict[str, list[np.ndarray]], tolerance: float) -> dict[str, Any]:
    """Figures of a scene, errors as shares of the mean."""
    from cotorra.metrics import paired_difference

    name = auto_name(tolerance)
    path, auto = (np.stack(images[key]).reshape(len(SEEDS), -1, 3).astype(np.float64) for key in ('PATH', name))
    mean = float(path.mean())
    told = found[name][0]['auto']
    apart = paired_difference(path, auto, mean)
    bound = max(entry['auto']['bound'] for entry in found[name])
    seconds = {key: sum(entry['cpu'] for entry in found[key]) for key in ('PATH', name)}
    faster = seconds['PATH'] / seconds[name]
    noises = {'AUTO': noise(images[name], mean), 'PATH': noise(images['PATH'], mean)}
    errors = max(np.hypot(noises['AUTO'], apart.value), tolerance / 100.0), max(noises['PATH'], tolerance / 100.0)
    shared = sum(e['pilot_seconds'] for e in found[name]) / sum(e['render_seconds'] for e in found['PATH'])
    return {
        'bound': bound,
        'measured': asdict(apart),
        'kept': 'yes' if apart.value <= bound else 'noise' if apart.low <= bound else 'NO',
        'noise_told': told['noise'],
        'noise': noises,
        'pilot': shared,
        'faster': faster,
        'at_equal': float(faster * (errors[1] / errors[0]) ** 2),
        'rays': sum(entry['rays'] for entry in found['PATH']) / sum(entry['rays'] for entry in found[name]),
        'told': told,
        'cpu': seconds,
    }


def noise(images: list[np.ndarray], mean: float) -> float:
    from cotorra.metrics import Reference, noise_and_bias

    return float(np.sqrt(noise_and_bias(images, Reference.from_image(images[0])).noise_mse)) / mean


def line(name: str, figures: dict[str, Any]) -> str:
    def part(share: float | None) -> str:
        return '-' if share is None else f'{100.0 * share:.2f}'

    told = figures['told']
    changed = [f'{row["name"]} {row["chosen"]} (of {row["asked"]})' for row in told['rows'] if row['simplified']]
    measured = figures['measured']
    cells = (
        name,
        part(figures['bound']),
        f'{part(measured["value"])} ±{part((measured["high"] - measured["low"]) / 2)}',
        figures['kept'],
        part(told['noise'][0] if told['noise'] else None),
        part(figures['noise']['AUTO']),
        part(figures['noise']['PATH']),
        part(figures['pilot']),
        f'{figures["faster"]:.2f}',
        f'{figures["at_equal"]:.2f}',
        ', '.join(changed) or told['reason'] or 'all',
    )
    return '  '.join([cell.ljust(width) for cell, width in zip(cells, WIDTHS, strict=False)] + [cells[-1]])


def summary(rows: dict[str, dict[str, Any]]) -> str:
    ratios, equal = (np.array([figures[key] for figures in rows.values()]) for key in ('faster', 'at_equal'))
    kept, unsure = (sum(figures['kept'] == word for figures in rows.values()) for word in ('yes', 'noise'))
    return (
        f'{kept} of {len(rows)} within the stated bound, {unsure} beyond it by no more than their noise; '
        f'faster {np.exp(np.log(ratios).mean()):.2f} times in the geometric mean, {ratios.min():.2f} at least; '
        f'at equal error {np.exp(np.log(equal).mean()):.2f} times, {equal.min():.2f} at least'
    )


def run(source: scenes.SceneSource, options: argparse.Namespace) -> dict[float, dict[str, Any]]:
    """Figures by tolerance. Raises RuntimeError with the last words of the process that failed."""
    from compare import read_exr

    with tempfile.TemporaryDirectory(prefix='cotorra-auto-') as folder:
        task = {
            'source': asdict(source),
            'size': options.size,
            'samples': options.samples,
            'tolerances': options.tolerance,
            'folder': folder,
        }
        (Path(folder) / 'task.json').write_text(json.dumps(task))
        done = subprocess.run(
            [sys.executable, __file__, '--worker', folder],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors='replace',
        )
        result = Path(folder) / 'result.json'
        if not result.is_file():
            words = '\n  '.join(done.stdout.splitlines()[-15:])
            raise RuntimeError(f'{source.name}: exit status {done.returncode}\n  {words}')
        found = json.loads(result.read_text())
        images = {name: [read_exr(entry['output'])[0] for entry in entries] for name, entries in found.items()}
        if options.images:
            options.images.mkdir(parents=True, exist_ok=True)
            for tolerance in options.tolerance:
                save(options.images / f'{source.name}-{tolerance:g}.png', images, tolerance)
        return {tolerance: measure(found, images, tolerance) for tolerance in options.tolerance}


def save(path: Path, images: dict[str, list[np.ndarray]], tolerance: float) -> None:
    """Both pictures and their difference."""
    from cotorra.metrics import Reference, same_image

    from compare import draw

    name = auto_name(tolerance)
    auto, full = (Reference.from_halves(*images[key]) for key in (name, 'PATH'))
    draw(path, auto.image, full.image, same_image(auto, full), (name, 'Path'))


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    if options.worker:
        folder = Path(options.worker)
        found = work(json.loads((folder / 'task.json').read_text()))
        (folder / 'result.json').write_text(json.dumps(found))
        # Blender 4.5 hangs at exit while an engine written in Python is registered.
        sys.stdout.flush()
        os._exit(0)
    tables: dict[float, dict[str, dict[str, Any]]] = {tolerance: {} for tolerance in options.tolerance}
    head = [cell.ljust(width) for cell, width in zip(('tol %', *HEAD), (5, *WIDTHS), strict=False)]
    print('  '.join([*head, HEAD[-1]]), flush=True)
    for source in options.sources:
        try:
            found = run(source, options)
        except RuntimeError as problem:
            print(f'{problem}', flush=True)
            continue
        for tolerance, figures in found.items():
            tables[tolerance][source.name] = figures
            print(f'{tolerance:<5g}  {line(source.name, figures)}', flush=True)
        if options.json:
            options.json.write_text(json.dumps(tables, indent=1))
    for tolerance, rows in tables.items():
        if rows:
            print(f'\ntolerance {tolerance:g} %: {summary(rows)}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
