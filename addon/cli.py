# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra render`: renders a .blend file or a demo at a terminal, with the Blender that the `bpy` module holds.

It sets, starts and reports; what is rendered and how is the engine's. Exit codes: 0 rendered, 1 failed, 2 wrong
arguments, 130 interrupted (what was rendered until then is saved).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import choices, explain, stats, watch
from .terminal import TerminalWatcher

if TYPE_CHECKING:
    import bpy

FAILED, WRONG_ARGUMENTS, INTERRUPTED = 1, 2, 130
FORMATS = {'.exr': 'OPEN_EXR', '.png': 'PNG'}


class CommandError(Exception):
    """Why nothing, or not all, was rendered; shown after the program's name."""

    def __init__(self, text: str, code: int = FAILED) -> None:
        super().__init__(text)
        self.code = code


def main(arguments: Sequence[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    watcher = TerminalWatcher(sys.stderr)
    before = signal.signal(signal.SIGINT, watcher.interrupt)
    try:
        with watch.attached(watcher):
            if options.command == 'explain':
                explain.run(options, open_scene, CommandError)
            else:
                render(options, watcher)
    except CommandError as error:
        watcher.note(f'cotorra: {error}')
        return error.code
    finally:
        signal.signal(signal.SIGINT, before)
    return INTERRUPTED if watcher.stop else 0


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(prog='cotorra', description='Cotorra, a render engine for Blender, at a terminal.')
    commands = top.add_subparsers(dest='command', required=True, metavar='COMMAND')
    line = commands.add_parser(
        'render',
        help='render a .blend file or a demo',
        description='Renders the active scene of a .blend file, or a demo, with Cotorra.',
        epilog='demos: ' + '; '.join(f'{name}: {text}' for name, text in choices.DEMOS.items()),
    )
    source = line.add_mutually_exclusive_group(required=True)
    source.add_argument('file', nargs='?', type=Path, metavar='FILE.blend')
    source.add_argument('--demo', choices=choices.DEMOS, metavar='NAME', help=', '.join(choices.DEMOS))
    line.add_argument(
        '-o',
        '--output',
        required=True,
        type=Path,
        metavar='OUT',
        help='OUT.exr (32-bit float; a layer for each pass where there are several) or OUT.png (8 bit, as Blender '
        'displays it). ### stands for the frame number',
    )
    line.add_argument('--frame', type=frames, metavar='N|A..B', help="a frame or a range (default: the file's frame)")
    line.add_argument('--samples', type=whole(1, choices.SAMPLES_MAX), metavar='N', help='rays for each pixel')
    line.add_argument('--seed', type=whole(0, choices.SEED_MAX), metavar='N')
    names = [identifier for identifier, _, _ in choices.INTEGRATORS]
    line.add_argument('--integrator', type=str.upper, choices=names, metavar='NAME', help=', '.join(names).lower())
    models = [identifier for identifier, _, _ in choices.MODELS]
    line.add_argument(
        '--model',
        type=str.upper,
        choices=models,
        metavar='NAME',
        help=f'render all materials with one reflection model: {", ".join(models).lower()}',
    )
    devices = ', '.join(identifier.lower() for identifier, _, _ in choices.DEVICES)
    line.add_argument('--device', type=device, metavar='NAME', help=f'{devices}; vulkan:1 for the second graphics card')
    tracings = [identifier for identifier, _, _ in choices.RAY_TRACINGS]
    line.add_argument(
        '--ray-tracing',
        type=str.upper,
        choices=tracings,
        metavar='NAME',
        help=f'on a graphics card: {", ".join(tracings).lower()}',
    )
    line.add_argument('--threads', type=whole(0, choices.THREADS_MAX), metavar='N', help='0 for all processor cores')
    line.add_argument('--size', type=size, metavar='WxH', help='in pixels')
    line.add_argument('--stats', type=Path, metavar='FILE.json', help='write times, rays, memory and warnings there')
    explain.add_command(commands)
    return top


def whole(lowest: int, highest: int) -> Any:
    """A type of argument: a whole number within limits."""

    def read(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'{text!r} is not a whole number') from None
        if not lowest <= number <= highest:
            raise argparse.ArgumentTypeError(f'{number} is not from {lowest} to {highest}')
        return number

    return read


def device(text: str) -> tuple[str, int]:
    """A device, and which one where there are several: 'vulkan:1'; -1 lets the engine choose."""
    name, colon, index = text.partition(':')
    names = [identifier for identifier, _, _ in choices.DEVICES]
    if name.upper() not in names:
        raise argparse.ArgumentTypeError(f'{name.upper()!r} is none of {", ".join(names)}')
    return name.upper(), whole(0, choices.DEVICE_INDEX_MAX)(index) if colon else -1


def frames(text: str) -> range:
    match = re.fullmatch(r'(-?\d+)(?:\.\.(-?\d+))?', text)
    if match is None:
        raise argparse.ArgumentTypeError(f'{text!r} is neither a frame nor a range A..B')
    first = int(match[1])
    last = int(match[2] or match[1])
    if last < first:
        raise argparse.ArgumentTypeError(f'the range {text} is empty')
    if max(abs(first), abs(last)) > choices.FRAME_MAX:
        raise argparse.ArgumentTypeError(f'frames go to {choices.FRAME_MAX}')
    return range(first, last + 1)


def size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r'(\d+)x(\d+)', text)
    if match is None:
        raise argparse.ArgumentTypeError(f'{text!r} is not a size such as 1920x1080')
    number = whole(1, choices.SIZE_MAX)
    return number(match[1]), number(match[2])


def render(options: argparse.Namespace, watcher: TerminalWatcher) -> None:
    """All that `cotorra render` does. Raises CommandError; an interrupt shows in `watcher.stop`."""
    # Look before Blender is loaded, and long before an image is lost.
    if options.file is not None and not options.file.is_file():
        raise CommandError(f'{options.file}: there is no such file')
    if options.output.suffix.lower() not in FORMATS:
        raise CommandError(f'{options.output}: the name must end in .exr or .png', WRONG_ARGUMENTS)
    outputs = {}
    for number in options.frame or [None]:
        outputs[number] = frame_path(options.output, number, several=len(options.frame or [0]) > 1)
        require_writable(outputs[number])
    if options.stats is not None:
        require_writable(options.stats)

    scene = open_scene(options)
    apply(options, scene)
    if None in outputs:
        outputs = {scene.frame_current: frame_path(options.output, scene.frame_current, several=False)}
        require_writable(outputs[scene.frame_current])
    figures: list[dict[str, Any]] = []
    try:
        for position, (number, path) in enumerate(outputs.items()):
            if watcher.stop:
                raise CommandError('interrupted; ' + f'frame {number} and later ones are not rendered', INTERRUPTED)
            watcher.label = f'Frame {number} ({position + 1}/{len(outputs)})' if len(outputs) > 1 else ''
            figures.append(render_frame(scene, number, path, watcher))
    finally:
        if options.stats is not None:
            write_stats(options.stats, options, figures)


def open_scene(options: argparse.Namespace) -> bpy.types.Scene:
    """Load Blender, register the engine, and open the file or build the demo."""
    try:
        import bpy
    except ImportError as error:
        raise CommandError(f'the Python package bpy, which holds Blender, cannot be loaded: {error}') from error
    from . import register

    register()
    if options.demo is not None:
        from . import demos

        return demos.build(options.demo)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(options.file.resolve()), load_ui=False)
    except RuntimeError as error:
        raise CommandError(f'{options.file}: {blender_words(error)}') from error
    if bpy.app.autoexec_fail:
        watch.active.message(
            'WARNING', f'{options.file}: its Python scripts were not run ({bpy.app.autoexec_fail_message})'
        )
    return bpy.context.scene


