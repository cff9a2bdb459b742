# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of the reflection models: D, G and F, and f cos of each model, over roughness, angle and index of refraction.

The directions are the same single-precision vectors for both sides, so that what is shown is the arithmetic's error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from charting import formulas
from charting.failures import UP, stable_distribution
from charting.kernels import DEFAULTS, evaluate, terms
from charting.stability import Axis, Map, relative, steps

F64 = NDArray[np.float64]
HEIGHT = (0.1, 90.0)  # angles from the normal of 0 to 89.9 degrees
# kernels/microfacet.h: where alpha² is at most 2e-10, roughness at most 0.00376, a surface is a mirror, as in Cycles.
SHARPEST = 0.0038
MIRROR = 'below roughness 0.0038 (grey) it is a mirror, as in Cycles: the highlight is narrower than 3 seconds of arc'


def maps(count: int) -> list[Map]:
    return [
        *(distribution(kind, count) for kind in ('GGX', 'BECKMANN', 'BLINN_PHONG')),
        *(masking(kind, count) for kind in ('SMITH_CORRELATED', 'SMITH', 'COOK_TORRANCE', 'SCHLICK_GGX')),
        dielectric(count),
        inside_dielectric(count),
        *(fresnel(kind, count) for kind in ('SCHLICK', 'F82')),
        conductor(count),
        *(cook_torrance(kind, count) for kind in ('GGX', 'BECKMANN')),
        *(oren_nayar(form, count) for form in ('QUALITATIVE', 'ENERGY_PRESERVING')),
        *(phong(model, count) for model in ('PHONG', 'BLINN_PHONG')),
        mirror_edge(count),
    ]


def angles(count: int) -> Axis:
    """Of the viewer, 90 degrees less its angle from the normal."""
    return Axis('degrees above the horizon', steps(1e-5, 90.0, count, *HEIGHT), HEIGHT)


def roughnesses(count: int) -> Axis:
    return Axis('roughness', single(steps(1e-4, 1.0, count, 0.001, SHARPEST)), (SHARPEST, 1.0))


def single(vectors: F64) -> F64:
    """Rounded to single precision."""
    return vectors.astype(np.float32).astype(np.float64)


def viewers(heights: F64) -> F64:
    """Unit vectors; the cosine is exact down to the horizon."""
    theta = np.radians(heights)
    return single(np.stack((-np.cos(theta), 0.0 * theta, np.sin(theta)), axis=-1))


def mirrored(wo: F64, tilt: float) -> F64:
    """Where a facet sends light that is tilted sideways by `tilt`: the light is as high as the viewer, about."""
    h = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    wi = 2.0 * (wo @ h)[:, None] * h - wo
    return single(wi / np.linalg.norm(wi, axis=-1, keepdims=True))


def sine2(wo: F64, wi: F64) -> F64:
    """Squared sine of the half vector's angle, which 53 bits hold where its cosine is 1."""
    h = wo + wi
    return (h[:, 0] ** 2 + h[:, 1] ** 2) / (h**2).sum(axis=-1)


def distribution(kind: str, count: int) -> Map:
    """D at a half vector as far from the normal as the highlight is wide."""
    x, y = roughnesses(count), angles(count)
    error = np.zeros((len(y.values), len(x.values)))
    wo = viewers(y.values)
    for i, roughness in enumerate(x.values):
        wi = mirrored(wo, min(roughness**2, 0.3))
        settings = {'model': 'COOK_TORRANCE', 'distribution': kind, 'roughness': float(roughness)}
        truth = np.array([stable_distribution(kind, roughness**2, s) for s in sine2(wo, wi)])
        found = terms(settings, wo, wi)[0]
        error[:, i] = np.where((wi[:, 2] > 0.0) & (found != 0.0), relative(found, truth), np.nan)
    return Map(f'D {kind}', x, y, error, MIRROR)


def term_map(name: str, settings: dict[str, Any], which: int, count: int, told: str) -> Map:
    x, y = roughnesses(count), angles(count)
    wo = viewers(y.values)
    error = np.zeros((len(y.values), len(x.values)))
    for i, roughness in enumerate(x.values):
        wi = mirrored(wo, min(roughness**2, 0.3))
        values = DEFAULTS | settings | {'model': 'COOK_TORRANCE', 'roughness': float(roughness)}
        h = formulas.half_vector(wo, wi)
        with np.errstate(all='ignore'):
            truth = formulas.masking(values, UP, wo, wi, h)[:, 0]
        found = terms(values, wo, wi)[which]
        mirror = terms(values, wo, wi)[0] == 0.0
        error[:, i] = np.where((wi[:, 2] > 0.0) & ~mirror, relative(found, truth), np.nan)
    return Map(name, x, y, error, told)


