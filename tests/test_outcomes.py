# SPDX-License-Identifier: GPL-3.0-or-later
"""Success at the command line is judged by what is there in the end: scenes whose picture is not the engine's alone.

Sequences, compositing, view layers that are off; the native module is a stand-in that renders grey.
"""

from __future__ import annotations

import json

import bpy
import OpenImageIO as oiio
import pytest
from cotorra import opening, terminal

from render_calls import run_cli
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture
def scene():
    made = build.new_scene()
    build.camera(made)
    build.mesh_object(made)
    return made


def rendered(tmp_path, name='o.exr', *arguments, fake=''):
    """Exit code, what was told, and the mean of the picture where there is one."""
    blend, path = tmp_path / 'scene.blend', tmp_path / name
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    code, told = run_cli('render', blend, '-o', path, '--size', '8x8', '--samples', 2, *arguments, fake=fake)
    found = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT) if path.exists() else None
    return code, told, found


@pytest.mark.parametrize('on', [True, False])
def test_compositing_of_another_scene_alone(scene, tmp_path, on):
    other = bpy.data.scenes.new('Other')
    other.camera = scene.camera
    other.collection.objects.link(scene.camera)
    other.render.resolution_x = other.render.resolution_y = 8
    other.cycles.use_denoising = False  # grey alone is told from what a denoiser makes of the stand-in's noise
    node = build.compositor(scene)
    node.scene, node.layer = other, other.view_layers[0].name
    scene.view_layers[0].use = False
    other.view_layers[0].use = on
    code, told, found = rendered(tmp_path)
    if on:
        assert code == 0 and found[..., 0].max() == pytest.approx(0.5, abs=0.02), told
    else:
        assert code == terminal.FAILED and found is None and 'no view layer' in told


@pytest.mark.parametrize('single', [False, True])
@pytest.mark.parametrize('name', ['o.exr', 'o.png'])
def test_no_view_layer_is_on(scene, tmp_path, name, single):
    """Blender would crash, or write a black picture."""
    scene.name = 'Dark'
    scene.view_layers.new('Second')
    for layer in scene.view_layers:
        layer.use = False
    scene.render.use_single_layer = single
    code, told, found = rendered(tmp_path, name)
    assert code == terminal.FAILED and found is None
    assert 'scene "Dark" has no view layer that is on' in told and 'Synchronizing' not in told


def test_an_error_that_costs_no_picture_is_a_warning(scene, tmp_path, monkeypatch):
    """Blender raises for anything that reported an error while it rendered."""
    honest = opening.render_in_blender
    monkeypatch.setattr(opening, 'render_in_blender', lambda scene: honest(scene) or 'the coffee is out')
    code, told, found = rendered(tmp_path)
    assert code == 0 and 'Warning: Scene "Scene", frame 1: the coffee is out' in told
    assert found is not None


def test_an_error_of_the_engine_is_a_failure_whatever_is_there(scene, tmp_path):
    scene.view_layers.new('Second')
    (tmp_path / 'o.exr').write_bytes(b'an older picture')
    code, told, _ = rendered(tmp_path, fake='fail_in=read')
    assert code == terminal.FAILED and 'o.exr is not written' in told and 'cannot be read' in told
    assert (tmp_path / 'o.exr').read_bytes() == b'an older picture'


def test_memory_for_blender_itself(monkeypatch, tmp_path):
    """A limit on addresses under which Blender would crash as it starts."""
    import resource

    monkeypatch.setattr(resource, 'getrlimit', lambda _kind: (900 * 2**20, 900 * 2**20))
    code, told = run_cli('render', '--demo', 'box_room', '-o', tmp_path / 'o.exr')
    assert code == terminal.FAILED and 'memory is limited to 900 MiB' in told and '1300 MiB' in told


def test_sides_below_blenders_smallest(scene, tmp_path):
    code, told, found = rendered(tmp_path, 'o.exr', '--size', '3x2000')
    assert code == 0 and found.shape[:2] == (2000, 3), told


# Blender keeps the camera of a scene strip by the scene's address, and takes it for compositing, also when another file
# was opened since: in one process, strips come last.


def strips(scene):
    return (scene.sequence_editor or scene.sequence_editor_create()).strips


def color_strip(scene, color):
    length = {'length': 10} if bpy.app.version >= (5, 0, 0) else {'frame_end': 11}
    strip = strips(scene).new_effect('Card', 'COLOR', 1, 1, **length)
    strip.color = color
    return strip


@pytest.mark.parametrize('name', ['o.exr', 'o.png'])
def test_a_sequence_that_shows_a_card(scene, tmp_path, name):
    color_strip(scene, (0.0, 1.0, 0.0))
    scene.view_settings.view_transform = 'Standard'
    scene.view_layers[0].use_pass_z = True  # a sequence has one picture, whatever the passes
    code, told, found = rendered(tmp_path, name)
    assert code == 0, told
    assert found[..., 1].min() > 0.9 and found[..., 0].max() == 0.0
    assert f'{name}: 8×8, ' in told and 'samples' not in told.splitlines()[-1]
    assert ''.join(oiio.ImageBuf(str(tmp_path / name)).spec().channelnames).startswith('RGB')


def test_a_sequence_that_shows_another_scene(scene, tmp_path):
    """The arguments hold for that scene, too, and its figures are kept."""
    other = bpy.data.scenes.new('Stage')
    other.camera = scene.camera
    other.render.resolution_x, other.render.resolution_y = scene.render.resolution_x, scene.render.resolution_y
    other.collection.objects.link(scene.camera)
    other.render.engine = 'CYCLES'
    strips(scene).new_scene('Shot', other, 1, 1)
    scene.view_layers[0].use = False
    code, told, found = rendered(tmp_path, 'o.exr', '--stats', tmp_path / 's.json')
    assert code == 0, told
    assert found[..., 0].max() == pytest.approx(0.5, abs=0.02)
    (layer,) = json.loads((tmp_path / 's.json').read_text())['frames'][0]['layers']
    assert layer['samples'] == 2 and layer['samples_done'] == 2


def test_a_muted_strip_shows_nothing(scene, tmp_path):
    color_strip(scene, (0.0, 1.0, 0.0)).mute = True
    code, told, found = rendered(tmp_path)
    assert code == 0 and '2 samples' in told
    assert found[..., 0].max() == found[..., 1].max() == 0.5
    scene = bpy.context.scene
    scene.view_layers[0].use = False
    code, told, _ = rendered(tmp_path, 'off.exr')
    assert code == terminal.FAILED and 'no view layer' in told
