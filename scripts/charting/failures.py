# SPDX-License-Identifier: GPL-3.0-or-later
"""Where methods fail: each formula as written, in single precision, and as the kernels compute it, against double.

The directions are the same single-precision vectors for all three, so that what is shown is the arithmetic's error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from charting import formulas
from charting.kernels import DEFAULTS, evaluate, terms
from charting.result import Chart, Table, panels

F32, F64 = NDArray[np.float32], NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
ONE = np.float32(1.0)
WORST = 1e8  # what is not finite is drawn here


def make(quick: bool) -> Chart:
    count = 25 if quick else 241
    figure, axes = panels('Error relative to double: as written, in 32 bits (red), and by the kernels (blue)', 2, 4)
    drawn = (
        lambda panel: distribution(panel, 'GGX', count),
        lambda panel: distribution(panel, 'BECKMANN', count),
        lambda panel: distribution(panel, 'BLINN_PHONG', count),
        lambda panel: masking(panel, count),
        lambda panel: phong(panel, count),
        lambda panel: shininess(panel, count),
        lambda panel: index_near_one(panel, count),
        lambda panel: critical_angle(panel, count),
    )
    rows = [draw(panel) for draw, panel in zip(drawn, axes, strict=True)]
    head = ('where', 'worst as written', 'not finite', 'worst by the kernels', 'what the kernels do')
    notes = ('worst: largest relative error of the finite values; not finite: share of the values',)
    return Chart('failures', [Table('failures', 'Where methods fail', head, rows, notes)], figure)


def direction(theta: F64, phi: float = 0.0) -> F64:
    """Unit vectors in single precision, held as double."""
    sine = np.sin(theta)
    vector = np.stack((sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)), axis=-1)
    return vector.astype(np.float32).astype(np.float64)


def error(found: F64, truth: F64) -> F64:
    with np.errstate(all='ignore'):
        return np.abs(found.astype(np.float64) - truth) / np.abs(truth)


def show(panel: Any, x: F64, naive: F64, ours: F64, title: str, across: str) -> tuple[float, float, float]:
    """Draws both errors; returns the worst as written, the share of it that is not finite, the worst of ours."""
    finite = np.isfinite(naive)
    for values, color in ((naive, 'tab:red'), (ours, 'tab:blue')):
        shown = np.where(np.isfinite(values), np.clip(values, 1e-9, WORST), WORST)
        panel.loglog(x, shown, color=color)
    panel.set(title=title, xlabel=across, ylabel='relative error', ylim=(1e-9, 3 * WORST))
    worst = float(naive[finite].max()) if finite.any() else float('nan')
    return worst, float(1.0 - finite.mean()), float(ours[np.isfinite(ours)].max())


def naive_half_cosine(wo: F64, wi: F64) -> F32:
    h = wo.astype(np.float32) + wi.astype(np.float32)
    return h[:, 2] / np.sqrt((h * h).sum(axis=-1))


def distribution(panel: Any, kind: str, count: int) -> tuple[Any, ...]:
    """D at a half vector as far from the normal as the highlight is wide, as roughness goes to 0."""
    roughness = np.geomspace(1e-4, 1.0, count)
    viewer = 0.5
    tilt = np.minimum(roughness**2, 0.3)
    wo, wi = direction(np.full(count, viewer), np.pi), direction(viewer + 2.0 * tilt)
    truth, ours, naive = (np.zeros(count) for _ in range(3))
    for k in range(count):
        settings = DEFAULTS | {
            'model': 'COOK_TORRANCE',
            'distribution': kind,
            'roughness': float(np.float32(roughness[k])),
        }
        h = formulas.half_vector(wo[k], wi[k])
        with np.errstate(all='ignore'):
            # 1 - nh² by sines: in 53 bits the cosine alone has no digits left for roughness 1e-4.
            truth[k] = stable_distribution(kind, settings['roughness'] ** 2, float(h[0] ** 2 + h[1] ** 2))
        ours[k] = terms(settings, wo[k], wi[k])[0][0]
    naive = naive_distribution(kind, roughness.astype(np.float32), naive_half_cosine(wo, wi))
    mirror = ours == 0.0
    ours_error = np.where(mirror, np.nan, error(ours, truth))
    measured = show(panel, roughness, error(naive, truth), np.where(mirror, 1e-9, ours_error), f'D {kind}', 'roughness')
    if mirror.any():
        panel.axvspan(roughness[0], roughness[mirror].max(), color='tab:blue', alpha=0.12)
    told = f'1 - nh² as a squared sine; a mirror up to roughness {roughness[mirror].max():.2g} (shaded)'
    return f'D {kind}, roughness to 1e-4', *measured[:2], float(np.nanmax(ours_error)), told


def stable_distribution(kind: str, a: float, sin2: float) -> float:
    if kind == 'GGX':
        return a**2 / (np.pi * (a**2 + (1.0 - a**2) * sin2) ** 2)
    if kind == 'BECKMANN':
        return np.exp(-sin2 / (a**2 * (1.0 - sin2))) / (np.pi * a**2 * (1.0 - sin2) ** 2)
    return np.exp((1.0 / a**2 - 1.0) * np.log1p(-sin2)) / (np.pi * a**2)


def naive_distribution(kind: str, roughness: F32, nh: F32) -> F32:
    """As models.md and the papers write it."""
    a2, pi = roughness**4, np.float32(np.pi)
    with np.errstate(all='ignore'):
        if kind == 'GGX':
            return a2 / (pi * (ONE + nh * nh * (a2 - ONE)) ** 2)
        if kind == 'BECKMANN':
            return np.exp((nh * nh - ONE) / (a2 * nh * nh)) / (pi * a2 * nh**4)
        p = np.float32(2.0) / a2 - np.float32(2.0)
        return (p + np.float32(2.0)) / (np.float32(2.0) * pi) * nh**p


def masking(panel: Any, count: int) -> tuple[Any, ...]:
    """f cos as both directions go to the horizon: 1 / (4 nv nl) and Lambda's 1 / t² grow beyond all bounds."""
    cosine = np.geomspace(1e-20, 1.0, count)[:-1]
    theta = np.pi / 2 - np.arcsin(cosine)
    wo, wi = direction(theta), direction(theta, 2.0)
    wo[:, 2] = wi[:, 2] = cosine.astype(np.float32)
    nv, a = cosine.astype(np.float32), np.float32(0.25)
    with np.errstate(all='ignore'):
        t = nv / (a * np.sqrt(ONE - nv * nv))
        naive_lambda = (-ONE + np.sqrt(ONE + ONE / (t * t))) / np.float32(2.0)
        naive = ONE / (ONE + naive_lambda + naive_lambda) / (np.float32(4.0) * nv * nv)
    worst = np.zeros(len(cosine))
    truth = 1.0 / (1.0 + 2.0 * smith_lambda(wo[:, 2], 0.25)) / (4.0 * wo[:, 2] ** 2)
    for kind in ('SMITH_CORRELATED', 'SMITH', 'COOK_TORRANCE', 'SCHLICK_GGX'):
        settings = DEFAULTS | {'model': 'COOK_TORRANCE', 'masking': kind, 'metallic': 1.0}
        found = sum(evaluate(settings, wo, wi))[:, 0]
        with np.errstate(all='ignore'):
            expected = formulas.f_cos(settings, UP, wo, wi)[:, 0]
        # In double precision the formulas as written hold down to cosines of 1e-7, where 1 + 1 / t² is 1 / t².
        known = cosine > 1e-7
        worst = np.maximum(worst, np.where(known, error(found, np.where(known, expected, 1.0)), 0.0))
        worst[~np.isfinite(found)] = np.inf
    measured = show(
        panel, cosine, error(naive, truth), np.maximum(worst, 1e-9), 'G toward the horizon, all four', 'nv = nl'
    )
    return 'G, nv and nl to 1e-20', *measured, 'G / (4 nv) with n·s Λ(s), which is finite; the cosine cancels 1 / nl'


