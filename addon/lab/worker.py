# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that renders: it opens a scene once, then renders one job after the other by any engine.

usage: python -m cotorra.lab.worker FOLDER. FOLDER/task.json says what to open; jobs come as lines of JSON at stdin, and
each is answered by a file FOLDER/NUMBER.json, the opening by 0.json. It ends where stdin does. It judges nothing.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import arguments, opening, stats, watch
from ..terminal import FAILED, CommandError
from . import plan

if TYPE_CHECKING:
    import bpy

    from ..metrics import Image

AREA = 320 * 180  # pixels, where no size is asked for; the file's own shape stays


class Clock:
    """Seconds and processor seconds from the first sample on, by what engines report while they render."""

    def __init__(self) -> None:
        self.cpu = self.wall = 0.0
        self.reset()

    def reset(self) -> None:
        self.cpu_begin = self.wall_begin = None

    def status(self, text: str, *_: object) -> None:
        """A handler of Blender's render_stats."""
        if 'Sample ' in text or 'Rendering' in text or 'Rendered ' in text:
            self.begin()

    def begin(self) -> None:
        if self.cpu_begin is None:
            self.cpu_begin, self.wall_begin = time.process_time(), time.perf_counter()

    def end(self, *_: object) -> None:
        """A handler of Blender's render_post."""
        if self.cpu_begin is not None:
            self.cpu = time.process_time() - self.cpu_begin
            self.wall = time.perf_counter() - self.wall_begin


class Silent(watch.Watcher):
    """Takes what the engine says, so that warnings can be told once by who started the worker."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.warnings: dict[str, None] = {}

    def progress(self, state: watch.Progress) -> None:
        if state.phase == 'Rendering':
            self.clock.begin()

    def message(self, level: str, text: str) -> None:
        if level == 'WARNING':
            self.warnings[text] = None


def open_task(task: dict[str, Any]) -> bpy.types.Scene:
    """Opens the file or demo and makes it ready: its own camera, layers and frame, at a reduced size."""
    from .. import compat

    file = Path(task['file']) if task['file'] else None
    scene = opening.open_scene(file, task['demo'])
    render = scene.render
    shape = render.resolution_x / render.resolution_y * render.pixel_aspect_x / render.pixel_aspect_y
    size = task['size'] or [round((AREA * shape) ** 0.5), round((AREA / shape) ** 0.5)]
    render.resolution_x, render.resolution_y = (max(arguments.RESOLUTION_MIN, side) for side in size)
    render.resolution_percentage = 100
    if file is not None and not opening.is_blend(file):
        from .. import importers

        importers.complete(scene)
    if scene.camera is None:
        raise CommandError(f'{task["file"] or task["demo"]}: scene "{scene.name}" has no camera')
    if not opening.has_layers(scene):
        raise CommandError(f'scene "{scene.name}" has no view layer that is on (Use for Rendering)')
    if task['frame'] is not None:
        scene.frame_set(task['frame'])
    if task['threads'] is not None:
        render.threads_mode = 'FIXED' if task['threads'] else 'AUTO'
        render.threads = max(1, task['threads'])
    # What Blender does before and after the engine is the same for all, and none of it is charted.
    render.use_compositing = render.use_sequencer = render.use_multiview = False
    render.use_persistent_data = False
    render.use_file_extension = False
    compat.set_image_format(render.image_settings, 'OPEN_EXR_MULTILAYER')
    render.image_settings.color_depth, render.image_settings.exr_codec = '32', 'NONE'
    scene.cotorra.use_device_fallback = False
    share_settings(scene)
    return scene


def share_settings(scene: bpy.types.Scene) -> None:
    """Cycles is given what holds for us, where it has a setting of the same meaning: both solve one problem."""
    from .. import cycles_settings

    for name, path in cycles_settings.INHERITED.items():
        owner, _, last = path.rpartition('.')
        theirs = getattr(scene, owner, None) if owner == 'cycles' else None
        if theirs is not None:
            setattr(theirs, last, cycles_settings.inherited(scene, name))


def set_up(scene: bpy.types.Scene, series: plan.Series, samples: int, seed: int) -> None:
    """Everything that one job may have changed for the next."""
    from .. import cycles_settings
    from .apply import apply

    if series.engine == 'EEVEE':
        require_eevee()
    apply(scene, series, samples)
    if series.engine == 'COTORRA':
        for name, value in (('seed', seed), ('time_limit', 0.0)):
            cycles_settings.override(scene, name, value)
    elif series.engine == 'CYCLES':
        scene.cycles.seed, scene.cycles.time_limit = seed, 0.0


def require_eevee() -> None:
    """EEVEE draws by OpenGL or Vulkan, and would end the process where there is neither."""
    import bpy
    import gpu

    try:
        if bpy.app.background and hasattr(gpu, 'init'):
            gpu.init()
        gpu.platform.backend_type_get()
    except (SystemError, AttributeError, RuntimeError) as error:
        raise CommandError(f'EEVEE cannot render here: {str(error).splitlines()[0]}') from error


def read_layers(path: Path) -> tuple[Image, dict[str, Any]]:
    """Combined of all layers, one below the other, (h, w, 3) float32, and the file's attributes."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise CommandError(f'Blender did not write the picture: {oiio.geterror()}')
    layers, attributes, part = [], {}, 0
    while source.seek_subimage(part, 0):
        spec = source.spec()
        attributes.update({entry.name: entry.value for entry in spec.extra_attribs})
        names = list(spec.channelnames)
        if any(name.endswith('.Combined.R') for name in names):
            pixels = source.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)
            for name in names:
                if name.endswith('.Combined.R'):
                    channels = [names.index(name[:-1] + channel) for channel in 'RGB']
                    layers.append(np.ascontiguousarray(pixels[:, :, channels], np.float32))
        part += 1
    source.close()
    if not layers:
        raise CommandError('Blender wrote no picture')
    return np.concatenate(layers), attributes


