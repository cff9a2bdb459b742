# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart as a figure for print, by matplotlib: a panel for each measure, and a sheet of pictures and errors.

Blender's own Python has no matplotlib: nothing imports this module but who has asked for it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from . import labels, pictures
from .results import CLOCKS, Line, Measure, Results, engine_name, front_of, told, white_of
from .style import color_of, marker_of

DPI = 150
INK, GREY = '#222222', '#8a8a8a'
FRONT = '#c9c9c9'
MOST_SHEET_ROWS = 8
SPARE = 1.15  # times beyond the first and last point that a curve is drawn
ROOM = 1.12  # powers of the axis' span that labels on the right have


def chart(results: Results, title: str, subtitle: str) -> Figure:
    """Panels of seconds against error, with the Pareto front, fitted curves, and a legend with slopes and biases."""
    columns = 2
    rows = math.ceil(len(results.measures) / columns)
    figure = Figure(figsize=(10.0, 4.1 * rows + 0.34 * len(results.lines) / 2 + 1.0), dpi=DPI, layout='constrained')
    FigureCanvasAgg(figure)
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.08)
    figure.suptitle(f'{title}\n', fontsize=13, fontweight='bold', x=0.02, ha='left', color=INK)
    figure.text(0.02, 0.985, f'\n{subtitle}', fontsize=8.5, color='#555555', va='top', linespacing=1.7)
    panels = figure.subplots(rows, columns, squeeze=False).flat
    for axes, measure in zip(panels, results.measures, strict=False):
        draw_panel(axes, results, measure)
    for axes in list(panels)[len(results.measures) :]:
        axes.set_axis_off()
    figure.legend(
        handles=[legend_line(line) for line in results.lines] + front_handle(),
        loc='outside lower center', ncols=2, fontsize=8, frameon=False, handlelength=2.6, columnspacing=3.0,
    )  # fmt: skip
    figure.canvas.draw()  # the places of everything are known now
    for axes, measure in zip(figure.axes, results.measures, strict=False):
        draw_labels(axes, results, measure)
    return figure


def draw_panel(axes: Axes, results: Results, measure: Measure) -> None:
    clock = results.clock
    axes.set(xscale='log', yscale='log')
    axes.set_title(measure.name, fontsize=10.5, loc='left', color=INK)
    axes.set_xlabel(f'{CLOCKS[clock]} of rendering', fontsize=9)
    axes.set_ylabel(f'error ({measure.name.split(" without")[0]})', fontsize=9)
    axes.grid(True, which='major', color='#ececec', linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors='#444444')
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)
    for line in results.lines:
        shade = color_of(line.series)
        known = [point for point in line.points if point.value(measure.key) > 0.0]
        seconds = [point.seconds(clock) for point in known]
        errors = [point.value(measure.key) for point in known]
        curve = line.curves.get(measure.key)
        if curve is not None:
            x = np.geomspace(curve.first / SPARE, curve.last * SPARE, 60)
            axes.plot(x, [curve.error(t) for t in x], color=shade, linewidth=1.2, alpha=0.85, zorder=3)
        else:
            axes.plot(seconds, errors, color=shade, linewidth=1.0, linestyle=':', alpha=0.85, zorder=3)
        axes.plot(seconds, errors, linestyle='', zorder=4, **marker_of(line.series))
    draw_front(axes, results, measure)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(10, subs=decades(axis)))
        axis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}' if value >= 1e-3 else f'{value:.0e}'))


def decades(axis: Any) -> tuple[float, ...]:
    """Ticks at 1, 2 and 5 where an axis spans less than two decades."""
    low, high = axis.get_view_interval()
    return (1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)


def draw_front(axes: Axes, results: Results, measure: Measure) -> None:
    stairs(axes, [(p.seconds(results.clock), p.value(measure.key)) for p in results.points])