def smith_lambda(cosine: F64, a: float) -> F64:
    slope2 = a * a * (1.0 - cosine**2) / cosine**2
    return slope2 / (2.0 * (1.0 + np.sqrt(1.0 + slope2)))


def phong(panel: Any, count: int) -> tuple[Any, ...]:
    """Classic Phong's f = ks (r·v)^n / nl has no bound; times the cosine it has."""
    cosine = np.geomspace(1e-45, 1.0, count)[:-1]
    wi = direction(np.pi / 2 - np.arcsin(cosine))
    wi[:, 2] = cosine.astype(np.float32)
    wo = direction(np.array([1.2]), np.pi)
    settings = DEFAULTS | {'model': 'PHONG', 'kd': 0.0}
    found = sum(evaluate(settings, wo, wi))[:, 0]
    nl = cosine.astype(np.float32)
    highlight = (found / settings['ks']).astype(np.float32)
    with np.errstate(all='ignore'):
        naive = np.float32(settings['ks']) * highlight / nl * nl
    truth = formulas.f_cos(settings, UP, wo, np.where(wi[:, 2:] > 0.0, wi, UP))[:, 0]
    known = wi[:, 2] > 0.0
    measured = show(
        panel,
        cosine,
        np.where(known, error(naive, truth), np.inf),
        np.where(known, error(found, truth), 1e-9),
        'Classic Phong: 1 / nl',
        'nl',
    )
    return 'Phong, nl to 0', *measured, 'f cos is evaluated, so that nl is never divided by'


