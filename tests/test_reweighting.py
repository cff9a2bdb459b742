# SPDX-License-Identifier: GPL-3.0-or-later
"""Fireflies held back by their weight: what is taken away, what is left as it is, and whose settings ask for it.

How much better pictures are is told by measurements beside references, not here.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from cotorra import cli, final_render, settings, stats
from cotorra.export import buffers as b
from cotorra.log import Log

from devices import on_both
from render_calls import read_exr, render_to
from scenes import build
from texture_scenes import ASIDE, F32, camera, materials, plane, render, scene

SIZE = 32
PASSES = ('combined', 'unweighted')
WORLD = 0.3
LAMP = 300.0


def lamp_beside() -> b.SceneBuffers:
    """A white wall under a grey world, and beside the picture a small square that shines and that bounces alone find:
    of 2,000 samples about one brings its light, a thousand times what the others bring."""
    side = 0.05
    lamp = plane(-side, side, 1.0)
    lamp.positions[:, 0] += np.float32(ASIDE - 1.5)
    colors = {'base_color': [[0.8] * 3, [0.0] * 3], 'emission': [[0.0] * 3, [LAMP] * 3]}
    made = materials(2, emission_sampling=[0, 0], **colors)
    return scene((plane(-8.0, 8.0), lamp), made, world=b.World(color=(WORLD,) * 3))


def lamp_in_sight() -> b.SceneBuffers:
    """A black wall, before it a square, a pixel wide, that shines."""
    side = 1.0 / SIZE
    lamp = plane(-side, side, 1.0)
    lamp.positions[:] += np.array([ASIDE + side, side, 0.0], F32)
    colors = {'base_color': [[0.0] * 3] * 2, 'emission': [[0.0] * 3, [LAMP] * 3]}
    return scene((plane(-8.0, 8.0), lamp), materials(2, emission_sampling=[0, 0], **colors))


def rendered(made: b.SceneBuffers, device: str, samples: int, strength: float, **others: object) -> dict:
    asked = {'integrator': 'PATH', 'max_bounces': 1, 'passes': PASSES, 'device': device} | others
    return render(made, camera(1.0, SIZE), samples=samples, reweighting=strength, **asked)


@on_both('strength', [(0.5,), (1.0,), (2.0,)], [(1.0,)])
def test_fireflies_add_little_to_their_pixels(device: str, strength: float) -> None:
    """Half of what is around, over the strength; what is around has fireflies, too, of as much."""
    made = lamp_beside()
    plain = rendered(made, device, 16, 0.0)
    found = rendered(made, device, 16, strength)
    np.testing.assert_array_equal(found['unweighted'], plain['unweighted'])
    np.testing.assert_array_equal(plain['combined'], plain['unweighted'])
    around = 0.8 * WORLD
    assert plain['combined'][..., 0].max() > 50.0 * around, 'no sample met the lamp'
    # In each of the cascades, and of the darkest nothing is held back: the light of a sample up to white.
    allowed = around * (1.0 + 3.0 * 0.5 / strength) + 1.0 / 16.0
    assert around <= found['combined'][..., 0].max() <= 1.5 * allowed
    dull = plain['combined'][..., 0] < 1.5 * around
    np.testing.assert_array_equal(found['combined'][dull], plain['combined'][dull])


def test_less_is_held_back_from_more_samples() -> None:
    made = lamp_beside()
    held = []
    for samples in (16, 256, 4096):
        found = rendered(made, 'CPU', samples, 1.0)
        plain, kept = (found[name][..., :3].mean(dtype=float) for name in ('unweighted', 'combined'))
        held.append((plain - kept) / plain)
    # At 16 samples hardly a pixel meets the lamp, at 4096 each does, and nothing is rare.
    assert held[0] > held[1] > 0.05 > 0.001 > held[2] >= 0.0, held


@on_both('samples', [(1,), (4,), (64,)], [(4,)])
def test_what_is_bright_by_itself_stays(device: str, samples: int) -> None:
    found = rendered(lamp_in_sight(), device, samples, 1.0)
    assert found['combined'].max() == pytest.approx(LAMP, rel=1e-5)
    np.testing.assert_array_equal(found['combined'], found['unweighted'])


def test_black_pictures_and_lights_below_0_stay_finite() -> None:
    made = lamp_beside()
    negative = [float(sign) * LAMP for sign in (1, -1, 1)]
    colors = {'base_color': [[0.8] * 3, [0.0] * 3], 'emission': [[0.0] * 3, negative]}
    for world in (0.0, 0.3):
        shown = scene(made.meshes, materials(2, emission_sampling=[0, 0], **colors), world=b.World(color=(world,) * 3))
        found = rendered(shown, 'CPU', 16, 1.0)
        assert np.isfinite(found['combined']).all()
        assert abs(found['combined'][..., :3]).max() <= abs(found['unweighted'][..., :3]).max()


def test_adaptive_sampling_and_tiles_leave_no_seam() -> None:
    """What is around a pixel does not end at its tile, nor with those that have as many samples."""
    found = rendered(lamp_beside(), 'CPU', 64, 1.0, adaptive=True, noise_threshold=0.05, adaptive_min_samples=16)
    held = (found['unweighted'] - found['combined'])[..., 0]
    assert (held >= -1e-5).all() and held.max() > 1.0


def test_off_keeps_no_memory() -> None:
    made = lamp_beside()
    sizes = [rendered(made, 'CPU', 1, strength)['stats']['memory_bytes'] for strength in (0.0, 1.0)]
    assert sizes[1] - sizes[0] == SIZE * SIZE * 3 * 16


@pytest.mark.parametrize(('name', 'value'), [('reweighting', -1.0), ('reweighting', np.inf), ('white', 0.0)])
def test_what_is_wrong_is_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f'settings.{name}'):
        render(lamp_in_sight(), camera(1.0, 4), **{name: value})


# ---- In Blender


@pytest.mark.usefixtures('engine')
def test_it_holds_where_our_own_settings_do() -> None:
    """Not of a file that was made for Cycles, unless it was asked for; never where Cycles' settings are to hold."""
    made = build.new_scene()
    own = made.cotorra
    found = []
    for chosen in (None, True, False):
        own.property_unset('use_reweighting')
        if chosen is not None:
            own.use_reweighting = chosen
        for settings_from in ('AUTO', 'CYCLES', 'COTORRA'):
            own.settings_from = settings_from
            strength = settings.render_settings(made, made.view_layers[0], (), Log()).reweighting
            found.append((chosen, settings_from, strength))
    assert {entry[:2] for entry in found if entry[2] == 1.0} == {(None, 'COTORRA'), (True, 'AUTO'), (True, 'COTORRA')}
    assert {entry[2] for entry in found} == {0.0, 1.0}
    own.settings_from, own.use_reweighting, own.integrator = 'COTORRA', True, 'TOON'
    assert settings.render_settings(made, made.view_layers[0], (), Log()).reweighting == 0.0


