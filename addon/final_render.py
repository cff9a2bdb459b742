# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render of one view layer: export, build, render, passes; with progress, and with a way out at any time.

It holds the order of things and what happens when they fail; it looks into no object and computes no pixel.
"""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import bpy
import numpy as np

from . import auto, denoise, export, health, lamps, native, passes, preview, settings, stats, watch
from .export.buffers import Camera, RenderSettings, SceneBuffers
from .log import Cancelled, Log, spelled
from .reporter import Reporter, position_in_frame
from .shader.ops import tables
from .sync import changes, stores

POLL_SECONDS = 0.02

# Pictures in between: the first soon, the next ones less and less often, and never for more than 1/20 of the time.
FIRST_PICTURE_SECONDS = 0.3
PICTURE_SECONDS = 1.0
PICTURE_GROWTH = 1.25
PICTURE_SECONDS_MAX = 10.0
PICTURE_COST = 20.0
MANY_LIGHTS = 100_000  # so many are told of
READINGS = ('unweighted', 'combined')  # the picture without and with weights of fireflies


class RenderError(Exception):
    """Something that the user can set right; shown as it is, without a traceback."""


def render_view_layer(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
    """Render one view layer into Blender's render result.

    Nothing is raised: an exception that reaches Blender leaves a blank file and exit code 0, or crashes it when it
    saves EXR. So the open result is always ended, and a failure becomes an error report, which Blender passes on.
    """
    error = ''
    # In a window the others end Blender, as they end every program.
    with watch.interrupt_as_flag(['SIGINT'] if in_window() else watch.STOP_SIGNALS) as interrupt:

        def should_stop() -> bool:
            watcher = watch.active
            return bool(interrupt.by) or stop_asked(engine) or (watcher is not None and watcher.stop)

        show = None if engine.is_preview else message_sink(engine)
        job = RenderJob(engine, depsgraph, Log(show, should_stop))
        try:
            job.begin()
            job.run()
        except Cancelled:
            job.stats.interrupted = True
            if not stop_asked(engine):  # else Blender stopped it itself, and knows
                if not job.frame_has_pixels():
                    error = 'Stopped before anything was rendered'
                elif interrupt.by:
                    error = f'Interrupted by {interrupt.by}; the render result holds what was rendered until then'
        except (RenderError, native.NativeError, MemoryError) as failure:
            error = str(failure) or 'out of memory'
        except BaseException as failure:
            watch.show_traceback()
            error = f'{type(failure).__name__}: {failure}'
        error = '; '.join(job.log.texts('ERROR')) or error
        try:
            job.end(error)
        except BaseException as failure:
            watch.show_traceback()
            error = error or f'{type(failure).__name__}: {failure}'
    if error and not engine.is_preview:
        engine.report({'ERROR'}, spelled(f'Cotorra: {error}'))


def stop_asked(engine: bpy.types.RenderEngine) -> bool:
    """Whether the user stopped the render in Blender: Esc in the window, Ctrl-C at `blender -b`."""
    return engine.test_break()


def message_sink(engine: bpy.types.RenderEngine) -> Callable[[str, str], None]:
    """Where messages go: to the watcher if there is one, else to Blender's Info log (background mode prints it)."""

    def show(level: str, text: str) -> None:
        if level == 'ERROR':
            return  # it ends the render, and is reported there
        if not watch.message(level, text):
            engine.report({level}, spelled(text))

    return show


def in_window() -> bool:
    """Whether anyone sees pictures in between."""
    return not bpy.app.background


