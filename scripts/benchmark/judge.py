# SPDX-License-Identifier: GPL-3.0-or-later
"""From renders to verdicts: errors, time at equal error, same image. Pure computation on what `runner.py` brings.

It renders nothing and prints nothing; `report.py` does that.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from statistics import mean, median
from typing import Any

from cotorra.metrics import Error, Reference, SameImage, fit_power_law, image_error, same_image, time_at_error

from benchmark.runner import Render


@dataclass(frozen=True, slots=True)
class Row:
    """One engine at one sample count; over seeds, errors are means and seconds medians."""

    engine: str
    samples: int
    render: float
    whole: float
    cpu: float
    memory: int | None  # peak above Blender's own, of the first render of the process; the later ones reuse it
    own: Error  # against the engine's own converged image: noise alone
    cycles: Error  # against Cycles' converged image: noise and any systematic difference


@dataclass(frozen=True, slots=True)
class EqualError:
    """Time for one engine's error with its most samples, over the other's time for the same error.

    measure: the field of `Error`.   samples: what ours needs.   extrapolated: outside half the least to twice the most.
    render, whole, cpu: Cycles' seconds over ours. CPU seconds are those per sample, free of all that is not sampling
    and little disturbed by other work on the machine.
    """

    measure: str
    error: float
    samples: float
    slope_ours: float
    slope_cycles: float
    render: float
    whole: float
    cpu: float
    extrapolated: bool


def mean_error(errors: list[Error]) -> Error:
    parts = [asdict(error) for error in errors]
    return Error(**{key: (max if key == 'bad' else mean)(part[key] for part in parts) for key in parts[0]})


def rows(engine: str, renders: list[Render], own: Reference, cycles: Reference, blender: int) -> list[Row]:
    """A row for each sample count, ascending; `blender` is the memory that Blender itself takes for a render."""
    result = []
    for samples in sorted({render.samples for render in renders}):
        chosen = [render for render in renders if render.samples == samples]
        result.append(
            Row(
                engine=engine,
                samples=samples,
                render=median(render.render for render in chosen),
                whole=median(render.whole for render in chosen),
                cpu=median(render.cpu for render in chosen),
                memory=renders[0].memory - blender if samples == renders[0].samples else None,
                own=mean_error([image_error(render.image, own) for render in chosen]),
                cycles=mean_error([image_error(render.image, cycles) for render in chosen]),
            )
        )
    return result


def cpu_per_sample(table: list[Row]) -> float:
    """Processor seconds of one more sample; NaN where they drown in those of everything else."""
    first, last = table[0], table[-1]
    rendering = last.cpu - first.cpu
    return rendering / (last.samples - first.samples) if rendering > 0.2 * last.cpu else math.nan


def equal_error(ours: list[Row], cycles: list[Row], measure: str, against: str = 'own') -> EqualError:
    """ValueError where an error does not fall, for instance for reaching a systematic difference."""

    def errors(table: list[Row]) -> tuple[list[int], list[float]]:
        return [row.samples for row in table], [getattr(getattr(row, against), measure) for row in table]

    counts, ours_errors = errors(ours)
    cycles_counts, cycles_errors = errors(cycles)
    cycles_law, ours_law = fit_power_law(cycles_counts, cycles_errors), fit_power_law(counts, ours_errors)
    last_ours, last_cycles = ours[-1], cycles[-1]
    target = cycles_errors[-1]
    seconds, needed = time_at_error(counts, ours_errors, last_ours.render, last_ours.samples, target)
    return EqualError(
        measure=measure,
        error=target,
        samples=needed,
        slope_ours=ours_law.slope,
        slope_cycles=cycles_law.slope,
        render=last_cycles.render / seconds,
        whole=last_cycles.whole / (last_ours.whole - last_ours.render + seconds),
        cpu=cpu_per_sample(cycles) * last_cycles.samples / (cpu_per_sample(ours) * needed),
        extrapolated=not counts[0] / 2 <= needed <= counts[-1] * 2,
    )


def against_cpu(ours: list[Row], renders: list[Render], reference: Reference, blender: int) -> dict[str, Any]:
    """Our CPU device's time over a graphics card's, to the error of the former's most samples; the error is trimmed."""
    table = rows('COTORRA, CPU', renders, reference, reference, blender)
    try:
        return {'rows': [asdict(row) for row in table], **asdict(equal_error(ours, table, 'trimmed'))}
    except ValueError as problem:
        return {'rows': [asdict(row) for row in table], 'failed': str(problem)}


def verdict(
    name: str,
    renders: list[Render],
    reference: Reference,
    cycles: list[Render],
    cycles_reference: Reference,
    blender: int,
    cpu: tuple[list[Render], Reference] | None = None,
) -> tuple[dict[str, Any], SameImage]:
    """Everything about one case, ready for JSON, and the comparison of the two converged images.

    cpu: the same by our CPU device, where `renders` are a graphics card's.
    """
    ours_rows = rows(name, renders, reference, cycles_reference, blender)
    cycles_rows = rows('CYCLES', cycles, cycles_reference, cycles_reference, blender)
    equal, failed = [], []
    for against in ('own', 'cycles'):
        for measure in ('relmse', 'trimmed', 'mse'):
            try:
                equal.append({'against': against, **asdict(equal_error(ours_rows, cycles_rows, measure, against))})
            except ValueError as problem:
                failed.append({'against': against, 'measure': measure, 'reason': str(problem)})
    same = same_image(reference, cycles_reference)
    same_numbers = asdict(same)
    del same_numbers['tiles']
    return {
        **({'cpu': against_cpu(ours_rows, *cpu, blender)} if cpu else {}),
        'rows': [asdict(row) for row in (*cycles_rows, *ours_rows)],
        'equal_error': equal,
        'equal_error_failed': failed,
        'same_image': {**same_numbers, 'holds': same.holds()},
        'stats': max(renders, key=lambda render: render.samples).stats,
    }, same
