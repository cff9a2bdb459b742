# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes, valid and invalid, through Blender in a process of its own: none crashes, hangs or has pixels that are
not finite. Those that once did are kept, shrunk, in fuzzing/kept, and rendered first.

COTORRA_SCENES=5000 scripts/test tests/test_fuzz.py is the long run, scripts/fuzz 5000 one of new seeds.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

import vulkan
from fuzzing.__main__ import Campaign, search, survey

KEPT = sorted((Path(__file__).resolve().parent / 'fuzzing' / 'kept').glob('*.json'))
SCENES = int(os.environ.get('COTORRA_SCENES', '200'))
SEED = 12  # of CI; another finds other scenes


@pytest.fixture(scope='module')
def campaign() -> Iterator[Campaign]:
    made = Campaign(seconds=30.0, device={})
    yield made
    made.close()


PLAIN = {
    'objects': [{'mesh': {'kind': 'quad'}, 'place': {}, 'materials': []}],
    'lights': [],
    'world': {'kind': 'plain', 'color': [1.0, 1.0, 1.0], 'strength': 1.0},
    'camera': None,
    'render': {
        'integrator': 'PATH', 'samples': 1, 'settings': {}, 'override': None, 'cycles': None, 'layer': {},
        'layer_settings': {}, 'transparent': False, 'border': None,
    },
}  # fmt: skip


@pytest.mark.parametrize(
    'fault, told', [('crash', 'crash (-6)'), ('hang', 'hangs for more than'), ('nan', 'not finite')]
)
def test_a_fault_is_found(campaign: Campaign, monkeypatch: pytest.MonkeyPatch, fault: str, told: str) -> None:
    """And the next scene is rendered all the same."""
    monkeypatch.setattr(campaign.runner, 'seconds', 0.5)
    assert told in campaign.runner.verdict(PLAIN | {'sabotage': fault})['fault']
    monkeypatch.undo()
    assert campaign.runner.verdict(PLAIN)['fault'] == ''


def test_a_survey_goes_on_after_a_fault_and_keeps_its_scene(
    campaign: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def judge(description: dict) -> dict:
        seen.append(description)
        return {'fault': 'crash' if len(seen) % 3 == 0 else ''}

    monkeypatch.setattr(campaign, 'judge', judge)
    found = survey(campaign, 12, SEED)
    assert len(seen) >= 12 and [entry['scene'] for entry in found] == seen[2::3]


@pytest.mark.parametrize('path', KEPT, ids=lambda path: path.stem)
def test_scenes_that_once_failed(campaign: Campaign, path: Path) -> None:
    assert campaign.judge(json.loads(path.read_text())['scene'])['fault'] == ''


def test_random_scenes(campaign: Campaign) -> None:
    found = search(campaign, SCENES, SEED)
    assert found is None, json.dumps(found)


@pytest.mark.long
@pytest.mark.parametrize('ray_tracing', ['SOFTWARE', 'HARDWARE'])
def test_random_scenes_on_vulkan(ray_tracing: str) -> None:
    """A few: lavapipe compiles kernels for what each uses, for 20 to 50 seconds."""
    runner = vulkan.open_lavapipe()
    if isinstance(runner, str):
        pytest.skip(runner)
    made = Campaign(seconds=60.0, device={'device': 'VULKAN', 'ray_tracing': ray_tracing})
    try:
        found = search(made, max(SCENES // 50, 2), SEED)
    finally:
        made.close()
    assert found is None, json.dumps(found)
