# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sky Texture: pictures of scattered light with a sun before them, and formulas of Preetham and of Hosek, as ops.

How light is scattered is native/sky.cpp's.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import native
from ..export.buffers import EXTENSION_EXTEND, INTERPOLATION_LINEAR
from .nodes_texture import coordinates
from .reader import Node, value
from .tree import ADD, DIVIDE, MULTIPLY, SUBTRACT, VECTOR_ADD, VECTOR_MULTIPLY, VECTOR_NORMALIZE, Ref

# More numbers of operations of the nodes Math and Vector Math.
MINIMUM, MAXIMUM, LESS, GREATER, ABSOLUTE = 12, 13, 15, 16, 18
SINE, COSINE, ARCSINE, ARCCOSINE, ARCTAN2 = 4, 5, 7, 8, 19
FRACTION, SQUARE_ROOT, SIGN, EXPONENT = 22, 23, 25, 26
VECTOR_DOT, VECTOR_DISTANCE, VECTOR_MAXIMUM = 7, 8, 19

EARTH = 6371000.0  # radius, metres
SMALLEST_SUN = 0.0005  # angle across; Cycles takes no less
LIMB = 0.6  # by how much the sun's edge is darker than its middle

XYZ_TO_REC709 = (
    (3.2409699, -1.5373832, -0.4986108, 0.0),
    (-0.9692436, 1.8759675, 0.0415551, 0.0),
    (0.0556301, -0.2039770, 1.0569715, 0.0),
)


@dataclass(frozen=True, slots=True)
class Calculator:
    """Ops by their signs."""

    node: Node

    def number(self, x: float | Ref) -> Ref:
        return self.node.constant(float(x)) if isinstance(x, float) else x

    def math(self, operation: int, a: float | Ref, b: float | Ref = 0.0) -> Ref:
        return self.node.builder.math(operation, self.number(a), self.number(b))

    def times(self, a: float | Ref, b: float | Ref) -> Ref:
        return self.math(MULTIPLY, a, b)

    def plus(self, a: float | Ref, b: float | Ref) -> Ref:
        return self.math(ADD, a, b)

    def minus(self, a: float | Ref, b: float | Ref) -> Ref:
        return self.math(SUBTRACT, a, b)

    def vector(self, operation: int, a: Ref, b: Ref) -> Ref:
        zero = self.node.constant(0.0)
        return self.node.emit('vector_math_v', a, b, zero, zero, mode=operation)

    def of_vectors(self, operation: int, a: Ref, b: Ref) -> Ref:
        """A number."""
        zero = self.node.constant(0.0)
        return self.node.emit('vector_math_f', a, b, zero, zero, mode=operation)

    def component(self, a: Ref, axis: int) -> Ref:
        return self.node.emit('component', a, mode=axis)


@value('ShaderNodeTexSky')
def _sky(node: Node, output: str) -> Ref:
    match node.node.sky_type:
        case 'PREETHAM':
            return _preetham(node)
        case 'HOSEK_WILKIE':
            return _hosek_wilkie(node)
    return _scattered(node)


# ---- Scattered light, and the sun.


def sun_position(elevation: float, rotation: float) -> tuple[float, float]:
    """Elevation from -90° to 90°, and the angle from +x to the sun's azimuth and a quarter on, as Cycles wraps them."""
    elevation = math.remainder(elevation, 2.0 * math.pi)
    if abs(elevation) > 0.5 * math.pi:
        elevation = math.copysign(math.pi, elevation) - elevation
        rotation += math.pi
    return elevation, -math.remainder(rotation, 2.0 * math.pi)


def _finite(node: Node, name: str) -> float:
    found = float(getattr(node.node, name))
    if math.isfinite(found):
        return found
    node.warn(f'{node.node.bl_rna.properties[name].name} is not a finite number: its default is used')
    return float(node.node.bl_rna.properties[name].default)