def apply(options: argparse.Namespace, scene: bpy.types.Scene) -> None:
    """Lay the arguments over the scene's own settings."""
    from . import compat, passes

    render = scene.render
    render.engine = choices.ENGINE
    if options.samples is not None:
        scene.cotorra.samples = options.samples
        for layer in scene.view_layers:
            layer.samples = 0  # else the layer's own number would win
    if options.seed is not None:
        scene.cotorra.seed = options.seed
    if options.integrator is not None:
        scene.cotorra.integrator = options.integrator
    if options.model is not None:
        scene.cotorra.use_model_override = True
        scene.cotorra.model_override.model = options.model
    if options.device is not None:
        scene.cotorra.device, scene.cotorra.device_index = options.device
    if options.ray_tracing is not None:
        scene.cotorra.ray_tracing = options.ray_tracing
    if options.threads is not None:
        render.threads_mode = 'FIXED' if options.threads else 'AUTO'
        render.threads = max(1, options.threads)
    if options.size is not None:
        # Blender's resolutions begin at 4: a smaller picture is a quarter of one that is not.
        factor = 4 if min(options.size) < 4 else 1
        wanted = (factor * options.size[0], factor * options.size[1])
        render.resolution_x, render.resolution_y = wanted
        render.resolution_percentage = 100 // factor
        if (render.resolution_x, render.resolution_y) != wanted:
            raise CommandError(f'Blender cannot render a picture of {options.size[0]}×{options.size[1]} pixels')
    if render.use_multiview:
        watch.active.message('WARNING', f'Scene "{scene.name}": of its stereo views one picture is rendered')
        render.use_multiview = False

    file_format = FORMATS[options.output.suffix.lower()]
    image = render.image_settings
    if file_format == 'PNG':
        compat.set_image_format(image, 'PNG')
        image.color_depth = '8'
        image.color_mode = 'RGBA' if render.film_transparent else 'RGB'
    else:
        layers = [layer for layer in scene.view_layers if layer.use]
        several = len(layers) > 1 or any(len(list(passes.requested(layer))) > 1 for layer in layers)
        compat.set_image_format(image, 'OPEN_EXR_MULTILAYER' if several else 'OPEN_EXR')
        image.color_depth = '32'
        image.exr_codec = 'ZIP'
        image.color_mode = 'RGBA'


