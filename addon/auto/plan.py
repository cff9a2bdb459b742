# SPDX-License-Identifier: GPL-3.0-or-later
"""What AUTO decides: how much a pilot may cost, which limits suffice, and how many samples.

All of it follows from figures alone, and never from the clock: the same scene, settings and seed are rendered alike on
every machine. What is rendered to get the figures is asked of a function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..metrics import Paired, effective_number, mean_interval
from .measure import FEW_PIXELS, Noise, few

# ---- What a pilot may cost


# Its share of the paths of the render that was asked for. The goal is 5 % of the time, and a path of so small pictures
# takes 1.2 to 1.8 times that of the whole (box_room and whitted_classic, 16 to 2 samples).
PILOT_SHARE = 0.025
SEARCH_MIN = 2  # samples; one costs 2.4 times as much a path, and tells nothing
SEARCH_WIDE = 4  # beyond, more pixels tell more than more samples of them, as long as there are no more than PIXELS_MAX
PIXELS = 1024
PIXELS_MAX = 4096
PIXELS_SHARE = 0.25  # of the picture's, at most
SEEDS = 4
SETTINGS = 10  # that are looked at, more or less: the base and its simplifications
VERIFIED = 2  # and what was chosen is rendered anew, beside the base
VERIFIED_WEIGHT = 2  # with so many times the samples
BETWEEN = 2  # and both once more, looking between the pixels
SAMPLES_MAX = 256  # of one picture; beyond, the pixels' own number is what limits an estimate


@dataclass(frozen=True, slots=True)
class Budget:
    """width, height: of the small pictures. search, verify: samples of each picture, for each of SEEDS seeds; what a
    search leaves over is added to those that verify."""

    width: int
    height: int
    search: int
    verify: int
    paths: int


def budget(width: int, height: int, samples: float) -> Budget | None:
    """What the pilot of a render of so many pixels and samples may take; None where it is too short for one."""
    paths = int(PILOT_SHARE * width * height * samples)
    pictures = (SETTINGS + VERIFIED * VERIFIED_WEIGHT + BETWEEN) * SEEDS
    pixels = min(max(PIXELS, min(paths / (pictures * SEARCH_WIDE), PIXELS_MAX)), PIXELS_SHARE * width * height)
    across = max(1, round((pixels * width / height) ** 0.5))
    across = min(across, width)
    down = min(max(1, round(pixels / across)), height)
    parts = pictures * across * down
    search = min(paths // parts, SAMPLES_MAX)
    if search < SEARCH_MIN:
        return None
    return Budget(across, down, search, min(VERIFIED_WEIGHT * search, SAMPLES_MAX), paths)


# ---- Limits


LIMITS = ('max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces', 'transparent_bounces')
LADDER = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128, 256, 512)
# Part of the rays that a lower limit must save, else it stays as it was set.
WORTH = 0.01


@dataclass(frozen=True, slots=True)
class Probe:
    """Settings beside the base: the difference of their converged pictures, and their rays as a share of the base's."""

    difference: Paired
    rays: float

    def suffices(self, tolerance: float) -> bool:
        return self.difference.high <= tolerance and not self.doubtful(tolerance)

    def doubtful(self, tolerance: float) -> bool:
        """Whether a few pixels make a difference that would matter if there were only some more of them."""
        return few(self.difference) and self.difference.high > DOUBTFUL * tolerance


# Of the tolerance: below, even an estimate that a few pixels make is small enough.
DOUBTFUL = 0.25


class Spent(Exception):
    """The pilot's paths are used up: what is not known by now stays unknown."""