def masking(kind: str, count: int) -> Map:
    return term_map(f'G {kind}', {'masking': kind}, 1, count, MIRROR)


def fresnel_map(name: str, settings: dict[str, Any], x: Axis, key: str, count: int, told: str) -> Map:
    y = angles(count)
    wo = viewers(y.values)
    wi = wo * [[-1.0, -1.0, 1.0]]
    error = np.zeros((len(y.values), len(x.values)))
    for i, value in enumerate(x.values):
        rounded = float(np.float32(value))
        given = rounded if key == 'ior' else (rounded,) * 3
        values = DEFAULTS | settings | {'model': 'COOK_TORRANCE', key: given}
        with np.errstate(all='ignore'):
            truth = formulas.fresnel(values, wo[:, 2:])[:, 0] * np.ones(len(wo))
        error[:, i] = relative(terms(values, wo, wi)[2][:, 0], truth)
    return Map(name, x, y, error, told)


def dielectric(count: int) -> Map:
    x = Axis('index of refraction - 1', steps(1e-6, 10.0, count, 0.01), (0.01, 10.0))
    y = angles(count)
    wo = viewers(y.values)
    wi = wo * [[-1.0, -1.0, 1.0]]
    error = np.zeros((len(y.values), len(x.values)))
    for i, excess in enumerate(x.values):
        ior = float(np.float32(1.0 + excess))
        c = wo[:, 2]
        inside = np.sqrt((ior - 1.0) * (ior + 1.0) + c * c)
        # (c - g)(c + g) = 1 - n², so that the difference is never formed.
        s = (1.0 - ior) * (1.0 + ior) / (c + inside) ** 2
        p = (ior**2 * c - inside) / (ior**2 * c + inside)
        truth = 0.5 * (s**2 + p**2)
        values = {'model': 'COOK_TORRANCE', 'fresnel': 'DIELECTRIC', 'ior': ior}
        error[:, i] = relative(terms(values, wo, wi)[2][:, 0], truth)
    told = 'next to 1 the two cosines differ by their rounding; F, and with it what a pixel may lose, is below 3e-5'
    return Map('F DIELECTRIC', x, y, error, told)


def inside_dielectric(count: int) -> Map:
    """From the denser side, past the critical angle: F is 1 there, and falls with a vertical tangent before it."""
    x = Axis('1 - index of refraction', steps(1e-4, 0.9, count, 0.01), (0.01, 0.9))
    y = angles(count)
    wo = viewers(y.values)
    wi = wo * [[-1.0, -1.0, 1.0]]
    error = np.zeros((len(y.values), len(x.values)))
    for i, lack in enumerate(x.values):
        ior = float(np.float32(1.0 - lack))
        c = wo[:, 2]
        g2 = (ior - 1.0) * (ior + 1.0) + c * c
        g = np.sqrt(np.maximum(g2, 0.0))
        s = (1.0 - ior) * (1.0 + ior) / (c + g) ** 2
        p = (ior**2 * c - g) / (ior**2 * c + g)
        truth = np.where(g2 <= 0.0, 1.0, 0.5 * (s**2 + p**2))
        values = {'model': 'COOK_TORRANCE', 'fresnel': 'DIELECTRIC', 'ior': ior}
        error[:, i] = relative(terms(values, wo, wi)[2][:, 0], truth)
    told = 'next to 1 the two cosines differ by their rounding, as from the other side'
    return Map('F DIELECTRIC from inside', x, y, error, told)


def mirror_edge(count: int) -> Map:
    """What it costs that so smooth a surface is a mirror: of a sharp edge in a picture, as a share of its contrast.

    A GGX lobe turns the edge into (1 + t / sqrt(4 alpha² + t²)) / 2 at an angle t from it; the pixel filter
    (Blackman-Harris, 1.5 pixels wide) weighs the difference from a step. The worst of all places of the edge.
    """
    x = Axis('roughness', steps(1e-4, SHARPEST, count, 0.001), (1e-4, 0.001))
    y = Axis('angle of a pixel (degrees)', steps(1e-3, 1.0, count, 0.015), (0.015, 1.0))
    half = 0.75
    offsets = np.linspace(0.0, 0.75, 61)

    def kernel(at: F64) -> F64:
        phase = 2.0 * np.pi * np.clip(at / (2.0 * half) + 0.5, 0.0, 1.0)
        return 0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase)

    whole = np.trapezoid(kernel(np.linspace(-half, half, 2001)), np.linspace(-half, half, 2001))
    wide = np.concatenate([-np.geomspace(2.0, 1e-9, 400), np.geomspace(1e-9, 2.0, 400)])
    error = np.zeros((len(y.values), len(x.values)))
    for j, pixel in enumerate(np.radians(y.values)):
        for i, roughness in enumerate(x.values):
            width = 2.0 * roughness**2 / pixel  # 2 alpha, in pixels
            change = 0.5 * (wide / np.sqrt(width**2 + wide**2) - np.sign(wide))
            moved = [np.trapezoid(kernel(wide - o) * change, wide) / whole for o in offsets]
            error[j, i] = np.abs(moved).max()
    told = (
        'above roughness 0.001, and in pixels of less than 0.015 degrees, an edge in the mirror is sharper than '
        'it should be; lamps without size are not seen in it at any roughness below 0.0038, as in Cycles'
    )
    return Map('Mirror instead of a lobe', x, y, error, told, measure='change of an edge over its contrast')


