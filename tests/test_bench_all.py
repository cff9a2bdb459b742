# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan, table and sheet of `./scripts/bench --all`, and the groups of `--shares`, on made-up figures.

Nothing is rendered here; the judgement itself is test_bench.py's.
"""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio
import pytest
from cotorra.export import buffers

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference, same_image

from benchmark import everything, runner, shares, sheet
from test_bench import halves, renders


def probe(seconds: float, start: float = 1.0) -> runner.Render:
    """Four samples, each of so many seconds, after a start."""
    return runner.Render(4, 7, np.zeros((2, 2, 3)), 4 * seconds, start + 4 * seconds, 8 * seconds, 0, {}, start)


@pytest.mark.parametrize('budget', [30.0, 100.0, 1000.0])
def test_a_plan_keeps_to_its_time(budget: float) -> None:
    ours, cycles = 0.02, 0.1
    found = everything.plan({'COTORRA': probe(ours), 'CYCLES': probe(cycles)}, budget)
    work = sum(everything.SHARES) * found.samples
    seconds = 5 + 8 + ours * (work + 2 * found.reference) + cycles * (2 * work + 2 * found.reference)
    assert seconds <= budget
    assert found.reference >= everything.REFERENCE * found.samples
    # The next larger plan does not fit.
    larger = [samples for samples in everything.SAMPLES if samples > found.samples]
    assert not larger or ours * 9.75 * larger[-1] + cycles * 11.5 * larger[-1] + 13 > budget


def test_without_time_the_plan_is_the_least() -> None:
    found = everything.plan({'COTORRA': probe(1.0), 'CYCLES': probe(1.0)}, 0.0)
    assert found.samples == everything.SAMPLES[-1] and found.reference == everything.REFERENCE * found.samples


def result(name: str) -> dict:
    ours, cycles = renders(1, 0.5, 0.1), renders(2, 1.0, 0.2)
    reference, truth = halves(3, 0.5), halves(4, 1.0)
    entry, _ = everything.judge.verdict('COTORRA', ours, reference, cycles, truth, 0)
    same = same_image(reference, truth, everything.TILE_LIMIT)
    return {
        'scene': name,
        **entry,
        'shipped': everything.against_shipped(ours, reference, renders(5, 1.0, 0.1), truth, 0),
        'same_2_percent': {key: getattr(same, key) for key in ('total', 'within', 'beyond_noise', 'noise')},
        'starts': {'COTORRA': {'first': 0.25}, 'CYCLES': {'first': None}},
        'plan': {'samples': 64},
    }


def test_table() -> None:
    """Half the variance and half the seconds a sample; as shipped Cycles takes the seconds that we take."""
    text = everything.table([result('plain'), {'scene': 'broken', 'error': 'no camera'}])
    lines = {line.split()[0]: line.split() for line in text.splitlines()}
    assert lines['broken'][1] == 'failed'
    row = lines['plain']
    assert row[1] == '64' and row[9:11] == ['0.25', '-']
    assert float(row[2]) == pytest.approx(4.0, rel=0.1)  # of noise; see test_bench
    assert float(row[5]) == pytest.approx(2.0, rel=0.1)
    assert lines['geometric'][2] == row[2]


def test_sheet(tmp_path: Path) -> None:
    """A row for each scene; what is too bright on our side is red, too dark blue."""
    flat = np.full((48, 64, 3), 0.5)
    drawn = sheet.Sheet(tmp_path / 'folder' / 'sheet.png')
    for factor in (1.2, 0.8):
        images = flat * factor, flat
        same = same_image(*(Reference.from_image(image) for image in images), everything.TILE_LIMIT)
        drawn.add({'scene': 'flat'}, same, images)
    pixels = oiio.ImageBuf(str(drawn.path)).get_pixels(oiio.FLOAT)
    height = 2 * (sheet.WIDTH * 48 / 64 + sheet.TITLE)
    assert pixels.shape[:2] == (height, 3 * sheet.WIDTH)
    for row, channel in ((0.3, 0), (0.8, 2)):
        assert pixels[int(row * height), int(2.5 * sheet.WIDTH), :3].argmax() == channel


@pytest.mark.parametrize('lamps', [0, 3, 40])
def test_groups_of_light(lamps: int) -> None:
    lights = buffers.Lights(*[np.zeros(lamps)] * 13, names=tuple(f'Lamp {i}' for i in range(lamps)))
    instances = buffers.Instances(*[np.zeros(5, np.uint32)] * 8)
    scene = buffers.SceneBuffers((), instances, SimpleNamespace(), np.zeros(0), lights, buffers.World())
    found, names = shares.grouped(scene)
    assert found.light_groups == tuple(names)
    assert names[-2:] == ['world', 'emitting meshes'] and found.world.light_group == len(names) - 2
    assert (found.instances.light_group == len(names) - 1).all()
    if lamps > shares.MOST_LAMPS:
        assert names[shares.MOST_LAMPS] == '16 other lamps'
    assert found.lights.light_group.tolist() == [min(i, shares.MOST_LAMPS) for i in range(lamps)]


def test_when_the_time_is_gone_the_rest_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each scene takes a minute of a clock of our own; two minutes are there for three."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(everything.time, 'perf_counter', lambda: clock.now)
    monkeypatch.setattr(everything.runner, 'blender_memory', lambda case: 0)
    given = []

    def one(case: runner.Case, blender: int, seconds: float) -> tuple:
        clock.now += 60.0
        given.append(seconds)
        return {'scene': case.source.name}, None, None

    monkeypatch.setattr(everything, 'one', one)
    sources = [everything.scenes.SceneSource(name, 'demo') for name in 'abc']
    found = everything.run(sources, 4, (32, 18), 2, 2.0, lambda *shown: None)
    assert [entry.get('error', '') for entry in found] == ['', '', 'no time was left for it']
    assert given == pytest.approx([0.9 * 40.0, 0.9 * 30.0])
