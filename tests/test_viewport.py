# SPDX-License-Identifier: GPL-3.0-or-later
"""One viewport from an edit to a picture, with the real native module and without a window.

Stand-ins take what would be drawn; what Blender's own window does is tried by scripts/window-test.
"""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import bpy
import numpy as np
import pytest
from cotorra import denoise, native, settings, stats
from cotorra.export.buffers import RenderSettings
from cotorra.export.studio import Studio
from cotorra.log import Log
from cotorra.ui import warnings_panel
from cotorra.viewport.viewport import Viewport

from devices import counts_bad_samples
from scenes import build
from scenes.depsgraphs import exported, exported_camera
from viewports import SIZE, Window, space

pytestmark = pytest.mark.usefixtures('engine')

SAMPLES = 8


@pytest.fixture
def window(monkeypatch: pytest.MonkeyPatch):
    scene = build.new_scene()
    scene.render.engine = 'COTORRA'
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.cycles.preview_samples, scene.cycles.use_preview_adaptive_sampling = SAMPLES, False
    camera = build.camera(scene)
    camera.location, camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
    build.mesh_object(scene)
    light = build.link(scene, 'Point', bpy.data.lights.new('Point', 'POINT'))
    light.location, light.data.energy = (0.5, 0.5, 3.0), 200.0
    found = Window(monkeypatch)
    yield found
    found.viewport.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith('cotorra')]


def final(scene: bpy.types.Scene, name: str = 'combined') -> np.ndarray:
    """What a final render of so many samples has."""
    module = native.load()
    built = module.Scene(exported(scene), embree=native.embree_library())
    evaluated = bpy.context.evaluated_depsgraph_get()
    found = settings.render_settings(evaluated.scene_eval, evaluated.view_layer_eval, ('combined', name), Log())
    session = module.Session(built, exported_camera(scene), replace(found, samples=SAMPLES, device='CPU'))
    session.start()
    assert session.wait(60.0)
    out = np.zeros((SIZE[1], SIZE[0], 4 if name == 'combined' else 3), np.float32)
    session.read(name, out)
    return out


def test_large_pixels_come_first_and_the_last_picture_is_the_final_one(window: Window) -> None:
    window.update()
    window.settle()
    pictures = window.pictures
    (first, place), (last, whole) = pictures[0], pictures[-1]
    assert first.shape[0] < SIZE[1] and place[2] >= SIZE[0] and place[3] >= SIZE[1]
    assert last.shape == (SIZE[1], SIZE[0], 4) and whole == (0, 0, *SIZE)
    assert window.said == 'Rendering Done'
    expected = final(bpy.context.scene)
    assert expected[..., :3].max() > 0.1
    tiles = (a[:, :, :3].reshape(4, 16, 6, 16, 3).mean(axis=(1, 3)) for a in (last, expected))
    # The bound. They differ, if at all, as both took the same samples of one scene.
    np.testing.assert_allclose(*tiles, rtol=0.005, atol=1e-4)


def test_a_view_that_moves_begins_anew_and_one_that_rests_does_not(window: Window) -> None:
    window.update()
    window.settle()
    count = len(window.pictures)
    window.draw()
    window.settle()
    assert len(window.pictures) == count
    bpy.context.scene.camera.location.x += 0.5
    bpy.context.view_layer.update()
    window.draw()
    window.settle()
    assert len(window.pictures) > count
    assert np.abs(window.pictures[-1][0] - final(bpy.context.scene)).max() < 1e-2


def test_an_edit_is_seen(window: Window) -> None:
    window.update()
    window.settle()
    before = window.pictures[-1][0][..., :3].mean()
    bpy.data.lights['Point'].energy *= 3.0
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    assert window.pictures[-1][0][..., :3].mean() == pytest.approx(3.0 * before, rel=1e-3)


def test_scene_lights_can_be_left_out(window: Window) -> None:
    """Blender tells nobody that this was switched off: the viewport sees it when it draws."""
    window.update()
    window.settle()
    window.space = space(lights=False)
    window.settle()
    assert window.pictures[-1][0][..., :3].max() == 0.0


@pytest.mark.parametrize(('shown', 'native_pass'), [('NORMAL', 'normal'), ('DIFFUSE_COLOR', 'diffuse_color')])
def test_another_pass_is_shown(window: Window, shown: str, native_pass: str) -> None:
    window.space = space(shown)
    window.update()
    window.settle()
    found = window.pictures[-1][0]
    expected = final(bpy.context.scene, native_pass)
    assert expected.any()
    np.testing.assert_allclose(found[..., :3], expected, atol=1e-3)
    assert (found[..., 3] == 1.0).all()


