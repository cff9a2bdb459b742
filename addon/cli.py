# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra render`: renders a .blend file or a demo at a terminal, with the Blender that the `bpy` module holds.

It sets, starts and reports; what is rendered and how is the engine's. Exit codes: 0 rendered, 1 failed, 2 wrong
arguments, 130 interrupted (what was rendered until then is saved).
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import choices, explain, outputs, stats, watch
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
RESOLUTION_MIN = 4  # Blender's
BLENDER_BYTES = 1300 * 2**20  # of addresses, before a file is opened (measured, 5.2); given less, Blender crashes


def main(arguments: Sequence[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    open_standard_streams()
    watcher = TerminalWatcher(sys.stderr)
    try:
        with watcher.stopped_by_signals(), watch.attached(watcher):
            if options.command == 'explain':
                explain.run(options, open_scene, CommandError)
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
    source = line.add_mutually_exclusive_group(required=True)
    source.add_argument('file', nargs='?', type=Path, metavar='FILE', help='what to render')
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
    line.add_argument('--samples', type=whole(1, choices.SAMPLES_MAX), metavar='N', help='paths for each pixel')
    line.add_argument('--seed', type=whole(0, choices.SEED_MAX), metavar='N', help='another number, other noise')
    one_of(line, '--integrator', choices.INTEGRATORS, "{} (default: the file's; path where it was never set)")
    line.add_argument(
        '--tolerance',
        type=percent,
        metavar='P',
        help='with integrator auto: most that what it leaves out may change the picture, percent of its mean',
    )
    line.add_argument(
        '--denoise',
        action=argparse.BooleanOptionalAction,
        help='take the noise out with OpenImageDenoise (default: as the file says, demos: no)',
    )
    line.add_argument(
        '--time-limit', type=seconds, metavar='S', help='stop each view layer after so many seconds, 0 for no limit'
    )
    one_of(
        line,
        '--settings',
        choices.SETTINGS_FROM,
        'whose settings hold: {} (default: those that were set for Cotorra, and for the rest those for Cycles)',
    )
    one_of(line, '--model', choices.MODELS, 'render all materials with one reflection model: {}')
    devices = ', '.join(identifier.lower() for identifier, _, _ in choices.DEVICES)
    line.add_argument('--device', type=device, metavar='NAME', help=f'{devices}; vulkan:1 for the second graphics card')
    one_of(line, '--ray-tracing', choices.RAY_TRACINGS, 'on a graphics card: {}')
    health = line.add_mutually_exclusive_group()
    health.add_argument('--health', action='store_true', help='count bad samples, and tell where they come from')
    health.add_argument('--strict', action='store_true', help='as --health; samples that are not finite are an error')
    line.add_argument('--threads', type=whole(0, choices.THREADS_MAX), metavar='N', help='0 for all processor cores')
    line.add_argument('--size', type=size, metavar='WxH', help='in pixels')
    line.add_argument('--stats', type=Path, metavar='FILE.json', help='write times, rays, memory and warnings there')
    explain.add_command(commands)
    chart.add_command(commands)
    compare.add_command(commands)
    return top


def one_of(line: argparse.ArgumentParser, option: str, items: Sequence[tuple[str, str, str]], text: str) -> None:
    """Adds an option that takes the identifier of one of these, in any case; text: its help, {} where they stand."""
    names = [identifier for identifier, _, _ in items]
    told = text.format(', '.join(names).lower())
    line.add_argument(option, type=str.upper, choices=names, metavar='NAME', help=told)


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


def seconds(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0.0 <= number <= choices.SECONDS_MAX:
        raise argparse.ArgumentTypeError(f'{text!r} is no time from 0 to {choices.SECONDS_MAX:g} s')
    return number


def percent(text: str) -> float:
    least, most = choices.TOLERANCES
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f'{text!r} is not from {least:g} to {most:g} %')
    return number


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
    sides = number(match[1]), number(match[2])
    if max(sides) > choices.SIZE_MAX // reduction(sides):
        most = choices.SIZE_MAX // RESOLUTION_MIN
        raise argparse.ArgumentTypeError(f'{text}: beside a side under {RESOLUTION_MIN}, {most} is the most')
    return sides


def reduction(sides: tuple[int, int]) -> int:
    """Blender's resolutions begin at 4: a smaller picture is rendered as a quarter of one that is not."""
    return RESOLUTION_MIN if min(sides) < RESOLUTION_MIN else 1


def render(options: argparse.Namespace, watcher: TerminalWatcher) -> None:
    """All that `cotorra render` does. Raises CommandError; an interrupt shows in `watcher.stop`."""
    # Look before Blender is loaded, and long before an image is lost.
    if options.file is not None:
        outputs.require_readable(options.file)
        if not is_blend(options.file) and options.file.suffix.lower() not in choices.IMPORTERS:
            raise CommandError(f'{options.file}: is none of .blend, {", ".join(choices.IMPORTERS)}', WRONG_ARGUMENTS)
    if options.output.suffix.lower() not in FORMATS:
        raise CommandError(f'{options.output}: the name must end in .exr or .png', WRONG_ARGUMENTS)
    several = len(options.frame or [0]) > 1
    paths = {number: outputs.frame_path(options.output, number, several) for number in options.frame or [None]}
    require_places(options, list(paths.values()))

    scene = open_scene(options)
    apply(options, scene)
    if options.file is not None and not is_blend(options.file):
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


def is_blend(path: Path) -> bool:
    """Whether it is a .blend file, by its name (backups end in .blend1) or by its first bytes, compressed or not."""
    if path.suffix.lower().startswith('.blend'):
        return True
    with path.open('rb') as file:
        return file.read(7).startswith((b'BLENDER', b'\x28\xb5\x2f\xfd', b'\x1f\x8b'))


def require_address_space() -> None:
    """Fail where a limit on the process's memory is too low for Blender to start."""
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < BLENDER_BYTES:
        needed = f'Blender needs {BLENDER_BYTES >> 20} MiB to start'
        raise CommandError(f'memory is limited to {limit >> 20} MiB (ulimit -v), and {needed}')


def open_scene(options: argparse.Namespace) -> bpy.types.Scene:
    """Load Blender, register the engine, and open the file or build the demo."""
    require_address_space()
    try:
        import bpy
    except ImportError as error:
        raise CommandError(f'the Python package bpy, which holds Blender, cannot be loaded: {error}') from error
    from . import register

    register()
    if options.demo is not None:
        from . import demos

        return demos.build(options.demo)
    if not is_blend(options.file):
        from . import importers

        return importers.load(options.file)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(options.file.resolve()), load_ui=False)
    except RuntimeError as error:
        raise CommandError(f'{options.file}: {blender_words(error)}') from error
    if bpy.app.autoexec_fail:
        watch.message('WARNING', f'{options.file}: its Python scripts were not run ({bpy.app.autoexec_fail_message})')
    return bpy.context.scene


def apply(options: argparse.Namespace, scene: bpy.types.Scene) -> None:
    """Lay the arguments over the file's own settings."""
    import bpy

    # Strips and compositing bring other scenes into the picture: what is said of the render holds for them too.
    for item in {scene, *bpy.data.scenes}:
        apply_to_engine(options, item)
    render = scene.render
    if options.size is not None:
        factor = reduction(options.size)
        render.resolution_x, render.resolution_y = (factor * side for side in options.size)
        render.resolution_percentage = 100 // factor
    if render.use_multiview:
        watch.message('WARNING', f'Scene "{scene.name}": of its stereo views one picture is rendered')
        render.use_multiview = False
    if not has_layers(scene) and not shows_sequence(scene) and not shows_other_scenes(scene):
        # Blender would write a black PNG, and crash where it writes EXR.
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


def has_layers(scene: bpy.types.Scene) -> bool:
    return any(layer.use for layer in scene.view_layers)


def shows_other_scenes(scene: bpy.types.Scene) -> bool:
    """Whether the picture is put together from other scenes' view layers, too."""
    from . import compat

    tree = compat.compositing_tree(scene) if scene.render.use_compositing else None
    trees = [tree] if tree is not None else []
    for tree in trees:  # grows by the groups that are met
        for node in tree.nodes:
            if node.type == 'R_LAYERS' and node.scene not in (None, scene) and has_layers(node.scene):
                return True
            inner = node.node_tree if node.type == 'GROUP' else None
            if inner is not None and inner not in trees:
                trees.append(inner)
    return False


def shows_sequence(scene: bpy.types.Scene) -> bool:
    """Whether the picture is the sequencer's; sound and what is muted show nothing."""
    editor = scene.sequence_editor
    strips = editor.strips if editor is not None and scene.render.use_sequencer else []
    return any(strip.type != 'SOUND' and not strip.mute for strip in strips)


def render_frame(scene: bpy.types.Scene, frame: int, path: Path, watcher: TerminalWatcher) -> dict[str, Any]:
    """Render one frame into its file and give its figures."""
    began = time.perf_counter()
    stats.clear_everything()
    if scene.frame_current != frame:
        scene.frame_set(frame)
    with outputs.replacing(path) as new:
        # Braces in Blender's paths are expressions; doubled ones stand for themselves.
        scene.render.filepath = str(new).replace('{', '{{').replace('}', '}}')
        failure = render_in_blender(scene)
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


def render_in_blender(scene: bpy.types.Scene) -> str:
    """Render into the scene's file path; the errors that Blender tells of, or ''."""
    import bpy

    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        return blender_words(error)
    return ''


def blender_words(error: RuntimeError) -> str:
    """Blender's own message out of the error that an operator raises."""
    lines = [re.sub(r'^Error: (Cotorra: )?', '', line) for line in str(error).splitlines()]
    return '; '.join(dict.fromkeys(line for line in lines if line))


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
