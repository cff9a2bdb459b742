# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders N random scenes in a process of its own; those that crash, hang or give pixels that are not finite are
written to build/fuzzed, and shrunk first where that is asked for: it takes up to five minutes for each, and leaves out
the rest of its hundred. The exit code is 1 if there is one.
"""

from __future__ import annotations

import argparse
import collections
import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis

from .descriptions import scenes
from .runner import Runner

ROOT = Path(__file__).resolve().parents[2]


class Campaign:
    """What was met in one run, and how often."""

    def __init__(self, seconds: float, device: dict[str, str]) -> None:
        self.runner = Runner(seconds)
        self.device = device
        self.rendered = 0
        self.met: collections.Counter[str] = collections.Counter()

    def judge(self, description: dict[str, Any]) -> dict[str, Any]:
        description = description | {'render': description['render'] | self.device}
        found = self.runner.verdict(description)
        self.rendered += 1
        if 'error' in found:
            self.met[f'error: {kind_of(found["error"])}'] += 1
        if found.get('kind') and self.is_blenders_own(description):
            self.met[f'{found["kind"]} of Blender itself'] += 1
            found['fault'] = ''
        return found

    def close(self) -> None:
        self.runner.close()

    def is_blenders_own(self, description: dict[str, Any]) -> bool:
        """Whether building the scene and evaluating it ends Blender, too, without a render."""
        alone = Runner(self.runner.seconds, build_only=True)
        try:
            return bool(alone.verdict(description).get('kind'))
        finally:
            alone.close()


def kind_of(text: str) -> str:
    """A message with names and numbers left out."""
    return re.sub(r'[-+]?\d[\d.e+-]*', 'N', re.sub(r'"[^"]*"', '"…"', text.strip().splitlines()[-1]))[:160]


def drawn(campaign: Campaign, count: int, seed: int, one: Callable[[dict[str, Any]], None]) -> Callable[[], None]:
    """Calls `one` with so many descriptions; where it raises, with ever smaller ones that make it raise."""
    settings = hypothesis.settings(
        max_examples=count,
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
        print_blob=False,
        report_multiple_bugs=False,
    )
    return hypothesis.seed(seed)(settings(hypothesis.given(scenes(campaign.runner.catalogue))(one)))


def survey(campaign: Campaign, count: int, seed: int) -> list[dict[str, Any]]:
    """All descriptions whose render has a fault, as they were drawn."""
    failing: list[dict[str, Any]] = []

    def one(description: dict[str, Any]) -> None:
        found = campaign.judge(description)
        if found['fault']:
            failing.append({'fault': found['fault'], 'scene': description})

    drawn(campaign, count, seed, one)()
    return failing


def search(campaign: Campaign, count: int, seed: int) -> dict[str, Any] | None:
    """The smallest description found whose render has a fault; None where all are in order."""
    failing: list[tuple[dict[str, Any], dict[str, Any]]] = []

    def one(description: dict[str, Any]) -> None:
        found = campaign.judge(description)
        if found['fault']:
            failing.append((description, found))
            raise AssertionError(kind_of(found['fault']))

    try:
        drawn(campaign, count, seed, one)()
    except BaseException as error:
        if not failing:
            raise
        if isinstance(error, KeyboardInterrupt):
            raise
        description, found = failing[-1]
        return {'fault': found['fault'], 'scene': description}
    return None


def main() -> int:
    parser = argparse.ArgumentParser(prog='fuzz', description=__doc__)
    parser.add_argument('count', metavar='N', type=int, help='how many scenes')
    parser.add_argument('--seed', type=int, default=int(time.time()), help='of the first hundred (the time)')
    parser.add_argument('--seconds', type=float, default=30.0, help='of processor time after which a scene hangs (30)')
    parser.add_argument('--device', default='CPU', choices=('CPU', 'VULKAN'))
    parser.add_argument('--ray-tracing', default='AUTO', choices=('AUTO', 'SOFTWARE', 'HARDWARE'))
    parser.add_argument('-o', '--output', type=Path, default=ROOT / 'build' / 'fuzzed')
    parser.add_argument('--shrink', action='store_true', help='each hundred ends with its first fault, made small')
    options = parser.parse_args()
    campaign = Campaign(options.seconds, {'device': options.device, 'ray_tracing': options.ray_tracing})
    failed, begun = 0, 0
    while begun < options.count:
        batch, seed = min(100, options.count - begun), options.seed + begun
        begun += batch
        smallest = search(campaign, batch, seed) if options.shrink else None
        for found in [smallest] if smallest else [] if options.shrink else survey(campaign, batch, seed):
            failed += 1
            options.output.mkdir(parents=True, exist_ok=True)
            path = options.output / f'{seed}-{failed}.json'
            path.write_text(json.dumps(found, indent=1) + '\n')
            print(f'seed {seed}: {found["fault"][-700:]}\n  {path}', flush=True)
        print(f'{campaign.rendered} renders, {failed} faults', file=sys.stderr, flush=True)
    campaign.close()
    print(f'{campaign.rendered} scenes rendered, {failed} faults, {campaign.runner.processor_seconds:.0f} s')
    for text, times in campaign.met.most_common(40):
        print(f'  {times:5} {text}')
    return int(failed > 0)


if __name__ == '__main__':
    sys.exit(main())
