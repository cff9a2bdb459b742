# SPDX-License-Identifier: GPL-3.0-or-later
"""From renders to figures: the error of each point, noise and bias, the slope of each series, what is on the front.

Pure computation; every figure of error is metrics.py's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import mean, median

import numpy as np

from .. import metrics
from ..metrics import Image, Interval, Parts, PowerLaw, Reference, SameImage
from .plan import Plan, Series
from .store import Render

CLOCKS = {'wall': 'seconds', 'cpu': 'processor seconds'}


@dataclass(frozen=True, slots=True)
class Measure:
    """One figure of error. power: of it in the error: 1 or 2, so that plain noise falls as time^(−power/2)."""

    key: str
    name: str
    power: int


MEASURES = (
    Measure('rmse', 'RMSE', 1),
    Measure('relmse', 'relMSE', 2),
    Measure('trimmed', 'relMSE without the worst 0.1 %', 2),
    Measure('flip', 'HDR-FLIP', 1),
)


@dataclass(slots=True)
class Point:
    """A series at one number of samples. Seconds are medians over its seeds, errors means; NaN where not known.

    parts: the error told apart, where there are two seeds. error and flip_map: (h, w), of the first seed.
    """

    series: Series
    samples: int
    seeds: int
    wall: float
    cpu: float
    whole: float
    rmse: float
    relmse: float
    trimmed: float
    flip: float
    bad: int
    parts: Parts | None
    image: Image
    error: np.ndarray
    front: set[str] = field(default_factory=set)  # keys of the measures in which nothing is faster and better

    def value(self, key: str) -> float:
        return getattr(self, key)

    def seconds(self, clock: str) -> float:
        return self.cpu if clock == 'cpu' else self.wall


@dataclass(frozen=True, slots=True)
class Curve:
    """error = (factor · seconds^−slope + floor)^(1/root); fitted between `first` and `last` seconds."""

    law: PowerLaw
    floor: float
    root: float
    first: float
    last: float

    def error(self, seconds: float) -> float:
        return (self.law.error(seconds) + self.floor) ** (1 / self.root)


@dataclass(slots=True)
class Line:
    """A series: its points by samples; its total bias against the reference, as a share of the mean, 95 %.

    slope: of relMSE's noise over time, 1 for plain Monte Carlo; NaN where it does not fall, and of what is denoised,
    whose time is not all of sampling.
    """

    series: Series
    points: list[Point]
    bias: Interval | None
    bias_relmse: float
    slope: float
    curves: dict[str, Curve]


@dataclass(frozen=True, slots=True)
class Between:
    """How far the converged pictures of two engines are apart, A − B."""

    a: str
    b: str
    total: Interval
    same: SameImage
    difference: np.ndarray


@dataclass(slots=True)
class Results:
    lines: list[Line]
    references: dict[Series, Reference]
    parts: dict[Series, list[Image]]
    between: Between | None
    clock: str
    measures: list[Measure]

    @property
    def points(self) -> list[Point]:
        return [point for line in self.lines for point in line.points]


def evaluate(plan: Plan, renders: Sequence[Render], clock: str) -> Results | None:
    """None where no reference has two parts yet: nothing can be said of an error."""
    parts = {
        series: [r.image for r in renders if r.job.reference and r.job.series == series] for series in plan.references()
    }
    parts = {series: images for series, images in parts.items() if len(images) >= 2}
    if not parts:
        return None
    references = {series: Reference.from_parts(images) for series, images in parts.items()}
    flips = metrics.has_flip()
    lines = []
    for series in plan.series:
        wanted = plan.reference_of(series)
        truth = wanted if wanted in references else next(iter(references))
        own = [r for r in renders if not r.job.reference and r.job.series == series]
        points = [
            point_of(series, samples, [r for r in own if r.job.samples == samples], references[truth], flips)
            for samples in sorted({r.job.samples for r in own})
        ]
        if points:
            most = [r.image for r in own if r.job.samples == points[-1].samples]
            lines.append(line_of(series, points, most, parts.get(series), parts[truth], references[truth], clock))
    measures = [measure for measure in MEASURES if measure.key != 'flip' or flips]
    results = Results(lines, references, parts, between(parts, references), clock, measures)
    for measure in measures:
        for point in front(results.points, measure.key, clock):
            point.front.add(measure.key)
    return results


def point_of(series: Series, samples: int, renders: Sequence[Render], reference: Reference, flips: bool) -> Point:
    errors = [metrics.image_error(render.image, reference) for render in renders]
    first = renders[0].image
    return Point(
        series=series,
        samples=samples,
        seeds=len(renders),
        wall=median(render.wall for render in renders),
        cpu=median(render.cpu for render in renders),
        whole=median(render.whole for render in renders),
        rmse=math.sqrt(max(0.0, mean(error.mse for error in errors))),
        relmse=mean(error.relmse for error in errors),
        trimmed=mean(error.trimmed for error in errors),
        flip=metrics.flip(first, reference.image.astype(np.float32))[0] if flips else math.nan,
        bad=max(error.bad for error in errors),
        parts=metrics.noise_and_bias([r.image for r in renders], reference) if len(renders) > 1 else None,
        image=first,
        error=metrics.error_map(first, reference),
    )


def line_of(
    series: Series,
    points: list[Point],
    most: list[Image],
    own_parts: list[Image] | None,
    truth_parts: list[Image],
    truth: Reference,
    clock: str,
) -> Line:
    """own_parts: of a reference of the series itself; it is then its own truth, and has no bias."""
    biased = own_parts is None and not series.converges
    bias = metrics.total_difference(most, truth_parts) if biased else None
    bias_relmse = metrics.noise_and_bias(most, truth).bias_relmse if biased and len(most) > 1 else 0.0
    curves = {measure.key: curve for measure in MEASURES if (curve := curve_of(points, measure, biased, clock))}
    slope = math.nan
    if not series.denoised:
        try:
            slope = noise_law(points, 'noise_relmse', clock).slope
        except ValueError:
            pass  # fireflies, or too few points
    return Line(series, points, bias, bias_relmse, slope, curves)


def noise_law(points: Sequence[Point], key: str, clock: str) -> PowerLaw:
    known = [point for point in points if point.parts is not None]
    noise = [getattr(point.parts, key) for point in known]
    return metrics.fit_power_law([point.seconds(clock) for point in known], noise)


def curve_of(points: list[Point], measure: Measure, biased: bool, clock: str) -> Curve | None:
    """Noise that falls with time above a bias that stays, where seeds tell the two apart; else a law of the error."""
    seconds = [point.seconds(clock) for point in points]
    ends = (min(seconds), max(seconds))
    try:
        if measure.key in ('rmse', 'relmse') and biased and not points[0].series.denoised:
            key = {'rmse': 'mse', 'relmse': 'relmse'}[measure.key]
            law = noise_law(points, f'noise_{key}', clock)
            floor = max(0.0, getattr(points[-1].parts, f'bias_{key}')) if points[-1].parts else 0.0
            return Curve(law, floor, 2.0 if measure.key == 'rmse' else 1.0, *ends)
        return Curve(metrics.fit_power_law(seconds, [p.value(measure.key) for p in points]), 0.0, 1.0, *ends)
    except ValueError:
        return None


def front(points: Sequence[Point], key: str, clock: str) -> list[Point]:
    """Pareto: those to which no other is both as fast and as good; by time."""
    best = front_of([(point.seconds(clock), point.value(key)) for point in points])
    by_place = {(point.seconds(clock), point.value(key)): point for point in reversed(points)}
    return [by_place[place] for place in best]


def front_of(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The Pareto front of (cost, error), by cost; errors that are not above 0 are none."""
    found: list[tuple[float, float]] = []
    for cost, error in sorted(point for point in points if point[1] > 0.0):
        if not found or error < found[-1][1]:
            found.append((cost, error))
    return found


def between(parts: dict[Series, list[Image]], references: dict[Series, Reference]) -> Between | None:
    if len(parts) < 2:
        return None
    (a, first), (b, second) = list(parts.items())[:2]
    white = white_of(references[b].image)
    difference = (references[a].image - references[b].image).mean(axis=2) / white
    same = metrics.same_image(references[a], references[b])
    return Between(engine_name(a), engine_name(b), metrics.total_difference(first, second), same, difference)


def engine_name(series: Series) -> str:
    return 'Cotorra' if series.engine == 'COTORRA' else series.name


def white_of(image: Image) -> float:
    """What is shown as white: the 99th percentile of the channels."""
    finite = image[np.isfinite(image)]
    return max(float(np.percentile(finite, 99)) if finite.size else 1.0, 1e-12)


def told(interval: Interval) -> str:
    """As '+0.12 % ± 0.03 %'."""
    half = '' if math.isinf(interval.half) else f' ± {100 * interval.half:.2g} %'
    return f'{100 * interval.value:+.2g} %{half}'
