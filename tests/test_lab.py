# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chart is planned by and what is computed of its renders, which are made up here. Nothing is rendered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cotorra.lab import labels, pictures, plan, results
from cotorra.lab.plan import Job, Plan, Series
from cotorra.lab.store import Render, Store
from cotorra.terminal import CommandError

PATH, DIRECT, CYCLES = Series(), Series(integrator='DIRECT'), Series('CYCLES')


def cost(beside: float = 0.1, rate: float = 0.01):
    return lambda job: beside + rate * job.samples


@pytest.mark.parametrize('beside, rate', [(0.1, 0.01), (2.0, 0.001), (0.01, 0.3)])
@pytest.mark.parametrize('seconds', [30.0, 120.0, 1000.0])
def test_a_budget_is_used_and_kept(beside: float, rate: float, seconds: float) -> None:
    chart = Plan(list(plan.DEFAULT_SERIES[:5]), [])
    plan.fit_to_budget(chart, cost(beside, rate), seconds)
    taken = sum(map(cost(beside, rate), chart.jobs()))
    assert taken <= seconds
    assert len(chart.series) >= 2 and len(chart.samples) >= 2
    # One step more, twice the samples, would have been too much, unless nothing is left to wish for.
    more = Plan(chart.series, plan.ladder(2 * chart.samples[-1], len(chart.samples)), chart.seeds)
    assert sum(map(cost(beside, rate), more.jobs())) > seconds


def test_the_plan_renders_both_references_before_points() -> None:
    chart = Plan([PATH, CYCLES, DIRECT], [1, 4])
    jobs = chart.jobs()
    assert [(job.reference, job.series.engine) for job in jobs[:4]] == [(True, 'COTORRA'), (True, 'CYCLES')] * 2
    assert len({job.key for job in jobs}) == len(jobs) == 3 * 2 * 2 + 2 * plan.PARTS
    assert chart.reference_of(DIRECT) == PATH and chart.reference_of(CYCLES) == CYCLES
    assert all(Job.read(job.content()) == job for job in jobs) and Plan.read(chart.content()) == chart


def test_combinations_that_mean_nothing_are_left_out() -> None:
    found = plan.chosen_series(['COTORRA', 'CYCLES'], ['PATH', 'AO'], ['', 'LAMBERT'], ['CPU'], [False], [False, True])
    names = [series.name for series in found]
    assert len(names) == len(set(names)) == 8
    assert 'Ambient Occlusion, denoised' not in names and 'Path, Lambert, denoised' in names


def renders(rng: np.random.Generator, chart: Plan, seconds: dict[Series, float], bias: dict[Series, float]):
    """Noise of variance 1/samples, relative to a ramp."""
    truth = np.geomspace(0.1, 3.0, 64 * 48 * 3).reshape(48, 64, 3)
    found = []
    for job in chart.jobs():
        noise = rng.normal(0.0, (0.2 / job.samples) ** 0.5, truth.shape)
        image = (truth * (1.0 + bias.get(job.series, 0.0)) * (1.0 + noise)).astype(np.float32)
        time = seconds[job.series] * job.samples
        found.append(Render(job, time, 2 * time, time + 1.0, image))
    return found


def test_noise_bias_and_slope_are_found() -> None:
    chart = Plan([PATH, CYCLES, DIRECT], [4, 16, 64], seeds=4)
    made = renders(np.random.default_rng(5), chart, {PATH: 0.1, CYCLES: 0.3, DIRECT: 0.02}, {DIRECT: -0.3})
    found = results.evaluate(chart, made, 'wall')
    path, cycles, direct = found.lines
    for line in found.lines:
        # 9,216 values and four seeds: noise is known to 2 %, its slope between factors of 4 to 1 %.
        assert line.slope == pytest.approx(1.0, abs=0.05)
    assert path.bias is None and cycles.bias is None
    assert direct.bias.value == pytest.approx(-0.3, abs=0.005) and not direct.bias.holds_zero
    assert [point.parts.bias_relmse for point in direct.points] == pytest.approx([0.088] * 3, rel=0.15)
    assert abs(found.between.total.value) < 0.005
    assert path.points[0].relmse / path.points[2].relmse == pytest.approx(16.0, rel=0.1)
    # On the front: the cheap direct light, then our paths, three times as fast as Cycles'.
    names = [(p.series.name, p.samples) for p in results.front(found.points, 'relmse', 'wall')]
    # (Cycles' last point has the error of our last one, but for noise.)
    assert names[:5] == [('Direct', 4), ('Direct', 16), ('Path', 4), ('Path', 16), ('Path', 64)]
    curve = direct.curves['relmse']
    assert curve.error(1e9) == pytest.approx(curve.floor) and curve.floor == pytest.approx(0.088, rel=0.15)