@pytest.mark.parametrize(('shown', 'native_pass'), [('LIGHT', 'light:1'), ('LIGHT_GROUP', 'lightgroup:1')])
def test_one_light_is_shown_alone(window: Window, shown: str, native_pass: str) -> None:
    """As final renders have it in a pass: there, numbers go by the names of all lamps or groups."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    other = build.link(scene, 'Blue', bpy.data.lights.new('Blue', 'POINT'))
    other.location, other.data.energy, other.data.color = (-0.7, 0.0, 2.0), 300.0, (0.1, 0.2, 1.0)
    for name in ('Blue', 'Point'):
        layer.lightgroups.add(name=name)
        bpy.data.objects[name].lightgroup = name
    layer.update()
    window.space = space(shown, alone='Point')
    window.update()
    window.settle()
    found = window.pictures[-1][0][..., :3]
    layer.cotorra.use_pass_lights = True
    np.testing.assert_allclose(found, final(scene, native_pass), atol=1e-3)
    both = final(scene)[..., :3]
    assert 0.1 < found.max() < both.max() and found[..., 2].mean() < 0.9 * both[..., 2].mean()

    window.space = space(shown, alone='Gone')
    window.settle()
    assert 'Gone' in window.engine.words[-1][0]
    window.space = space(shown)
    window.settle()
    assert 'No light' in window.engine.words[-1][0]
    np.testing.assert_allclose(window.pictures[-1][0][..., :3], both, atol=1e-3)


@counts_bad_samples
def test_bad_samples_are_shown(window: Window) -> None:
    """A lamp below 0 gives them."""
    window.space = space('HEALTH')
    bpy.data.lights['Point'].energy = -200.0
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    found = window.pictures[-1][0]
    np.testing.assert_allclose(found[..., :3], final(bpy.context.scene, 'health'), atol=1e-3)
    assert found[..., 1].max() > 0.0


def test_a_transparent_film_has_holes(window: Window) -> None:
    bpy.context.scene.render.film_transparent = True
    bpy.data.objects['Quad'].scale = (0.2, 0.2, 0.2)
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    alpha = window.pictures[-1][0][..., 3]
    assert alpha[0, 0] == 0.0 and alpha[SIZE[1] // 2, SIZE[0] // 2] == pytest.approx(1.0)


def test_pause_leaves_the_picture_and_goes_on_where_it_ends(window: Window) -> None:
    scene = bpy.context.scene
    window.update()
    window.settle()
    count = len(window.pictures)
    scene.cycles.preview_pause = True
    bpy.data.lights['Point'].energy *= 2.0
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    assert window.said == 'Rendering Paused' and len(window.pictures) == count
    scene.cycles.preview_pause = False
    window.settle()
    assert window.said == 'Rendering Done' and len(window.pictures) > count


def test_zero_samples_go_on_without_end(window: Window) -> None:
    bpy.context.scene.cycles.preview_samples = 0
    window.update()
    window.draw()
    for _ in range(3):
        window.draw()
    assert window.viewport.look()
    assert window.said.startswith('Sample') and '/' not in window.said


@pytest.mark.parametrize('size', [(1, 1), (1, 300), (7, 5)])
def test_a_region_of_any_size(window: Window, size: tuple[int, int]) -> None:
    window.size = size
    window.update()
    window.settle()
    assert window.pictures[-1][0].shape == (size[1], size[0], 4)
    assert np.isfinite(window.pictures[-1][0]).all()


def test_no_camera_is_needed_for_a_free_view(window: Window, monkeypatch: pytest.MonkeyPatch) -> None:
    context = window.context
    context.region_data.view_perspective = 'PERSP'
    bpy.context.scene.camera = None
    bpy.context.view_layer.update()
    monkeypatch.setattr(Window, 'context', context)
    window.update()
    window.settle()
    assert window.said == 'Rendering Done'


def test_a_failure_is_told_in_the_viewport_and_over_with_the_next_edit(
    window: Window, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    def missing() -> None:
        raise native.NativeError('no module today')

    with monkeypatch.context() as patch:
        patch.setattr(native, 'load', missing)
        window.update()
        for _ in range(3):
            window.draw()
        assert window.said == 'Cotorra: no module today' and not window.pictures
    window.update()
    window.settle()
    assert window.said == 'Rendering Done'
    assert 'Traceback' not in capfd.readouterr().err


def test_a_fault_prints_its_traceback_once(
    window: Window, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    def broken(*_: object) -> None:
        raise ValueError('broken export')

    monkeypatch.setattr('cotorra.export.export_scene', broken)
    for _ in range(3):
        window.update()
        window.draw()
    assert window.said == 'Cotorra: broken export'
    assert capfd.readouterr().err.count('Traceback') == 1


def test_an_engine_that_blender_freed_is_let_go(window: Window) -> None:
    class Freed:
        @property
        def is_preview(self) -> bool:
            raise ReferenceError

    window.update()
    window.draw()
    freed = Freed()
    window.viewport._engine = lambda: freed
    assert not window.viewport.look()
    assert window.viewport.closed and not window.viewport.look()


def test_threads_end_with_the_engine(window: Window) -> None:
    """Blender frees an engine when it pleases; nobody else holds the viewport then."""
    bpy.context.scene.cycles.preview_samples = 0
    window.update()
    window.draw()
    session = window.viewport._progression._session
    assert not session.wait(0.0)
    window.viewport = None
    assert session.wait(0.0)
    window.viewport = Viewport(window.engine)


def test_an_update_that_changes_nothing_costs_no_samples(window: Window) -> None:
    """What is selected, Blender tells too. Rays stop meanwhile, and go on."""
    bpy.context.scene.cycles.preview_samples = 0

    def samples(at_least: int) -> int:
        end = time.perf_counter() + 60.0
        while (found := window.viewport._progression.figures()[0]) < at_least or window.viewport._progression.coarse:
            assert time.perf_counter() < end, f'{found} samples'
            window.draw()
        return found

    window.update()
    window.draw()
    before = samples(SAMPLES)
    session = window.viewport._progression._session
    held: list[bool] = []
    hold = window.viewport._progression.hold
    window.viewport._progression.hold = lambda: (hold(), held.append(window.viewport._progression._held))
    window.update()
    assert held == [True] and not window.viewport._progression._held
    samples(before + 1)
    assert window.viewport._progression._session is session


def test_where_nothing_takes_the_noise_out_it_is_told(window: Window, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object) -> None:
        raise denoise.DenoiseError('no library today')

    monkeypatch.setattr(denoise, 'denoised', missing)
    bpy.context.scene.cycles.use_preview_denoising = True
    window.update()
    window.settle()
    assert window.said == 'Rendering Done' and window.engine.words[-1][0].startswith('Not denoised: no library today')
    assert window.pictures[-1][0][..., :3].max() > 0.1


def test_what_is_left_out_is_told(window: Window) -> None:
    scene = bpy.context.scene
    window.update()
    before = stats.of_viewports(scene.name)
    bpy.data.objects['Quad'].is_holdout = True
    bpy.context.view_layer.update()
    window.update()
    said = set(stats.of_viewports(scene.name)) - set(before)
    assert said == {'Object "Quad": holdout is not supported yet: it is rendered as an ordinary object'}
    assert said <= set(warnings_panel.problems(scene))


def test_noise_is_taken_out_from_a_sample_on(window: Window) -> None:
    """The clean picture replaces the noisy one, and no noisy one is shown after it."""
    scene = bpy.context.scene
    quad = bpy.data.objects['Quad']
    quad.location.z = -0.5
    bpy.data.lights['Point'].shadow_soft_size = 1.0
    block = build.mesh_object(scene, 'Block')
    block.scale, block.location = (0.4, 0.4, 1.0), (0.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    noisy = window.pictures[-1][0][..., :3]
    scene.cycles.use_preview_denoising, scene.cycles.preview_denoising_start_sample = True, 4
    scene.update_tag()
    bpy.context.view_layer.update()
    window.settle()
    clean = window.pictures[-1][0][..., :3]
    assert clean.shape == noisy.shape and np.isfinite(clean).all()
    assert clean.mean() == pytest.approx(noisy.mean(), rel=0.05)

    def roughness(pixels: np.ndarray) -> float:
        return float(np.abs(np.diff(pixels.mean(axis=2), axis=1)).mean())

    assert roughness(clean) < 0.8 * roughness(noisy)
    assert not window.viewport._denoiser.busy and window.viewport._clean


def without_card(reason: str) -> SimpleNamespace:
    """The native module where a graphics card cannot be used."""
    module = native.load()

    def session(scene: object, camera: object, settings: RenderSettings, **options: object) -> object:
        if settings.device != 'CPU':
            raise module.DeviceError(reason)
        return module.Session(scene, camera, settings, **options)

    return SimpleNamespace(**{**vars(module), 'Session': session})


@pytest.mark.parametrize('falls_back', [True, False])
def test_a_card_that_fails(window: Window, monkeypatch: pytest.MonkeyPatch, falls_back: bool) -> None:
    """The CPU renders instead, and the viewport says so; or it says what is wrong, where that is not wanted."""
    scene = bpy.context.scene
    scene.cotorra.device, scene.cotorra.use_device_fallback = 'VULKAN', falls_back
    stand_in = without_card('the card is lost')
    monkeypatch.setattr(native, 'load', lambda: stand_in)
    window.update()
    window.settle()
    if not falls_back:
        assert window.said == 'Cotorra: VULKAN: the card is lost' and not window.pictures
        return
    assert window.said == 'Rendering Done' and window.pictures[-1][0][..., :3].max() > 0.1
    assert any('The CPU renders instead of VULKAN: the card is lost' in words for words, _ in window.engine.words)
    # It stays so with edits, until another card is chosen.
    count = len(window.pictures)
    bpy.data.lights['Point'].energy *= 2.0
    bpy.context.view_layer.update()
    window.update()
    window.settle()
    assert window.said == 'Rendering Done' and len(window.pictures) > count


def test_a_card_keeps_the_scene_where_the_view_moves(window: Window, module: ModuleType) -> None:
    scene = bpy.context.scene
    scene.cotorra.device = 'VULKAN'
    window.update()
    window.settle()
    session = window.viewport._progression._session
    expected = final(scene)
    assert np.abs(window.pictures[-1][0] - expected).mean() < 1e-3
    scene.camera.location.x += 0.5
    bpy.context.view_layer.update()
    window.settle()
    assert window.viewport._progression._session is session
    assert session.stats()['device'] != 'CPU'
    assert np.abs(window.pictures[-1][0] - final(scene)).mean() < 1e-3
    assert np.abs(window.pictures[-1][0] - expected).mean() > 1e-2


def test_studio_light_takes_the_place_of_the_world(window: Window, tmp_path: Path, monkeypatch) -> None:
    """An image of one color lights by it, and is seen as far as its opacity says."""
    image = bpy.data.images.new('Studio', 8, 4, float_buffer=True, is_data=True)
    image.pixels = [0.5, 0.25, 0.125, 1.0] * 32
    image.filepath_raw, image.file_format = str(tmp_path / 'studio.exr'), 'OPEN_EXR'
    image.save()
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new('World')
    scene.world.color = (0.0, 0.0, 1.0)
    bpy.data.objects['Quad'].scale = (0.3, 0.3, 0.3)
    bpy.data.objects['Point'].hide_viewport = True
    bpy.context.view_layer.update()
    chosen = Studio(str(tmp_path / 'studio.exr'), 1.0, 2.0, 0.25)
    for user in ('export.studio', 'viewport.viewport'):
        monkeypatch.setattr(f'cotorra.{user}.read_studio', lambda _space: chosen)
    window.update()
    window.settle()
    picture = window.pictures[-1][0][..., :3]
    seen = 0.25 * 2.0 * np.array((0.5, 0.25, 0.125)) + 0.75 * np.array((0.0, 0.0, 1.0))
    assert picture[0, 0] == pytest.approx(seen, rel=1e-3)
    lit = picture[SIZE[1] // 2, SIZE[0] // 2]
    assert lit[0] == pytest.approx(2.0 * lit[1], rel=0.02) and lit[1] == pytest.approx(2.0 * lit[2], rel=0.02)
    assert 0.5 < lit[0] < 1.0  # of 1.0 that arrives a new material reflects 0.8 or so
    chosen = Studio(str(tmp_path / 'none.exr'), 0.0, 1.0, 0.0)
    window.settle()  # Blender tells nobody that another was chosen
    assert window.pictures[-1][0][0, 0, :3] == pytest.approx((0.0, 0.0, 1.0))
    assert any(text.startswith('Studio light: image "none.exr"') for text in stats.of_viewports(scene.name))