@pytest.mark.usefixtures('engine')
def test_the_command_line_says_how_strictly() -> None:
    line = ['render', '--demo', 'box_room', '-o', 'room.exr', '--settings', 'auto', '--reweight']
    for text, strength in (('0', 0.0), ('1', 1.0), ('2.5', 2.5)):
        made = build.new_scene()
        cli.apply(cli.parser().parse_args([*line, text]), made)
        assert settings.render_settings(made, made.view_layers[0], (), Log()).reweighting == strength
    for wrong in ('-1', 'nan', '1e9', 'much'):
        with pytest.raises(SystemExit):
            cli.parser().parse_args([*line, wrong])


@pytest.mark.usefixtures('engine', 'fake')
def test_the_plain_mean_is_a_pass_and_the_change_is_told(tmp_path, monkeypatch) -> None:
    made = build.new_scene()
    build.camera(made)
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 16, 8
    made.cotorra.settings_from, made.cotorra.samples, made.cotorra.use_denoising = 'COTORRA', 2, False
    read = final_render.passes.read

    def darker(session, result, native):
        return read(session, result, native) * (0.75 if native == 'combined' else 1.0)

    monkeypatch.setattr(final_render.passes, 'read', darker)
    found = read_exr(render_to(made, tmp_path / 'all.exr', multilayer=True))
    layers = {name.removeprefix('ViewLayer.'): channels for name, channels in found.items()}
    assert layers['Combined']['R'][4, 8] == 0.75 * layers['Unweighted Image']['R'][4, 8]
    assert stats.last(made.name)[0].reweighting == pytest.approx(-25.0)
    made.cotorra.use_reweighting = False
    assert 'ViewLayer.Unweighted Image' not in read_exr(render_to(made, tmp_path / 'off.exr', multilayer=True))
    assert bpy.context.scene == made and stats.last(made.name)[0].reweighting == 0.0
