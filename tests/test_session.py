# SPDX-License-Identifier: GPL-3.0-or-later
"""What a session decides: where adaptive sampling stops, how soon it stops itself, which group light goes to.

The pictures are made so that the answer is known beforehand, on both devices. No Blender here.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cotorra import native
from cotorra.export import buffers as b

from devices import on_both
from texture_scenes import ASIDE, F32, I32, U32, camera, instances, lights, materials, plane, render, scene

TILE = 16  # pixels
SIZE = 2 * TILE
NOISY = [(5, 6), (15, 9), (20, 0), (31, 31)]  # column and row: inside a tile, at its edge, at the picture's edge


# ---- Adaptive sampling


def noisy_pixels() -> b.SceneBuffers:
    """A wall that shines evenly; before it, in a few pixels, patches whose light depends on where a lamp of size is
    sampled: they have noise at every number of samples, the wall has none."""
    wide = 2.0 / SIZE
    patches = []
    for column, row in NOISY:
        x, y = ((i + 0.5) * wide - 1.0 for i in (column, row))
        patch = plane(-0.3 * wide, 0.3 * wide, 0.1)
        patch.positions[:] += np.array([x + ASIDE, y, 0.0], F32)
        patches.append(patch)
    count = 1 + len(patches)
    made = materials(
        count,
        base_color=[[0.0] * 3] + [[0.8] * 3] * len(patches),
        emission=[[0.5] * 3] + [[0.0] * 3] * len(patches),
        emission_sampling=[0] * count,
    )
    frame = np.eye(3, 4, dtype=F32)[None].copy()
    frame[0, :, 3] = 0.2, 0.1, 1.0
    arrays = {'type': np.array([b.LIGHT_POINT], U32), 'size': np.array([0.5], F32), 'transform': frame}
    lamp = replace(lights(((0.0, 0.0, -1.0), 9.0)), visibility=np.array([b.VISIBLE_DIFFUSE], U32), **arrays)
    return scene((plane(-2.0, 2.0), *patches), made, lights=lamp)


@on_both('least, stops', [(1, 2), (5, 8), (16, 16)], [(5, 8)])
def test_where_adaptive_sampling_stops(device: str, least: int, stops: int) -> None:
    """Passes end after 1, 2, 4, 8 ... samples. A pixel goes on while it, or one beside it in its tile, has noise; the
    others stop with the first pass that takes them to the minimum (with one sample there is nothing to compare)."""
    found = render(
        noisy_pixels(),
        camera(1.0, SIZE),
        samples=64,
        adaptive=True,
        noise_threshold=1e-6,
        adaptive_min_samples=least,
        device=device,
        passes=('combined', 'sample_count'),
    )['sample_count'][..., 0]
    expected = np.full((SIZE, SIZE), stops)
    rows, columns = np.mgrid[:SIZE, :SIZE]
    for column, row in NOISY:
        beside = (abs(columns - column) <= 1) & (abs(rows - row) <= 1)
        tile = (columns // TILE == column // TILE) & (rows // TILE == row // TILE)
        expected[beside & tile] = 64
    assert (found == expected).all(), f'\n{np.argwhere(found != expected)}'


def test_the_minimum_follows_from_the_threshold() -> None:
    """16 samples, or 1.6 / sqrt(threshold) where that is more: 51 here, so that the pass that ends with 64 decides."""
    settings = {'samples': 128, 'adaptive': True, 'passes': ('combined', 'sample_count')}
    for threshold, stops in ((0.5, 16), (1e-3, 64)):
        found = render(noisy_pixels(), camera(1.0, SIZE), noise_threshold=threshold, **settings)['sample_count']
        assert found.min() == stops


@on_both('samples', [(1,), (8,)], [(8,)])
def test_the_noise_that_is_left(device: str, samples: int) -> None:
    """A pixel's error as the stop rule sees it, also where nothing stops: none where there is no noise, and none is
    known of one sample."""
    settings = {'samples': samples, 'adaptive': False, 'device': device, 'passes': ('combined', 'noise')}
    found = render(noisy_pixels(), camera(1.0, SIZE), **settings)
    noise = found['noise'][..., 0]
    noisy = np.zeros((SIZE, SIZE), bool)
    for column, row in NOISY:
        noisy[row, column] = True
    assert (noise[~noisy] == 0.0).all()
    assert (noise[noisy] > 0.0).all() == (samples > 1)
    # Two halves whose mean is the picture: neither is further from it than the picture is bright.
    mean = found['combined'][..., :3].sum(axis=2)
    assert (noise * np.sqrt(mean) <= mean * 1.001 + 1e-6).all()


def edges() -> b.SceneBuffers:
    """Squares that shine before a black wall, turned so that their edges cross pixels in all ways; no other noise."""
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]], F32)
    squares = []
    for x, y in np.argwhere(np.ones((5, 5))) * 0.4 - 0.8:
        square = plane(-0.12, 0.12, 0.1)
        square.positions[:, :2] = square.positions[:, :2] @ turn + np.array([x + ASIDE, y], F32)
        squares.append(square)
    count = 1 + len(squares)
    colors = {'base_color': [[0.0] * 3] * count, 'emission': [[0.0] * 3] + [[0.5] * 3] * len(squares)}
    return scene((plane(-2.0, 2.0), *squares), materials(count, emission_sampling=[0] * count, **colors))


def soft_shadow() -> b.SceneBuffers:
    """A wall, half in the light of a lamp of size, which a square hides from it in part."""
    made = noisy_pixels()
    hidden = plane(-0.3, 0.3, 0.5)
    hidden.positions[:, 0] += np.float32(ASIDE + 0.8)
    colors = {'base_color': [[0.8] * 3, [0.0] * 3], 'emission': [[0.0] * 3] * 2}
    return scene((plane(-2.0, 2.0), hidden), materials(2, **colors), lights=made.lights)


@pytest.mark.parametrize('made', [edges, soft_shadow])
@pytest.mark.parametrize('samples', [16, 64])
def test_the_noise_that_is_told_is_what_remains(made: Callable[[], b.SceneBuffers], samples: int) -> None:
    """Within a fifth, also where samples converge faster than at random: at edges, the error falls as n^-0.75."""
    seen_by = replace(camera(1.0, SIZE), filter_width=1.5)
    truth = render(made(), seen_by, samples=1 << 12, seed=1)['combined'][..., :3]
    told = remains = 0.0
    for seed in range(2, 6):
        settings = {'samples': samples, 'seed': seed, 'passes': ('combined', 'noise')}
        found = render(made(), seen_by, **settings)
        told += found['noise'].mean()
        picture = found['combined'][..., :3]
        error = abs(picture - truth).sum(axis=2)
        # The brighter of the two: a pixel whose one sample is found in no truth would count for a hundred.
        remains += (error / (1e-4 + np.sqrt(np.maximum(picture, truth).sum(axis=2)))).mean()
    assert remains == pytest.approx(told, rel=0.2)


# ---- Samples where they are needed


def test_samples_are_taken_where_they_were_told_to_be() -> None:
    """A column takes as many as `most` says, or as the pass in which it reaches them ends with; none fewer than all had
    before. What a pixel shows does not depend on how many its neighbours take."""
    module = native.load()
    built = module.Scene(noisy_pixels(), threads=1, embree=native.embree_library())
    settings = b.RenderSettings(
        integrator='DIRECT', samples=256, spread_after=8, threads=2, passes=('combined', 'sample_count')
    )
    pictures = []
    for wanted in (np.resize([1, 8, 9, 16, 100, 128], SIZE), np.full(SIZE, 128)):
        session = module.Session(built, camera(1.0, SIZE), settings)
        with pytest.raises(RuntimeError, match='spread'):
            session.spread(np.zeros((SIZE, SIZE), U32))
        session.start()
        assert session.wait(300.0) and session.samples_done() == 8
        differences = np.zeros((SIZE, SIZE, 3), F32)
        session.differences(differences)
        rows, columns = np.nonzero(differences[..., 0])
        assert {(x, y) for x, y in zip(columns.tolist(), rows.tolist(), strict=True)} == set(NOISY)
        # A ray to each pixel; from each patch in the tile one to the lamp, and one by its BSDF that may meet it.
        in_tiles = np.zeros((2, 2), F32)
        for x, y in NOISY:
            in_tiles[y // TILE, x // TILE] += 2.0 / TILE**2
        assert differences[::TILE, ::TILE, 2] == pytest.approx(1.0 + in_tiles, rel=1e-6)
        assert (differences[..., 2] == np.kron(differences[::TILE, ::TILE, 2], np.ones((TILE, TILE)))).all()
        session.spread(np.tile(wanted, (SIZE, 1)).astype(U32))
        session.start()
        assert session.wait(300.0) and session.progress() == 1.0
        found = np.zeros((SIZE, SIZE, 1), F32), np.zeros((SIZE, SIZE, 4), F32)
        session.read('sample_count', found[0])
        session.read('combined', found[1])
        ends = np.resize([8, 8, 16, 16, 128, 128], SIZE) if wanted[0] == 1 else wanted
        assert (found[0][..., 0] == ends).all()
        pictures.append(found[1])
    same = np.resize([False] * 4 + [True] * 2, SIZE)
    assert (pictures[0][:, same] == pictures[1][:, same]).all()


@pytest.mark.parametrize('wrong', [{'spread_after': 9}, {'spread_after': 8, 'adaptive': True}, {'spread_after': 64}])
def test_where_samples_cannot_be_spread(wrong: dict) -> None:
    with pytest.raises(ValueError, match='spread_after'):
        render(noisy_pixels(), camera(1.0, SIZE), **({'samples': 32} | wrong))


# ---- Stopping


def test_a_session_stops_in_the_middle_of_a_pass() -> None:
    """One tile of 256 pixels, and passes of 32 samples: eight batches of 1,024 paths each. The wish to stop is seen
    between two batches, not only at the end of a pass. Counted in samples, since how long one takes depends on much."""
    walls = plane(-1e4, 1e4, -1.0), plane(-1e4, 1e4, 1.0)
    made = materials(2, base_color=[[1.0] * 3] * 2, emission=[[1e-3] * 3] * 2, emission_sampling=[0] * 2)
    module = native.load()
    built = module.Scene(scene(walls, made), threads=1, embree=native.embree_library())
    between = camera(0.5, TILE, 0.5)
    limits = {'max_bounces': 500, 'diffuse_bounces': 500, 'integrator': 'PATH'}
    session = module.Session(built, between, b.RenderSettings(samples=1 << 16, threads=1, **limits))
    session.start()
    while session.samples_done() < 32:
        assert not session.wait(0.0), 'it ended by itself'
        time.sleep(0.001)
    session.cancel()
    done = session.samples_done() * TILE**2
    assert session.wait(60.0)
    assert session.stats()['samples'] - done <= 3 * 1024, 'it went on to the end of the pass'


# ---- Light groups


@on_both('group', [(-1,), (0,), (1,)], [(-1,)])
def test_light_goes_to_its_group_alone(device: str, group: int) -> None:
    """The world's, an emitter's and a lamp's in turn; without a group it goes to none."""
    names = ('combined', 'lightgroup:0', 'lightgroup:1')
    world = b.World((0.3, 0.3, 0.3), light_group=group)
    lamp = replace(lights(((0.0, 0.0, -1.0), 3.0)), light_group=np.array([group], I32))
    glow = materials(emission=[[0.5] * 3])
    of_object = instances(1, light_group=np.array([group], I32))
    cases = {
        'world': scene((plane(-0.5, 0.5),), materials(), world=world),
        'emitter': scene((plane(-0.5, 0.5),), glow, instances=of_object),
        'lamp': scene((plane(-0.5, 0.5),), materials(), lights=lamp),
    }
    for name, made in list(cases.items())[: 3 if device == 'CPU' else 1]:
        grouped = replace(made, light_groups=('A', 'B'))
        found = render(grouped, camera(1.0, TILE), samples=4, integrator='PATH', passes=names, device=device)
        assert found['combined'][..., :3].max() > 0.1, name
        for k in (0, 1):
            expected = found['combined'][..., :3] if k == group else 0.0
            assert found[f'lightgroup:{k}'] == pytest.approx(expected, rel=1e-6), (name, k)
