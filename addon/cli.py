# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra render`: renders a .blend file or a demo at a terminal, with the Blender that the `bpy` module holds.

It sets, starts and reports; what is rendered and how is the engine's. Exit codes: 0 rendered, 1 failed, 2 wrong
arguments, 130 interrupted (what was rendered until then is saved).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import arguments, choices, explain, opening, outputs, stats, watch
from .lab import chart, compare
from .terminal import (
    INTERRUPTED,
    WRONG_ARGUMENTS,
    CommandError,
    TerminalWatcher,
    flush_standard_streams,
    open_standard_streams,
)

if TYPE_CHECKING:
    import bpy

FORMATS = {'.exr': 'OPEN_EXR', '.png': 'PNG'}


def main(words: Sequence[str] | None = None) -> int:
    options = parser().parse_args(words)
    open_standard_streams()
    watcher = TerminalWatcher(sys.stderr)
    try:
        with watcher.stopped_by_signals(), watch.attached(watcher):
            if options.command == 'explain':
                explain.run(options)
            elif options.command == 'chart':
                chart.run(options, watcher)
            elif options.command == 'compare':
                compare.run(options, watcher)
            else:
                render(options, watcher)
    except CommandError as error:
        watcher.note(f'cotorra: {error}')
        return error.code
    finally:
        flush_standard_streams()
    return INTERRUPTED if watcher.stop else 0


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(prog='cotorra', description='Cotorra, a render engine for Blender, at a terminal.')
    commands = top.add_subparsers(dest='command', required=True, metavar='COMMAND')
    line = commands.add_parser(
        'render',
        help='render a file or a demo',
        description='Renders the active scene of a .blend file, a file of another program '
        f'({", ".join(choices.IMPORTERS)}), or a demo, with Cotorra. A camera and lights are added to files of other '
        'programs that have none.',
        epilog='demos: ' + '; '.join(f'{name}: {text}' for name, text in choices.DEMOS.items()),
    )
    arguments.add_source(line)
    line.add_argument(
        '-o',
        '--output',
        required=True,
        type=Path,
        metavar='OUT',
        help='OUT.exr (32-bit float; a layer for each pass where there are several) or OUT.png (8 bit, as Blender '
        'displays it). ### stands for the frame number',
    )
    line.add_argument(
        '--frame', type=arguments.frames, metavar='N|A..B', help="a frame or a range (default: the file's frame)"
    )
    line.add_argument(
        '--samples', type=arguments.whole(1, choices.SAMPLES_MAX), metavar='N', help='paths for each pixel'
    )
    line.add_argument(
        '--seed', type=arguments.whole(0, choices.SEED_MAX), metavar='N', help='another number, other noise'
    )
    arguments.one_of(line, '--integrator', choices.INTEGRATORS, "{} (default: the file's; path where it was never set)")
    line.add_argument(
        '--tolerance',
        type=arguments.percent,
        metavar='P',
        help='with integrator auto: most that what it leaves out may change the picture, percent of its mean',
    )
    line.add_argument(
        '--denoise',
        action=argparse.BooleanOptionalAction,
        help='take the noise out with OpenImageDenoise (default: as the file says, demos: yes)',
    )
    line.add_argument(
        '--reweight',
        type=arguments.strength,
        metavar='S',
        help='hold fireflies back: 1 as usual, 2 twice as strictly, 0 not at all (default: as the file says, demos: 1)',
    )
    line.add_argument(
        '--share-samples',
        action=argparse.BooleanOptionalAction,
        help='let samples count for all pixels whose filter reaches them (default: as the file says, else yes; never '
        'in pictures that are denoised or reweighted)',
    )
    line.add_argument(
        '--time-limit',
        type=arguments.seconds,
        metavar='S',
        help='stop each view layer after so many seconds, 0 for no limit',
    )
    arguments.one_of(
        line,
        '--settings',
        choices.SETTINGS_FROM,
        'whose settings hold: {} (default: those that were set for Cotorra, and for the rest those for Cycles)',
    )
    arguments.one_of(line, '--model', choices.MODELS, 'render all materials with one reflection model: {}')
    devices = ', '.join(identifier.lower() for identifier, _, _ in choices.DEVICES)
    line.add_argument(
        '--device', type=arguments.device, metavar='NAME', help=f'{devices}; vulkan:1 for the second graphics card'
    )
    arguments.one_of(line, '--ray-tracing', choices.RAY_TRACINGS, 'on a graphics card: {}')
    health = line.add_mutually_exclusive_group()
    health.add_argument('--health', action='store_true', help='count bad samples, and tell where they come from')
    health.add_argument('--strict', action='store_true', help='as --health; samples that are not finite are an error')
    line.add_argument(
        '--threads', type=arguments.whole(0, choices.THREADS_MAX), metavar='N', help='0 for all processor cores'
    )
    line.add_argument('--size', type=arguments.size, metavar='WxH', help='in pixels')
    line.add_argument('--stats', type=Path, metavar='FILE.json', help='write times, rays, memory and warnings there')
    explain.add_command(commands)
    chart.add_command(commands)
    compare.add_command(commands)
    return top


