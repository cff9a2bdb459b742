# SPDX-License-Identifier: GPL-3.0-or-later
"""How much light each model reflects in all, in a white furnace, over roughness (or shininess) and angle of the viewer.

The kernels' own f cos is integrated over the hemisphere by a rule of its own; no kernel samples anything here.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from charting.kernels import evaluate
from charting.result import Chart, Table, panels

F64 = NDArray[np.float64]
# The rule's own error, found by doubling its points, is below this; what is above 1 by more makes energy.
TRUSTED = 2e-3
METAL = {'base_color': (1.0, 1.0, 1.0), 'metallic': 1.0}
PLASTIC = {'base_color': (1.0, 1.0, 1.0), 'metallic': 0.0}
SPECULAR_ONLY = {'kd': 0.0, 'ks': 1.0}
DISTRIBUTIONS = ('GGX', 'BECKMANN', 'BLINN_PHONG')
MASKINGS = ('SMITH_CORRELATED', 'SMITH', 'COOK_TORRANCE', 'SCHLICK_GGX')
FRESNELS = ('SCHLICK', 'DIELECTRIC', 'CONDUCTOR', 'F82')


@dataclass(frozen=True, slots=True)
class Variant:
    """axis: what x stands for: roughness, shininess or sigma."""

    name: str
    settings: dict[str, Any]
    axis: str


def variants() -> list[Variant]:
    found = [
        Variant('Lambert', {**PLASTIC, 'model': 'LAMBERT'}, 'roughness'),
        Variant('Oren-Nayar', {**PLASTIC, 'model': 'OREN_NAYAR'}, 'sigma'),
        Variant(
            'Oren-Nayar, energy preserving',
            {**PLASTIC, 'model': 'OREN_NAYAR', 'oren_nayar_form': 'ENERGY_PRESERVING'},
            'sigma',
        ),
        Variant('Toon', {'model': 'TOON', 'toon_lit': (1.0,) * 3, 'toon_shade': (1.0,) * 3}, 'roughness'),
    ]
    for name, model in (('Phong', 'PHONG'), ('Blinn-Phong', 'BLINN_PHONG')):
        for form in (False, True):
            settings = {**PLASTIC, **SPECULAR_ONLY, 'model': model, 'normalized': form}
            found.append(Variant(f'{name}{", normalized" if form else ""}, ks 1', settings, 'shininess'))
    for d in DISTRIBUTIONS:
        for g in MASKINGS:
            settings = {**METAL, 'model': 'COOK_TORRANCE', 'distribution': d, 'masking': g}
            found.append(Variant(f'D {d} G {g}, F = 1', settings, 'roughness'))
    for split in ('ENERGY', 'MIX'):
        for f in FRESNELS:
            settings = {**PLASTIC, 'model': 'COOK_TORRANCE', 'fresnel': f, 'split': split}
            if split == 'MIX':
                settings['metallic'] = 0.5
            found.append(Variant(f'F {f}, {split}, white', settings, 'roughness'))
    return found


def make(quick: bool) -> Chart:
    steps, points = (3, 24) if quick else (11, 64)
    axes_values = {
        'roughness': np.linspace(0.05, 1.0, steps),
        'shininess': np.geomspace(1.0, 1e4, steps),
        'sigma': np.linspace(0.0, np.pi / 2, steps),
    }
    angles = np.radians(
        np.array([0.0, 45.0, 85.0]) if quick else np.array([0, 15, 30, 45, 60, 70, 75, 80, 85, 88, 89.5])
    )
    shown, columns = variants(), 6
    lines = -(-len(shown) // columns)
    figure, axes = panels(
        'Albedo in a white furnace (white = 1, red: more light than arrives)',
        lines,
        columns,
        3.0,
        2.5,
    )
    rows = []
    for variant, panel in zip(shown, axes, strict=False):
        values = axes_values[variant.axis]
        found = np.array([[albedo(variant, value, angle, points) for value in values] for angle in angles])
        rows.append(row(variant, values, angles, found))
        draw(panel, variant, values, angles, found)
    for panel in axes[len(shown) :]:
        panel.axis('off')
    head = ('model', 'lowest', 'highest', 'at', 'angle', 'verdict')
    notes = (
        f'energy: more than {1 + TRUSTED:.3f} of the light that arrives, brightest channel; base color, kd, F0: white',
        'classic Phong and Blinn-Phong: ks (r·v)^n and ks (n·h)^n alone, which are known to make energy for small n',
    )
    return Chart('furnace', [Table('furnace', 'White furnace: albedo over all angles', head, rows, notes)], figure)


def albedo(variant: Variant, value: float, angle: float, points: int) -> float:
    """Of the brightest channel."""
    settings = dict(variant.settings)
    key = {'roughness': 'roughness', 'shininess': 'shininess', 'sigma': 'oren_nayar_sigma'}[variant.axis]
    settings[key] = float(value)
    # How wide the highlight is about the half vector, as GGX's alpha.
    width = {'roughness': value**2, 'shininess': np.sqrt(2.0 / (value + 2.0)), 'sigma': 1.0}[variant.axis]
    wo = np.array([np.sin(angle), 0.0, np.cos(angle)])
    directions, weights = smooth_rule(points)
    sum_of_lobes = (evaluate(settings, wo, directions)[0] * weights[:, None]).sum(axis=0)
    directions, weights = sharp_rule(wo, float(np.clip(width, 1e-3, 1.0)), points)
    sum_of_lobes += (evaluate(settings, wo, directions)[1] * weights[:, None]).sum(axis=0)
    return float(sum_of_lobes.max())


@functools.cache
def smooth_rule(points: int) -> tuple[F64, F64]:
    """For the diffuse lobe: Gauss-Legendre in the angle from the normal, equal steps around it."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    theta, step = (nodes + 1.0) * np.pi / 4, weights * np.pi / 4
    phi = (np.arange(points) + 0.5) * 2.0 * np.pi / points
    theta, phi = (values.ravel() for values in np.meshgrid(theta, phi, indexing='ij'))
    wi = np.stack((np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), axis=-1)
    return wi, np.repeat(step, points) * np.sin(theta) * 2.0 * np.pi / points