@dataclass(slots=True)
class Search:
    """The lowest limits that suffice, one kind after the other, each beside those that were lowered before.

    base:      limits as they were set, by name.
    probe:     measures limits beside the base; raises Spent.
    tolerance: highest difference, share of the mean.
    allowed:   the limits that may be lowered, and 'integrator': whether bounces may be left out altogether.
    present:   the limits that can make a difference in this scene.
    """

    base: dict[str, int]
    probe: Callable[[dict[str, int]], Probe]
    tolerance: float
    allowed: frozenset[str]
    present: frozenset[str] = frozenset(LIMITS)
    found: dict[str, int] = field(default_factory=dict)
    rays: float = 1.0
    spent: bool = False
    probes: dict[str, dict[int, Probe]] = field(default_factory=dict)

    def run(self) -> dict[str, int]:
        self.found = dict(self.base)
        try:
            for name in LIMITS:
                self.lower(name)
        except Spent:
            self.spent = True
        return self.found

    def lower(self, name: str) -> None:
        candidates = self.candidates(name)
        if not candidates:
            return
        probes = self.probes.setdefault(name, {})

        def suffices(value: int) -> bool:
            probes[value] = self.probe(self.with_limit(name, value))
            return probes[value].suffices(self.tolerance)

        best = lowest(candidates, suffices)
        if best is not None and probes[best].rays <= self.rays - WORTH:
            self.found = self.with_limit(name, best)
            self.rays = probes[best].rays

    def why(self, name: str) -> str:
        """Why a limit is what it became."""
        probes = self.probes.get(name, {})
        if self.found[name] < self.base[name] and self.found[name] in probes:
            return f'more make less than {percent(self.tolerance)} of the mean'
        if name not in self.allowed and not (name == 'max_bounces' and 'integrator' in self.allowed):
            return 'switched off'
        if name not in self.present:
            return 'nothing in the scene asks for it'
        if not probes:
            return 'the pilot was too short to look at it' if self.spent else 'no lower one is left to look at'
        highest = probes[max(probes)]
        if highest.suffices(self.tolerance):
            return 'a lower one saves nothing'
        if highest.doubtful(self.tolerance):
            return f'{UNSURE}: a few pixels decide'
        if highest.difference.low <= self.tolerance:
            return f'{UNSURE}: {max(probes)} make {interval(highest.difference)} of difference'
        return f'needed: {max(probes)} make {interval(highest.difference)} of difference'

    def with_limit(self, name: str, value: int) -> dict[str, int]:
        """The limits with one of them lower; none of a kind is above that of all."""
        limits = self.found | {name: value}
        if name == 'max_bounces':
            for kind in ('diffuse_bounces', 'glossy_bounces', 'transmission_bounces'):
                limits[kind] = min(limits[kind], value)
        return limits

    def candidates(self, name: str) -> list[int]:
        """Lower limits, ascending."""
        kinds = ('diffuse_bounces', 'glossy_bounces', 'transmission_bounces')
        if name not in self.present or (name in kinds and self.found['max_bounces'] == 0):
            return []
        values = [value for value in LADDER if value < self.found[name]]
        if name == 'max_bounces':
            # More than all kinds allow together changes nothing.
            together = sum(self.base[kind] for kind in kinds)
            values = [
                value
                for value in values
                if value < together and (name in self.allowed if value else 'integrator' in self.allowed)
            ]
        elif name not in self.allowed:
            return []
        return values


def lowest(candidates: Sequence[int], suffices: Callable[[int], bool]) -> int | None:
    """The first of ascending candidates that suffices, each above it sufficing too; None where the last does not."""
    low, high = 0, len(candidates)
    while low < high:
        middle = (low + high) // 2
        if suffices(candidates[middle]):
            high = middle
        else:
            low = middle + 1
    return candidates[low] if low < len(candidates) else None


# ---- Shadow rays


# Part of the rays that must be saved; each that is left costs one random number more.
LIGHT_WORTH = 0.05


@dataclass(frozen=True, slots=True)
class Shadows:
    """Rays to little light, traced at random: RenderSettings.light_threshold.

    rays, noise: as shares of what they are with all of these rays. noise: of `measure.typical`. variance: of the mean
    over the pixels, 1 at least.
    """

    threshold: float
    rays: float = 1.0
    noise: float = 1.0
    variance: float = 1.0

    @property
    def worth(self) -> bool:
        """Whether the time for as much noise falls by as much as is asked."""
        return self.rays * max(self.noise, 1.0) ** 2 <= 1.0 - LIGHT_WORTH


