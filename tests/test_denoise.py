# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising: pictures whose truth is known, what becomes of the passes, and what is said where it cannot be done.

How good the denoiser itself is, is not ours to test.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from cotorra import denoise, final_render, stats

import fake_native
from render_calls import read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

HEIGHT, WIDTH = 48, 64


def noisy_picture() -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """A picture of two halves, the same with noise, and its features."""
    clean = np.full((HEIGHT, WIDTH, 3), 0.2, np.float32)
    clean[:, WIDTH // 2 :] = (0.9, 0.5, 0.1)
    noise = np.random.default_rng(7).gamma(1.0, 1.0, clean.shape).astype(np.float32)
    normal = np.zeros_like(clean)
    normal[..., 2] = 1.0
    return clean, clean * noise, {'denoising_albedo': clean.copy(), 'denoising_normal': normal}


@pytest.mark.parametrize('inputs', ['RGB', 'RGB_ALBEDO', 'RGB_ALBEDO_NORMAL'])
@pytest.mark.parametrize('prefilter', ['NONE', 'FAST', 'ACCURATE'])
def test_noise_goes_and_the_picture_stays(inputs, prefilter):
    clean, noisy, features = noisy_picture()
    given = noisy.copy()
    how = denoise.Denoising(inputs, prefilter, 'FAST', threads=1)
    found = denoise.denoised(noisy, {name: features[name] for name in how.features()}, how)
    assert (noisy == given).all() and found.shape == clean.shape
    # An exponential distribution has its mean for a deviation; half of it gone is far from all that goes.
    assert np.abs(found - clean).mean() < 0.5 * np.abs(noisy - clean).mean()
    assert found.mean() == pytest.approx(clean.mean(), rel=0.1)


def test_it_stops_where_asked():
    _, noisy, features = noisy_picture()
    assert denoise.denoised(noisy, features, denoise.Denoising(), lambda: True) is None


@pytest.fixture
def scene() -> bpy.types.Scene:
    made = build.new_scene()
    build.camera(made)
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 16, 8
    made.cotorra.samples = 2
    made.cotorra.use_denoising = True
    return made


def brightened(color, features, how, should_cancel=None):
    assert set(features) == set(how.features())
    return color + 1.0


@pytest.mark.usefixtures('fake')
def test_combined_is_denoised_and_the_noisy_image_stays(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(final_render.denoise, 'denoised', brightened)
    scene.view_layers[0].cycles.denoising_store_passes = True
    scene.view_layers[0].lightgroups.add(name='Key')
    found = read_exr(render_to(scene, tmp_path / 'all.exr', multilayer=True))
    layers = {name.removeprefix('ViewLayer.'): channels for name, channels in found.items()}
    assert set(layers) == {'Combined', 'Noisy Image', 'Denoising Albedo', 'Denoising Normal', 'Combined_Key'}
    inner = {name: channels['R'][4, 8] for name, channels in layers.items() if 'R' in channels}
    assert inner['Combined'] == inner['Noisy Image'] + 1.0
    assert inner['Combined_Key'] == inner['Noisy Image']
    assert layers['Combined']['A'][4, 8] == layers['Noisy Image']['A'][4, 8]


@pytest.mark.usefixtures('fake')
def test_exposure_comes_after_the_denoiser(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(final_render.denoise, 'denoised', brightened)
    scene.cycles.film_exposure = 2.0
    found = read_exr(render_to(scene, tmp_path / 'all.exr', multilayer=True))
    noisy = found['ViewLayer.Noisy Image']['R'][4, 8]
    assert found['ViewLayer.Combined']['R'][4, 8] == pytest.approx(noisy + 2.0)


@pytest.mark.usefixtures('fake')
def test_what_the_denoiser_reads_is_rendered(scene):
    for inputs, wanted in (('RGB', set()), ('RGB_ALBEDO', {'denoising_albedo'})):
        scene.cotorra.denoising_inputs = inputs
        bpy.ops.render.render()
        assert set(fake_native.sessions[-1].settings.passes) == {'combined'} | wanted


@pytest.mark.usefixtures('fake')
def test_without_the_library_the_picture_stays_noisy(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(denoise, 'candidates', lambda: ['/nowhere/libOpenImageDenoise.so'])
    denoise.open_library.cache_clear()
    found = read_exr(render_to(scene, tmp_path / 'all.exr', multilayer=True))
    denoise.open_library.cache_clear()
    assert found['ViewLayer.Combined']['R'][4, 8] == found['ViewLayer.Noisy Image']['R'][4, 8]
    [warning] = stats.last(scene.name)[0].warnings
    assert warning.startswith('The picture is not denoised') and '/nowhere/libOpenImageDenoise.so' in warning


@pytest.mark.usefixtures('fake')
def test_a_time_limit_keeps_what_is_there(scene, monkeypatch):
    fake_native.configure('sample_seconds=0.05')
    scene.cotorra.samples, scene.cotorra.time_limit, scene.cotorra.use_denoising = 1000, 0.3, False
    bpy.ops.render.render()
    [layer] = stats.last(scene.name)
    assert 0 < layer.samples_done < 1000
    assert not layer.interrupted and not layer.error and not layer.warnings
