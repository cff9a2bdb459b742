# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums of shaders as one Principled BSDF: the algebra behind Mix and Add Shader.

It knows no node and no Blender; surface.py reads the trees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

Color = tuple[float, ...]  # three, scene-linear

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Bsdf:
    """The constants of a Principled BSDF without emission and alpha; the defaults are a new material's."""

    base_color: Color = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 0.5
    ior: float = 1.5
    specular_level: float = 0.5
    specular_tint: Color = WHITE
    multi_ggx: bool = True

    @property
    def is_diffuse(self) -> bool:
        return self.metallic == 0.0 and self.specular_level == 0.0


def diffuse(color: Color) -> Bsdf:
    """A Diffuse BSDF: its surface does not reflect, so F0 = 0."""
    return Bsdf(base_color=color, ior=1.0, specular_level=0.0, roughness=1.0)


@dataclass(frozen=True, slots=True)
class Closure:
    """A weighted sum: transparency × what lies behind + emission + weight × bsdf. Black by default."""

    transparency: float = 0.0
    emission: Color = BLACK
    weight: float = 0.0
    bsdf: Bsdf | None = None


def scale(closure: Closure, factor: float) -> Closure:
    emission = tuple(part * factor for part in closure.emission)
    return Closure(closure.transparency * factor, emission, closure.weight * factor, closure.bsdf)


def add(a: Closure, b: Closure, warn: Callable[[str], None]) -> Closure:
    """The sum of two closures; of two BSDFs that make no one BSDF, the heavier one with the weight of both."""
    weight = a.weight + b.weight
    heavy, light = (a, b) if a.weight >= b.weight else (b, a)
    bsdf = heavy.bsdf
    if light.weight > 0.0 and light.bsdf != heavy.bsdf:
        assert heavy.bsdf is not None and light.bsdf is not None  # what has weight has a BSDF
        if heavy.bsdf.is_diffuse and light.bsdf.is_diffuse:
            parts = zip(heavy.bsdf.base_color, light.bsdf.base_color, strict=True)
            bsdf = diffuse(tuple((h * heavy.weight + s * light.weight) / weight for h, s in parts))
        else:
            warn('a mix of two BSDFs is not supported yet: only the stronger one is used')
    emission = tuple(x + y for x, y in zip(a.emission, b.emission, strict=True))
    return Closure(a.transparency + b.transparency, emission, weight, bsdf)


def principled(closure: Closure, warn: Callable[[str], None]) -> tuple[Bsdf, Color, float]:
    """A closure as Principled BSDF: its constants, emission and alpha.

    Principled is (1 - alpha) × what lies behind + alpha × (emission + bsdf). So alpha is 1 - transparency, the emission
    is divided by it, and a BSDF whose weight is not alpha must be diffuse, where the weight goes into the colour.
    """
    alpha = min(max(1.0 - closure.transparency, 0.0), 1.0)
    bsdf = closure.bsdf if closure.bsdf is not None and closure.weight > 0.0 else diffuse(BLACK)
    if alpha == 0.0:
        if any(closure.emission):
            warn('emission of a fully transparent surface is not supported yet: left out')
        return bsdf, BLACK, 0.0
    weight = closure.weight / alpha
    if bsdf.is_diffuse:
        bsdf = replace(bsdf, base_color=tuple(part * weight for part in bsdf.base_color))
    elif abs(weight - 1.0) > 1e-4:
        warn('a part of a glossy BSDF is not supported yet: the whole is used')
    return bsdf, tuple(part / alpha for part in closure.emission), alpha