def render(options: argparse.Namespace, watcher: TerminalWatcher) -> None:
    """All that `cotorra render` does. Raises CommandError; an interrupt shows in `watcher.stop`."""
    # Look before Blender is loaded, and long before an image is lost.
    if options.file is not None:
        opening.require_source(options.file)
    if options.output.suffix.lower() not in FORMATS:
        raise CommandError(f'{options.output}: the name must end in .exr or .png', WRONG_ARGUMENTS)
    several = len(options.frame or [0]) > 1
    paths = {number: outputs.frame_path(options.output, number, several) for number in options.frame or [None]}
    require_places(options, list(paths.values()))

    scene = opening.open_scene(options.file, options.demo)
    apply(options, scene)
    if options.file is not None and not opening.is_blend(options.file):
        from . import importers

        importers.complete(scene)
    if None in paths:
        paths = {scene.frame_current: outputs.frame_path(options.output, scene.frame_current, several=False)}
        require_places(options, list(paths.values()))
    figures: list[dict[str, Any]] = []
    failure: CommandError | None = None
    try:
        for position, (number, path) in enumerate(paths.items()):
            if watcher.stop:
                raise CommandError(f'interrupted; frame {number} and later ones are not rendered', INTERRUPTED)
            watcher.label = f'Frame {number} ({position + 1}/{len(paths)})' if len(paths) > 1 else ''
            figures.append(render_frame(scene, number, path, watcher))
    except CommandError as error:
        failure = error
    if options.stats is not None:
        try:
            write_stats(options, figures, watcher.warnings())
        except CommandError as error:
            failure = CommandError(f'{failure}; {error}', failure.code) if failure is not None else error
    if failure is not None:
        raise failure


def require_places(options: argparse.Namespace, paths: list[Path]) -> None:
    """Fail where an image or the statistics cannot be written, or would be written over each other or over the file."""
    files = [options.file] if options.file is not None else []
    for path in paths:
        outputs.require_writable(path)
        outputs.require_apart(path, files, 'the image')
    if options.stats is not None:
        outputs.require_writable(options.stats)
        outputs.require_apart(options.stats, [*paths, *files], 'the statistics')


def apply(options: argparse.Namespace, scene: bpy.types.Scene) -> None:
    """Lay the arguments over the file's own settings."""
    import bpy

    # Strips and compositing bring other scenes into the picture: what is said of the render holds for them too.
    for item in {scene, *bpy.data.scenes}:
        apply_to_engine(options, item)
    render = scene.render
    if options.size is not None:
        factor = arguments.reduction(options.size)
        render.resolution_x, render.resolution_y = (factor * side for side in options.size)
        render.resolution_percentage = 100 // factor
    if render.use_multiview:
        watch.message('WARNING', f'Scene "{scene.name}": of its stereo views one picture is rendered')
        render.use_multiview = False
    if not opening.shows_anything(scene):
        raise CommandError(f'scene "{scene.name}" has no view layer that is on (Use for Rendering)')
    apply_format(options, scene)


def apply_to_engine(options: argparse.Namespace, scene: bpy.types.Scene) -> None:
    """What the engine is told of a scene."""
    from . import cycles_settings

    render = scene.render
    render.engine = choices.ENGINE
    if options.settings is not None:
        scene.cotorra.settings_from = options.settings
    for name, option in (
        ('samples', options.samples),
        ('seed', options.seed),
        ('use_denoising', options.denoise),
        ('time_limit', options.time_limit),
    ):
        if option is not None:
            cycles_settings.override(scene, name, option)
    if options.samples is not None:
        for layer in scene.view_layers:
            layer.samples = 0  # else the layer's own number would win
    if options.integrator is not None:
        scene.cotorra.integrator = options.integrator
    if options.tolerance is not None:
        scene.cotorra.auto_tolerance = options.tolerance
    if options.reweight is not None:
        if options.reweight > 0.0 and scene.cotorra.settings_from == 'CYCLES':
            watch.message('WARNING', f'Scene "{scene.name}": fireflies are not reweighted with the settings for Cycles')
        scene.cotorra.use_reweighting = options.reweight > 0.0
        scene.cotorra.reweighting_strength = options.reweight or 1.0
    if options.share_samples is not None:
        scene.cotorra.use_sample_sharing = options.share_samples
    if options.model is not None:
        scene.cotorra.use_model_override = True
        scene.cotorra.model_override.model = options.model
    if options.device is not None:
        scene.cotorra.device, scene.cotorra.device_index = options.device
    if options.ray_tracing is not None:
        scene.cotorra.ray_tracing = options.ray_tracing
    if options.health or options.strict:
        scene.cotorra.health = 'STRICT' if options.strict else 'REPORT'
    if options.threads is not None:
        render.threads_mode = 'FIXED' if options.threads else 'AUTO'
        render.threads = max(1, options.threads)


