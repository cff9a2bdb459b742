# SPDX-License-Identifier: GPL-3.0-or-later
"""The reflection models in double precision, as their papers write them, with nothing done for stability or speed.

Charts and tests hold the kernels against this; it shares no code with them. Settings are named as in kernels.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
Settings = dict[str, Any]


def dot(a: F64, b: F64) -> F64:
    return (a * b).sum(axis=-1, keepdims=True)


def f_cos(settings: Settings, n: F64, wo: F64, wi: F64) -> F64:
    """f(wo, wi) cos (N, 3); n, wo and wi are unit vectors (N, 3) or (3,). 0 where wi is below n."""
    nl = dot(n, wi)
    models: dict[str, Callable[[Settings, F64, F64, F64], F64]] = {
        'LAMBERT': lambda s, n, wo, wi: base(s) / np.pi * dot(n, wi),
        'OREN_NAYAR': oren_nayar,
        'PHONG': phong,
        'BLINN_PHONG': phong,
        'COOK_TORRANCE': cook_torrance,
        'TOON': toon,
    }
    with np.errstate(all='ignore'):
        found = models[settings['model']](settings, n, wo, wi)
    return np.where(nl > 0.0, found, 0.0)


def base(settings: Settings) -> F64:
    return np.array(settings['base_color'], np.float64)


def half_vector(wo: F64, wi: F64) -> F64:
    h = wo + wi
    return h / np.linalg.norm(h, axis=-1, keepdims=True)


def oren_nayar(settings: Settings, n: F64, wo: F64, wi: F64) -> F64:
    """Oren & Nayar 1994, eq. 30; or EON (Portsmouth, Kutz & Hill 2024) with roughness sigma / (pi / 2)."""
    sigma, rho = settings['oren_nayar_sigma'], base(settings)
    nl, nv = dot(n, wi), dot(n, wo)
    s = dot(wo, wi) - nl * nv  # sin sin cos(phi_i - phi_o)
    if settings['oren_nayar_form'] == 'QUALITATIVE':
        a = 1.0 - 0.5 * sigma**2 / (sigma**2 + 0.33)
        b = 0.45 * sigma**2 / (sigma**2 + 0.09)
        return rho / np.pi * (a + b * np.maximum(s, 0.0) / np.maximum(nl, nv)) * nl
    r = min(sigma / (np.pi / 2.0), 1.0)
    a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * np.pi)) * r)

    def albedo(cosine: F64) -> F64:
        theta = np.arccos(np.clip(cosine, -1.0, 1.0))
        sine = np.sin(theta)
        g = sine * (theta - sine * cosine) + 2.0 / 3.0 * (sine / cosine * (1.0 - sine**3) - sine)
        return a * (1.0 + r / np.pi * g)

    mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * np.pi)) * r)
    single = rho / np.pi * a * (1.0 + r * np.where(s > 0.0, s / np.maximum(nl, nv), s))
    lost = (1.0 - albedo(nv)) * (1.0 - albedo(nl)) / (1.0 - mean) if r > 0.0 else 0.0
    return (single + rho**2 * mean / (1.0 - rho * (1.0 - mean)) / np.pi * lost) * nl


def phong(settings: Settings, n: F64, wo: F64, wi: F64) -> F64:
    """Phong 1975, Blinn 1977: ks cos^k / nl in the classic form, ks times a norm times cos^k in the normalised one."""
    nl, k = dot(n, wi), float(settings['shininess'])
    if settings['model'] == 'PHONG':
        cosine, norm = dot(2.0 * nl * n - wi, wo), (k + 2.0) / (2.0 * np.pi)
    else:
        cosine = dot(n, half_vector(wo, wi))
        norm = (k + 2.0) * (k + 4.0) / (8.0 * np.pi * (2.0 ** (-k / 2.0) + k))
    scale = norm * nl if settings['normalized'] else 1.0
    highlight = settings['ks'] * np.array(settings['specular_color']) * np.maximum(cosine, 0.0) ** k * scale
    return settings['kd'] * base(settings) * nl + highlight


def toon(settings: Settings, n: F64, wo: F64, wi: F64) -> F64:
    steps = settings['toon_steps']
    tone = np.minimum(np.floor(dot(n, wi) * steps), steps - 1) / (steps - 1)
    lit, shade = (np.array(settings[name], np.float64) for name in ('toon_lit', 'toon_shade'))
    return (shade + tone * (lit - shade)) / (2.0 * np.pi)


def cook_torrance(settings: Settings, n: F64, wo: F64, wi: F64) -> F64:
    """Cook & Torrance 1982: d / pi + s D F G / (4 nv nl)."""
    h = half_vector(wo, wi)
    nl, nv, metallic = dot(n, wi), dot(n, wo), float(settings['metallic'])
    f = fresnel(settings, dot(wo, h))
    specular = distribution(settings, dot(n, h)) * f * masking(settings, n, wo, wi, h) / (4.0 * nv * nl)
    diffuse = base(settings) / np.pi * (1.0 - metallic)
    if settings['split'] == 'ENERGY':
        return ((1.0 - f) * diffuse + specular) * nl
    return (diffuse + metallic * specular) * nl


def distribution(settings: Settings, nh: F64) -> F64:
    """D of the half vector's cosine."""
    a = settings['roughness'] ** 2
    if settings['distribution'] == 'GGX':
        return a**2 / (np.pi * (1.0 + nh**2 * (a**2 - 1.0)) ** 2)
    if settings['distribution'] == 'BECKMANN':
        return np.exp((nh**2 - 1.0) / (a**2 * nh**2)) / (np.pi * a**2 * nh**4)
    p = 2.0 / a**2 - 2.0
    return (p + 2.0) / (2.0 * np.pi) * nh**p