def shininess(panel: Any, count: int) -> tuple[Any, ...]:
    """cos^n for large n, where the cosine is next to 1: powf of a rounded cosine, against a squared sine's log1p."""
    exponent = np.geomspace(1.0, 1e7, count)
    wo = direction(np.full(count, 0.6), np.pi)
    wi = direction(0.6 + 1.0 / np.sqrt(exponent) * 0.5)
    truth, ours = np.zeros(count), np.zeros(count)
    for k in range(count):
        settings = DEFAULTS | {
            'model': 'BLINN_PHONG',
            'kd': 0.0,
            'ks': 1.0,
            'shininess': float(np.float32(exponent[k])),
        }
        h = formulas.half_vector(wo[k], wi[k])
        truth[k] = np.exp(0.5 * settings['shininess'] * np.log1p(-(h[0] ** 2 + h[1] ** 2)))
        ours[k] = sum(evaluate(settings, wo[k], wi[k]))[0, 0]
    naive = naive_half_cosine(wo, wi) ** exponent.astype(np.float32)
    measured = show(panel, exponent, error(naive, truth), error(ours, truth), 'Blinn-Phong: (n·h)^n', 'shininess')
    return 'shininess to 1e7', *measured, '(1 - sin²)^(n/2) by a logarithm of what is taken from 1'


def index_near_one(panel: Any, count: int) -> tuple[Any, ...]:
    """F of a dielectric whose index goes to 1: a difference of cosines that are nearly equal."""
    excess = np.geomspace(1e-6, 1.0, count)
    ior = (1.0 + excess).astype(np.float32).astype(np.float64)
    cosine = 0.7
    wo = direction(np.array([np.arccos(cosine)]))
    wi = wo * [[-1.0, -1.0, 1.0]]
    c = float(wo[0, 2])
    g = np.sqrt(ior**2 - 1.0 + c * c)
    # (c - g)(c + g) = 1 - ior², so that the difference is never formed.
    s = (1.0 - ior) * (1.0 + ior) / (c + g) ** 2
    p = (ior**2 * c - g) / (ior**2 * c + g)
    truth = 0.5 * (s**2 + p**2)
    ours = [
        terms(DEFAULTS | {'model': 'COOK_TORRANCE', 'fresnel': 'DIELECTRIC', 'ior': float(n)}, wo, wi)[2][0, 0]
        for n in ior
    ]
    n32, c32 = ior.astype(np.float32), np.float32(c)
    g32 = np.sqrt(n32 * n32 - ONE + c32 * c32)
    naive = np.float32(0.5) * (
        ((c32 - g32) / (c32 + g32)) ** 2 + ((n32 * n32 * c32 - g32) / (n32 * n32 * c32 + g32)) ** 2
    )
    measured = show(panel, excess, error(naive, truth), error(np.array(ours), truth), 'Dielectric F: η to 1', 'η - 1')
    return 'η to 1', *measured, 'the same formula; F itself is below 1e-6 where it has no digits, and 0 at 1'


def critical_angle(panel: Any, count: int) -> tuple[Any, ...]:
    """Inside glass: beyond the critical angle the square root's argument is negative."""
    ior = float(np.float32(1.0 / 1.5))
    critical = np.arcsin(ior)
    beyond = np.concatenate((-np.geomspace(1e-6, 0.5, count)[::-1], np.geomspace(1e-6, 0.5, count)))
    wo = direction(critical + beyond)
    wi = wo * [[-1.0, -1.0, 1.0]]
    settings = DEFAULTS | {'model': 'COOK_TORRANCE', 'fresnel': 'DIELECTRIC', 'ior': ior}
    truth = formulas.fresnel(settings, wo[:, 2:])[:, 0]
    ours = terms(settings, wo, wi)[2][:, 0]
    c, n2 = wo[:, 2].astype(np.float32), np.float32(ior) * np.float32(ior)
    with np.errstate(all='ignore'):
        g = np.sqrt(n2 - ONE + c * c)
        naive = np.float32(0.5) * (((c - g) / (c + g)) ** 2 + ((n2 * c - g) / (n2 * c + g)) ** 2)
    degrees = np.degrees(critical + beyond)
    measured = show(
        panel, degrees, error(naive, truth), error(ours, truth), 'Total internal reflection', 'angle inside, degrees'
    )
    panel.set_xscale('linear')
    return 'critical angle', *measured, 'the root of what is below 0 is 0: both fractions are then 1'