def fresnel(kind: str, count: int) -> Map:
    x = Axis('F0', steps(1e-6, 1.0, count), (1e-4, 1.0))
    return fresnel_map(f'F {kind}', {'fresnel': kind, 'f0_mode': 'COLOR'}, x, 'f0', count, 'nothing fails')


def conductor(count: int) -> Map:
    x = Axis('extinction k', steps(1e-4, 1e4, count), (1e-2, 100.0))
    settings = {'fresnel': 'CONDUCTOR', 'conductor_n': (0.2,) * 3}
    return fresnel_map(
        'F CONDUCTOR, n 0.2', settings, x, 'conductor_k', count, 'at 100 and more F is 1 but for a rounding'
    )


def model_map(name: str, settings: dict[str, Any], x: Axis, key: str, tilts: F64, count: int, told: str) -> Map:
    """f cos of a model; tilts: of the facet, for each x."""
    y = angles(count)
    wo = viewers(y.values)
    error = np.zeros((len(y.values), len(x.values)))
    for i, value in enumerate(x.values):
        wi = mirrored(wo, float(tilts[i]))
        values = DEFAULTS | settings | {key: float(np.float32(value))}
        truth = stable_f_cos(values, wo, wi)
        mirror = values['model'] == 'COOK_TORRANCE' and terms(values, wo, wi)[0] == 0.0
        error[:, i] = np.where(
            (wi[:, 2] > 0.0) & ~np.asarray(mirror), relative(sum(evaluate(values, wo, wi))[:, 0], truth), np.nan
        )
    return Map(name, x, y, error, told)


def stable_f_cos(values: dict[str, Any], wo: F64, wi: F64) -> F64:
    """formulas.f_cos, whose D loses in 53 bits what narrow highlights need.

    What is meant by vectors that are rounded to single precision are unit ones: of Phong's highlights their length
    would be raised to the power of the shininess.
    """
    if values['model'] == 'COOK_TORRANCE':
        h = formulas.half_vector(wo, wi)
        d = np.array([stable_distribution(values['distribution'], values['roughness'] ** 2, s) for s in sine2(wo, wi)])
        f = formulas.fresnel(values, formulas.dot(wo, h))[:, 0]
        with np.errstate(all='ignore'):
            g = formulas.masking(values, UP, wo, wi, h)[:, 0]
        diffuse = formulas.base(values)[0] / np.pi * (1.0 - values['metallic'])
        return (1.0 - f) * diffuse * wi[:, 2] + d * f * g / (4.0 * wo[:, 2])
    if values['model'] in ('PHONG', 'BLINN_PHONG'):
        wo, wi = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (wo, wi))
    return formulas.f_cos(values, UP, wo, wi)[:, 0]


def cook_torrance(kind: str, count: int) -> Map:
    x = roughnesses(count)
    tilts = np.minimum(x.values**2, 0.3)
    return model_map(
        f'Cook-Torrance, {kind}',
        {'model': 'COOK_TORRANCE', 'distribution': kind, 'metallic': 1.0},
        x,
        'roughness',
        tilts,
        count,
        MIRROR,
    )


def oren_nayar(form: str, count: int) -> Map:
    x = Axis('sigma (radians)', np.linspace(0.0, np.pi / 2, count), (0.0, np.pi / 2), log=False)
    settings = {'model': 'OREN_NAYAR', 'oren_nayar_form': form}
    told = 'next to the horizon the small cosine is a difference of vectors'
    return model_map(f'Oren-Nayar, {form}', settings, x, 'oren_nayar_sigma', np.full(count, 0.3), count, told)


def phong(model: str, count: int) -> Map:
    x = Axis('shininess', steps(1.0, 1e7, count, 1e6), (1.0, 1e6))
    settings = {'model': model, 'ks': 1.0, 'kd': 0.0}
    tilts = 0.5 / np.sqrt(x.values)
    told = 'beyond the largest shininess that there is to set, the mirrored direction has too few digits'
    name = f'{model.replace("_", "-").title()} highlight'
    return model_map(name, settings, x, 'shininess', tilts, count, told)