def own_clock(text: str) -> float:
    """Seconds of Cycles' '[hh:]mm:ss.ff'."""
    seconds = 0.0
    for part in text.split(':'):
        seconds = seconds * 60 + float(part)
    return seconds


def render(scene: bpy.types.Scene, job: dict[str, Any], folder: Path, clock: Clock, sharing: bool) -> dict[str, Any]:
    """Renders a job (series, samples, seed) and answers with seconds and the picture's file.

    sharing: the file's setting. Pictures of references do without: their pixels are taken as independent.
    """
    series = plan.Series(**job['series'])
    set_up(scene, series, job['samples'], job['seed'])
    scene.cotorra.use_sample_sharing = sharing and not job['reference']
    path = folder / 'render.exr'
    path.unlink(missing_ok=True)
    scene.render.filepath = str(path).replace('{', '{{').replace('}', '}}')
    stats.clear_everything()
    clock.reset()
    began, cpu = time.perf_counter(), time.process_time()
    failure = opening.render_in_blender(scene)
    whole, cpu = time.perf_counter() - began, time.process_time() - cpu
    layers = stats.everything()
    problem = '; '.join(layer.error for layer in layers if layer.error) or failure
    if not path.exists() or any(layer.error for layer in layers):
        raise CommandError(f'{series.name}: {problem or "nothing was rendered"}')
    image, attributes = read_layers(path)
    wall = clock.wall if clock.cpu_begin is not None else whole
    if series.engine == 'COTORRA':
        wall = sum(layer.render_seconds + layer.denoise_seconds for layer in layers)
    elif series.engine == 'CYCLES':
        # Its clock shows hundredths of a second: of short renders ours tells more.
        theirs = [value for name, value in attributes.items() if name.endswith('.render_time')]
        seconds = sum(own_clock(str(value)) for value in theirs)
        wall = seconds if seconds > 1.0 else min(wall, seconds + 0.01 * len(theirs))
    target = folder / f'{job["number"]}.npy'
    np.save(target, image)
    inner = clock.cpu if clock.cpu_begin is not None else cpu
    return {'wall': max(wall, 1e-4), 'cpu': max(inner, 1e-4), 'whole': whole, 'image': str(target)}


def answer(folder: Path, number: int, content: dict[str, Any]) -> None:
    new = folder / f'{number}.new'
    new.write_text(json.dumps(content), encoding='utf-8')
    os.replace(new, folder / f'{number}.json')


def main(folder: Path) -> None:
    clock = Clock()
    watcher = Silent(clock)
    with watch.attached(watcher):
        try:
            task = json.loads((folder / 'task.json').read_text(encoding='utf-8'))
            scene = open_task(task)
            import bpy

            bpy.app.handlers.render_stats.append(clock.status)
            bpy.app.handlers.render_post.append(clock.end)
            found = {
                'scene': scene.name,
                'size': [scene.render.resolution_x, scene.render.resolution_y],
                'frame': scene.frame_current,
                'layers': sum(layer.use for layer in scene.view_layers),
                'blender': bpy.app.version_string,
            }
            sharing = scene.cotorra.use_sample_sharing
            answer(folder, 0, found)
        except CommandError as error:
            answer(folder, 0, {'error': str(error), 'code': error.code})
            return
        except Exception as error:
            answer(folder, 0, {'error': f'{type(error).__name__}: {error}', 'code': FAILED})
            raise
        for line in sys.stdin:
            job = json.loads(line)
            try:
                done = render(scene, job, folder, clock, sharing)
            except CommandError as error:
                done = {'error': str(error)}
            answer(folder, job['number'], {**done, 'warnings': list(watcher.warnings)})


if __name__ == '__main__':
    main(Path(sys.argv[1]))
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 hangs at exit while an engine written in Python is registered