def test_front_of_known_points() -> None:
    def point(seconds: float, error: float) -> results.Point:
        empty = np.zeros((1, 1, 3))
        return results.Point(PATH, 1, 1, seconds, seconds, seconds, error, error, error, error, 0, None, empty, empty)

    points = [point(2, 3), point(1, 5), point(3, 3), point(4, 1), point(0.5, 9), point(5, 2), point(6, 0)]
    assert [(p.wall, p.relmse) for p in results.front(points, 'relmse', 'wall')] == [(0.5, 9), (1, 5), (2, 3), (4, 1)]


def test_without_a_reference_there_is_no_chart() -> None:
    chart = Plan([PATH], [4])
    assert results.evaluate(chart, [], 'wall') is None


def test_labels_do_not_cover_each_other() -> None:
    rng = np.random.default_rng(3)
    anchors = rng.uniform(40, 460, (24, 2))
    marks = [(x - 6, y - 6, x + 6, y + 6) for x, y in anchors]
    wanted = [labels.Label(f'{i}', tuple(anchor), (60.0, 12.0), i % 2 == 0) for i, anchor in enumerate(anchors)]
    frame = (0.0, 0.0, 500.0, 500.0)
    boxes = labels.place(wanted, marks, frame)
    placed = [box for box in boxes if box is not None]
    assert all(box is not None for box, label in zip(boxes, wanted, strict=True) if label.needed)
    for index, box in enumerate(placed):
        assert all(labels.overlap(box, other) == 0.0 for other in [*placed[index + 1 :], *marks])
        assert labels.overlap(box, frame) == pytest.approx(60.0 * 12.0)


def test_a_broken_render_is_rendered_again(tmp_path: Path) -> None:
    store = Store(tmp_path, {'scene': 'a'})
    assert store.open(fresh=False) is None
    store.write_plan(Plan([PATH], [4]))
    job = Job(PATH, 4, 1)
    np.save(tmp_path / 'given.npy', np.ones((2, 3, 3), np.float32))
    store.keep(job, {'wall': 1.0, 'cpu': 2.0, 'whole': 3.0, 'image': str(tmp_path / 'given.npy')})
    assert store.has(job) and store.all()[0].job == job and store.all()[0].image.shape == (2, 3, 3)
    (store.renders / f'{job.key}.npy').write_bytes(b'half')
    assert store.all() == [] and not store.has(job)
    store.close()
    assert Store(tmp_path, {'scene': 'a'}).open(fresh=False) == Plan([PATH], [4])
    with pytest.raises(CommandError, match=r'scene a \(now b\)'):
        Store(tmp_path, {'scene': 'b'}).open(fresh=False)
    assert Store(tmp_path, {'scene': 'b'}).open(fresh=True) is None


def test_two_charts_at_once_need_two_folders(tmp_path: Path) -> None:
    one, other = Store(tmp_path, {'scene': 'a'}), Store(tmp_path, {'scene': 'a'})
    one.open(fresh=False)
    for fresh in (False, True):
        with pytest.raises(CommandError, match='another process makes a chart there'):
            other.open(fresh)
    one.close()
    assert other.open(fresh=False) is None
    other.close()


@pytest.mark.parametrize('share', [0.0, 0.3, 1.0])
def test_a_slider_shows_one_picture_left_of_it_and_the_other_right(share: float) -> None:
    """Three pictures of one color each, 4 rows of 10 columns, with titles of 2 rows above."""
    parts = [np.full((6, 10, 3), color, np.uint8) for color in (10, 20, 30)]
    for part, title in zip(parts, (1, 2, 3), strict=True):
        part[:2] = title
    found = pictures.wiped(pictures.side_by_side(parts), (10, 4), share)
    assert found.shape == (8, 20 + pictures.GAP, 3)
    assert (found[:2, :10] == 1).all() and (found[2:4, :10] == 2).all() and (found[:2, -10:] == 3).all()
    cut = round(10 * share)
    edge = {cut - 1, cut} if 0 < cut < 10 else set()
    for column in set(range(10)) - edge:
        assert (found[4:, column] == (10 if column < cut else 20)).all()
    assert all((found[4:, column] > 200).all() for column in edge)
    assert (found[4:, -10:] == 30).all()


def test_pictures_show_what_is_bad(tmp_path: Path) -> None:
    image = np.full((4, 6, 3), 0.5, np.float32)
    image[1, 2, 0], image[2, 3, 1] = np.nan, np.inf
    shown = pictures.displayed(image, 1.0)
    assert [tuple(shown[place]) for place in ((1, 2), (2, 3))] == [pictures.BAD] * 2
    assert tuple(shown[0, 0]) == (188, 188, 188)  # sRGB of 0.5
    error = np.array([[0.0, 0.01, 0.1, 1.0, np.nan]])
    ends = [tuple(color) for color in pictures.heat(error)[0]]
    assert ends[0] == ends[1] == pictures.HEAT[0][1] and ends[2] == pictures.HEAT[2][1]
    assert ends[3] == pictures.HEAT[-1][1] and ends[4] == pictures.BAD
    pictures.write(tmp_path / 'a.png', shown)
    assert (tmp_path / 'a.png').read_bytes().startswith(b'\x89PNG')
