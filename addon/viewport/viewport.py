# SPDX-License-Identifier: GPL-3.0-or-later
"""One viewport from an edit to what is seen: export, build, sessions, picture; and what is said where that fails.

One lives as long as the engine instance that Blender makes for a region. A failure is told in the viewport and is over
with the next edit: no exception reaches Blender from here.
"""

from __future__ import annotations

import sys
import time
import weakref
from dataclasses import replace
from typing import Any

import bpy

from .. import export, native, settings, stats, watch
from ..denoise import Denoising
from ..export.buffers import Camera, RenderSettings, SceneBuffers
from ..export.studio import read_studio
from ..lamps import lone_lamp
from ..log import Log, spelled
from ..reporter import duration
from ..sync import changes, stores
from . import preview, ticking, view
from .building import Build
from .denoising import Denoiser
from .drawing import Canvas
from .progression import Picture, Progression

# How long the window waits for what will soon be there, rather than to show what is old.
WAIT_FOR_BUILD = 0.1
WAIT_FOR_COARSE = 0.05


class ViewportError(Exception):
    """Something that the user can set right."""


class Viewport:
    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = weakref.ref(engine)
        self._canvas = Canvas()
        self._progression: Progression | None = None
        self._build: Build | None = None
        self._store: stores.Store | None = None
        self._buffers: SceneBuffers | None = None  # of which the scene is, or will be, built
        self._how: tuple = ()
        self._scene: Any = None  # the native one
        self._traceable = False  # whether it has what the CPU needs
        self._settings: RenderSettings | None = None
        self._camera: Camera | None = None
        self._shown: tuple = ()
        self._film: Any = None
        self._exported: tuple | None = None  # what of the space's settings the scene was exported with
        self._stale = False  # whether a session must begin, whatever the camera
        self._paused = False
        self._denoiser = Denoiser()
        self._denoising: Denoising | None = None
        self._clean = False  # whether what is shown is without noise
        self._began = time.perf_counter()
        self._rested = 0.0
        self._lost: tuple[tuple, str] | None = None  # a graphics card that failed, and what is said of it
        self._told = ''  # the failure whose traceback was printed last
        self._note = ''  # why what is shown is not what was chosen
        self.message = ''
        self.closed = False

    def __del__(self) -> None:
        self.close()  # Blender freed the engine, which held this

    # ---- What Blender calls

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Something of the scene changed."""
        self._guarded(self._update, context, depsgraph)
        ticking.watch(self)

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        region = context.region
        size = (max(region.width, 1), max(region.height, 1))
        self._guarded(self._render, context, depsgraph, size)
        engine = self._engine()
        if engine is None:
            return
        self._guarded(self._canvas.draw, engine, depsgraph.scene, size)
        engine.update_stats(*map(spelled, self._words()))

    def look(self) -> bool:
        """Ask for a redraw where there is something new; whether to be asked again."""
        engine = self._engine()
        if engine is None or self.closed:
            return False
        build, progression = self._build, self._progression
        try:
            engine.is_preview  # noqa: B018  raises where Blender freed the engine and Python still holds it
        except ReferenceError:
            self.close()
            return False
        try:
            news = (build is not None and build.done()) or (progression is not None and progression.has_news())
            news = news or self._denoiser.has_news
        except Exception:  # of the session's threads: `draw` tells it
            news = True
        if news:
            engine.tag_redraw()
        return build is not None or (progression is not None and progression.working) or self._denoiser.busy

    def close(self) -> None:
        """End all threads, and let go of what is held. May be called again."""
        self.closed = True
        ticking.forget(self)
        stats.forget_viewport(id(self))
        self._denoiser.cancel()
        build, self._build = self._build, None
        if build is not None:
            build.cancel()
        progression, self._progression = self._progression, None
        if progression is not None:
            progression.close()
        self._scene = self._store = self._buffers = None
        self._canvas.clear()

    # ---- From an edit to a native scene

    def _update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        module = native.load()
        if self._progression is not None:
            self._progression.hold()  # of what was before: it would only delay what comes now
        self.message = ''
        self._exported = _filters(context.space_data)
        log = Log()
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        if self._store is None:
            self._store = stores.store_of(depsgraph)
        store = self._store
        store.kept.note(depsgraph.updates)
        buffers = export.export_scene(depsgraph, scene, layer, log, context.space_data, store.kept)
        found = self._wanted(scene, layer, preview.shown_pass(context.space_data, layer)[0], log)
        settings.warn_left_out(scene, layer, log)
        stats.note_viewport(id(self), depsgraph.scene.name, log.texts('WARNING'))
        errors = log.texts('ERROR')
        if errors:
            raise ViewportError('; '.join(errors))
        how = found.device, found.threads
        known = self._buffers
        self._buffers, self._how, same_how = buffers, how, how == self._how
        if known is not None and same_how and changes.equal(known, buffers):
            self._buffers = known
            if self._build is None and self._progression is not None:
                self._progression.resume()
            return  # what it is built of stands
        if self._build is not None:
            self._build.cancel()
        embree = native.embree_library() if found.device == 'CPU' else None
        self._build = Build(module, buffers, found.threads, embree, store.scene)
        self._build.done(WAIT_FOR_BUILD)

    def _take_build(self) -> None:
        build = self._build
        if build is None or not build.done():
            return
        self._build = None
        if build.error is not None:
            raise build.error
        if build.scene is not None:
            self._scene = self._store.scene = build.scene
            self._traceable = build.for_cpu
            self._stale = True

    # ---- From a native scene to a picture

    def _wanted(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, shown: str, log: Log) -> RenderSettings:
        """The settings, with the CPU in place of a graphics card that failed, for as long as it is the chosen one."""
        found = preview.render_settings(scene, layer, shown, log)
        return replace(found, device='CPU') if self._lost is not None and self._lost[0] == _card(found) else found

    def _render(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, size: tuple[int, int]) -> None:
        try:
            self._advance(context, depsgraph, size)
        except Exception as failure:
            scene, settings = depsgraph.scene_eval, self._settings
            if settings is None or settings.device == 'CPU' or not _of_device(failure):
                raise
            if not scene.cotorra.use_device_fallback:
                raise ViewportError(f'{settings.device}: {failure}') from failure
            self._lost = _card(settings), f'The CPU renders instead of {settings.device}: {failure}'
            self._rest()
            self._update(context, depsgraph)

    def _advance(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, size: tuple[int, int]) -> None:
        if self._exported is not None and self._exported != _filters(context.space_data):
            self._update(context, depsgraph)  # of which Blender tells nobody
        self._take_build()
        if self._scene is None:
            return
        log = Log()
        scene, layer, space = depsgraph.scene_eval, depsgraph.view_layer_eval, context.space_data
        camera_object = space.camera if space.use_local_camera else depsgraph.scene.camera
        if camera_object is not None:
            camera_object = camera_object.evaluated_get(depsgraph)
        camera = view.read_view(scene, space, context.region_data, size, camera_object, log)
        if camera is None:
            raise ViewportError('; '.join(log.texts('ERROR')))
        shown, self._note = preview.shown_pass(space, layer)
        wanted = self._wanted(scene, layer, shown, log)
        if wanted.device == 'CPU' and not self._traceable:
            return  # another is being built
        finest = preview.pixel_size(scene, context.preferences)
        self._film = settings.film(scene, camera, log)
        self._paused = preview.paused(depsgraph.scene)
        if self._paused:
            if self._progression is not None:
                self._progression.stop()
            self._stale = True
            return
        self._denoising, start = preview.denoising(scene, shown), preview.denoising_start(scene)
        known = wanted, shown, finest, self._denoising, start
        if self._stale or not view.same(camera, self._camera) or known != self._shown:
            self._restart(camera, known)
            self._progression.wait(WAIT_FOR_COARSE)
        self._show(self._progression.take(), size)
        if self._progression.working or self._denoiser.busy:
            ticking.watch(self)
        elif self._rested == 0.0:
            self._rested = time.perf_counter() - self._began

    def _restart(self, camera: Camera, known: tuple) -> None:
        wanted, shown, finest, how, start = known
        if self._progression is None:
            self._progression = Progression(native.load())
        self._denoiser.cancel()
        self._camera, self._settings, self._shown = camera, wanted, known
        self._stale = self._clean = False
        self._began, self._rested = time.perf_counter(), 0.0
        self.message = ''
        features = () if how is None else how.features()
        self._progression.restart(self._scene, camera, wanted, shown, finest, features, start if features else 0)

    def _show(self, picture: Picture | None, size: tuple[int, int]) -> None:
        """The newest picture: a clean one, from the first of these on."""
        how, start = self._shown[3:]
        if picture is not None:
            wanted = how is not None and picture.divisor == self._shown[2] and picture.samples >= start
            if wanted and not self._denoiser.error:
                self._denoiser.offer(picture, how)
            if not self._clean:
                self._load(picture, size)
        clean = self._denoiser.take()
        if clean is not None:
            self._clean = True
            self._load(clean, size)

    def _load(self, picture: Picture, size: tuple[int, int]) -> None:
        native_pass = self._shown[1]
        pixels = picture.pixels.copy() if self._denoising is not None else picture.pixels
        if native_pass == 'sample_count':
            pixels[..., :3] /= max(picture.samples, 1)
        self._film.develop(native_pass, pixels)
        self._canvas.load(pixels, picture.place, size)

    # ---- What is said

    def _words(self) -> tuple[str, str]:
        """Blender's line over the viewport: how far it is, or what is wrong."""
        if self.message:
            return '', f'Cotorra: {self.message}'
        if self._paused:
            return '', 'Rendering Paused'
        if self._scene is None:
            return '', 'Building' if self._build is not None else 'Waiting'
        progression = self._progression
        if progression is None or self._settings is None:
            return '', 'Rendering'
        samples, fraction = progression.figures()
        if progression.coarse:
            samples, fraction = 0, 0.0
        total = self._settings.samples
        elapsed = time.perf_counter() - self._began
        lost = self._lost is not None and self._settings.device == 'CPU'
        notes = [note for note in (self._note, self._lost[1] if lost else '') if note]
        if self._denoiser.error and self._denoising is not None:
            notes.append(f'Not denoised: {self._denoiser.error}')
        if not progression.working:
            return ' | '.join([*notes, f'Time: {duration(self._rested)}']), 'Rendering Done'
        words = [*notes, f'Time: {duration(elapsed)}']
        if total == preview.SAMPLES_MAX:
            return ' | '.join(words), f'Sample {samples}'
        if 0.0 < fraction < 1.0:
            words.append(f'Remaining: {duration(elapsed * (1.0 - fraction) / fraction)}')
        return ' | '.join(words), f'Sample {samples}/{total}'

    def _guarded(self, work: Any, *arguments: Any) -> None:
        """Whatever goes wrong becomes the message in the viewport."""
        try:
            work(*arguments)
        except (ViewportError, native.NativeError, MemoryError) as failure:
            self._fail(str(failure) or 'out of memory')
        except Exception as failure:
            text = str(failure) or type(failure).__name__
            if not _of_device(failure) and text != self._told:
                self._told = text
                watch.show_traceback()
            self._fail(text)

    def _fail(self, message: str) -> None:
        self._rest()
        self.message = message

    def _rest(self) -> None:
        """Nothing is at work, and nothing will be before the next edit."""
        self._denoiser.cancel()
        build, self._build = self._build, None
        if build is not None:
            build.cancel()
        if self._progression is not None:
            self._progression.close()
        self._scene, self._stale = None, False
        self._exported = self._buffers = None


def _card(settings: RenderSettings) -> tuple:
    return settings.device, settings.device_index, settings.ray_tracing


def _filters(space: bpy.types.SpaceView3D) -> tuple:
    """What decides what a viewport shows, beside the scene."""
    local = space.local_view is not None, space.use_local_collections
    return *local, space.shading.use_scene_lights_render, read_studio(space), lone_lamp(space)


def _of_device(failure: Exception) -> bool:
    """Whether a graphics card failed, and no program."""
    kind = getattr(sys.modules.get('cotorra_native'), 'DeviceError', None)
    return kind is not None and isinstance(failure, kind)
