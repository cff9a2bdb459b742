# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine inside Blender: registration, settings, passes, view layers, borders, and the order of things in a render.

Pixels come from a stand-in for the native module, whose values are known; images are other tests'.
"""

from __future__ import annotations

import re
import time
from types import SimpleNamespace

import bpy
import cotorra
import numpy as np
import pytest
from cotorra import engine, final_render, passes, reporter, stats

import fake_native
from render_calls import here, read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine', 'fake')

DATA_PASSES = {
    'use_pass_z': ('Depth', 'Z'),
    'use_pass_position': ('Position', 'XYZ'),
    'use_pass_normal': ('Normal', 'XYZ'),
    'use_pass_uv': ('UV', 'UVA'),
    'use_pass_object_index': ('Object Index', 'X'),
    'use_pass_material_index': ('Material Index', 'X'),
    'use_pass_diffuse_color': ('Diffuse Color', 'RGB'),
    'use_pass_emit': ('Emission', 'RGB'),
    'use_pass_environment': ('Environment', 'RGB'),
    'use_pass_shadow': ('Shadow', 'RGB'),
    'use_pass_ambient_occlusion': ('Ambient Occlusion', 'RGB'),
}


@pytest.fixture
def scene() -> bpy.types.Scene:
    made = build.new_scene()
    build.camera(made)
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 12, 8
    made.cotorra.samples = 4
    return made


def settings_of(scene: bpy.types.Scene) -> object:
    """What the native session is given."""
    bpy.ops.render.render()
    return fake_native.sessions[-1].settings


def test_registering_twice_and_unregistering_leaves_blender_as_it_was(scene):
    def engines():
        return {
            panel.__name__: set(panel.COMPAT_ENGINES)
            for panel in bpy.types.Panel.__subclasses__()
            if hasattr(panel, 'COMPAT_ENGINES') and not panel.__name__.startswith('COTORRA')
        }

    def known():
        return {name for name in dir(bpy.types) if name.startswith(('COTORRA', 'Cotorra'))}

    cotorra.register()
    shown = engines()
    cotorra.unregister()
    plain = engines()
    cotorra.unregister()
    assert not known()
    for owner in ('Scene', 'ViewLayer', 'Material', 'Light'):
        assert not hasattr(getattr(bpy.types, owner), 'cotorra'), owner
    assert not any('COTORRA' in names for names in plain.values())
    cotorra.register()
    assert engines() == shown
    assert {name: names - {'COTORRA'} for name, names in shown.items()} == plain


def test_standard_panels_are_shown_and_those_of_cycles_left_alone():
    shown = {
        panel.__name__
        for panel in bpy.types.Panel.__subclasses__()
        if 'COTORRA' in getattr(panel, 'COMPAT_ENGINES', ())
    }
    for name in (
        'DATA_PT_lens',
        'DATA_PT_camera',
        'DATA_PT_context_light',
        'WORLD_PT_context_world',
        'EEVEE_MATERIAL_PT_context_material',
        'MATERIAL_PT_custom_props',
        'RENDER_PT_format',
        'RENDER_PT_output',
        'RENDER_PT_frame_range',
        'RENDER_PT_color_management',
        'VIEWLAYER_PT_layer',
        'COTORRA_VIEWLAYER_PT_override',
        'COTORRA_VIEWLAYER_PT_passes_light_groups',
        'DATA_PT_uv_texture',
        'OBJECT_PT_visibility',
    ):
        assert name in shown
    for name in ('DATA_PT_camera_dof', 'DATA_PT_EEVEE_light', 'RENDER_PT_eevee_sampling', 'DATA_PT_light'):
        assert name not in shown
    assert not any(name.startswith('CYCLES') for name in shown)


def test_every_pass_is_named_as_in_blender_and_upright(scene, tmp_path):
    layer = scene.view_layers[0]
    for flag in DATA_PASSES:
        setattr(layer, flag, True)
    layer.cotorra.use_pass_sample_count = True
    layer.lightgroups.add(name='Key')
    layer.lightgroups.add(name='Fill')
    found = read_exr(render_to(scene, tmp_path / 'all.exr', multilayer=True))

    wanted = {f'ViewLayer.{here(name)}': channels for name, channels in DATA_PASSES.values()}
    wanted |= {
        'ViewLayer.Combined': 'RGBA',
        'ViewLayer.Debug Sample Count': 'X',
        'ViewLayer.Combined_Key': 'RGB',
        'ViewLayer.Combined_Fill': 'RGB',
    }
    assert {name: set(layers) for name, layers in found.items()} == {
        name: set(channels) for name, channels in wanted.items()
    }
    for channels in found.values():
        for pixels in channels.values():
            assert pixels.shape == (8, 12)
            assert pixels[-1, 0] == 0.0 and np.count_nonzero(pixels == 0.0) == 1  # only the lower left pixel is dark
    # Every sample was taken, and the pass says so as a part of all.
    assert found['ViewLayer.Debug Sample Count']['X'].max() == 1.0


def test_light_groups_are_read_by_their_place(scene):
    layer = scene.view_layers[0]
    layer.lightgroups.add(name='Key')
    layer.lightgroups.add(name='Fill')
    bpy.ops.render.render()
    assert fake_native.reads == ['combined', 'lightgroup:0', 'lightgroup:1']
    assert fake_native.sessions[-1].settings.passes == ('combined', 'lightgroup:0', 'lightgroup:1')


def test_only_asked_passes_are_rendered(scene):
    assert settings_of(scene).passes == ('combined',)


def test_the_sample_count_switch_of_cycles_is_heard(scene):
    if not hasattr(scene.view_layers[0], 'cycles'):
        pytest.skip('this Blender has no Cycles')
    scene.view_layers[0].cycles.pass_debug_sample_count = True
    assert 'sample_count' in settings_of(scene).passes


def test_passes_that_stay_away_are_named(scene):
    scene.view_layers[0].use_pass_mist = True
    scene.view_layers[0].aovs.add().name = 'Mask'
    scene.render.use_motion_blur = True
    bpy.ops.render.render()
    assert stats.last(scene.name)[0].warnings == [
        'Scene "Scene": motion blur is not rendered yet',
        'View layer "ViewLayer": pass "Mist" is not rendered yet',
        'View layer "ViewLayer": pass "AOV Mask" is not rendered yet',
    ]


def test_reinhard_compresses_combined_after_exposure_and_nothing_else(scene, tmp_path):
    layer = scene.view_layers[0]
    layer.use_pass_emit = layer.use_pass_z = True
    plain = read_exr(render_to(scene, tmp_path / 'plain.exr', multilayer=True))
    assert not scene.cotorra.use_reinhard  # the picture is scene-linear unless asked for
    scene.cotorra.use_reinhard, scene.cotorra.reinhard_white, scene.cycles.film_exposure = True, 2.0, 6.0
    found = read_exr(render_to(scene, tmp_path / 'image.exr', multilayer=True))
    rgb = np.stack([plain['ViewLayer.Combined'][channel] for channel in 'RGB'], axis=-1).astype(np.float64) * 6.0
    luminance = rgb @ (0.2126, 0.7152, 0.0722)
    assert luminance.max() > 2.0
    wanted = rgb * ((1.0 + luminance / 2.0**2) / (1.0 + luminance))[..., None]
    for index, channel in enumerate('RGB'):
        assert found['ViewLayer.Combined'][channel] == pytest.approx(wanted[..., index], rel=1e-6)
    assert np.array_equal(found['ViewLayer.Combined']['A'], plain['ViewLayer.Combined']['A'])
    emission = f'ViewLayer.{here("Emission")}'
    assert found[emission]['R'] == pytest.approx(6.0 * plain[emission]['R'])


def test_film_exposure_of_cycles_scales_light_and_nothing_else(scene, tmp_path):
    if not hasattr(scene, 'cycles'):
        pytest.skip('this Blender has no Cycles')
    scene.cycles.film_exposure = 3.0
    layer = scene.view_layers[0]
    layer.use_pass_emit = layer.use_pass_environment = layer.use_pass_diffuse_color = layer.use_pass_z = True
    layer.lightgroups.add(name='Key')
    found = read_exr(render_to(scene, tmp_path / 'x.exr', multilayer=True))
    brightest = {
        f'{name.removeprefix("ViewLayer.")}.{channel}': float(pixels.max())
        for name, channels in found.items()
        for channel, pixels in channels.items()
        if channel in 'RAZ'
    }
    assert brightest == {
        'Combined.R': 1.5,
        'Combined.A': 0.5,
        f'{here("Emission")}.R': 1.5,
        f'{here("Environment")}.R': 1.5,
        'Combined_Key.R': 1.5,
        f'{here("Diffuse Color")}.R': 0.5,
        'Depth.Z': 0.5,
    }


def test_settings_reach_the_session(scene):
    own = scene.cotorra
    own.integrator = 'PATH'
    own.samples, own.seed = 7, 3
    own.max_bounces, own.diffuse_bounces, own.glossy_bounces, own.transparent_bounces = 5, 4, 3, 2
    own.use_adaptive_sampling, own.noise_threshold, own.adaptive_min_samples = True, 0.25, 2
    scene.render.film_transparent = True
    scene.render.threads_mode, scene.render.threads = 'FIXED', 3
    given = settings_of(scene)
    assert (given.integrator, given.samples, given.seed) == ('PATH', 7, 3)
    assert (given.max_bounces, given.diffuse_bounces, given.glossy_bounces, given.transparent_bounces) == (5, 4, 3, 2)
    assert (given.adaptive, given.noise_threshold, given.adaptive_min_samples) == (True, 0.25, 2)
    assert (given.transparent_film, given.threads) == (True, 3)
    own.use_adaptive_sampling = scene.render.film_transparent = False
    given = settings_of(scene)
    assert (given.adaptive, given.transparent_film) == (False, False)


def test_a_view_layers_own_samples_win(scene):
    scene.view_layers[0].samples = 9
    assert settings_of(scene).samples == 9


def test_animated_settings_hold_for_their_frame(scene):
    scene.cotorra.samples = 2
    scene.cotorra.keyframe_insert('samples', frame=1)
    scene.cotorra.samples = 6
    scene.cotorra.keyframe_insert('samples', frame=2)
    scene.cotorra.use_animated_seed = True
    scene.cotorra.seed = 10
    scene.frame_set(2)
    given = settings_of(scene)
    assert (given.samples, given.seed) == (6, 12)
    scene.frame_set(1)
    assert settings_of(scene).samples == 2


def test_each_view_layer_is_rendered_and_counted(scene, tmp_path):
    scene.view_layers.new('Second').use_pass_z = True
    unused = scene.view_layers.new('Unused')
    unused.use = False
    found = read_exr(render_to(scene, tmp_path / 'layers.exr', multilayer=True))
    assert set(found) == {'ViewLayer.Combined', 'Second.Combined', 'Second.Depth'}
    figures = stats.last(scene.name)
    assert [(entry.layer, entry.width, entry.height, entry.samples_done) for entry in figures] == [
        ('ViewLayer', 12, 8, 4),
        ('Second', 12, 8, 4),
    ]
    bpy.ops.render.render()
    assert len(stats.last(scene.name)) == 2  # the earlier render is forgotten


@pytest.mark.parametrize('crop', [False, True])
def test_a_border_renders_its_pixels_only(scene, tmp_path, crop):
    render = scene.render
    render.resolution_x, render.resolution_y = 100, 50
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.2, 0.7, 0.1, 0.4
    found = read_exr(render_to(scene, tmp_path / 'border.exr'))['']['R']
    assert fake_native.sessions[-1].camera.region == (20, 5, 50, 15)
    if crop:
        assert found.shape == (15, 50)
        assert found[-1, 0] == 0.0
    else:
        assert found.shape == (50, 100)
        inside = found[50 - 20 : 50 - 5, 20:70]
        assert inside[-1, 0] == 0.0 and inside[0, 0] == 0.5
        assert np.count_nonzero(found) == inside.size - 1


def test_borders_of_any_size_agree_with_blender(scene):
    """Blender cuts borders in single precision; a size of our own that differs would be an error."""
    render = scene.render
    render.use_border = True
    rounds = np.random.default_rng(5)
    for _ in range(30):
        render.resolution_x, render.resolution_y = (int(side) for side in rounds.integers(1, 300, 2))
        low, high = np.sort(rounds.uniform(0.0, 1.0, (2, 2)), axis=0)
        render.border_min_x, render.border_min_y = low
        render.border_max_x, render.border_max_y = high
        try:
            bpy.ops.render.render()
        except RuntimeError as error:
            assert 'Border area selected' in str(error)  # Blender's own word on an empty border


def test_pictures_in_between_come_soon_and_then_less_often(scene, monkeypatch):
    monkeypatch.setattr(final_render, 'in_window', lambda: True)
    monkeypatch.setattr(final_render, 'FIRST_PICTURE_SECONDS', 0.1)
    monkeypatch.setattr(final_render, 'PICTURE_SECONDS', 0.2)
    monkeypatch.setattr(final_render, 'PICTURE_GROWTH', 2.0)
    fake_native.configure('sample_seconds=0.05')
    scene.cotorra.samples = 24
    scene.view_layers[0].use_pass_z = True
    bpy.ops.render.render()
    # At 0.1 s, 0.3 s and 0.7 s, of Combined only; and everything at the end, after 1.2 s.
    assert fake_native.reads[-2:] == ['combined', 'depth']
    assert fake_native.reads[:-2] == ['combined'] * 3


def test_pictures_in_between_cost_little(scene, monkeypatch):
    monkeypatch.setattr(final_render, 'in_window', lambda: True)
    monkeypatch.setattr(final_render, 'FIRST_PICTURE_SECONDS', 0.0)
    monkeypatch.setattr(final_render, 'PICTURE_SECONDS', 0.0)
    fake_native.configure('sample_seconds=0.05 read_seconds=0.04')
    scene.cotorra.samples = 30
    bpy.ops.render.render()
    # A picture of 0.04 s may come every 0.8 s at most: two in 1.5 s, and the last one.
    assert 2 <= len(fake_native.reads) <= 3


def test_the_shader_editor_offers_blenders_nodes():
    """By default Blender takes a Python engine for one with nodes of its own, and hides the Principled BSDF."""
    assert not engine.CotorraRenderEngine.bl_use_shading_nodes_custom


def test_the_compositor_gets_the_image(scene, tmp_path):
    layers = build.compositor(scene)
    layers.scene = scene
    tree = layers.id_data
    inverted = tree.nodes.new('CompositorNodeInvert')
    tree.links.new(inverted.outputs['Color'], tree.links[0].to_socket)
    tree.links.new(layers.outputs['Image'], inverted.inputs['Color'])
    found = read_exr(render_to(scene, tmp_path / 'inverted.exr'))['']['R']
    assert found[-1, 0] == 1.0 and found[0, 0] == 0.5


def test_persistent_data_is_harmless(scene):
    scene.render.use_persistent_data = True
    bpy.ops.render.render()
    scene.cotorra.samples = 6
    assert settings_of(scene).samples == 6


def test_an_animation_renders_each_frame(scene, tmp_path):
    scene.frame_start, scene.frame_end = 3, 5
    scene.render.image_settings.file_format = 'PNG'
    scene.render.filepath = str(tmp_path / 'frame')
    bpy.ops.render.render(animation=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['frame0003.png', 'frame0004.png', 'frame0005.png']
    assert [entry.frame for entry in stats.last(scene.name)] == [5]


def status_lines(monkeypatch) -> list[str]:
    """What the engine tells Blender for its status line, from now on."""
    lines: list[str] = []

    class Told(reporter.Reporter):
        def __init__(self, engine, *rest):
            quiet = {name: lambda *_, **__: None for name in ('update_progress', 'update_memory_stats')}
            super().__init__(SimpleNamespace(update_stats=lambda head, line: lines.append(head + line), **quiet), *rest)

    monkeypatch.setattr(final_render, 'Reporter', Told)
    return lines


def test_the_status_line_is_that_of_cycles(scene, monkeypatch):
    """Remaining time, the memory that the render takes, samples; in the part that Blender prints in background, too."""
    monkeypatch.setattr(reporter, 'BACKGROUND_SECONDS', 0.0)
    fake_native.configure('sample_seconds=0.1 bytes=3000000')
    lines = status_lines(monkeypatch)
    bpy.ops.render.render()
    assert lines[0] == 'Synchronizing'
    assert any(re.fullmatch(r'Remaining: 00:00\.\d\d \| Mem: 6M \| Sample [123]/4', line) for line in lines)
    assert lines[-1] == 'Mem: 6M | Sample 4/4'


def test_the_status_line_names_the_layer_where_there_are_several(scene, monkeypatch):
    scene.view_layers.new('Second')
    lines = status_lines(monkeypatch)
    bpy.ops.render.render()
    assert {line.split(' | ')[0] for line in lines} == {f'{scene.name}, ViewLayer', f'{scene.name}, Second'}


def test_the_window_is_redrawn_seldom_and_for_several_reasons_at_once(scene, monkeypatch):
    """Each picture and each status line redraws the whole window, which answers nobody meanwhile."""
    monkeypatch.setattr(final_render, 'in_window', lambda: True)
    monkeypatch.setattr(reporter, 'BACKGROUND_SECONDS', 10.0)
    monkeypatch.setattr(final_render, 'FIRST_PICTURE_SECONDS', 0.3)
    fake_native.configure('sample_seconds=0.2')
    lines = status_lines(monkeypatch)
    bpy.ops.render.render()
    # The first line as soon as there is one, one with the picture, the last; no other was due in 0.8 s.
    assert len([line for line in lines if 'Sample' in line]) == 3
    assert len(fake_native.reads) == 2


@pytest.mark.parametrize(
    ('seconds', 'text'), [(0.0, '00:00.00'), (61.239, '01:01.24'), (59.999, '01:00.00'), (3661.5, '01:01:01.50')]
)
def test_durations_are_written_as_blender_does(seconds, text):
    assert reporter.duration(seconds) == text


def test_figures_are_kept(scene):
    start = time.perf_counter()
    fake_native.configure('build_seconds=0.2')
    bpy.ops.render.render()
    spent = time.perf_counter() - start
    (entry,) = stats.last(scene.name)
    assert 0.2 <= entry.build_seconds <= spent
    assert 0.0 < entry.sync_seconds < entry.total_seconds <= spent
    assert entry.rays == {'camera': 384, 'shadow': 0, 'bounce': 0}
    assert entry.features == ['fake'] and entry.left_out == ['real pixels: this is a fake']
    assert entry.memory_peak_bytes >= entry.memory_before_bytes > 100e6


def test_names_of_passes_are_unique_and_known_to_the_border():
    entries = (*passes.PASSES, *passes.OWN_PASSES, *passes.DENOISING_PASSES)
    names = [entry.name for entry in entries]
    assert len(set(names)) == len(names)
    natives = {entry.native for entry in entries} | {'combined', 'unweighted', 'sample_count'}
    assert natives == set(passes.NATIVE_CHANNELS)
    for entry in entries:
        assert passes.NATIVE_CHANNELS[entry.native] == len(entry.channels)
