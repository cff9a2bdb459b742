# SPDX-License-Identifier: GPL-3.0-or-later
"""The reflection models once more, in float64 and as their papers write them, with angles where the papers have angles.

Written without a look at the kernels' forms: where those avoid a cancellation, this one trusts the longer numbers.
"""

from __future__ import annotations

import numpy as np

import model_bench as bench
from model_bench import Materials, unit

# Directions are (N, 3) of length 1, n = z; cosines and angles are (N,). Materials have N entries, or one.


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(-1)


# ---- Diffuse


def oren_nayar(sigma: np.ndarray, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """pi f / albedo, Oren & Nayar 1994, eq. 30."""
    theta_o, theta_i = (np.arccos(np.clip(v[:, 2], -1, 1)) for v in (wo, wi))
    delta_phi = np.arctan2(wi[:, 1], wi[:, 0]) - np.arctan2(wo[:, 1], wo[:, 0])
    a = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33)
    b = 0.45 * sigma**2 / (sigma**2 + 0.09)
    alpha, beta = np.maximum(theta_o, theta_i), np.minimum(theta_o, theta_i)
    return a + b * np.maximum(0, np.cos(delta_phi)) * np.sin(alpha) * np.tan(beta)


def eon(albedo: np.ndarray, r: np.ndarray, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """pi f of EON, Portsmouth, Kutz & Hill 2024, with the exact albedo of the single-scattering part."""

    def single_albedo(theta: np.ndarray) -> np.ndarray:
        g = np.sin(theta) * (theta - np.sin(theta) * np.cos(theta))
        g += 2 / 3 * np.tan(theta) * (1 - np.sin(theta) ** 3) - 2 / 3 * np.sin(theta)
        return a * (1 + r * g / np.pi)

    a = 1 / (1 + (0.5 - 2 / (3 * np.pi)) * r)
    s = dot(wo, wi) - wo[:, 2] * wi[:, 2]
    t = np.where(s > 0, np.maximum(wo[:, 2], wi[:, 2]), 1)
    mean = a * (1 + (2 / 3 - 28 / (15 * np.pi)) * r)
    lost = np.prod([1 - single_albedo(np.arccos(np.clip(v[:, 2], -1, 1))) for v in (wo, wi)], 0)
    multiple = albedo**2 * mean[:, None] / (1 - albedo * (1 - mean[:, None]))
    return albedo * (a * (1 + r * s / t))[:, None] + multiple * (lost / np.maximum(1 - mean, 1e-300))[:, None]


def toon(lit: np.ndarray, shade: np.ndarray, steps: np.ndarray, ni: np.ndarray) -> np.ndarray:
    tone = np.minimum(np.floor(ni * steps), steps - 1) / (steps - 1)
    return shade + (lit - shade) * tone[:, None]


# ---- Terms of Cook-Torrance


def D(kind: int | np.ndarray, nh: np.ndarray, a: np.ndarray) -> np.ndarray:
    p = 2 / a**2 - 2
    ggx = a**2 / (np.pi * (1 + nh**2 * (a**2 - 1)) ** 2)
    beckmann = np.exp((nh**2 - 1) / (a**2 * nh**2)) / (np.pi * a**2 * nh**4)
    return np.choose(kind, [ggx, beckmann, (p + 2) / (2 * np.pi) * nh**p])


def Lambda(kind: int | np.ndarray, ns: np.ndarray, a: np.ndarray) -> np.ndarray:
    t = ns / (a * np.sqrt(np.maximum(1 - ns**2, 1e-30)))
    ggx = (-1 + np.sqrt(1 + 1 / t**2)) / 2
    fit = np.where(t < 1.6, (1 - 1.259 * t + 0.396 * t**2) / (3.535 * t + 2.181 * t**2), 0)
    return np.where(kind == bench.GGX, ggx, fit)


def G(masking: int | np.ndarray, kind: int | np.ndarray, *cosines: np.ndarray, a: np.ndarray) -> np.ndarray:
    """`cosines`: no, ni, nh, oh."""
    no, ni, nh, oh = cosines
    lambda_o, lambda_i = Lambda(kind, no, a), Lambda(kind, ni, a)
    k = a / 2
    cavity = np.minimum(1, np.minimum(2 * nh * no / oh, 2 * nh * ni / oh))
    schlick = no / (no * (1 - k) + k) * (ni / (ni * (1 - k) + k))
    smith = 1 / (1 + lambda_o) / (1 + lambda_i)
    return np.choose(masking, [1 / (1 + lambda_o + lambda_i), smith, cavity, schlick])


def fresnel(n: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Unpolarised reflectance at an interface to the (complex) index n, by Fresnel's equations with Snell's law."""
    transmitted = np.sqrt(1 - (1 - c**2) / n.astype(complex) ** 2)
    s = (c - n * transmitted) / (c + n * transmitted)
    p = (n * c - transmitted) / (n * c + transmitted)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


def F0(m: Materials) -> np.ndarray:
    base, metallic = m.base_color.astype(float), m.metallic.astype(float)[:, None]
    eta = m.ior.astype(float)[:, None]
    choices = [m.models.f0.astype(float), 0.04 + (base - 0.04) * metallic, ((eta - 1) / (eta + 1)) ** 2 + 0 * base]
    return np.clip(np.choose(m.models.f0_mode[:, None], choices), 0, 1)


def F(m: Materials, oh: np.ndarray) -> np.ndarray:
    f0, c = F0(m), oh[:, None]

    def schlick(c: np.ndarray | float) -> np.ndarray:
        return f0 + (1 - f0) * (1 - c) ** 5

    # F82-tint (Kutz et al. 2021): at c = 1/7 Schlick's value times the tint.
    bend = schlick(1 / 7) * (1 - m.models.f82_tint) * 7 * (7 / 6) ** 6
    index = m.models.conductor_n + 1j * m.models.conductor_k
    return np.choose(
        m.models.fresnel[:, None],
        [
            schlick(c),
            fresnel(m.ior.astype(float)[:, None] + 0 * f0, c),
            fresnel(index.astype(complex), c),
            np.maximum(schlick(c) - bend * c * (1 - c) ** 6, 0),
        ],
    )


# ---- Models: f cos of the diffuse part and of the highlight


def phong(m: Materials, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    n = m.models.shininess.astype(float)
    ni = wi[:, 2]
    blinn = m.models.model == bench.BLINN_PHONG
    mirror = wi * [-1, -1, 1]  # of l about n
    power = np.where(blinn, np.maximum(unit(wo + wi)[:, 2], 0), np.maximum(dot(mirror, wo), 0)) ** n
    norm = np.where(blinn, (n + 2) * (n + 4) / (8 * np.pi * (2 ** (-n / 2) + n)), (n + 2) / (2 * np.pi))
    power = np.where(m.models.normalized == 1, power * norm * ni, power)  # classic: (r.v)^n / nl times nl
    return m.models.ks.astype(float)[:, None] * m.models.specular_color * power[:, None]


def cook_torrance_terms(m: Materials, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    h = unit(wo + wi)
    a = m.roughness.astype(float) ** 2
    nh, oh = h[:, 2], dot(h, wo)
    kind = m.models.distribution
    return D(kind, nh, a), G(m.models.masking, kind, wo[:, 2], wi[:, 2], nh, oh, a=a), F(m, oh)


def cook_torrance(m: Materials, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d, g, f = cook_torrance_terms(m, wo, wi)
    metallic = m.metallic.astype(float)[:, None]
    specular = (d * g / (4 * wo[:, 2]))[:, None] * f
    diffuse = (1 - metallic) * m.base_color / np.pi * wi[:, 2:]
    mix = m.models.split[:, None] == bench.MIX
    return np.where(mix, diffuse, diffuse * (1 - f)), np.where(mix, specular * metallic, specular)


def repeated(m: Materials, count: int) -> Materials:
    """The same materials, `count` of them."""
    if len(m.metallic) == count:
        return m
    names = [name for name in m.__slots__ if isinstance(getattr(m, name), np.ndarray)]
    arrays = {name: np.repeat(getattr(m, name), count, 0) for name in names}
    models = {name: np.repeat(getattr(m.models, name), count, 0) for name in m.models.__slots__}
    return Materials(**arrays, models=type(m.models)(**models))


def evaluate(m: Materials, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f cos of the diffuse part and of the highlight, both directions above the surface."""
    count = max(len(m.metallic), len(wo), len(wi))
    m = repeated(m, count)
    wo, wi = (unit(np.broadcast_to(np.asarray(v, float), (count, 3))) for v in (wo, wi))
    model, ni = m.models.model[:, None], wi[:, 2:]
    base, sigma = m.base_color.astype(float), m.models.oren_nayar_sigma.astype(float)
    rough = np.where(
        m.models.oren_nayar_form[:, None] == 0,
        base * oren_nayar(sigma, wo, wi)[:, None],
        eon(base, np.minimum(2 * sigma / np.pi, 1), wo, wi),
    )
    tones = toon(m.models.toon_lit, m.models.toon_shade, m.models.toon_steps.astype(float), wi[:, 2])
    metal_diffuse, metal_specular = cook_torrance(m, wo, wi)
    lambert = base / np.pi * ni
    phong_diffuse = m.models.kd.astype(float)[:, None] * base * ni
    diffuse = [0 * base, lambert, rough / np.pi * ni, phong_diffuse, phong_diffuse, metal_diffuse, tones / (2 * np.pi)]
    highlight = phong(m, wo, wi)
    specular = [0 * base, 0 * base, 0 * base, highlight, highlight, metal_specular, 0 * base]
    return np.choose(model, diffuse), np.choose(model, specular)
