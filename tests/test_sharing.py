# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that count for every pixel whose filter reaches them: the same picture, with less noise, on both devices."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
import pytest
from cotorra import cli, settings
from cotorra.export import buffers as b
from cotorra.log import Log
from cotorra.viewport import preview

from devices import on_both
from scenes import build
from texture_scenes import ASIDE, F32, camera, lights, materials, plane, render, scene

SIZE = 40  # tiles of 16 x 16, and smaller ones at two sides
WORLD = 0.3


def lamp_beside() -> b.SceneBuffers:
    """A white wall under a grey world; a lamp that bounces alone find makes noise, as much in all pixels; and the upper
    half of the picture is darker."""
    lamp = plane(-2.0, 2.0, 3.0)
    lamp.positions[:, 0] += np.float32(ASIDE + 5.0)
    roof = plane(-8.0, 8.0, 0.01)
    roof.positions[:, 1] += np.float32(8.0)
    colors = {'base_color': [[0.8] * 3, [0.0] * 3, [0.2] * 3], 'emission': [[0.0] * 3, [9.0] * 3, [0.0] * 3]}
    made = materials(3, emission_sampling=[0, 0, 0], **colors)
    return scene((plane(-8.0, 8.0), lamp, roof), made, world=b.World(color=(WORLD,) * 3))


def rendered(
    made: b.SceneBuffers, device: str, width: float = 1.5, kind: str = 'BLACKMAN_HARRIS', **others: object
) -> dict:
    asked = {'integrator': 'PATH', 'max_bounces': 1, 'device': device, 'sharing': True, 'samples': 16} | others
    return render(made, replace(camera(1.0, SIZE), filter=kind, filter_width=width), **asked)


@on_both('samples', [(1,), (3,), (16,)], [(3,)])
def test_what_is_the_same_everywhere_stays_so(device: str, samples: int) -> None:
    made = scene((plane(-0.1, 0.1, 50.0),), materials(1), world=b.World(color=(WORLD,) * 3))
    found = rendered(made, device, samples=samples, passes=('combined', 'sample_count'))
    # A sum of products over a sum of weights, rounded: 2.4e-7 at most, measured.
    np.testing.assert_allclose(found['combined'][..., :3], WORLD, rtol=1e-6)
    assert (found['sample_count'] == samples).all()


def test_the_picture_is_the_same_and_its_noise_less() -> None:
    made = lamp_beside()
    own, shared = (
        np.stack([rendered(made, 'CPU', sharing=on, seed=seed)['combined'][..., 0] for seed in range(48)]).astype(float)
        for on in (False, True)
    )
    error = np.sqrt((own.var(axis=0, ddof=1) + shared.var(axis=0, ddof=1)) / len(own))
    z = (shared.mean(axis=0) - own.mean(axis=0)) / error
    # 1600 pixels, the shared ones correlated; the largest of as many normal numbers is 3.4 +- 0.3.
    assert abs(z).max() < 5.0
    assert z.std() < 1.2
    assert abs(z.mean()) < 4.0 * 3.0 / SIZE  # nine pixels are about one
    variance = shared.var(axis=0, ddof=1) / own.var(axis=0, ddof=1)
    flat = np.r_[2:18, 22 : SIZE - 2]  # rows away from the edge and from the border
    inside, border = np.r_[2:14, 18:30], np.r_[0, SIZE - 1, 15, 16, 31, 32]
    assert np.median(variance[np.ix_(flat, inside)]) == pytest.approx(0.5, abs=0.06)
    assert 0.45 < np.median(variance[np.ix_(flat, border)]) < 0.8  # of a tile: fewer pixels share


def penumbra() -> b.SceneBuffers:
    """A wall, half of which a roof keeps from a wide sun: its light is smooth, and a pixel's own samples do well."""
    roof = plane(-8.0, 8.0, 3.0)
    roof.positions[:, 1] += np.float32(8.0)
    sun = replace(lights(((0.0, 0.0, -1.0), 3.0)), size=np.array([1.0], F32))
    return scene((plane(-20.0, 20.0), roof), materials(2), lights=sun)


@pytest.mark.parametrize('samples', [16, 64])
def test_smooth_light_is_no_noisier_for_it(samples: int) -> None:
    """All samples shared have 2.8 and 4.4 times the variance of each pixel's own here."""
    own, shared = (
        np.stack(
            [
                render(penumbra(), seen_from_below_the_roof(), samples=samples, seed=seed, sharing=on)['combined'][
                    ..., 0
                ]
                for seed in range(12)
            ]
        ).astype(float)
        for on in (False, True)
    )
    assert 0.1 < own.mean() / own.max() < 0.9
    assert shared.var(axis=0, ddof=1).mean() < 1.15 * own.var(axis=0, ddof=1).mean()
    assert shared.mean() == pytest.approx(own.mean(), rel=2e-3)


def seen_from_below_the_roof() -> b.Camera:
    return replace(camera(1.0, 32, height=2.5), filter_width=1.5)


