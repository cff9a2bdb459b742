# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's judgement on renders whose noise and seconds are made up, and what its command line refuses.

Nothing is rendered here; test_same_image.py renders.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference

import bench
import compare
from benchmark import judge, report, runner, scenes

COUNTS = (16, 32, 64)


def truth() -> np.ndarray:
    """A ramp over three orders of magnitude."""
    return np.repeat(np.geomspace(0.01, 10, 192), 108).reshape(192, 108).T[..., None] * np.array([1.0, 0.8, 0.5])


def renders(seed: int, variance: float, seconds: float, bias: float = 0.0) -> list[runner.Render]:
    """Renders with relative variance `variance` and `seconds` for one sample, and two seconds of preparation."""
    rng = np.random.default_rng(seed)
    image = truth() * (1 + bias)
    return [
        runner.Render(
            samples=n,
            seed=seed,
            image=image * (1 + rng.normal(0, (variance / n) ** 0.5, image.shape)),
            render=seconds * n,
            whole=2 + seconds * n,
            cpu=2 * seconds * n,
            memory=3000 + n,
            stats={},
        )
        for n in reversed(COUNTS)
    ]


def halves(seed: int, variance: float, bias: float = 0.0) -> Reference:
    rng = np.random.default_rng(seed)
    image = truth() * (1 + bias)
    return Reference.from_halves(*(image * (1 + rng.normal(0, (variance / 256) ** 0.5, image.shape)) for _ in range(2)))


def test_equal_error_of_known_engines() -> None:
    # Half the variance and half the seconds a sample: a quarter of the time to equal error.
    ours, cycles = renders(1, 0.5, 0.1), renders(2, 1.0, 0.2)
    result, same = judge.verdict('OURS', ours, halves(3, 0.5), cycles, halves(4, 1.0), blender=1000)
    assert not result['equal_error_failed']
    for entry in result['equal_error']:
        # The brightest tenth of 62,208 noisy values makes most of the MSE, which is known to 2 %; fits double that.
        assert entry['samples'] == pytest.approx(32, rel=0.1)
        assert entry['render'] == pytest.approx(4.0, rel=0.1)
        assert entry['cpu'] == pytest.approx(4.0, rel=0.1)
        assert entry['whole'] == pytest.approx((2 + 12.8) / (2 + 3.2), rel=0.1)
        assert entry['slope_ours'] == pytest.approx(1.0, abs=0.05)
        assert not entry['extrapolated']
    assert same.beyond_noise == 0.0
    assert [row['memory'] for row in result['rows']] == [None, None, 2064] * 2


def test_a_systematic_difference_is_no_noise() -> None:
    ours, cycles = renders(1, 0.5, 0.1, bias=0.1), renders(2, 1.0, 0.2)
    result, same = judge.verdict('OURS', ours, halves(3, 0.5, bias=0.1), cycles, halves(4, 1.0), blender=0)
    ratio = {(entry['against'], entry['measure']): entry['render'] for entry in result['equal_error']}
    assert ratio['own', 'trimmed'] == pytest.approx(4.0, rel=0.05)
    assert ratio.get(('cycles', 'trimmed'), 0.0) < 2.5
    assert same.total == pytest.approx(0.1, abs=0.002)
    assert same.beyond_noise == 1.0


def test_report_is_complete() -> None:
    ours, cycles = renders(1, 0.5, 0.1), renders(2, 1.0, 0.2)
    result, same = judge.verdict('OURS', ours, halves(3, 0.5), cycles, halves(4, 1.0), blender=0)
    text = report.case_text('a scene', result, same, 108 * 192)
    assert text.count('OURS') == text.count('CYCLES') == 3
    case = {'scene': 'a scene', 'bounces': 0, 'engines': ['OURS', 'CYCLES'], **result}
    line = report.summary([case]).splitlines()[-1]
    assert line.split()[:3] == ['a', 'scene', '0']
    assert float(line.split()[3]) == pytest.approx(4.0, rel=0.05)


def test_seconds_of_cycles() -> None:
    assert runner.clock('00:01.25') == 1.25
    assert runner.clock('01:02:03.50') == 3723.5


def test_scene_names() -> None:
    assert scenes.find('box_room').kind == 'demo'
    with pytest.raises(ValueError, match=r'no scene is called boxroom; there are three_lights'):
        scenes.find('boxroom')
    with pytest.raises(ValueError, match=r'none\.blend: no such file'):
        scenes.find('none.blend')


@pytest.mark.parametrize(
    'arguments', [['boxroom'], ['--size', '640'], ['--size', '0x9'], ['--samples', '2'], ['--bounces', '-1']]
)
def test_bad_arguments(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        bench.parse(arguments)
    assert end.value.code == 2
    assert 'error:' in capsys.readouterr().err


def test_compare_names_a_missing_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare.main([str(tmp_path / 'a.exr'), str(tmp_path / 'b.exr')]) == 2
    assert 'a.exr' in capsys.readouterr().err