def sharp_rule(wo: F64, alpha: float, points: int) -> tuple[F64, F64]:
    """For the highlight: half vectors spread as GGX spreads them about the normal, (Walter et al. 2007, eq. 35-36)."""
    u, phi = (grid.ravel() for grid in np.meshgrid(*(2 * [(np.arange(points) + 0.5) / points])))
    phi = 2.0 * np.pi * phi
    tangent2 = alpha * alpha * u / (1.0 - u)
    cos_h = 1.0 / np.sqrt(1.0 + tangent2)
    sin_h = np.sqrt(tangent2) * cos_h
    h = np.stack((sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h), axis=-1)
    oh = h @ wo
    wi = 2.0 * oh[:, None] * h - wo
    density = alpha**2 * cos_h / (np.pi * (cos_h**2 * alpha**2 + sin_h**2) ** 2) / (4.0 * np.abs(oh))
    above = (wi[:, 2] > 0.0) & (oh > 0.0)
    return wi[above], 1.0 / (points**2 * density[above])


def row(variant: Variant, values: F64, angles: F64, found: F64) -> tuple[Any, ...]:
    at = np.unravel_index(found.argmax(), found.shape)
    energy = found.max() > 1.0 + TRUSTED
    return (
        variant.name,
        float(found.min()),
        float(found.max()),
        f'{variant.axis} {values[at[1]]:.3g}',
        f'{np.degrees(angles[at[0]]):.3g}°',
        'MAKES ENERGY' if energy else 'keeps it' if found.min() > 1.0 - TRUSTED else 'loses some',
    )


def draw(panel: Any, variant: Variant, values: F64, angles: F64, found: F64) -> None:
    degrees = np.degrees(angles)
    panel.pcolormesh(values, degrees, found, cmap='RdBu_r', vmin=0.0, vmax=2.0, shading='gouraud')
    if found.max() > 1.0 + TRUSTED:
        panel.contour(values, degrees, found, levels=[1.0 + TRUSTED], colors='black', linewidths=1.2)
    panel.set_title(f'{variant.name}\n{found.min():.2f} to {found.max():.2f}', fontsize=7)
    panel.set_xlabel(variant.axis, fontsize=7)
    panel.set_ylabel('angle of the viewer, degrees', fontsize=7)
    panel.tick_params(labelsize=6)
    if variant.axis == 'shininess':
        panel.set_xscale('log')
