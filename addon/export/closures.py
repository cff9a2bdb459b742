# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums of shaders as one Principled BSDF: the algebra behind Mix and Add Shader.

It knows no node and no Blender; surface.py reads the trees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from .textures import BLACK, WHITE, Color, NormalMap, NotAffineError, Texture, affine, constant, multiply
from .textures import add as add_textures


@dataclass(frozen=True, slots=True)
class Bsdf:
    """The inputs of a Principled BSDF without emission and alpha; the defaults are a new material's."""

    base_color: Color | Texture = (0.8, 0.8, 0.8)
    metallic: float | Texture = 0.0
    roughness: float | Texture = 0.5
    ior: float | Texture = 1.5
    specular_level: float | Texture = 0.5
    specular_tint: Color | Texture = WHITE
    multi_ggx: bool = True
    normal: NormalMap | None = None
    transmission: float = 0.0

    @property
    def is_diffuse(self) -> bool:
        return self.metallic == 0.0 and self.specular_level == 0.0 and self.transmission == 0.0


def diffuse(color: Color | Texture, normal: NormalMap | None = None) -> Bsdf:
    """A Diffuse BSDF: its surface does not reflect, so F0 = 0."""
    return Bsdf(base_color=color, ior=1.0, specular_level=0.0, roughness=1.0, normal=normal)


@dataclass(frozen=True, slots=True)
class Closure:
    """A weighted sum: transparency × what lies behind + emission + weight × bsdf. Black by default.

    cover: if not None, a texture that all of it is multiplied by; the rest of 1 shows what lies behind.
    """

    transparency: float = 0.0
    emission: Color | Texture = BLACK
    weight: float = 0.0
    bsdf: Bsdf | None = None
    cover: Texture | None = None

    @property
    def is_clear(self) -> bool:
        """Whether it shows nothing but what lies behind."""
        return self == Closure(transparency=1.0)


def scale(closure: Closure, factor: float) -> Closure:
    return replace(
        closure,
        transparency=closure.transparency * factor,
        emission=_scaled(closure.emission, factor),
        weight=closure.weight * factor,
    )


def mask(closure: Closure, cover: Texture, warn: Callable[[str], None]) -> Closure:
    """The closure where cover is 1, what lies behind where it is 0."""
    opaque = 1.0 - closure.transparency
    if closure.cover is not None:
        if cover.lookup is not None:
            warn('alpha by two textures is not supported yet: only one is used')
            return closure
        return replace(closure, cover=multiply(closure.cover, cover))
    if opaque <= 0.0:
        return closure
    inner = replace(scale(closure, 1.0 / opaque), transparency=0.0)
    return replace(inner, cover=affine(cover, opaque, 0.0))


def add(a: Closure, b: Closure, warn: Callable[[str], None]) -> Closure:
    """The sum of two closures; of two BSDFs that make no one BSDF, the heavier one with the weight of both."""
    if b == Closure() or a == Closure():
        return a if b == Closure() else b
    if a.cover is not None or b.cover is not None:
        warn('alpha by a texture in a part of a mix is not supported yet: that part is opaque')
    weight = a.weight + b.weight
    heavy, light = (a, b) if a.weight >= b.weight else (b, a)
    bsdf = heavy.bsdf
    if light.weight > 0.0 and light.bsdf != heavy.bsdf:
        assert heavy.bsdf is not None and light.bsdf is not None  # what has weight has a BSDF
        bsdf = _mixed_diffuse(heavy, light) if heavy.bsdf.is_diffuse and light.bsdf.is_diffuse else None
        if bsdf is None:
            warn('a mix of two BSDFs is not supported yet: only the stronger one is used')
            bsdf = heavy.bsdf
    emission = _sum(a.emission, b.emission)
    if emission is None:
        warn('a sum of two textures of emission is not supported yet: only one is used')
        emission = a.emission
    return Closure(a.transparency + b.transparency, emission, weight, bsdf)


def principled(closure: Closure, warn: Callable[[str], None]) -> tuple[Bsdf, Color | Texture, float | Texture]:
    """A closure as Principled BSDF: its constants, emission and alpha.

    Principled is (1 - alpha) × what lies behind + alpha × (emission + bsdf). So alpha is 1 - transparency, the emission
    is divided by it, and a BSDF whose weight is not alpha must be diffuse, where the weight goes into the colour.
    """
    alpha = min(max(1.0 - closure.transparency, 0.0), 1.0)
    bsdf = closure.bsdf if closure.bsdf is not None and closure.weight > 0.0 else diffuse(BLACK)
    if alpha == 0.0:
        if closure.emission != BLACK:
            warn('emission of a fully transparent surface is not supported yet: left out')
        return bsdf, BLACK, 0.0
    weight = closure.weight / alpha
    if bsdf.is_diffuse:
        bsdf = replace(bsdf, base_color=_scaled(bsdf.base_color, weight))
    elif abs(weight - 1.0) > 1e-4:
        warn('a part of a glossy BSDF is not supported yet: the whole is used')
    return bsdf, _scaled(closure.emission, 1.0 / alpha), alpha if closure.cover is None else closure.cover


def _mixed_diffuse(a: Closure, b: Closure) -> Bsdf | None:
    """One diffuse BSDF for two, if their colours have a sum."""
    if a.bsdf.normal != b.bsdf.normal:
        return None
    share = 1.0 / (a.weight + b.weight)
    color = _sum(_scaled(a.bsdf.base_color, a.weight * share), _scaled(b.bsdf.base_color, b.weight * share))
    return None if color is None else diffuse(color, a.bsdf.normal)


def _scaled(value: Color | Texture, factor: float) -> Color | Texture:
    if isinstance(value, Texture):
        return affine(value, factor, 0.0)
    return tuple(part * factor for part in value)


def _sum(a: Color | Texture, b: Color | Texture) -> Color | Texture | None:
    """None where the sum is no affine function of one image."""
    if not (isinstance(a, Texture) or isinstance(b, Texture)):
        return tuple(x + y for x, y in zip(a, b, strict=True))
    try:
        first, second = (value if isinstance(value, Texture) else constant(value) for value in (a, b))
        return add_textures(first, second)
    except NotAffineError:
        return None
