# SPDX-License-Identifier: GPL-3.0-or-later
"""The misprints of the three founding texts (a ray-tracing engine, an OpenGL study, a Whitted ray tracer): right
against misprinted, with a figure of the damage each. In double precision; no kernel is run, for none has a misprint.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from charting.result import Chart, Table, panels

F64 = NDArray[np.float64]
RIGHT, WRONG = 'tab:blue', 'tab:red'


def make(quick: bool) -> Chart:
    count = 65 if quick else 1025
    figure, axes = panels('Misprints of the founding texts: right (blue) and misprinted (red)', 2, 4)
    drawn = (schlick, half_vector, light_window, lambert, beckmann_t, sobel, triangle, recursion)
    rows = [draw(panel, count) for draw, panel in zip(drawn, axes, strict=True)]
    head = ('misprint', 'what is measured', 'right', 'misprinted', 'damage')
    return Chart('misprints', [Table('misprints', 'Misprints and their damage', head, rows)], figure)


def pair(panel: Any, x: F64, right: F64, wrong: F64, title: str, across: str, up: str) -> None:
    panel.plot(x, right, color=RIGHT)
    panel.plot(x, wrong, color=WRONG)
    panel.set(title=title, xlabel=across, ylabel=up)


def schlick(panel: Any, count: int) -> tuple[Any, ...]:
    """F0 must be the material's (0.04 for plastic, not 0.5) and the angle that between v and h, not l and v."""
    cosine = np.cos(np.linspace(0.0, np.pi / 2, count))  # v·h; l and v are then twice that angle apart
    right = 0.04 + 0.96 * (1.0 - cosine) ** 5
    wrong = 0.5 + 0.5 * (1.0 - np.clip(2.0 * cosine**2 - 1.0, 0.0, 1.0)) ** 5
    pair(
        panel,
        np.degrees(np.arccos(cosine)),
        right,
        wrong,
        'Schlick: F0 0.5, angle of l and v',
        'angle of v and h, degrees',
        'F',
    )
    means = [float(2.0 * np.trapezoid(-curve * cosine, cosine)) for curve in (right, wrong)]
    return 'Schlick', 'mean F of plastic, cosine-weighted', *means, f'{means[1] / means[0]:.1f} times as much mirrored'


def ggx(nh: F64, a: float) -> F64:
    return a * a / (np.pi * (1.0 + nh * nh * (a * a - 1.0)) ** 2)


def half_vector(panel: Any, count: int) -> tuple[Any, ...]:
    """h = l + v must be normalised: its length is up to 2, n·h then passes the pole of D at nh² = 1 / (1 − a²)."""
    a, viewer = 0.5**2, np.radians(30.0)
    light = np.linspace(-np.pi / 2, np.pi / 2, count)
    sum_nh = np.cos(light) + np.cos(viewer)
    length = 2.0 * np.cos((light + viewer) / 2.0)  # both in one plane, on opposite sides of n
    right, wrong = ggx(sum_nh / length, a), ggx(sum_nh, a)
    pair(panel, np.degrees(light), right, wrong, 'GGX D: h not normalised', 'angle of l, degrees (v at 30°)', 'D')
    panel.set_yscale('log')
    peaks = [float(np.interp(viewer, light, curve)) for curve in (right, wrong)]
    pole = np.degrees(np.arccos(1.0 / np.sqrt(1.0 - a * a) - np.cos(viewer)))
    told = f'{peaks[0] / peaks[1]:.0f} times too dark there, and without bound at {pole:.0f}°'
    return 'half vector', 'D in the mirror direction, roughness 0.5', *peaks, told


def light_window(panel: Any, count: int) -> tuple[Any, ...]:
    """max(min(1 − (d/R)⁴, 1), 0) / d², not max(min(1 − (d/R)⁴, 1), d²)."""
    reach = 10.0
    d = np.linspace(0.5, 1.2 * reach, count)
    inner = np.minimum(1.0 - (d / reach) ** 4, 1.0)
    right, wrong = np.maximum(inner, 0.0) / d**2, np.maximum(inner, d**2)
    pair(panel, d, right, wrong, 'Light window: max with d², undivided', 'd (m), R = 10 m', 'attenuation')
    panel.set_yscale('symlog', linthresh=1e-3)
    at = float(np.interp(0.5 * reach, d, right)), float(np.interp(0.5 * reach, d, wrong))
    return 'light window', 'attenuation at R / 2', *at, f'{at[1] / at[0]:.0f} times; grows with d, no end at R'


def lambert(panel: Any, count: int) -> tuple[Any, ...]:
    """f = base/π; with nl in f beside the cosine of the rendering equation the surface loses a third of the light."""
    angle = np.linspace(0.0, np.pi / 2, count)
    right, wrong = np.cos(angle) / np.pi, np.cos(angle) ** 2 / np.pi
    pair(panel, np.degrees(angle), right, wrong, 'Lambert: an extra nl', 'angle of l, degrees', 'f nl')
    albedos = [float(2.0 * np.pi * np.trapezoid(curve * np.sin(angle), angle)) for curve in (right, wrong)]
    return 'Lambert', 'albedo of white', *albedos, f'{1.0 - albedos[1] / albedos[0]:.1%} of the light lost'