def apply_format(options: argparse.Namespace, scene: bpy.types.Scene) -> None:
    """The kind of image file; layers and passes that do not fit into one picture make a multilayer EXR."""
    from . import compat, passes

    image = scene.render.image_settings
    if FORMATS[options.output.suffix.lower()] == 'PNG':
        compat.set_image_format(image, 'PNG')
        image.color_depth = '8'
        image.color_mode = 'RGBA' if scene.render.film_transparent else 'RGB'
        return
    layers = [layer for layer in scene.view_layers if layer.use]
    # The noisy image alone, beside a denoised one, is no reason for a file that few programs read.
    several = len(layers) > 1 or any(len(list(passes.requested(layer, denoised=False))) > 1 for layer in layers)
    compat.set_image_format(image, 'OPEN_EXR_MULTILAYER' if several else 'OPEN_EXR')
    image.color_depth = '32'
    image.exr_codec = 'ZIP'
    image.color_mode = 'RGBA'


def render_frame(scene: bpy.types.Scene, frame: int, path: Path, watcher: TerminalWatcher) -> dict[str, Any]:
    """Render one frame into its file and give its figures."""
    began = time.perf_counter()
    stats.clear_everything()
    if scene.frame_current != frame:
        scene.frame_set(frame)
    with outputs.replacing(path) as new:
        # Braces in Blender's paths are expressions; doubled ones stand for themselves.
        scene.render.filepath = str(new).replace('{', '{{').replace('}', '}}')
        failure = opening.render_in_blender(scene)
        # Whether it went well is judged by what is there: Blender tells of errors that cost no picture, and of success
        # without one.
        layers = stats.everything()
        if any(layer.error for layer in layers) and any(layer.interrupted for layer in layers):
            raise CommandError(f'interrupted before anything was rendered; {path} is not written', INTERRUPTED)
        if any(layer.error for layer in layers) or (failure and not new.exists()):
            raise CommandError(f'{path} is not written, scene "{scene.name}", frame {frame}: {failure}')
        if not new.exists():
            raise CommandError(f'{path}: Blender did not write the image')
        width, height = outputs.require_whole(new, path)
    if failure:
        watch.message('WARNING', f'Scene "{scene.name}", frame {frame}: {failure}')
    seconds = time.perf_counter() - began
    words = [f'{width}×{height}']
    if layers:
        last = layers[-1]
        words.append(
            f'{last.samples_done} of {last.samples} samples' if last.interrupted else f'{last.samples} samples'
        )
    words.append(f'{seconds:.2f} s')
    if layers:
        words[-1] += (
            f' (sync {sum(layer.sync_seconds for layer in layers):.2f}, '
            f'build {sum(layer.build_seconds for layer in layers):.2f}, '
            f'render {sum(layer.render_seconds for layer in layers):.2f})'
        )
    watcher.note(f'{path}: {", ".join(words)}')
    return {'frame': frame, 'output': str(path), 'seconds': seconds, 'layers': [asdict(layer) for layer in layers]}


def write_stats(options: argparse.Namespace, figures: list[dict[str, Any]], warnings: list[str]) -> None:
    """The figures of all frames, and their sums; with what was warned of, also outside the renders."""
    layers = [layer for frame in figures for layer in frame['layers']]

    def total(key: str) -> float:
        return sum(layer[key] for layer in layers)

    def every(key: str) -> list[str]:
        return list(dict.fromkeys(text for layer in layers for text in layer[key]))

    rays: dict[str, int] = {}
    for layer in layers:
        for kind, count in layer['rays'].items():
            rays[kind] = rays.get(kind, 0) + count
    content = {
        'source': str(options.demo or options.file),
        'sync_seconds': total('sync_seconds'),
        'build_seconds': total('build_seconds'),
        'render_seconds': total('render_seconds'),
        'total_seconds': sum(frame['seconds'] for frame in figures),
        'rays': rays,
        'samples': max((layer['samples'] for layer in layers), default=0),
        'features': every('features'),
        'left_out': every('left_out'),
        'health': every('health'),
        'warnings': list(dict.fromkeys([*warnings, *every('warnings')])),
        'memory_peak_bytes': max((layer['memory_peak_bytes'] for layer in layers), default=0),
        'memory_above_bytes': max((layer['memory_above_bytes'] for layer in layers), default=0),
        'interrupted': any(layer['interrupted'] for layer in layers),
        'frames': figures,
    }
    text = json.dumps(content, indent=2, ensure_ascii=False) + '\n'
    with outputs.replacing(options.stats) as new:
        # Bytes of a name that are no UTF-8 become JSON's own \udc80 to \udcff.
        new.write_text(text, encoding='utf-8', errors='backslashreplace')


if __name__ == '__main__':
    sys.exit(main())