@pytest.mark.parametrize(
    ('kind', 'width'), [('BLACKMAN_HARRIS', 1.5), ('BLACKMAN_HARRIS', 0.9), ('BOX', 2.0), ('GAUSSIAN', 0.8)]
)
def test_an_edge_is_as_soft_as_the_filter(kind: str, width: float) -> None:
    """A half plane that shines, without noise but that of the filter's samples."""
    half = plane(-8.0, 8.0)
    half.positions[:, 0] += np.float32(-8.0 + 0.03)
    made = scene((half,), materials(1, base_color=[[0.0] * 3], emission=[[1.0] * 3], emission_sampling=[0]))
    own, shared = (
        rendered(made, 'CPU', width, kind, sharing=on, samples=256)['combined'][..., 0] for on in (False, True)
    )
    profiles = [picture.astype(float).mean(axis=0) for picture in (own, shared)]
    assert ((profiles[0] > 0.01) & (profiles[0] < 0.99)).any()
    # Both have the noise of 10,240 samples a column: 1.8e-4 apart at most, measured.
    np.testing.assert_allclose(profiles[1], profiles[0], atol=7e-4)


@pytest.mark.parametrize(
    ('kind', 'width'), [('BLACKMAN_HARRIS', 0.5), ('BLACKMAN_HARRIS', 1.6), ('BOX', 1.0), ('GAUSSIAN', 1.5)]
)
def test_filters_too_narrow_or_too_wide_share_nothing(kind: str, width: float) -> None:
    own, shared = (rendered(lamp_beside(), 'CPU', width, kind, sharing=on) for on in (False, True))
    np.testing.assert_array_equal(own['combined'], shared['combined'])
    assert own['stats']['memory_bytes'] == shared['stats']['memory_bytes']


def test_reweighting_has_samples_of_each_pixel() -> None:
    own, shared = (rendered(lamp_beside(), 'CPU', sharing=on, reweighting=1.0) for on in (False, True))
    np.testing.assert_array_equal(own['combined'], shared['combined'])


def test_other_passes_and_sums_of_threads_stay_as_they_are() -> None:
    passes = ('combined', 'normal', 'depth', 'environment')
    made = lamp_beside()
    own, shared, again = (rendered(made, 'CPU', sharing=on, passes=passes) for on in (False, True, True))
    for name in passes[1:]:
        np.testing.assert_array_equal(own[name], shared[name])
    assert (own['combined'] != shared['combined']).any()
    np.testing.assert_array_equal(again['combined'], shared['combined'])


@pytest.mark.parametrize('adaptive', [False, True])
def test_both_devices_show_the_same(adaptive: bool, lavapipe: object) -> None:
    asked = {'samples': 64, 'adaptive': adaptive, 'noise_threshold': 0.05, 'adaptive_min_samples': 4}
    passes = ('combined', 'sample_count')
    cpu, vulkan = (rendered(lamp_beside(), d, passes=passes, transparent_film=True, **asked) for d in ('CPU', 'VULKAN'))
    np.testing.assert_array_equal(cpu['sample_count'], vulkan['sample_count'])
    if adaptive:
        assert 4 <= cpu['sample_count'].min() < cpu['sample_count'].max()
    # Sums in another order: 8e-7 apart at most, measured; five times that.
    np.testing.assert_allclose(cpu['combined'], vulkan['combined'], rtol=4e-6)


def test_where_neighbours_stop_the_picture_stays_right() -> None:
    """Pixels that go on beside others that have stopped take nothing wrong from them: the dark half stops first."""
    made = lamp_beside()
    asked = {'samples': 256, 'adaptive': True, 'noise_threshold': 0.03, 'adaptive_min_samples': 16}
    pictures = [rendered(made, 'CPU', seed=seed, passes=('combined', 'sample_count'), **asked) for seed in range(24)]
    counts = np.stack([p['sample_count'] for p in pictures])
    assert np.ptp(counts.mean(axis=(0, 3) if counts.ndim == 4 else 0)) > 16
    shared = np.stack([p['combined'][..., 0] for p in pictures]).astype(float)
    truth = np.stack(
        [rendered(made, 'CPU', sharing=False, samples=1024, seed=99 + k)['combined'][..., 0] for k in range(4)]
    )
    rows = shared.mean(axis=(0, 2)) / truth.astype(float).mean(axis=(0, 2))
    # Noise of a row 0.003, the largest of 40 0.007, measured.
    np.testing.assert_allclose(rows, 1.0, atol=0.012)


# ---- In Blender


@pytest.mark.usefixtures('engine')
def test_it_is_on_but_for_denoisers() -> None:
    made = build.new_scene()
    layer, own = made.view_layers[0], made.cotorra

    def found() -> tuple[bool, bool]:
        viewport = preview.render_settings(made, layer, 'combined', Log())
        return settings.render_settings(made, layer, (), Log()).sharing, viewport.sharing

    own.settings_from, own.use_denoising, own.use_preview_denoising = 'COTORRA', False, True
    assert found() == (True, False)
    own.use_denoising, own.use_preview_denoising = True, False
    assert found() == (False, True)
    own.use_denoising = False
    assert found() == (True, True)
    for passes in (('light:0',), ('combined', 'lightgroup:1'), ('term_d',)):  # they add up to Combined
        assert not settings.render_settings(made, layer, passes, Log()).sharing
    own.use_sample_sharing = False
    assert found() == (False, False)


@pytest.mark.usefixtures('engine')
def test_the_command_line_says_whether() -> None:
    line = ['render', '--demo', 'box_room', '-o', 'room.exr', '--no-denoise']
    for more, on in (([], True), (['--share-samples'], True), (['--no-share-samples'], False)):
        made = build.new_scene()
        cli.apply(cli.parser().parse_args([*line, *more]), made)
        assert settings.render_settings(made, made.view_layers[0], (), Log()).sharing == on
    assert bpy.context.scene is not None