def light_threshold(deviation: float, rays: float) -> float:
    """The light below which a shadow ray is best traced at random: samples of such a deviation take so many rays.

    A ray that brings c with probability p, as c / p, costs p of a ray and adds c² (1 / p - 1) at most to the variance v
    of a sample of r rays. The product of both is least with p = c sqrt(r / v): where c is sqrt(v / r), all are traced.
    """
    return deviation / max(rays, 1.0) ** 0.5


# ---- Words


UNSURE = 'the pilot cannot tell'


def percent(share: float) -> str:
    return f'{100.0 * share:.2g} %'


def interval(found: Paired) -> str:
    return f'{100.0 * found.low:.2g} to {100.0 * found.high:.2g} %'


# ---- Samples


@dataclass(frozen=True, slots=True)
class Added:
    """Root mean square of what pixels that stop early add to the error: estimate, and upper end of its interval.

    pixels: how many make it, see `metrics.effective_number`.
    """

    value: float
    high: float
    pixels: float


@dataclass(frozen=True, slots=True)
class Sampling:
    """How many samples a pixel takes, at most where `adaptive`, until its error is below `threshold`."""

    samples: int
    adaptive: bool = False
    threshold: float = 0.01
    least: int = 0  # RenderSettings.adaptive_min_samples

    def first_look(self) -> int:
        """Samples before which no pixel stops (native/session.cpp, update_pending)."""
        return self.least or max(16, round(1.6 / max(self.threshold, 1e-6) ** 0.5))

    def words(self) -> str:
        return f'{self.samples} samples' + (f' to a noise of {self.threshold:.2g}' if self.adaptive else '')

    def taken(self, noise: Noise, expected: np.ndarray | None = None) -> np.ndarray:
        """Samples that each pixel is expected to take, (P,). expected: an error other than its own, any shape."""
        if not self.adaptive:
            return np.full((noise.error if expected is None else expected).shape, float(self.samples))
        least = min(self.first_look(), self.samples)
        wanted = np.clip(noise.samples_to(self.threshold, expected), least, self.samples)
        ends = np.array(pass_ends(self.samples), np.float64)
        return ends[np.minimum(np.searchsorted(ends, wanted - 1e-9), len(ends) - 1)]

    def error(self, noise: Noise) -> tuple[float, float]:
        """Root mean square of the noise that is left, share of the mean: estimate, and upper end of its interval."""
        left = noise.after(self.taken(noise))
        return float(np.sqrt(left.mean())), float(np.sqrt(mean_interval(left)[1]))

    def added(self, noise: Noise, other: Sampling) -> Added:
        """What it leaves beyond what `other` does, which takes no fewer samples of any pixel; as shares of the mean.

        Where a pixel stops is told by other seeds than what is left of its noise: what stops because it missed rare
        light is in it.
        """
        errors, variances = noise.apart if noise.apart is not None else (noise.error[None], noise.variance[None])
        fall = noise.fall(self.taken(noise, errors)) - noise.fall(other.taken(noise, errors))
        more = (variances * np.maximum(fall, 0.0)).mean(axis=0)
        high = max(mean_interval(more)[1], 0.0)
        return Added(float(np.sqrt(more.mean())), float(np.sqrt(high)), effective_number(more))

    def work(self, noise: Noise) -> float:
        """Samples of a pixel in the mean, each as dear as it is."""
        return float(np.average(self.taken(noise), weights=noise.cost))


LONGEST_PASS = 32  # native/session.cpp, kLongestPass


def pass_ends(samples: int) -> list[int]:
    """The sample counts after which the native module looks at a pixel's error."""
    ends, done = [], 0
    while done < samples:
        done += min(max(done, 1), LONGEST_PASS, samples - done)
        ends.append(done)
    return ends