def _scattered(node: Node) -> Ref:
    own, c = node.node, Calculator(node)
    multiple = own.sky_type == 'MULTIPLE_SCATTERING'
    elevation, rotation = sun_position(_finite(node, 'sun_elevation'), _finite(node, 'sun_rotation'))
    size = max(_finite(node, 'sun_size'), SMALLEST_SUN)
    altitude = _finite(node, 'altitude')
    aerosol = 'aerosol_density' if hasattr(own, 'aerosol_density') else 'dust_density'  # 4.5's name
    densities = [_finite(node, name) for name in ('air_density', aerosol, 'ozone_density')]
    made: list[tuple] = []  # at most one

    def sky() -> tuple:
        if not made:
            made.append(native.load().sky(multiple, elevation, size, altitude, *densities))
        return made[0]

    key = ('sky', multiple, elevation, altitude, *densities)
    image = node.reader.scene.images.computed('Sky', key, lambda: sky()[0])

    # 1. The place in the picture.
    direction = coordinates(node)
    x, y, z = (c.component(direction, axis) for axis in range(3))
    up = c.math(ARCSINE, z)
    turns = c.times(c.minus(rotation - 0.5 * math.pi, c.math(ARCTAN2, y, x)), 1.0 / (2.0 * math.pi))
    root = c.math(SQUARE_ROOT, c.times(c.math(ABSOLUTE, up), 2.0 / math.pi))
    place = node.emit(
        'combine',
        c.math(FRACTION, turns),
        c.plus(c.times(c.times(c.math(SIGN, up), root), 0.5), 0.5),
        node.constant(0.0),
    )
    mode = INTERPOLATION_LINEAR | EXTENSION_EXTEND << 2
    zero = node.constant(0.0)
    light = node.emit('image_v', place, node.constant(float(image)), zero, zero, mode=mode)
    light = c.vector(VECTOR_MAXIMUM, light, zero)
    if not own.sun_disc:
        return light

    # 2. The sun: from below to above its colour changes evenly, and it is darker at the edge.
    azimuth = rotation + 0.5 * math.pi
    flat = math.cos(elevation)
    sun = (flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation))
    _, low, high = sky()
    intensity = _finite(node, 'sun_intensity')
    if intensity == 0.0 or max(*low, *high) <= 0.0:
        return light
    if node.reader.kind == 'world' and not node.is_fed('Vector') and direction == node.at_point('position'):
        node.reader.scene.suns.append((*sun, size))
    apart = c.of_vectors(VECTOR_DISTANCE, direction, node.constant(sun))
    if _is_unit(node):
        angle = c.times(c.math(ARCSINE, c.times(apart, 0.5)), 2.0)
    else:
        opposite = c.of_vectors(VECTOR_DISTANCE, direction, node.constant(tuple(-part for part in sun)))
        angle = c.times(c.math(ARCTAN2, apart, opposite), 2.0)
    share = c.times(angle, 2.0 / size)
    horizon = math.asin(EARTH / (EARTH + max(altitude, 0.0))) - 0.5 * math.pi
    shown = c.times(c.math(LESS, share, 1.0), c.math(GREATER, up, horizon))
    inner = c.math(SQUARE_ROOT, c.math(MAXIMUM, c.minus(1.0, c.times(share, share)), 0.0))
    limb = c.plus(1.0 - LIMB, c.times(inner, LIMB))
    height = node.builder.splat(c.plus(c.times(c.minus(up, elevation), 1.0 / size), 0.5))
    across = node.constant(tuple(float(b - a) for a, b in zip(low, high, strict=True)))
    disc = c.vector(VECTOR_ADD, node.constant(tuple(map(float, low))), c.vector(VECTOR_MULTIPLY, across, height))
    disc = c.vector(VECTOR_MAXIMUM, disc, zero)
    disc = node.builder.scale(disc, c.times(c.times(shown, limb), intensity))
    return c.vector(VECTOR_ADD, light, disc)


def _is_unit(node: Node) -> bool:
    """Whether the node is sure to get directions of length 1."""
    return node.reader.kind == 'world' and not node.is_fed('Vector')


