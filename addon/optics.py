# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel's equations for the presets: from n and k to the colors that models without n and k reflect.

The kernels have their own; this runs once, when a preset is chosen.
"""

from __future__ import annotations

import math


def perpendicular(n: float, k: float = 0.0) -> float:
    """F0: the part of perpendicular light that a surface with refractive index n + ik reflects."""
    return ((n - 1.0) ** 2 + k * k) / ((n + 1.0) ** 2 + k * k)


def conductor(cosine: float, n: float, k: float) -> float:
    """The part of unpolarised light that a metal reflects at an angle (Born and Wolf, Principles of Optics, 14.4.1).

    With the complex t = sqrt((n + ik)² - sin²): r_s = (cos - t) / (cos + t), r_p = r_s (t cos - sin²) / (t cos + sin²).
    """
    sine2 = 1.0 - cosine * cosine
    t = (complex(n, k) ** 2 - sine2) ** 0.5
    s = (cosine - t) / (cosine + t)
    p = s * (t * cosine - sine2) / (t * cosine + sine2)
    return (abs(s) ** 2 + abs(p) ** 2) / 2.0


def edge_tint(n: float, k: float) -> float:
    """F82's tint: the metal's reflection at cos = 1/7, over that of Schlick's formula with the same F0."""
    cosine = 1.0 / 7.0
    f0 = perpendicular(n, k)
    return min(conductor(cosine, n, k) / (f0 + (1.0 - f0) * (1.0 - cosine) ** 5), 1.0)


def shininess(roughness: float, half_vector: bool) -> float:
    """The exponent whose highlight is as wide as microfacets of that roughness: 2 / a² - 2 about the half vector.

    About the mirrored direction, which turns twice as fast, a quarter of it.
    """
    exponent = max(2.0 / max(roughness, 1e-3) ** 4 - 2.0, 0.0)
    return exponent if half_vector else exponent / 4.0


def mean(values: tuple[float, ...]) -> float:
    return math.fsum(values) / len(values)
