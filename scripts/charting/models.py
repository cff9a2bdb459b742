# SPDX-License-Identifier: GPL-3.0-or-later
"""What each model, each D, G, F and each integrator costs on box_room, and how far it is from the path-traced image.

The table that the OpenGL study gives, made for ours, with Cycles in the same run. Rendering is done by benchmark/.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from cotorra.lab.figure import place_texts, stairs
from cotorra.metrics import Image, Reference, image_error, noise_and_bias, total_difference

from benchmark import runner, scenes
from charting.result import Chart, Table, panels

BOUNCES = 4
OVERRIDE = 'cotorra.model_override'
# A job's settings stay for the next one, so that each job sets all of these.
DEFAULTS = {
    'cotorra.integrator': 'PATH',
    'cotorra.use_model_override': False,
    f'{OVERRIDE}.model': 'PRINCIPLED',
    f'{OVERRIDE}.normalized': False,
    f'{OVERRIDE}.oren_nayar_form': 'QUALITATIVE',
    f'{OVERRIDE}.distribution': 'GGX',
    f'{OVERRIDE}.masking': 'SMITH_CORRELATED',
    f'{OVERRIDE}.fresnel': 'SCHLICK',
}
MODELS = {
    'Principled': {},
    'Lambert': {'model': 'LAMBERT'},
    'Oren-Nayar': {'model': 'OREN_NAYAR'},
    'Oren-Nayar, energy preserving': {'model': 'OREN_NAYAR', 'oren_nayar_form': 'ENERGY_PRESERVING'},
    'Phong': {'model': 'PHONG'},
    'Phong, normalized': {'model': 'PHONG', 'normalized': True},
    'Blinn-Phong': {'model': 'BLINN_PHONG'},
    'Blinn-Phong, normalized': {'model': 'BLINN_PHONG', 'normalized': True},
    'Toon': {'model': 'TOON'},
    'Cook-Torrance': {'model': 'COOK_TORRANCE'},
    'D Beckmann': {'model': 'COOK_TORRANCE', 'distribution': 'BECKMANN'},
    'D Blinn-Phong': {'model': 'COOK_TORRANCE', 'distribution': 'BLINN_PHONG'},
    'G Smith': {'model': 'COOK_TORRANCE', 'masking': 'SMITH'},
    'G Cook-Torrance': {'model': 'COOK_TORRANCE', 'masking': 'COOK_TORRANCE'},
    'G Schlick-GGX': {'model': 'COOK_TORRANCE', 'masking': 'SCHLICK_GGX'},
    'F dielectric': {'model': 'COOK_TORRANCE', 'fresnel': 'DIELECTRIC'},
    'F conductor': {'model': 'COOK_TORRANCE', 'fresnel': 'CONDUCTOR'},
    'F F82': {'model': 'COOK_TORRANCE', 'fresnel': 'F82'},
}
INTEGRATORS = ('DIRECT', 'PATH', 'WHITTED', 'AO', 'TOON')


@dataclass(frozen=True, slots=True)
class Plan:
    size: tuple[int, int]
    samples: int
    repeats: int
    reference_samples: int


@dataclass(slots=True)
class Measured:
    """seconds: of rendering alone, by each engine's own clock, one a repeat; cpu: of the whole render."""

    seconds: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)


def make(quick: bool) -> Chart:
    plan = Plan((64, 36), 2, 2, 16) if quick else Plan((320, 180), 16, 5, 512)
    case = runner.Case(scenes.find('box_room'), BOUNCES, plan.size, os.cpu_count() or 1)
    _, reference = runner.measure(case, 'COTORRA', [], [], plan.reference_samples, (2001, 2002))
    ours = render(case, 'COTORRA', {**variants(), **{name: {'cotorra.integrator': name} for name in INTEGRATORS}}, plan)
    limits = ('max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces')
    cycles_setups = {
        f'Cycles, {bounces} bounces': {f'cycles.{limit}': bounces for limit in limits} for bounces in (0, BOUNCES)
    }
    cycles = render(case, 'CYCLES', cycles_setups, plan)

    frame = f'{plan.size[0]}×{plan.size[1]}, {plan.samples} samples, {case.threads} threads, median of {plan.repeats}'
    notes = (
        'reference: Principled, path traced; relMSE: of one frame; no noise: what more samples would leave',
        'total: difference of the image mean; ms: rendering alone, without export, BVH and saving',
    )
    head = ('model', 'direct ms', 'direct ms/Ms', 'direct relMSE', 'path ms', 'ms/Ms', 'relMSE', 'no noise', 'total')
    rows = []
    for name in MODELS:
        direct, path = (judged(ours[f'{name}, {kind}'], reference, plan) for kind in ('DIRECT', 'PATH'))
        rows.append((name, direct[0], direct[1], direct[2], *path))
    models = Table('models', f'box_room, one model for everything, {frame}', head, rows, notes)
    others = {**{name: ours[name] for name in INTEGRATORS}, **cycles}
    head = ('integrator', 'ms', 'ms/Ms', 'relMSE', 'no noise', 'total')
    lines = [(name, *judged(measured, reference, plan)) for name, measured in others.items()]
    integrators = Table('integrators', f'box_room as it is, {frame}', head, lines, notes)
    return Chart('models', [models, integrators], draw(rows, lines))