def beckmann_lambda(t: F64) -> F64:
    fit = (1.0 - 1.259 * t + 0.396 * t * t) / (3.535 * t + 2.181 * t * t)
    return np.where(t < 1.6, fit, 0.0)


def beckmann_t(panel: Any, count: int) -> tuple[Any, ...]:
    """t = ns / (a sqrt(1 − ns²)); without the square the surface shadows itself less in between."""
    a = 0.6**2
    angle = np.linspace(0.0, np.pi / 2, count + 2)[1:-1]
    ns = np.cos(angle)
    curves = [1.0 / (1.0 + beckmann_lambda(ns / (a * np.sqrt(below)))) for below in (1.0 - ns * ns, 1.0 - ns)]
    pair(
        panel,
        np.degrees(angle),
        *curves,
        't without the square',
        'angle of s, degrees (roughness 0.6)',
        'G1 (Beckmann)',
    )
    at = int(np.abs(curves[1] - curves[0]).argmax())
    values = [float(curve[at]) for curve in curves]
    return 'Smith t', f'G1 at {np.degrees(angle[at]):.0f}°', *values, f'{values[1] / values[0] - 1.0:+.1%}'


def sobel(panel: Any, count: int) -> tuple[Any, ...]:
    """[−1 0 1; −2 0 2; −1 0 1]; one corner with the wrong sign answers where nothing changes."""
    x = np.linspace(-1.0, 1.0, max(count // 8, 17))
    picture = np.where(x > 0.0, 1.0, 0.5)[None, :].repeat(3, axis=0)
    kernel = np.array([[-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0], [-1.0, 0.0, 1.0]])
    slipped = kernel.copy()
    slipped[2, 0] = 1.0
    windows = np.lib.stride_tricks.sliding_window_view(picture, (3, 3))[0]
    right, wrong = ((windows * mask).sum(axis=(1, 2)) for mask in (kernel, slipped))
    pair(panel, x[1:-1], right, wrong, 'Sobel: a sign slipped', 'x, one edge at 0', 'gradient')
    flat = [float(abs(curve[-1])) for curve in (right, wrong)]
    return (
        'Sobel',
        'answer where the picture is flat and 1',
        *flat,
        f'an edge everywhere ({max(right):.1f} at the edge)',
    )


def triangle(panel: Any, count: int) -> tuple[Any, ...]:
    """u and v belong to the second and third vertex (Möller and Trumbore 1997): (1 − u − v) a + u b + v c."""
    values = np.array([0.0, 0.5, 1.0])  # at the vertices a, b, c
    u = np.linspace(0.0, 1.0, count)
    v = 0.25 * (1.0 - u)
    weights = np.stack((1.0 - u - v, u, v), axis=-1)
    right, wrong = weights @ values, weights[:, [1, 2, 0]] @ values
    pair(panel, u, right, wrong, 'Möller-Trumbore: vertices turned', 'u, v = (1 − u) / 4', 'interpolated value')
    grid_u, grid_v = np.meshgrid(u, u)
    inside = grid_u + grid_v <= 1.0
    all_weights = np.stack((1.0 - grid_u - grid_v, grid_u, grid_v), axis=-1)[inside]
    error = np.abs((all_weights - all_weights[:, [1, 2, 0]]) @ values)
    spread = float(values.max() - values.min())
    told = f'up to {error.max() / spread:.0%} of the difference between vertices'
    return 'Möller-Trumbore', 'mean error of an interpolated value', 0.0, float(error.mean()), told


def recursion(panel: Any, count: int) -> tuple[Any, ...]:
    """Two rays at each hit: without a bound they never end. Closed scene, kr = 0.2 and kt = 0.7 everywhere."""
    reflected, refracted, threshold = 0.2, 0.7, 0.003
    deepest = 24 if count > 100 else 12
    depth = np.arange(deepest + 1)
    free, bound, kept = [], [], [1.0]
    for level in depth:
        free.append(2.0**level + (free[-1] if free else 0.0))
        # `kept` holds the throughputs of this level that are above the bound; below it a ray is not sent.
        bound.append(len(kept) + (bound[-1] if bound else 0))
        kept = [value * k for value in kept for k in (reflected, refracted) if value * k > threshold]
    pair(panel, depth, np.array(bound), np.array(free), 'Recursion without a bound', 'depth', 'rays for a camera ray')
    panel.set_yscale('log')
    lost = (reflected + refracted) ** 8
    told = f'{free[-1] / bound[-1]:.0f} times at depth {deepest}, then on; depth 8 leaves out {lost:.0%} of the weight'
    return 'recursion', f'rays at depth {deepest}, throughput > {threshold}', float(bound[-1]), float(free[-1]), told