def smith_lambda(settings: Settings, ns: F64) -> F64:
    """Lambda toward s: GGX's, or the rational fit for Beckmann's (Walter et al. 2007)."""
    t = ns / (settings['roughness'] ** 2 * np.sqrt(1.0 - ns**2))
    if settings['distribution'] == 'GGX':
        return (-1.0 + np.sqrt(1.0 + 1.0 / t**2)) / 2.0
    return np.where(t < 1.6, (1.0 - 1.259 * t + 0.396 * t**2) / (3.535 * t + 2.181 * t**2), 0.0)


def masking(settings: Settings, n: F64, wo: F64, wi: F64, h: F64) -> F64:
    """G."""
    nl, nv = dot(n, wi), dot(n, wo)
    kind = settings['masking']
    if kind == 'COOK_TORRANCE':
        groove = 2.0 * dot(n, h) / dot(wo, h)
        return np.minimum(1.0, np.minimum(groove * nv, groove * nl))
    if kind == 'SCHLICK_GGX':
        k = settings['roughness'] ** 2 / 2.0
        return nl / (nl * (1.0 - k) + k) * nv / (nv * (1.0 - k) + k)
    toward, away = smith_lambda(settings, nv), smith_lambda(settings, nl)
    if kind == 'SMITH':
        return 1.0 / ((1.0 + toward) * (1.0 + away))
    return 1.0 / (1.0 + toward + away)


def fresnel(settings: Settings, c: F64) -> F64:
    """F of the cosine between the half vector and the viewer."""
    kind, ior = settings['fresnel'], settings['ior']
    if kind == 'DIELECTRIC' or kind == 'CONDUCTOR':
        n, k = (np.array(settings[name]) for name in ('conductor_n', 'conductor_k'))
        index = ior + 0j if kind == 'DIELECTRIC' else n + 1j * k
        inside = np.sqrt(index**2 - (1.0 - c**2) + 0j)
        perpendicular = (c - inside) / (c + inside)
        parallel = (index**2 * c - inside) / (index**2 * c + inside)
        return (np.abs(perpendicular) ** 2 + np.abs(parallel) ** 2) / 2.0 * np.ones(3)
    f0 = {
        'COLOR': np.array(settings['f0'], np.float64),
        'METALLIC': 0.04 + settings['metallic'] * (base(settings) - 0.04),
        'IOR': np.full(3, ((ior - 1.0) / (ior + 1.0)) ** 2),
    }[settings['f0_mode']]

    def schlick(cosine: F64 | float) -> F64:
        return f0 + (1.0 - f0) * (1.0 - cosine) ** 5

    if kind == 'SCHLICK':
        return schlick(c)
    # Kutz et al. 2021: less a term c (1 - c)^6 so that F at c = 1/7 is tinted.
    edge = schlick(1.0 / 7.0) * (1.0 - np.array(settings['f82_tint'])) / (1.0 / 7.0 * (6.0 / 7.0) ** 6)
    return schlick(c) - edge * c * (1.0 - c) ** 6