def render_frame(scene: bpy.types.Scene, frame: int, path: Path, watcher: TerminalWatcher) -> dict[str, Any]:
    """Render one frame into its file and give its figures."""
    import bpy

    began = time.perf_counter()
    stats.clear(scene.name)
    if scene.frame_current != frame:
        scene.frame_set(frame)
    # Braces in Blender's paths are expressions; doubled ones stand for themselves.
    scene.render.filepath = str(path.resolve()).replace('{', '{{').replace('}', '}}')
    old = modified(path)
    failure = ''
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        failure = blender_words(error)
    layers = stats.last(scene.name)
    if failure:
        if any(layer.interrupted for layer in layers):
            raise CommandError(f'interrupted before anything was rendered; {path} is not written', INTERRUPTED)
        raise CommandError(f'{path} is not written, scene "{scene.name}", frame {frame}: {failure}')
    if not layers:
        raise CommandError(f'{path} is not written, scene "{scene.name}" renders none of its view layers')
    if modified(path) == old:
        raise CommandError(f'{path}: Blender did not write the image')
    require_whole(path)
    seconds = time.perf_counter() - began
    last = layers[-1]
    samples = f'{last.samples_done} of {last.samples}' if last.interrupted else str(last.samples)
    watcher.note(
        f'{path}: {last.width}×{last.height}, {samples} samples, {seconds:.2f} s '
        f'(sync {sum(layer.sync_seconds for layer in layers):.2f}, '
        f'build {sum(layer.build_seconds for layer in layers):.2f}, '
        f'render {sum(layer.render_seconds for layer in layers):.2f})'
    )
    return {'frame': frame, 'output': str(path), 'seconds': seconds, 'layers': [asdict(layer) for layer in layers]}


def frame_path(pattern: Path, frame: int | None, several: bool) -> Path:
    """The file of a frame: its number in place of the last run of #, else before the suffix if frames are several."""
    hashes = re.search(r'#+(?=[^#]*$)', pattern.name)
    if hashes is None and several:
        return pattern.with_name(f'{pattern.stem}{frame:04d}{pattern.suffix}')
    if hashes is None or frame is None:
        return pattern
    number = f'{frame:0{len(hashes[0])}d}'
    return pattern.with_name(pattern.name[: hashes.start()] + number + pattern.name[hashes.end() :])


def require_writable(path: Path) -> None:
    """Fail now if the file cannot be written later; folders that are missing are made, as Blender does."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f'{path}: the folder {path.parent} cannot be made: {error.strerror}') from error
    try:
        existed = path.exists()
        with path.open('ab'):
            pass
        if not existed:
            path.unlink()
    except OSError as error:
        raise CommandError(f'{path}: cannot be written: {error.strerror}') from error


def require_whole(path: Path) -> None:
    """Fail if the image breaks off: where the disk is full, Blender writes half an image and tells of success."""
    import OpenImageIO as oiio

    image = oiio.ImageInput.open(str(path))
    part = 0
    while image is not None and image.seek_subimage(part, 0):
        part += 1
        spec = image.spec()
        if image.read_scanline(spec.y + spec.height - 1, 0, 'float') is None:
            part = 0
            break
    if part == 0:
        raise CommandError(f'{path}: the image was not written to its end; is there space left?')


def modified(path: Path) -> tuple[int, int] | None:
    """When the file was written last, and its size; None where there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def blender_words(error: RuntimeError) -> str:
    """Blender's own message out of the error that an operator raises."""
    lines = [re.sub(r'^Error: (Cotorra: )?', '', line) for line in str(error).splitlines()]
    return '; '.join(dict.fromkeys(line for line in lines if line))


def write_stats(path: Path, options: argparse.Namespace, figures: list[dict[str, Any]]) -> None:
    """The figures of all frames, and their sums."""
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
        'warnings': every('warnings'),
        'memory_peak_bytes': max((layer['memory_peak_bytes'] for layer in layers), default=0),
        'memory_above_bytes': max((layer['memory_above_bytes'] for layer in layers), default=0),
        'interrupted': any(layer['interrupted'] for layer in layers),
        'frames': figures,
    }
    try:
        path.write_text(json.dumps(content, indent=2, ensure_ascii=False) + '\n', encoding='utf-8')
    except OSError as error:
        raise CommandError(f'{path}: cannot be written: {error.strerror}') from error


if __name__ == '__main__':
    sys.exit(main())