# Other sampling must save this part of the samples, or it stays as it was set.
SAMPLING_WORTH = 0.2
ADAPTIVE_ROOM = 4  # a pixel takes from a fourth of the samples that suffice for all to four times as many
THRESHOLDS = tuple(1e-4 * 2.0 ** (step / 4) for step in range(54))  # up to 1


# Pixels are first looked at after this part of the samples, and as many as each seed of the pilot has: a look takes a
# pixel and its eight neighbours, which tells no less than the pilot's other seeds do of one pixel.
LEAST_SHARE = 8


def sampling(
    asked: Sampling, noise: Noise, before: Noise, bias: float, tolerance: float, stopping: bool = True
) -> Sampling:
    """The cheapest sampling whose error is within the tolerance, or beyond that of what was asked for by no more.

    Where the noise is beyond the tolerance, pixels stop where that adds less than the tolerance to the error, root mean
    square over the picture: what they miss by stopping, which is no more than the noise that they stop at, is in that.

    noise, before: with the other simplifications, and without them. bias: upper end of the difference that they make.
    stopping: whether pixels may stop that look clean.
    """
    _, highest = asked.error(noise)
    room = max(tolerance**2 - bias**2, 0.0) ** 0.5
    # Where a few pixels make the noise, no estimate of it is sure; what is added elsewhere may be.
    sure = not (noise.dominated or before.dominated)
    within = sure and highest <= room
    # What was asked for leaves this much; the difference is an error, too.
    left = max(asked.error(before)[0] ** 2 - bias**2, 0.0) ** 0.5
    enough = [
        other
        for count in pass_ends(asked.samples)[:-1]
        if sure and count >= 2
        for other in [replace(asked, samples=count)]
        # Beside a forecast, another one is as sure as that is; beside the tolerance, the interval counts.
        if (other.error(noise)[1] <= room if within else other.error(noise)[0] <= left)
    ]
    if within and asked.adaptive:
        enough += [
            other
            for threshold in THRESHOLDS
            if threshold > asked.threshold
            for other in [replace(asked, threshold=threshold)]
            if other.error(noise)[1] <= room
        ]
    elif within and stopping:
        suffices = min((other.samples for other in enough), default=asked.samples)
        most, least = min(suffices * ADAPTIVE_ROOM, asked.samples), max(suffices // ADAPTIVE_ROOM, 1)
        stopped = [Sampling(most, True, threshold, least) for threshold in THRESHOLDS]
        enough += [other for other in stopped if other.error(noise)[1] <= room]
    if stopping:
        enough += [other for other in stops(asked, noise) if adds_little(other.added(noise, asked), room)]
    if not enough:
        return asked
    best = min(enough, key=lambda other: other.work(noise))
    return best if best.work(noise) <= (1.0 - SAMPLING_WORTH) * asked.work(before) else asked


def stops(asked: Sampling, noise: Noise) -> list[Sampling]:
    """The same samples, but for pixels that stop."""
    least = max(16, asked.samples // LEAST_SHARE, round(noise.samples))
    if asked.adaptive:
        return [
            replace(asked, threshold=threshold, least=max(least, asked.first_look()))
            for threshold in THRESHOLDS
            if threshold > asked.threshold
        ]
    return [replace(asked, adaptive=True, threshold=threshold, least=least) for threshold in THRESHOLDS]


def adds_little(added: Added, room: float) -> bool:
    return added.high <= room and (added.pixels >= FEW_PIXELS or added.high <= DOUBTFUL * room)


def missed(chosen: Sampling, asked: Sampling, noise: Noise) -> float:
    """Most that pixels miss which stop earlier than was asked for: what they add, or the noise that they stop at."""
    if chosen == asked or not chosen.adaptive:
        return 0.0
    return chosen.added(noise, asked).high if chosen.samples == asked.samples else chosen.error(noise)[1]