def _by_height(c: Calculator, direction: Ref) -> Ref:
    """The unit vector of a height z that has the azimuth of any vector of that z (Cycles goes through two angles)."""
    x, y, z = (c.component(direction, axis) for axis in range(3))
    z = c.math(MAXIMUM, c.math(MINIMUM, z, 1.0), -1.0)
    flat = c.math(SQUARE_ROOT, c.math(MAXIMUM, c.minus(1.0, c.times(z, z)), 0.0))
    azimuth = c.math(ARCTAN2, y, x)
    return c.node.emit('combine', c.times(flat, c.math(COSINE, azimuth)), c.times(flat, c.math(SINE, azimuth)), z)


# ---- Preetham, Shirley and Smits 1999.

# Of the five numbers of Perez's formula for Y, x and y: what the turbidity is multiplied by, and what is added.
PEREZ = np.array(
    (
        ((0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)),
        ((-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)),
        ((-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)),
    )
)
# Of x and y at the zenith: rows for T^2, T and 1, columns for the cube of the sun's zenith angle down to 1.
ZENITH = np.array(
    (
        (
            (0.00166, -0.00375, 0.00209, 0.0),
            (-0.02903, 0.06377, -0.03202, 0.00394),
            (0.11693, -0.21196, 0.06052, 0.25886),
        ),
        (
            (0.00275, -0.00610, 0.00317, 0.0),
            (-0.04214, 0.08970, -0.04153, 0.00516),
            (0.15346, -0.26756, 0.06670, 0.26688),
        ),
    )
)
LUMINANCE = 0.06  # Blender's scale
LOWEST = 0.5 * math.pi - 0.001  # zenith angle, from which on the sky stays the same


def _preetham(node: Node) -> Ref:
    c, sun = Calculator(node), _sun(node)
    theta = math.acos(min(max(float(sun[2]), -1.0), 1.0))
    scales, numbers = preetham_constants(_finite(node, 'turbidity'), theta)

    cosine, angle = _angles(node, sun)
    gamma = c.math(ARCCOSINE, cosine)
    slant = c.math(DIVIDE, 1.0, c.math(COSINE, angle))
    square = c.times(cosine, cosine)

    def perez(scale: float, a: float, b: float, g: float, d: float, e: float) -> Ref:
        first = c.plus(1.0, c.times(a, c.math(EXPONENT, c.times(b, slant))))
        second = c.plus(c.plus(1.0, c.times(g, c.math(EXPONENT, c.times(d, gamma)))), c.times(e, square))
        return c.times(scale, c.times(first, second))

    luminance, x, y = (perez(scale, *row) for scale, row in zip(scales, numbers, strict=True))
    ratio = c.math(DIVIDE, luminance, y)
    rest = c.minus(c.minus(1.0, x), y)
    return _rec709(c, node.emit('combine', c.times(x, ratio), luminance, c.times(rest, ratio)))


def _sun(node: Node) -> np.ndarray:
    """The direction to the sun."""
    sun = np.array(tuple(node.node.sun_direction), float)
    if not np.isfinite(sun).all() or not sun.any():
        node.warn('its sun has no direction: it stands in the zenith')
        sun = np.array((0.0, 0.0, 1.0))
    return sun / np.linalg.norm(sun)


def _angles(node: Node, sun: np.ndarray) -> tuple[Ref, Ref]:
    """The cosine of the angle from the sun, and the zenith angle, LOWEST at most."""
    c = Calculator(node)
    direction = coordinates(node)
    if _is_unit(node):
        direction = c.vector(VECTOR_NORMALIZE, direction, node.constant(0.0))
    else:
        direction = _by_height(c, direction)
    cosine = c.of_vectors(VECTOR_DOT, direction, node.constant(tuple(map(float, sun))))
    return cosine, c.math(MINIMUM, c.math(ARCCOSINE, c.component(direction, 2)), LOWEST)


def _rec709(c: Calculator, xyz: Ref) -> Ref:
    rows = [c.node.constant(row[:3]) for row in XYZ_TO_REC709]
    rgb = c.node.emit('affine', xyz, *rows, c.node.constant(0.0))
    return c.vector(VECTOR_MAXIMUM, rgb, c.node.constant(0.0))