def stairs(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """The Pareto front of points (cost, error), as a staircase: at a cost, the least error that is reached by then."""
    best = front_of(points)
    if not best:
        return
    costs, errors = zip(*best, strict=True)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    right = left * (right / left) ** ROOM
    axes.step([*costs, right], [*errors, errors[-1]], where='post', color=FRONT, linewidth=5, zorder=1,
              solid_capstyle='round', solid_joinstyle='round')  # fmt: skip
    axes.plot([costs[0]] * 2, [errors[0], high], color=FRONT, linewidth=5, zorder=1)
    axes.set(xlim=(left, right), ylim=(low, high))


def on_stairs(axes: Axes, points: Sequence[tuple[float, float]]) -> list[labels.Box]:
    """Boxes along the front, in pixels."""
    best = front_of(points)
    corners = [(best[0][0], axes.get_ylim()[1])] if best else []
    for cost, error in best:
        corners += [(cost, corners[-1][1]), (cost, error)]
    if corners:
        corners.append((axes.get_xlim()[1], corners[-1][1]))
    return along([axes.transData.transform(corner) for corner in corners])


def front_handle() -> list[Any]:
    from matplotlib.lines import Line2D

    return [Line2D([], [], color=FRONT, linewidth=5, label='Pareto front: nothing is both faster and nearer')]


def legend_line(line: Line) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color_of(line.series), linewidth=1.2, label=legend_text(line), **{
        key: value for key, value in marker_of(line.series).items() if key != 'color'
    })  # fmt: skip


def legend_text(line: Line) -> str:
    words = [line.series.name]
    if not math.isnan(line.slope):
        words.append(f'noise² ∝ time$^{{−{line.slope:.2f}}}$')
    if line.bias is not None:
        words.append(f'bias {told(line.bias)}')
    return ', '.join(words[:1]) + (': ' + ', '.join(words[1:]) if words[1:] else '')


def draw_labels(axes: Axes, results: Results, measure: Measure) -> None:
    """Names of series at their last points, numbers of samples at all; neither covers the other, a marker or a line."""
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    wanted: list[tuple[labels.Label, str, float]] = []
    obstacles: list[labels.Box] = []
    radius = 4.2 * DPI / 72
    for line in results.lines:
        places = []
        for point in line.points:
            if point.value(measure.key) <= 0.0:
                continue
            x, y = axes.transData.transform((point.seconds(results.clock), point.value(measure.key)))
            places.append((x, y, point))
            obstacles.append((x - radius, y - radius, x + radius, y + radius))
        obstacles += along([(x, y) for x, y, _ in places])
        curve = line.curves.get(measure.key)
        if curve is not None:
            times = np.geomspace(curve.first / SPARE, curve.last * SPARE, 16)
            obstacles += along([axes.transData.transform((t, curve.error(t))) for t in times])
        for x, y, point in places:
            text = str(point.samples)
            wanted.append((label(text, (x, y), 6.5, False, renderer, figure), '#666666', 6.5))
        if places:
            x, y, _ = places[-1]
            wanted.append((label(line.series.name, (x, y), 8.0, True, renderer, figure), color_of(line.series), 8.0))
    obstacles += on_stairs(axes, [(p.seconds(results.clock), p.value(measure.key)) for p in results.points])
    boxes = labels.place([entry for entry, _, _ in wanted], obstacles, (frame.x0, frame.y0, frame.x1, frame.y1))
    for (entry, color, size), box in zip(wanted, boxes, strict=True):
        if box is not None:
            write(axes, entry, box, color, size)


def write(axes: Axes, entry: labels.Label, box: labels.Box, color: str, size: float) -> None:
    """A label at its place, with a line to what it names where that is away."""
    centre = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
    if entry.needed and math.dist(nearest(box, entry.anchor), entry.anchor) > 8.0 * DPI / 72:
        ends = axes.transData.inverted().transform([entry.anchor, nearest(box, entry.anchor)])
        axes.plot(*ends.T, color=color, linewidth=0.6, zorder=2, scalex=False, scaley=False)
    place = axes.transData.inverted().transform(centre)
    text = axes.text(*place, entry.text, fontsize=size, color=color, ha='center', va='center', zorder=5)
    text.set_path_effects([withStroke(linewidth=2.2, foreground='white')])


def place_texts(axes: Axes, texts: Sequence[tuple[str, tuple[float, float], str]], size: float) -> None:
    """A text beside each point (text, (cost, error), color), none over another; the figure must have been drawn."""
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    anchors = [axes.transData.transform(point) for _, point, _ in texts]
    obstacles = [(x - 6.0, y - 6.0, x + 6.0, y + 6.0) for x, y in anchors]
    wanted = [label(text, at, size, True, renderer, figure) for (text, _, _), at in zip(texts, anchors, strict=True)]
    boxes = labels.place(wanted, obstacles, (frame.x0, frame.y0, frame.x1, frame.y1))
    for entry, box, (_, _, color) in zip(wanted, boxes, texts, strict=True):
        write(axes, entry, box, color, size)


