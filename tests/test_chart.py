# SPDX-License-Identifier: GPL-3.0-or-later
"""Each chart can be made, coarse and small, and writes what it says. What the charts show is for people to judge."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference

import chart


def made(name: str, folder: Path) -> dict[str, list[dict[str, str]]]:
    """The rows of each table that the quick chart writes, by file name."""
    assert chart.main([name, '--quick', '-o', str(folder)]) == 0
    assert (folder / f'{name}.png').stat().st_size > 10_000
    return {path.stem: list(csv.DictReader(path.open())) for path in folder.glob('*.csv')}


def test_misprints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = made('misprints', tmp_path)['misprints']
    assert [row['misprint'] for row in rows] == [
        'Schlick', 'half vector', 'light window', 'Lambert', 'Smith t', 'Sobel', 'Möller-Trumbore', 'recursion',
    ]  # fmt: skip
    by_name = {row['misprint']: (float(row['right']), float(row['misprinted'])) for row in rows}
    # ∫ cos / π = 1 and ∫ cos² / π = 2/3 over the hemisphere, by trapezoids of 64 steps.
    assert np.allclose(by_name['Lambert'], (1.0, 2.0 / 3.0), rtol=1e-3)
    # Schlick's mean, cosine-weighted, is F0 + (1 − F0) / 21.
    assert by_name['Schlick'][0] == pytest.approx(0.04 + 0.96 / 21.0, rel=3e-3)
    assert 'misprinted' in capsys.readouterr().out


def test_bad_name(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        chart.main(['misprint'])
    assert end.value.code == 2
    assert 'misprints' in capsys.readouterr().err


def test_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from charting import models

    judged, errors = models.judged, []

    def judge(measured: models.Measured, reference: Reference, plan: models.Plan) -> tuple[float, ...]:
        """Keeps the standard error of the difference of the means, too. (Pixels are independent.)"""
        variance = Reference.from_halves(*measured.images).variance + reference.variance
        errors.append(float(np.sqrt(variance.mean(axis=2).sum()) / variance[..., 0].size / reference.image.mean()))
        return judged(measured, reference, plan)

    monkeypatch.setattr(models, 'judged', judge)
    tables = made('models', tmp_path)
    assert [row['model'] for row in tables['models-models']] == list(models.MODELS)
    integrators = {row['integrator']: row for row in tables['models-integrators']}
    # Cycles' own clock shows hundredths of a second: none, for so small a frame.
    assert all(float(row['ms']) > 0.0 for name, row in integrators.items() if not name.startswith('Cycles'))
    # Fewer than one in a hundred frames lie further from the reference by noise: 2.58 standard errors, 9 % here.
    error = dict(zip(integrators, errors[-len(integrators) :], strict=True))['PATH']
    assert abs(float(integrators['PATH']['total'])) < 2.58 * error
    (principled,) = (row for row in tables['models-models'] if row['model'] == 'Principled')
    assert principled['total'] == integrators['PATH']['total'], 'the scene as it is, from the same random numbers'
    assert float(integrators['DIRECT']['total']) < -0.2


def test_furnace(tmp_path: Path) -> None:
    rows = {row['model']: row for row in made('furnace', tmp_path)['furnace']}
    # Where the energy is known: white Lambert, EON and two equal tones give back all of it, classic Phong
    # 2π / (n + 1) of it toward the normal, which is π for the least n here, 1.
    for name in ('Lambert', 'Oren-Nayar, energy preserving', 'Toon'):
        assert rows[name]['verdict'] == 'keeps it', name
    assert float(rows['Phong, ks 1']['highest']) == pytest.approx(np.pi, rel=5e-3)
    # Oren-Nayar's short form makes 1 % too, but at a sigma between those of the quick chart.
    makers = {name for name, row in rows.items() if row['verdict'] == 'MAKES ENERGY'}
    assert makers == {
        'Phong, ks 1',
        'Blinn-Phong, ks 1',
        'D BLINN_PHONG G SMITH_CORRELATED, F = 1',
        'D BLINN_PHONG G SMITH, F = 1',
        *(f'F {fresnel}, ENERGY, white' for fresnel in ('SCHLICK', 'DIELECTRIC', 'CONDUCTOR', 'F82')),
    }


def test_failures(tmp_path: Path) -> None:
    rows = {row['where']: row for row in made('failures', tmp_path)['failures']}
    ours = {where: float(row['worst by the kernels']) for where, row in rows.items()}
    # A highlight's terms keep a few roundings of 6e-8; F next to F = 0 and next to the critical angle cannot.
    assert max(error for where, error in ours.items() if where not in ('η to 1', 'critical angle')) < 1e-5
    assert float(rows['D GGX, roughness to 1e-4']['worst as written']) > 0.1
    assert float(rows['critical angle']['not finite']) > 0.3


def test_stability(tmp_path: Path) -> None:
    """The coarse atlas: no method is worse than promised, where it is promised."""
    rows = made('stability', tmp_path)['stability-summary']
    assert len(rows) > 40
    worst = {row['method']: float(row['worst where promised']) / float(row['limit']) for row in rows}
    assert {name: error for name, error in worst.items() if not error <= 1.0} == {}
    told = (tmp_path / 'stability.md').read_text()
    assert all(f'| {name} |' in told for name in worst)