def preetham_constants(turbidity: float, theta: float) -> tuple[list[float], list[list[float]]]:
    """Scales of Y, x and y, and their five numbers each. theta: the sun's zenith angle."""
    numbers = PEREZ @ np.array((turbidity, 1.0))
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * theta)
    bright = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    powers = np.array((theta**3, theta**2, theta, 1.0))
    zenith = [LUMINANCE * bright, *(np.array((turbidity**2, turbidity, 1.0)) @ ZENITH @ powers)]
    scales = []
    for at_zenith, (a, b, g, d, e) in zip(zenith, numbers, strict=True):
        above = (1.0 + a * math.exp(b)) * (1.0 + g * math.exp(d * theta) + e * math.cos(theta) ** 2)
        scales.append(float(at_zenith / above))
    return scales, [[float(number) for number in row] for row in numbers]


# ---- Hosek and Wilkie 2012, "An Analytic Model for Full Spectral Sky-Dome Radiance", equation 8.

TURBIDITIES = 10  # from 1 on


@functools.cache
def hosek_wilkie_table() -> np.ndarray:
    """(turbidity, albedo 0 and 1, XYZ, number, control point) of 10 x 2 x 3 x 10 x 6; see hosek_wilkie.csv."""
    file = Path(__file__).with_name('hosek_wilkie.csv')
    return np.loadtxt(file, delimiter=',', comments='#').reshape(TURBIDITIES, 2, 3, 10, 6)


def hosek_wilkie_constants(turbidity: float, albedo: float, elevation: float) -> np.ndarray:
    """(3, 10): for X, Y and Z the ten numbers of the formula. elevation: of the sun, radians, not below 0.

    Bezier curves of the fifth degree over the cube root of the elevation; between turbidities and albedos linear.
    """
    turbidity, albedo = min(max(turbidity, 1.0), float(TURBIDITIES)), min(max(albedo, 0.0), 1.0)
    x = min(elevation / (0.5 * math.pi), 1.0) ** (1.0 / 3.0)
    curve = np.array([math.comb(5, k) * x**k * (1.0 - x) ** (5 - k) for k in range(6)])
    low = min(int(turbidity), TURBIDITIES - 1)
    between = turbidity - low
    table = hosek_wilkie_table()
    of_turbidity = (1.0 - between) * table[low - 1] + between * table[low]
    return ((1.0 - albedo) * of_turbidity[0] + albedo * of_turbidity[1]) @ curve


def _hosek_wilkie(node: Node) -> Ref:
    c, sun = Calculator(node), _sun(node)
    if sun[2] < 0.0:  # a sun that has set stands on the horizon
        azimuth = math.atan2(sun[1], sun[0])
        sun = np.array((math.cos(azimuth), math.sin(azimuth), 0.0))
    elevation = math.asin(min(float(sun[2]), 1.0))
    numbers = hosek_wilkie_constants(_finite(node, 'turbidity'), _finite(node, 'ground_albedo'), elevation)

    cosine, angle = _angles(node, sun)
    gamma = c.math(ARCCOSINE, cosine)
    height = c.math(COSINE, angle)
    slant = c.math(DIVIDE, 1.0, c.plus(height, 0.01))
    zenith = c.math(SQUARE_ROOT, height)
    square = c.times(cosine, cosine)

    def radiance(row: np.ndarray) -> Ref:
        a, b, e, h, plain, falling, ray, mie, up, scale = (float(number) for number in row)
        first = c.plus(1.0, c.times(a, c.math(EXPONENT, c.times(b, slant))))
        wide = c.minus(1.0 + h * h, c.times(2.0 * h, cosine))
        glow = c.math(DIVIDE, c.plus(1.0, square), c.times(wide, c.math(SQUARE_ROOT, wide)))
        second = c.plus(plain, c.times(falling, c.math(EXPONENT, c.times(e, gamma))))
        second = c.plus(second, c.times(ray, square))
        second = c.plus(second, c.plus(c.times(mie, glow), c.times(up, zenith)))
        return c.times(scale, c.times(first, second))

    return _rec709(c, node.emit('combine', *(radiance(row) for row in numbers)))
