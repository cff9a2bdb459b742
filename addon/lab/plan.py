# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chart renders: series of settings, each with a few numbers of samples, and the references they are held to.

It renders nothing; how long things take is told to it.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from .. import choices

ENGINES = ('COTORRA', 'CYCLES', 'EEVEE')
# Integrators whose pictures are noisy in the way that denoisers and the adaptive stop know.
SAMPLED = ('PATH', 'DIRECT', 'AUTO')
RUNGS = 4  # numbers of samples of a series, unless asked otherwise
STEP = 4  # from one to the next: half the error, each
MOST_SAMPLES = 64  # where there is no budget
LADDER_MAX = 2**16
REFERENCE_SHARE = 4  # a reference has so many times the most samples
PARTS = 4  # of a reference, each of its own seed
REFERENCE_SEED = 10_001  # of the first part; points take 1 and up
PILOT_SAMPLES = 4
PILOT_SEED = 1
# Cycles' own default threshold, 0.01, as that of 400 samples: noise falls with their square root.
ADAPTIVE_NOISE = 0.2
# A pixel that is hard may take so many times the samples of the rung.
ADAPTIVE_REACH = 4


@dataclass(frozen=True, slots=True)
class Series:
    """One way to render. model: of choices.MODELS for all materials; '' leaves them as they are."""

    engine: str = 'COTORRA'
    integrator: str = 'PATH'
    model: str = ''
    device: str = 'CPU'
    adaptive: bool = False
    denoised: bool = False

    @property
    def name(self) -> str:
        if self.engine == 'COTORRA':
            words = [_name(choices.INTEGRATORS, self.integrator)]
            if self.model:
                words.append(_name(choices.MODELS, self.model))
            if self.device != 'CPU':
                words.append(self.device.capitalize())
        else:
            words = [{'CYCLES': 'Cycles', 'EEVEE': 'EEVEE'}[self.engine]]
        words += ['adaptive'] * self.adaptive + ['denoised'] * self.denoised
        return ', '.join(words)

    @property
    def key(self) -> str:
        """For file names."""
        return re.sub(r'[^a-z0-9]+', '-', f'{self.engine}-{self.name}'.lower()).strip('-')

    @property
    def converges(self) -> bool:
        """Whether its picture is the reference's engine's, given samples enough."""
        plain = not self.model and not self.denoised and not self.adaptive
        return self.engine != 'EEVEE' and self.integrator == 'PATH' and plain


def _name(items: Sequence[tuple[str, str, str]], wanted: str) -> str:
    return next(name for identifier, name, _ in items if identifier == wanted)


# What is charted where nothing is asked for, the most telling first.
DEFAULT_SERIES = (
    Series(),
    Series('CYCLES'),
    Series(denoised=True),
    Series(integrator='DIRECT'),
    Series('CYCLES', denoised=True),
    Series(adaptive=True),
    Series('CYCLES', adaptive=True),
    Series(integrator='WHITTED'),
    Series(integrator='DIRECT', denoised=True),
    Series(adaptive=True, denoised=True),
)


@dataclass(frozen=True, slots=True)
class Job:
    """One render. reference: a part of the reference of its series' engine, or of what is compared tile by tile."""

    series: Series
    samples: int
    seed: int
    reference: bool = False

    @property
    def key(self) -> str:
        return f'{"reference-" if self.reference else ""}{self.series.key}-{self.samples}-{self.seed}'

    def content(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def read(content: dict[str, Any]) -> Job:
        return Job(**{**content, 'series': Series(**content['series'])})


@dataclass(slots=True)
class Plan:
    """series: in order of importance. samples: ascending; empty until a budget has decided."""

    series: list[Series]
    samples: list[int]
    seeds: int = 2
    reference_samples: int = 0  # of all parts together; 0: REFERENCE_SHARE times the most
    points: int = 20

    def content(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def read(content: dict[str, Any]) -> Plan:
        return Plan(**{**content, 'series': [Series(**entry) for entry in content['series']]})

    def references(self) -> list[Series]:
        """The series whose converged pictures are the references: an engine's own, as far as it has one."""
        own = [Series(engine) for engine in ('COTORRA', 'CYCLES') if any(s.engine == engine for s in self.series)]
        return own or [Series('CYCLES')]

    def reference_of(self, series: Series) -> Series:
        """An engine's own, so that the error of what converges is noise alone; EEVEE's is the first there is."""
        own = [reference for reference in self.references() if reference.engine == series.engine]
        return (own or self.references())[0]

    def part_samples(self) -> int:
        return max(1, (self.reference_samples or REFERENCE_SHARE * max(self.samples)) // PARTS)

    def reference_jobs(self, first: int, last: int) -> list[Job]:
        """Parts `first` to `last` of each reference, part by part."""
        return [
            Job(series, self.part_samples(), REFERENCE_SEED + part, True)
            for part in range(first, last)
            for series in self.references()
        ]

    def jobs(self) -> list[Job]:
        """Everything, in the order in which a chart that is stopped is worth most."""
        return [*self.reference_jobs(0, 2), *self.point_jobs(), *self.reference_jobs(2, PARTS)]

    def point_jobs(self) -> list[Job]:
        """By samples, so that a disturbance of the machine hits all series alike; seeds inmost."""
        order = itertools.product(self.samples, self.series, range(1, self.seeds + 1))
        return [Job(series, samples, seed) for samples, series, seed in order]


def ladder(most: int, rungs: int) -> list[int]:
    """Numbers of samples up to `most`, STEP apart."""
    return sorted({max(1, most // STEP**rung) for rung in range(rungs)})


def chosen_series(
    engines: Sequence[str],
    integrators: Sequence[str],
    models: Sequence[str],
    devices: Sequence[str],
    adaptive: Sequence[bool],
    denoised: Sequence[bool],
) -> list[Series]:
    """Every combination that means something, each once; an empty list of a kind stands for its usual."""
    found: dict[Series, None] = {}
    for engine, stops, clean in itertools.product(engines, adaptive, denoised):
        if engine == 'EEVEE':
            found[Series('EEVEE')] = None
        elif engine == 'CYCLES':
            found[Series('CYCLES', adaptive=stops, denoised=clean)] = None
        else:
            for integrator, model, device in itertools.product(integrators, models, devices):
                sampled = integrator in SAMPLED
                found[Series(engine, integrator, model, device, stops and sampled, clean and sampled)] = None
    return list(found)


def fit_to_budget(plan: Plan, seconds_of: Callable[[Job], float], seconds: float) -> None:
    """Choose the samples, and leave out series from the end, rungs and seeds, so that all fits into the seconds.

    As many points as fit, their first rung of one sample at least; where nothing fits, the least that is a chart.
    """
    every = list(plan.series)
    counts = [len(every)] if len(every) < 2 else range(2, len(every) + 1)
    shapes = sorted(itertools.product(counts, range(2, RUNGS + 1)), key=lambda shape: (-shape[0] * shape[1], shape[1]))
    for seeds in sorted({plan.seeds, 1}, reverse=True):
        for count, rungs in shapes:
            plan.series, plan.seeds = every[:count], seeds
            most = 0
            while most < LADDER_MAX:
                plan.samples = ladder(max(STEP ** (rungs - 1), 2 * most), rungs)
                if sum(seconds_of(job) for job in plan.jobs()) > seconds:
                    break
                most = plan.samples[-1]
            if most and count * rungs <= max(plan.points, 4):
                plan.samples = ladder(most, rungs)
                return
    plan.samples = ladder(STEP, 2)