def variants() -> dict[str, dict[str, Any]]:
    """Scene settings of each model under DIRECT and PATH."""
    found = {}
    for name, model in MODELS.items():
        for integrator in ('DIRECT', 'PATH'):
            settings = {'cotorra.integrator': integrator, 'cotorra.use_model_override': bool(model)}
            found[f'{name}, {integrator}'] = settings | {f'{OVERRIDE}.{key}': value for key, value in model.items()}
    return found


def render(case: runner.Case, engine: str, setups: dict[str, dict[str, Any]], plan: Plan) -> dict[str, Measured]:
    """All setups one after the other in one Blender, and all of it again, so that a slow minute hits all alike."""
    defaults = DEFAULTS if engine == 'COTORRA' else {}
    with tempfile.TemporaryDirectory(prefix='cotorra-chart-') as work:
        order = [(name, repeat) for repeat in range(plan.repeats) for name in setups]
        jobs = [{'samples': 1, 'seed': 1, 'output': ''}]  # the first render in a process pays for what later ones find
        jobs += [
            {
                'samples': plan.samples,
                'seed': 11 + repeat,
                'output': str(Path(work, f'{index}.exr')),
                'settings': defaults | setups[name],
            }
            for index, (name, repeat) in enumerate(order)
        ]
        done = runner.run_worker(runner.task_of(case, engine, jobs))['renders'][1:]
        results = {name: Measured() for name in setups}
        for (name, _), entry in zip(order, done, strict=True):
            finished = runner.finished(engine, entry)
            results[name].seconds.append(finished.render)
            results[name].cpu.append(finished.cpu)
            results[name].images.append(finished.image)
    return results


def judged(measured: Measured, reference: Reference, plan: Plan) -> tuple[float, float, float, float, float]:
    """ms a frame, ms a million samples, relMSE of a frame, of it what is no noise, difference of the mean."""
    seconds = median(measured.seconds)
    samples = plan.size[0] * plan.size[1] * plan.samples
    error = float(np.mean([image_error(image, reference).relmse for image in measured.images]))
    systematic = noise_and_bias(measured.images, reference).bias_relmse
    total = total_difference(measured.images, [reference.image]).value
    return 1e3 * seconds, 1e9 * seconds / samples, error, systematic, total


def draw(models: list[tuple[Any, ...]], integrators: list[tuple[Any, ...]]) -> Any:
    """Cost against error with the Pareto front: models on the left, integrators and Cycles on the right."""
    figure, (left, right) = panels('box_room: ms a frame and error against the path-traced image', 1, 2, 7.4, 6.4)
    found = []
    for offset, error, kind, color in ((1, 3, 'direct', 'tab:orange'), (4, 6, 'path', 'tab:blue')):
        left.scatter([row[offset] for row in models], [row[error] for row in models], color=color, label=kind, s=22)
        found += [(row[offset], row[error], str(number), color) for number, row in enumerate(models, 1)]
    for number, row in enumerate(models, 1):
        left.plot([], [], linestyle='', label=f'{number} {row[0]}')
    left.legend(loc='upper center', bbox_to_anchor=(0.5, -0.12), ncols=3, fontsize=7, handlelength=1.0)
    known = [(row[1], row[3], row[0], 'tab:gray' if row[0].startswith('Cycles') else 'tab:blue') for row in integrators]
    right.scatter([point[0] for point in known], [point[1] for point in known], color=[point[3] for point in known])
    left.set_title('one model for everything')
    right.set_title('integrators, materials as they are')
    for axes in (left, right):
        axes.set(xlabel='ms a frame', ylabel='relMSE of a frame', xscale='log', yscale='log')
        axes.grid(True, which='major', color='#ececec')
        axes.set_axisbelow(True)
        axes.margins(0.12)
    for axes, points in ((left, found), (right, known)):
        stairs(axes, [point[:2] for point in points])
    figure.canvas.draw()
    for axes, points in ((left, found), (right, known)):
        texts = [(text, (x, y), color) for x, y, text, color in points]
        place_texts(axes, texts, size=7.5)
    return figure