class RenderJob:
    """One view layer on its way through the phases; lives as long as `render_view_layer` runs."""

    def __init__(self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, log: Log) -> None:
        self.engine = engine
        self.depsgraph = depsgraph
        self.log = log
        self.scene = depsgraph.scene_eval
        self.layer = depsgraph.view_layer_eval
        self.result: bpy.types.RenderResult | None = None
        self.film = passes.Film()
        self.denoising: denoise.Denoising | None = None
        self.time_limit = 0.0  # seconds, 0: none
        self.tolerance = 0.01  # integrator AUTO's, share of the mean
        self.is_spread = False
        self.filter_width = 0.0  # pixels
        self.auto: tuple[auto.Facts, auto.Materials | None] | None = None  # until it has chosen
        self.start = time.perf_counter()
        self.memory = stats.MemoryMeter()
        self.stats = stats.LayerStats(self.layer.name, self.scene.frame_current)
        self.reporter = Reporter(engine, depsgraph.scene, self.layer, self.memory)

    def begin(self) -> None:
        """Open the render result; its size is the border's where a border is rendered."""
        engine = self.engine
        if position_in_frame(self.depsgraph.scene, self.layer)[0] == 0 and not engine.is_preview:
            stats.clear(self.scene.name)
        self.result = engine.begin_result(0, 0, engine.resolution_x, engine.resolution_y, layer=self.layer.name)
        if self.result is None or len(self.result.layers) == 0:
            raise RenderError(f'Blender gave no render result for view layer "{self.layer.name}"')

    def frame_has_pixels(self) -> bool:
        """Whether anything of this frame is rendered, in this view layer or in one before."""
        return any(entry.progress > 0.0 for entry in [*stats.last(self.scene.name), self.stats])

    def run(self) -> None:
        """Export, build and render; raises Cancelled when the user stops it, or stopped an earlier layer."""
        if any(entry.interrupted for entry in stats.last(self.scene.name)):
            raise Cancelled
        module = native.load()
        settings.warn_left_out(self.scene, self.layer, self.log)

        # Synchronise: Blender's data become arrays.
        self.reporter.phase('Synchronizing')
        began = time.perf_counter()
        camera_object = self.engine.camera_override or self.scene.camera
        if camera_object is not None:
            camera_object = camera_object.evaluated_get(self.depsgraph)
        camera = export.export_camera(self.scene, camera_object, self.log)
        if camera is None:
            raise RenderError(f'Scene "{self.scene.name}" has no camera that can be rendered')
        self.filter_width = camera.filter_width
        size = (self.result.resolution_x, self.result.resolution_y)
        if camera.region[2:] != size:
            raise ValueError(f'the camera renders {camera.region}, but Blender wants {size}')
        store = None if self.engine.is_preview else stores.store_of_render(self.depsgraph)
        kept = None if store is None else store.kept
        buffers = export.export_scene(self.depsgraph, self.scene, self.layer, self.log, kept=kept)
        sources = passes.native_sources(self.result, buffers.light_groups, lamps.pass_numbers(self.layer))
        self.denoising = settings.denoising(self.scene, self.layer)
        features = self.denoising.features() if self.denoising is not None else ()
        render_settings = settings.render_settings(
            self.scene, self.layer, tuple(dict.fromkeys([*sources.values(), *features])), self.log
        )
        self.film = settings.film(self.scene, camera, self.log)
        self.time_limit = settings.time_limit(self.scene, self.log)
        if self.engine.is_preview:
            render_settings = preview.smaller(render_settings)
            self.denoising, self.time_limit = None, preview.SECONDS_MAX
        self.tolerance = settings.auto_tolerance(self.scene, self.log)
        # Previews are over before a pilot would be.
        if self.scene.cotorra.integrator == 'AUTO' and not self.engine.is_preview:
            parts = self.auto_parts(buffers)
            self.auto = auto.facts(buffers), auto.Materials(buffers, parts) if parts else None
        self.stats.sync_seconds = time.perf_counter() - began
        self.memory.sample()
        self.log.checkpoint()

        # Build: the arrays become a scene that rays can be sent into.
        self.reporter.phase('Building')
        began = time.perf_counter()
        native_scene, previous = self.native_scene(module, buffers, store)
        ops = {op.number: name for name, op in tables().ops.items()} if render_settings.health else {}
        names = health.Names(buffers.materials.names, buffers.lights.names, ops)
        del buffers
        if render_settings.device == 'CPU':
            self.build_bvh(module, native_scene, render_settings.threads, previous)
        del previous
        self.stats.build_seconds = time.perf_counter() - began
        self.stats.scene = dict(native_scene.stats())
        self.tell_of_lights(self.stats.scene)
        self.reporter.scene_bytes = self.stats.scene['memory_bytes']
        self.memory.sample()
        self.log.checkpoint()

        # Choose: integrator AUTO leaves out what the picture does not need.
        if self.auto is not None:
            native_scene, render_settings = self.choose(module, native_scene, camera, render_settings)
            self.auto = None
        told = dataclasses.replace(render_settings, samples=auto.asked_samples(render_settings))
        self.stats.describe(size, self.scene.cotorra.device, told)

        # Render: until all samples are there or the user stops it; either way what is there goes into the passes.
        self.reporter.phase('Rendering')
        session = self.open_session(module, native_scene, camera, render_settings)
        figures = session.stats()
        if figures['device'] != 'CPU':
            self.log.info(f'{figures["device"]} renders, tracing rays by {figures["isa"]}')
        try:
            try:
                self.render(session, render_settings, sources)
            except module.DeviceError as error:
                if session.progress() > 0.0:
                    passes.write(session, self.result, sources, render_settings.samples, self.film)
                self.fall_back(module, native_scene, render_settings, error, session)
                session.continue_on_cpu()
                self.render(session, render_settings, sources)
            self.tell_of_clamping(session, render_settings)
            if render_settings.reweighting > 0.0:
                self.tell_of_reweighting(session)
            if render_settings.adaptive:
                self.tell_of_noise(session, render_settings)
            self.tell_of_health(session, render_settings, names)
            if self.denoising is not None:
                self.denoise(session, self.denoising)
        finally:
            session.cancel()
            self.stats.take(session)
            if self.is_spread:
                self.stats.samples_done = min(self.stats.samples_done, self.stats.auto['spread']['fewest'])

    def auto_parts(self, buffers: SceneBuffers) -> tuple[auto.Part, ...]:
        """Of the materials, what AUTO may leave out: nothing of those that are switched off."""
        if 'models' not in settings.auto_rows(self.scene.cotorra):
            return ()
        kept = frozenset(entry.name for entry in bpy.data.materials if not entry.cotorra.use_auto)
        return tuple(auto.parts_of(buffers, kept))

    def choose(
        self, module: ModuleType, scene: Any, camera: Camera, render_settings: RenderSettings
    ) -> tuple[Any, RenderSettings]:
        """What AUTO makes of the scene and the settings; it says so before the render begins."""
        self.reporter.phase('Pilot')
        began = time.perf_counter()
        facts, materials = self.auto
        rows = settings.auto_rows(self.scene.cotorra)

        def build(buffers: SceneBuffers) -> Any:
            made = interruptible(module, self.log, lambda stop: module.Scene(buffers, should_cancel=stop, bvh=False))
            self.build_bvh(module, made, render_settings.threads)
            return made

        pilot = auto.Pilot(module, scene, camera, self.log.checkpoint, build)
        chosen = auto.choose(pilot, camera, render_settings, facts, self.tolerance, rows, materials, self.time_limit)
        self.stats.pilot_seconds = time.perf_counter() - began
        self.stats.auto = chosen.figures()
        for sentence in chosen.sentences():
            self.log.info(sentence)
        return chosen.scene or scene, chosen.settings

    def native_scene(self, module: ModuleType, buffers: SceneBuffers, store: stores.Store | None) -> tuple[Any, Any]:
        """The scene, and one from before whose BVHs it may take over; with Persistent Data the very one from before,
        where nothing changed."""
        if store is None:
            return interruptible(
                module, self.log, lambda stop: module.Scene(buffers, should_cancel=stop, bvh=False)
            ), None
        previous = store.scene
        if store.buffers is not None and changes.equal(store.buffers, buffers):
            return previous, None
        scene = interruptible(
            module,
            self.log,
            lambda stop: module.Scene(buffers, should_cancel=stop, bvh=False, editable=True, previous=previous),
        )
        store.scene, store.buffers = scene, buffers
        return scene, previous

    def tell_of_lights(self, scene: dict) -> None:
        """What a great many lights cost: so many are seldom meant."""
        count = scene['lights'] + scene['emitters']
        if count >= MANY_LIGHTS:
            self.log.info(
                f'{scene["lights"]} lamps and {scene["emitters"]} triangles that emit take '
                f'{scene["light_bytes"] / 2**20:.0f} MiB and {scene["light_tree_seconds"]:.1f} s'
            )

    def build_bvh(self, module: ModuleType, scene: Any, threads: int, previous: Any = None) -> None:
        """What the CPU needs to trace rays, if it has not; graphics cards build their own."""
        embree = native.embree_library()
        known = {} if previous is None else {'previous': previous}
        interruptible(module, self.log, lambda stop: scene.build_bvh(threads, embree, should_cancel=stop, **known))

    def open_session(self, module: ModuleType, scene: Any, camera: Camera, render_settings: RenderSettings) -> Any:
        try:
            return module.Session(scene, camera, render_settings)
        except module.DeviceError as error:
            self.fall_back(module, scene, render_settings, error)
            return module.Session(scene, camera, dataclasses.replace(render_settings, device='CPU'))

    def fall_back(
        self, module: ModuleType, scene: Any, render_settings: RenderSettings, error: Exception, session: Any = None
    ) -> None:
        """Prepares the scene for the CPU, where the user allows that it takes over; raises RenderError else."""
        device, done = render_settings.device, session is not None and session.progress() > 0.0
        if device == 'CPU' or not self.scene.cotorra.use_device_fallback:
            kept = '; the render result holds what was rendered until then' if done else ''
            raise RenderError(f'{device}: {error}{kept}') from error
        after = f' after {session.samples_done()} of {render_settings.samples} samples' if done else ''
        self.log.warning(f'The CPU renders instead of {device}{after}: {error}')
        self.reporter.phase('Building')
        began = time.perf_counter()
        self.build_bvh(module, scene, render_settings.threads)
        self.stats.build_seconds += time.perf_counter() - began
        self.stats.scene = dict(scene.stats())
        self.reporter.scene_bytes = self.stats.scene['memory_bytes']
        self.stats.device = f'{device}, CPU' if done else 'CPU'
        self.reporter.phase('Rendering')

    def render(self, session: Any, render_settings: RenderSettings, sources: dict[str, str]) -> None:
        film = self.film
        began, late = time.perf_counter(), False
        show_pictures = in_window()
        next_picture, pause = time.perf_counter() + FIRST_PICTURE_SECONDS, PICTURE_SECONDS
        session.start()
        self.tell_progress(session, render_settings)
        while not session.wait(POLL_SECONDS) or self.spread(session, render_settings):
            if self.log.stopped():
                session.cancel()
                continue
            now = time.perf_counter()
            late = late or (0.0 < self.time_limit <= now - began and session.samples_done() > 0)
            if late:
                session.cancel()
                continue
            picture_due = show_pictures and now >= next_picture
            if picture_due:
                passes.write(session, self.result, sources, render_settings.samples, film, only='Combined')
                self.engine.update_result(self.result)
                cost = time.perf_counter() - now
                next_picture = now + cost + max(pause, PICTURE_COST * cost)
                pause = min(pause * PICTURE_GROWTH, PICTURE_SECONDS_MAX)
            self.tell_progress(session, render_settings, redrawn=picture_due)
        passes.write(session, self.result, sources, render_settings.samples, film)
        self.tell_progress(session, render_settings, last=True)
        if late and session.progress() < 1.0:
            self.log.info(
                f'The time limit of {self.time_limit:g} s ended the render after {session.samples_done()} of '
                f'{auto.asked_samples(render_settings)} samples'
            )
        elif session.progress() < 1.0:
            self.log.checkpoint()

    def tell_progress(self, session: Any, render_settings: RenderSettings, **when: bool) -> None:
        """Of the samples that were asked for; a session that will be spread may take more of some pixels."""
        asked = auto.asked_samples(render_settings)
        scale = 1.0 if self.is_spread else render_settings.samples / asked
        self.reporter.rendering(session, asked, scale, **when)

    def spread(self, session: Any, render_settings: RenderSettings) -> bool:
        """Lets a session that has its first samples go on where there is noise. False where nothing is to go on."""
        first = render_settings.spread_after
        if self.is_spread or not 0 < first <= session.samples_done() or self.log.stopped():
            return False
        self.is_spread = True
        combined = passes.read(session, self.result, 'combined')
        differences = np.zeros((*combined.shape[:2], 3), np.float32)
        session.differences(differences)
        samples = auto.asked_samples(render_settings)
        reach = auto.shared_reach(render_settings, self.filter_width)
        found = auto.spread_samples(differences, combined[..., :3].sum(axis=2), first, samples, reach)
        self.stats.auto['spread'] = found.figures()
        self.log.info(found.sentence())
        session.spread(found.most)
        session.start()
        return True

    def tell_of_clamping(self, session: Any, render_settings: RenderSettings) -> None:
        """How much light the file's means against fireflies took out of the picture or blurred, where that is counted.

        Caustics are what comes to a rough surface by way of gloss or glass.
        """
        figures = session.stats()
        names = ('held_light', 'held_caustics', 'caustics')
        light = figures.get('light', 0.0)
        held, of_caustics, caustics = (100.0 * figures.get(name, 0.0) / light if light > 0.0 else 0.0 for name in names)
        if held > 0.0:
            told = f', {of_caustics:.2g} % in caustics' if of_caustics > 0.0 else ''
            self.log.info(f'Clamping held back {held:.2g} % of the light{told}')
        if render_settings.filter_glossy > 0.0 and caustics > of_caustics:
            self.log.info(f'Filter Glossy blurred caustics that are {caustics - of_caustics:.2g} % of the light')

    def tell_of_reweighting(self, session: Any) -> None:
        """What the weights of fireflies took out of the picture (below 0) or, where light takes away, put into it."""
        plain, kept = (float(passes.read(session, self.result, name)[..., :3].mean(dtype=float)) for name in READINGS)
        if plain == 0.0:
            return
        self.stats.reweighting = 100.0 * (kept - plain) / abs(plain)
        self.log.info(
            f'Reweighting fireflies changed the light by {self.stats.reweighting:+.2g} % '
            f'(pass "{passes.UNWEIGHTED_IMAGE}" is without)'
        )

    def tell_of_noise(self, session: Any, render_settings: RenderSettings) -> None:
        """The error that is left: below the threshold where few samples did, above it where the last one came first."""
        self.stats.noise = float(passes.read(session, self.result, 'noise').mean())
        self.log.info(f'Noise left: {self.stats.noise:.2g} (threshold {render_settings.noise_threshold:.2g})')

    def tell_of_health(self, session: Any, render_settings: RenderSettings, names: health.Names) -> None:
        """Samples that were dropped, and where bad ones come from, where they are counted. STRICT: an error."""
        figures = session.stats()
        bad, rejected = figures.get('bad_samples', []), figures.get('rejected_samples', 0)
        if render_settings.health and render_settings.device != 'CPU':
            self.log.warning('Bad samples are counted on the CPU alone')
        self.stats.health = health.report(bad, figures.get('samples', 0), rejected, names)
        for text in self.stats.health:
            self.log.warning(f'Numerical health: {text}')
        if rejected and not render_settings.health:
            self.log.info('Render > Speed and Accuracy > Numerical Health tells where such samples come from')
        if self.scene.cotorra.health == 'STRICT' and health.faults(bad):
            raise RenderError(f'{health.faults(bad)} samples are bad (Numerical Health is strict)')

    def denoise(self, session: Any, how: denoise.Denoising) -> None:
        """Replace Combined, which stays as it is where that is stopped or cannot be done."""
        self.reporter.phase('Denoising')
        began = time.perf_counter()
        pixels = passes.read(session, self.result, 'combined')
        features = {name: passes.read(session, self.result, name) for name in how.features()}
        try:
            clean = interruptible(
                native.load(), self.log, lambda stop: denoise.denoised(pixels[..., :3], features, how, stop)
            )
        except denoise.DenoiseError as error:
            self.log.warning(f'The picture is not denoised: {error}')
            return
        self.log.checkpoint()
        pixels[..., :3] = clean
        passes.write_combined(self.result, pixels, self.film)
        self.stats.denoise_seconds = time.perf_counter() - began

    def end(self, error: str) -> None:
        """Give the result back to Blender, with whatever is in it, and keep the figures."""
        if self.result is not None:
            self.engine.end_result(self.result)
        self.log.close()
        self.stats.error = error
        self.stats.warnings = self.log.texts('WARNING')
        self.stats.total_seconds = time.perf_counter() - self.start
        self.stats.measure(self.memory)
        if not self.engine.is_preview:  # Blender's scenes for previews are no scene of the user's
            stats.record(self.scene.name, self.stats)


def interruptible(module: ModuleType, log: Log, work: Callable[[Callable[[], bool]], Any]) -> Any:
    """What `work(should_cancel)` returns; a thread of its own does it, so that this one sees the wish to stop."""
    cancel = threading.Event()
    outcome: list[Any] = []
    failure: list[BaseException] = []

    def run() -> None:
        try:
            outcome.append(work(cancel.is_set))
        except BaseException as error:
            failure.append(error)

    worker = threading.Thread(target=run, name='cotorra build', daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(POLL_SECONDS)
        if log.stopped():
            cancel.set()
    if failure:
        raise Cancelled if isinstance(failure[0], module.Cancelled) else failure[0]
    return outcome[0]