def along(places: Sequence[Any]) -> list[labels.Box]:
    """Small boxes along the lines between points, which labels keep clear of."""
    boxes = []
    for (x0, y0), (x1, y1) in itertools.pairwise(places):
        for share in np.linspace(0.0, 1.0, 2 + int(math.dist((x0, y0), (x1, y1)) / 8)):
            x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            boxes.append((x - 2.0, y - 2.0, x + 2.0, y + 2.0))
    return boxes


def nearest(box: labels.Box, point: tuple[float, float]) -> tuple[float, float]:
    return min(max(point[0], box[0]), box[2]), min(max(point[1], box[1]), box[3])


def label(text: str, anchor: Any, size: float, needed: bool, renderer: Any, figure: Figure) -> labels.Label:
    measured = figure.text(0, 0, text, fontsize=size)
    extent = measured.get_window_extent(renderer)
    measured.remove()
    return labels.Label(text, (float(anchor[0]), float(anchor[1])), (extent.width + 3, extent.height + 2), needed)


def sheet(results: Results, title: str) -> Figure:
    """A row for each series: its picture and error at each number of samples; the references come first."""
    lines = results.lines[:MOST_SHEET_ROWS]
    most = max(3, *(len(line.points) for line in lines))
    reference = next(iter(results.references.values())).image
    shape = reference.shape[0] / reference.shape[1]
    inch, gap, words, margin = 10.0, 0.04, 0.36, 0.1
    width = (inch - 2 * margin) / (2 * most) - gap
    step = width * shape + words
    high = step * (len(lines) + 1) + 0.35 + margin
    figure = Figure(figsize=(inch, high), dpi=DPI)
    FigureCanvasAgg(figure)
    figure.text(margin / inch, 1 - 0.1 / high, title, fontsize=12, fontweight='bold', color=INK, va='top')
    white = white_of(reference)

    def put(row: int, column: int, picture: pictures.Bytes, above: str, color: str = INK, size: float = 6.5) -> Axes:
        left, bottom = margin + column * (width + gap), high - 0.35 - (row + 1) * step
        axes = figure.add_axes((left / inch, bottom / high, width / inch, width * shape / high))
        axes.imshow(picture, aspect='auto', interpolation='nearest')
        axes.set_axis_off()
        axes.set_title(above, fontsize=size, loc='left', pad=2, color=color)
        return axes

    for column, (series, truth) in enumerate(results.references.items()):
        put(0, column, pictures.displayed(truth.image, white), f'reference, {engine_name(series)}')
    if results.between is not None:
        limit = pictures.round_limit(results.between.difference)
        shown = pictures.signed(results.between.difference, limit)
        put(0, 2, shown, f'{results.between.a} − {results.between.b}, ±{100 * limit:g} % of white')
    for row, line in enumerate(lines, 1):
        for index, point in enumerate(line.points):
            name = f'{line.series.name}\n' if index == 0 else ''
            put(row, 2 * index, pictures.displayed(point.image, white), f'{name}{samples_text(point.samples)}')
            told = f'{point.seconds(results.clock):.2g} s, relMSE {point.relmse:.1e}'
            put(row, 2 * index + 1, pictures.heat(point.error), told, GREY, 5.5)
    draw_scale(put(0, 2 * most - 2, np.full((1, 1, 3), 255, np.uint8), ''))
    return figure


def samples_text(samples: int) -> str:
    return f'{samples} sample{"s" if samples > 1 else ""}'


def draw_scale(axes: Axes) -> None:
    """What the colors of the errors mean."""
    ramp = np.geomspace(pictures.HEAT_LOW, pictures.HEAT_HIGH, 200)[None].repeat(8, axis=0)
    axes.imshow(pictures.heat(ramp), aspect='auto', extent=(0, 1, 0.4, 0.6))
    axes.set(xlim=(-0.1, 1.1), ylim=(0, 1))
    axes.text(0, 0.68, 'relative error', fontsize=6.5, va='bottom')
    for place, text in ((0, '1 %'), (0.5, '10 %'), (1, '100 %')):
        axes.text(place, 0.34, text, fontsize=6, va='top', ha={0: 'left', 1: 'right'}.get(place, 'center'))
