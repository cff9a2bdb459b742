# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart as one HTML page that opens without a server: plot, pictures and table, all in the file.

page.html is its frame; what is written here is the data.
"""

from __future__ import annotations

import base64
import html
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from . import pictures
from .plan import Series
from .results import CLOCKS, Line, Point, Results, engine_name, told, white_of
from .store import replace_text
from .style import MARKERS, color_of, kind

FRAME = Path(__file__).with_name('page.html')


def write(path: Path, results: Results, title: str, subtitle: str, notes: list[str]) -> None:
    white = white_of(next(iter(results.references.values())).image)
    data = plot_data(results)
    for line, shown in zip(results.lines, data['lines'], strict=True):
        for point, entry in zip(line.points, shown['points'], strict=True):
            entry['picture'] = encoded(pictures.displayed(point.image, white))
            entry['error'] = encoded(pictures.heat(point.error))
    data['references'] = [
        {'name': engine_name(series), 'picture': encoded(pictures.displayed(truth.image, white))}
        for series, truth in results.references.items()
    ]
    data['heat'] = [f'rgb{color}' for _, color in pictures.HEAT]
    text = FRAME.read_text(encoding='utf-8')
    # "</" would end the script that holds the data.
    parts = {
        'TITLE': html.escape(title),
        'SUBTITLE': html.escape(subtitle),
        'NOTES': ''.join(f'<li>{html.escape(note)}</li>' for note in notes),
        'DATA': json.dumps(data).replace('</', '<\\/'),
    }
    for name, value in parts.items():
        text = text.replace(f'{{{{{name}}}}}', value)
    replace_text(path, text)


def plot_data(results: Results) -> dict[str, Any]:
    """All that a plot shows, as JSON knows it; pictures left out."""
    return {
        'clock': CLOCKS[results.clock],
        'measures': [{'key': measure.key, 'name': measure.name} for measure in results.measures],
        'lines': [line_data(line, results) for line in results.lines],
    }


def line_data(line: Line, results: Results) -> dict[str, Any]:
    return {
        'name': line.series.name,
        'series': asdict(line.series),
        'color': color_of(line.series),
        'marker': MARKERS[kind(line.series)],
        'hollow': line.series.denoised,
        'slope': number(line.slope),
        'bias': told(line.bias) if line.bias is not None else '',
        'truth': truth_of(line.series, results),
        'curves': {key: samples_of(curve) for key, curve in line.curves.items()},
        'points': [point_data(point, results) for point in line.points],
    }


def truth_of(series: Series, results: Results) -> int:
    """Index of the reference that its error is against."""
    known = list(results.references)
    own = [index for index, reference in enumerate(known) if reference.engine == series.engine]
    return own[0] if own else 0


def samples_of(curve: Any, count: int = 40) -> list[list[float]]:
    first, last = curve.first / 1.15, curve.last * 1.15
    times = [first * (last / first) ** (index / (count - 1)) for index in range(count)]
    return [[time, curve.error(time)] for time in times]


def point_data(point: Point, results: Results) -> dict[str, Any]:
    return {
        'samples': point.samples,
        'seeds': point.seeds,
        'seconds': point.seconds(results.clock),
        'wall': point.wall,
        'cpu': point.cpu,
        'whole': point.whole,
        **{measure.key: number(point.value(measure.key)) for measure in results.measures},
        'noise': number(point.parts.noise_relmse) if point.parts else None,
        'bias': number(point.parts.bias_relmse) if point.parts else None,
        'bad': point.bad,
        'front': sorted(point.front),
    }


def number(value: float) -> float | None:
    """JSON knows no NaN."""
    return value if math.isfinite(value) else None


def encoded(picture: pictures.Bytes) -> str:
    return 'data:image/jpeg;base64,' + base64.b64encode(pictures.jpeg(picture)).decode('ascii')
