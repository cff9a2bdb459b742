# SPDX-License-Identifier: GPL-3.0-or-later
"""From the settings that were asked for to the cheapest that suffice, by way of a pilot, and what is said of it.

Each simplification is a row: what was asked for, what it became, and why.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..choices import AUTO_ROWS
from ..export.buffers import Camera, RenderSettings, SceneBuffers
from ..metrics import Paired, paired_difference
from . import measure, plan
from .facts import Facts, undetected
from .measure import Noise
from .models import NORMAL, Part, needless, without, work
from .pilot import Pilot, Rendered, seeds, shift_of, small_camera
from .plan import LIMITS, percent
from .spread import spreading

# Rows and the limits that they lower.
LIMIT_OF = {
    'bounces': 'max_bounces',
    'diffuse': 'diffuse_bounces',
    'glossy': 'glossy_bounces',
    'transmission': 'transmission_bounces',
    'transparent': 'transparent_bounces',
}
NAMES = {key: name for key, name, _ in AUTO_ROWS}
SEARCH, VERIFY = 0, 1  # parts of a pilot: each has seeds of its own
MODEL_PROBES = 4  # scenes that are built to find what materials can do without
ALL = 'all of them'


@dataclass(frozen=True, slots=True)
class Row:
    """A simplification. key: of choices.AUTO_ROWS. asked, chosen: as the user reads them."""

    key: str
    asked: str
    chosen: str
    why: str

    @property
    def simplified(self) -> bool:
        return self.chosen != self.asked


@dataclass(frozen=True, slots=True)
class Materials:
    """The exported scene, and the parts of its materials that may be left out."""

    buffers: SceneBuffers
    parts: tuple[Part, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """settings: to render with. Shares of the mean, of the base's rays and of the samples that were asked for.

    scene:      the native scene to render; None: the one that was given.
    reason:     why all is modelled as it was asked for; empty where something is simplified.
    difference: of the converged picture from that of what was asked for; None where nothing was left out.
    noise:      that is expected to be left, and the upper end of its interval; None where no pilot tells.
    stopped:    most that pixels miss which stop earlier than was asked for.
    dominated:  whether a few pixels make most of the noise, of which an interval tells nothing.
    """

    settings: RenderSettings
    rows: tuple[Row, ...] = ()
    reason: str = ''
    tolerance: float = 0.0
    difference: Paired | None = None
    noise: tuple[float, float] | None = None
    stopped: float = 0.0
    dominated: bool = False
    rays: float = 1.0
    samples: float = 1.0
    pilot: dict[str, Any] | None = None
    scene: Any = None

    @property
    def bound(self) -> float:
        """Most that the converged picture differs by: what was left out, and what pixels that stop early miss."""
        return math.hypot(self.difference.high if self.difference is not None else 0.0, self.stopped)

    def figures(self) -> dict[str, Any]:
        """For the statistics: what JSON can hold."""
        return {
            'integrator': self.settings.integrator,
            'reason': self.reason,
            'tolerance': self.tolerance,
            'difference': asdict(self.difference) if self.difference is not None else None,
            'bound': self.bound,
            'noise': list(self.noise) if self.noise is not None else None,
            'dominated': self.dominated,
            'rays': self.rays,
            'samples': self.samples,
            'rows': [asdict(row) | {'name': NAMES[row.key], 'simplified': row.simplified} for row in self.rows],
            'pilot': self.pilot,
            'sentences': self.sentences(),
        }

    def sentences(self) -> list[str]:
        """What is said before the render."""
        said = []
        changed = [row for row in self.rows if row.simplified]
        if self.reason:
            said.append(f'AUTO models everything: {self.reason}')
        elif not changed:
            said.append('AUTO models everything: the pilot found nothing cheaper that suffices')
        else:
            what = ', '.join(f'{NAMES[row.key]} {row.chosen} instead of {row.asked}' for row in changed)
            saved = [f'{percent(1.0 - self.rays)} fewer rays a sample'] if self.rays < 1.0 else []
            saved += [f'{percent(1.0 - self.samples)} fewer samples'] if self.samples < 1.0 else []
            said.append('; '.join([f'AUTO: {what}', *([' and '.join(saved)] if saved else [])]))
        unsure = [NAMES[row.key] for row in self.rows if row.why.startswith(plan.UNSURE)]
        if unsure:
            said.append(f'AUTO keeps what the pilot cannot tell about: {", ".join(unsure)}')
        if self.difference is not None:
            d = self.difference
            said.append(
                f'AUTO: the converged picture differs by {percent(d.value)} of the mean '
                f'(95 %: {plan.interval(d)}; tolerance {percent(self.tolerance)})'
            )
        if self.noise is not None:
            told = f'AUTO: noise of {percent(self.noise[0])} of the mean is expected '
            told += '(or more: a few pixels make most of it)' if self.dominated else f'(up to {percent(self.noise[1])})'
            if self.noise[0] > self.tolerance:
                told += f': the samples are too few for {percent(self.tolerance)}'
            said.append(told)
        if self.pilot is not None:
            p = self.pilot
            said.append(
                f'AUTO: the pilot took {p["seconds"]:.2g} s, {percent(p["share"])} of the paths of the whole '
                f'({p["width"]}×{p["height"]} pixels, {p["settings"]} settings)'
            )
        return said


def choose(
    pilot: Pilot,
    camera: Camera,
    asked: RenderSettings,
    found: Facts,
    tolerance: float,
    allowed: frozenset[str],
    materials: Materials | None = None,
    time_limit: float = 0.0,
) -> Choice:
    """asked: the settings, their integrator being PATH. allowed: the rows (choices.AUTO_ROWS) that are on.

    materials: what may be left out of them; None: nothing. time_limit: of the render, seconds; 0: none. The pilot's
    camera is set here. Raises what the native module raises, and what `pilot.stop` does.
    """
    everything = Choice(asked, tolerance=tolerance)
    if not allowed:
        return replace(everything, reason='all its simplifications are switched off')
    if asked.device != 'CPU':
        return replace(everything, reason='pilots are rendered on the CPU only so far')
    if time_limit > 0.0:
        return replace(everything, reason='time ends the render: nothing tells how long a pilot may be')
    spend, reason = affordable(camera, asked, found)
    if spend is None:
        result = replace(everything, reason=reason)
    else:
        result = Trial(pilot, camera, asked, found, tolerance, allowed, spend, materials).run()
    if 'sampling' not in allowed:
        return result
    return replace(result, settings=spreading(result.settings, camera.region[2] * camera.region[3]))


def affordable(camera: Camera, asked: RenderSettings, found: Facts) -> tuple[plan.Budget | None, str]:
    """What a pilot may take; or None, and why there is none."""
    columns, rows = camera.region[2:]
    set_sampling = sampling_of(asked)
    least = min(set_sampling.samples, set_sampling.first_look()) if asked.adaptive else asked.samples
    spend = plan.budget(columns, rows, least)
    if spend is None:
        return None, 'the render is too short for a pilot'
    paths = spend.width * spend.height * plan.SEEDS * (spend.search + spend.verify)
    missed = undetected(found, paths, asked.reflective_caustics, asked.refractive_caustics)
    if missed is not None:
        caster, lamp = missed
        return None, (
            f'"{caster.name}" ({caster.kind}) may throw caustics of light "{lamp.name}", which is too small for a '
            'pilot to find them'
        )
    return spend, ''


def sampling_of(settings: RenderSettings) -> plan.Sampling:
    return plan.Sampling(settings.samples, settings.adaptive, settings.noise_threshold, settings.adaptive_min_samples)


class Trial:
    """The pilot of one render, from its first picture to what is chosen."""

    def __init__(
        self,
        pilot: Pilot,
        camera: Camera,
        asked: RenderSettings,
        found: Facts,
        tolerance: float,
        allowed: frozenset[str],
        spend: plan.Budget,
        materials: Materials | None,
    ) -> None:
        self.materials = materials
        self.scene: Any = None  # without the needless parts of materials
        self.pilot, self.asked, self.found = pilot, asked, found
        self.tolerance, self.allowed, self.spend = tolerance, allowed, spend
        self.spreads = spreading(asked, camera.region[2] * camera.region[3]) != asked
        self.pilot.camera = small_camera(camera, spend.width, spend.height, shift=shift_of(asked.seed))
        self.between = small_camera(camera, spend.width, spend.height, between=True)
        self.settings_seen = 0
        self.mean = 0.0
        self.base: Rendered | None = None
        self.known: dict[tuple[int, ...], plan.Probe] = {}

    def run(self) -> Choice:
        everything = Choice(self.asked, tolerance=self.tolerance)
        self.base = self.render(self.asked, self.spend.search, SEARCH, look=True)
        self.mean = float(self.base.pictures.mean())
        if not self.mean > 0.0:
            return replace(everything, reason='the picture of the pilot is black', pilot=self.cost())
        limits = {name: getattr(self.asked, name) for name in LIMITS}
        lowered = {LIMIT_OF[key] for key in self.allowed if key in LIMIT_OF} | self.allowed & {'integrator'}
        if self.asked.transparent_film:
            lowered.discard('transparent_bounces')
        shadows = self.lit()
        search = plan.Search(limits, self.probe, self.tolerance, frozenset(lowered), self.found.present)
        chosen = with_limits(self.asked, search.run())
        left_out, model_row = self.modelled(chosen)
        difference, rays, noise, before, why = self.verified(chosen)
        if difference is None:
            chosen, self.scene = self.asked, None
        rows = self.limit_rows(search, chosen, why)
        if model_row is not None:
            rows.append(
                model_row if self.scene is not None or not left_out else replace(model_row, chosen=ALL, why=why)
            )
        if shadows is not None:
            chosen, row = self.light_row(chosen, shadows)
            rows.append(row)
            if shadows.worth:
                rays *= shadows.rays
                noise = replace(noise, variance=noise.variance * shadows.variance)
        room = difference.high if difference is not None else 0.0
        sampling, row = self.sampled(noise, before, room)
        rows.append(row)
        asked = sampling_of(self.asked)
        return Choice(
            replace(
                chosen,
                samples=sampling.samples,
                adaptive=sampling.adaptive,
                noise_threshold=sampling.threshold,
                adaptive_min_samples=sampling.least,
            ),
            tuple(rows),
            '',
            self.tolerance,
            difference,
            sampling.error(noise),
            plan.missed(sampling, asked, noise),
            noise.dominated,
            rays,
            sampling.work(noise) / asked.work(before),
            self.cost(),
            self.scene,
        )

    def render(
        self,
        settings: RenderSettings,
        samples: int,
        part: int,
        scene: Any = None,
        camera: Camera | None = None,
        look: bool = False,
    ) -> Rendered:
        self.settings_seen += 1
        return self.pilot.render(settings, samples, seeds(self.asked.seed, plan.SEEDS, part), scene, camera, look)

    def cost_of(self, pictures: int, samples: int) -> int:
        """Paths."""
        return pictures * samples * plan.SEEDS * self.spend.width * self.spend.height

    def affords(self, paths: int) -> bool:
        """Whether so many more paths leave those that state the error."""
        later = self.cost_of(plan.VERIFIED, self.spend.verify) + self.cost_of(plan.BETWEEN, self.spend.search)
        return self.pilot.paths + paths + later <= self.spend.paths

    def lit(self) -> plan.Shadows | None:
        """What it brings to trace rays to little light at random; None where that is not looked at."""
        cost = self.cost_of(1, self.spend.search)
        if 'light' not in self.allowed or not self.affords(cost):
            return None
        samples, before = self.spend.search, measure.typical(self.base.pictures, self.spend.search)
        limit = plan.light_threshold(before, self.base.rays / cost)
        if limit <= self.asked.light_threshold:
            return None
        other = self.render(replace(self.asked, light_threshold=limit), samples, SEARCH)
        variances = [pictures.var(axis=0, ddof=1).mean() for pictures in (other.pictures, self.base.pictures)]
        return plan.Shadows(
            limit,
            other.rays / self.base.rays,
            measure.typical(other.pictures, samples) / before,
            max(float(variances[0] / variances[1]), 1.0),
        )

    def light_row(self, chosen: RenderSettings, shadows: plan.Shadows) -> tuple[RenderSettings, Row]:
        """Such rays change no mean: nothing has to be verified."""
        asked = random_below(self.asked.light_threshold)
        if not shadows.worth:
            return chosen, Row('light', asked, asked, f'more saves less than {percent(plan.LIGHT_WORTH)} of the time')
        told = random_below(shadows.threshold)
        why = f'{percent(1.0 - shadows.rays)} fewer rays, {percent(shadows.variance - 1.0)} more variance'
        return replace(chosen, light_threshold=shadows.threshold), Row('light', asked, told, why)

    def modelled(self, chosen: RenderSettings) -> tuple[list[Part], Row | None]:
        """Leaves out what the materials do not need, beside the limits that were chosen. None: nothing to leave out."""
        parts = [] if self.materials is None else unseen(self.materials.parts, self.asked.passes)
        if 'models' not in self.allowed or not parts:
            return [], None
        buffers, cost = self.materials.buffers, work(self.materials.buffers)
        each = cost + self.cost_of(1, self.spend.search)
        short = False

        def suffices(parts: list[Part]) -> bool:
            nonlocal short
            short = short or not self.affords(each)
            if short:
                return False
            scene = self.pilot.built(without(buffers, parts), cost)
            other = self.render(chosen, self.spend.search, SEARCH, scene)
            apart = paired_difference(self.base.pictures, other.pictures, self.mean)
            good = plan.Probe(apart, 1.0).suffices(self.tolerance)
            if good:
                self.scene = scene
            return good

        found = needless(parts, suffices, MODEL_PROBES)
        if found:
            without_them = 'without ' + ', '.join(part.words for part in found)
            return found, Row('models', ALL, without_them, f'they make less than {percent(self.tolerance)} of the mean')
        why = 'the pilot was too short to look at them' if short else f'each makes {percent(self.tolerance)} or more'
        return [], Row('models', ALL, ALL, why)

    def probe(self, limits: dict[str, int]) -> plan.Probe:
        key = tuple(limits[name] for name in LIMITS)
        if key not in self.known:
            if not self.affords(self.cost_of(1, self.spend.search)):
                raise plan.Spent
            other = self.render(with_limits(self.asked, limits), self.spend.search, SEARCH)
            apart = paired_difference(self.base.pictures, other.pictures, self.mean)
            self.known[key] = plan.Probe(apart, other.rays / self.base.rays)
        return self.known[key]

    def verified(self, chosen: RenderSettings) -> tuple[Paired | None, float, Noise, Noise, str]:
        """The difference of what was found, from seeds that it was not found by; None where that is nothing, or fails.

        With it: rays as a share of the base's, noise of a sample with and without it, and why it failed.
        """
        same = chosen == self.asked and self.scene is None
        left = self.spend.paths - self.pilot.paths
        if same:
            samples = left // self.cost_of(1, 1)
        else:
            left -= self.cost_of(plan.BETWEEN, self.spend.search)
            samples = left // self.cost_of(plan.VERIFIED, 1)
        samples = min(samples, plan.SAMPLES_MAX)
        base = self.render(self.asked, samples, VERIFY)

        def noise_before() -> Noise:
            found = measure.noise(base.pictures, samples, self.mean, (self.base.pictures, self.spend.search))
            return replace(found, cost=measure.costs(self.base.empty, base.rays / self.cost_of(1, samples)))

        before = noise_before()
        if same:
            return None, 1.0, before, before, ''
        other = self.render(chosen, samples, VERIFY, self.scene)
        wide = [
            self.render(settings, self.spend.search, VERIFY, scene, self.between).pictures
            for settings, scene in ((self.asked, None), (chosen, self.scene))
        ]
        # What lies between the pixels is part of the mean, too.
        self.mean = max(float(wide[0].mean()), 0.0) or self.mean
        before = noise_before()
        apart = paired_difference(base.pictures, other.pictures, self.mean)
        probe = plan.Probe(apart, other.rays / base.rays)
        if not probe.suffices(self.tolerance):
            why = f'{plan.UNSURE}: other seeds make it {plan.interval(apart)} of difference'
            return None, 1.0, before, before, why
        if measure.seen_between(*wide, self.mean, self.tolerance):
            why = f'{plan.UNSURE}: something small and bright lies between its pixels'
            return None, 1.0, before, before, why
        after = replace(measure.noise(other.pictures, samples, self.mean), slope=before.slope, cost=before.cost)
        return apart, probe.rays, after, before, ''

    def limit_rows(self, search: plan.Search, chosen: RenderSettings, why: str) -> list[Row]:
        direct = chosen.integrator == 'DIRECT'
        rows = []
        if 'integrator' in self.allowed:
            told = search.why('max_bounces') if direct or not self.asked.max_bounces else why or 'bounces count'
            rows.append(Row('integrator', 'Path', 'Direct' if direct else 'Path', told))
        for key, name in LIMIT_OF.items():
            asked, now = getattr(self.asked, name), getattr(chosen, name)
            told = why or search.why(name)
            # Of a limit that is lower than it was only because that of all bounces is.
            if direct and key != 'transparent':
                now, told = asked, 'Direct has none'
            elif now < asked and now not in search.probes.get(name, {}):
                told = 'no more than all bounces together'
            elif key == 'transparent' and key in self.allowed and self.asked.transparent_film:
                told = 'alpha depends on it, which no pilot measures'
            rows.append(Row(key, str(asked), str(now), told))
        return rows

    def sampled(self, noise: Noise, before: Noise, bias: float) -> tuple[plan.Sampling, Row]:
        """The samples that suffice, and their row."""
        asked = sampling_of(self.asked)
        best, why = asked, 'as few as suffice'
        if 'sampling' not in self.allowed:
            why = 'switched off'
        else:
            best = plan.sampling(asked, noise, before, bias, self.tolerance, stopping=not self.spreads)
            dominated = noise.dominated or before.dominated
            if best == asked and self.spreads:
                why = 'the render itself tells where they are needed'
            elif best == asked and dominated:
                why = f'{plan.UNSURE}: a few pixels make most of the noise'
            elif best != asked and best.samples == asked.samples:
                why = f'adds no more than {percent(best.added(noise, asked).high)} to the error'
            elif best != asked:
                why = f'leaves noise of {percent(best.error(noise)[0])}, as asked {percent(asked.error(before)[0])}'
        return best, Row('sampling', asked.words(), best.words(), why)

    def cost(self) -> dict[str, Any]:
        whole = self.spend.paths / plan.PILOT_SHARE
        return {
            'width': self.spend.width,
            'height': self.spend.height,
            'samples': self.spend.search,
            'seeds': plan.SEEDS,
            'settings': self.settings_seen,
            'paths': self.pilot.paths,
            'share': self.pilot.paths / whole,
            'seconds': self.pilot.wall,
        }


def random_below(threshold: float) -> str:
    return f'at random below {threshold:.2g}' if threshold > 0.0 else ALL


def unseen(parts: Sequence[Part], passes: Sequence[str]) -> list[Part]:
    """The parts that no pass shows beside the light: terms are of lobes, and some passes of normals."""
    if any(name.startswith('term_') or name == 'denoising_albedo' for name in passes):
        return []
    normals = 'normal' in passes or 'denoising_normal' in passes
    return [part for part in parts if not (normals and part.argument == NORMAL)]


def with_limits(asked: RenderSettings, limits: dict[str, int]) -> RenderSettings:
    """Without a bounce, Direct renders the same, without the ambient light that it may have."""
    settings = replace(asked, **limits)
    if limits['max_bounces'] > 0:
        return settings
    return replace(settings, integrator='DIRECT', ambient_strength=0.0)
