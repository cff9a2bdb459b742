# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF of kernels/bsdf.h a second time: float64, from angles, as the papers write it.

Slow and plain on purpose; nothing of the kernels is used but the values of the albedo tables.
"""

from __future__ import annotations

import numpy as np

F64 = np.ndarray


def reflectance(alpha: float, mu: float, slopes: int = 400) -> tuple[float, float]:
    """Albedo of GGX with F = 1 toward cosine mu, and the share of visible normals that reflect upward.

    Midpoint rule over the surface's slopes, which neither the tables nor the sampling use.
    """
    # Slope = alpha tan(q) brings all slopes into (-pi/2, pi/2), and D becomes smooth there.
    q = ((np.arange(slopes) + 0.5) / slopes - 0.5) * np.pi
    slope, measure = alpha * np.tan(q), alpha / np.cos(q) ** 2 * np.pi / slopes
    x, y = np.meshgrid(slope, slope)
    density = 1 / (np.pi * alpha**2 * (1 + (x**2 + y**2) / alpha**2) ** 2) * np.outer(measure, measure)
    o = np.array([np.sqrt(1 - mu**2), 0, mu])
    h = np.stack([-x, -y, np.ones_like(x)], -1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    c = np.maximum(h @ o, 0)
    ni = 2 * c * h[..., 2] - mu
    lambda_o, lambda_i = smith_lambda(np.array(mu), alpha), smith_lambda(np.maximum(ni, 1e-9), alpha)
    visible = density * c / h[..., 2] / (mu * (1 + lambda_o)) * (ni > 0)
    return float((visible * (1 + lambda_o) / (1 + lambda_o + lambda_i)).sum()), float(visible.sum())


def smith_lambda(cosine: F64, alpha: F64 | float) -> F64:
    """Heitz 2014, eq. 72."""
    tangent = np.sqrt(np.maximum(1 / cosine**2 - 1, 0))
    return (np.sqrt(1 + (alpha * tangent) ** 2) - 1) / 2


def fresnel(cosine: F64, eta: F64) -> F64:
    """Fresnel's equations in the form of Snell's law, s and p apart."""
    sine = np.sqrt(np.maximum(1 - cosine**2, 0)) / eta
    inside = np.sqrt(np.maximum(1 - sine**2, 0))
    s = (cosine - eta * inside) / (cosine + eta * inside)
    p = (eta * cosine - inside) / (eta * cosine + inside)
    return np.where(sine >= 1, 1.0, (s**2 + p**2) / 2)


def _read(table: F64, *coordinates: F64) -> F64:
    """Linear interpolation on a grid over the unit cube; the first coordinate runs fastest."""
    result: F64 = np.zeros(np.shape(coordinates[0]))
    cells = []
    for coordinate, nodes in zip(coordinates, table.shape[::-1], strict=True):
        x = np.clip(coordinate, 0, 1) * (nodes - 1)
        low = np.minimum(x.astype(int), nodes - 2)
        cells.append(((low, 1 - (x - low)), (low + 1, x - low)))
    for corner in np.ndindex(*(2,) * len(cells)):
        picked = [cells[axis][side] for axis, side in enumerate(corner)]
        result = result + table[tuple(i for i, _ in reversed(picked))] * np.prod([w for _, w in picked], axis=0)
    return result


def evaluate(material: np.ndarray, tables: np.ndarray, n: F64, wo: F64, wi: F64) -> tuple[F64, F64]:
    """f cos of the diffuse and of the glossy lobe, (N, 3) each; wo and wi above n, roughness above the mirror's."""
    value = {name: material[name].astype(float) for name in material.dtype.names}
    e_table, mean_table, dielectric, _ = np.split(tables.astype(float), [1024, 1056, 5152])
    base, tint = value['base_color'], value['specular_tint']
    roughness, metallic = np.clip(value['roughness'], 0, 1), np.clip(value['metallic'], 0, 1)[:, None]
    no, ni = (n * wo).sum(-1), (n * wi).sum(-1)
    h = wo + wi
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    c = (wo * h).sum(-1)

    # 1. Reflection of a rough surface, single scattering, F = 1.
    alpha = roughness**2
    sine2 = (np.cross(n, h) ** 2).sum(-1)
    nh2 = 1 - sine2
    distribution = 1 / (np.pi * alpha**2 * nh2**2 * (1 + sine2 / nh2 / alpha**2) ** 2)
    g2 = 1 / (1 + smith_lambda(no, alpha) + smith_lambda(ni, alpha))
    rough = (distribution * g2 / (4 * no))[:, None]

    # 2. Multiple scattering (Kulla & Conty 2017).
    e = np.where(value['flags'].astype(int) & 16, _read(e_table.reshape(32, 32), no, roughness), 1)[:, None]
    mean = _read(mean_table, roughness)[:, None]

    def scale(f_average: F64) -> F64:
        f_multiple = f_average * mean / (1 - f_average * (1 - mean))
        return 1 + f_multiple * (1 - e) / e

    # 3. Metal: F82-tint (Kutz et al. 2021).
    f0, f82 = np.clip(base, 0, 1), np.clip(tint, 0, 1)

    def schlick_curve(x: F64) -> F64:
        return f0 + (1 - f0) * (1 - x) ** 5

    x82 = 1 / 7
    b = schlick_curve(np.array(x82)) * (1 - f82) / (x82 * (1 - x82) ** 6)
    cc = c[:, None]
    metal = np.maximum(schlick_curve(cc) - b * cc * (1 - cc) ** 6, 0)
    glossy = metallic * metal * scale(f0 + (1 - f0) / 21 - b / 126)

    # 4. Dielectric: the curve of eta, drawn between the user's F0 and 1.
    level = np.maximum(value['specular_level'], 0)
    user = ((value['ior'] - 1) / (value['ior'] + 1)) ** 2 * 2 * level
    root = np.sqrt(np.clip(user, 0, 0.99))
    adjusted = ((1 + root) / (1 - root)) ** np.where(value['ior'] < 1, -1, 1)
    eta = np.where(level == 0.5, value['ior'], adjusted)
    own = ((eta - 1) / (eta + 1)) ** 2
    average = np.where(
        eta < 1,
        0.997118 + 0.1014 * eta - 0.965241 * eta**2 - 0.130607 * eta**3,
        (eta - 1) / (4.08567 + 1.00071 * eta),
    )
    f0_user = np.minimum(tint * user[:, None], 1)

    def curve(f: F64) -> F64:
        return f0_user + (1 - f0_user) * np.clip((f - own) / (1 - own), 0, 1)[:, None]

    present = ((eta != 1) & (metallic[:, 0] < 1 - 1e-5))[:, None]
    coating = scale(curve(average)) * present
    glossy = glossy + (1 - metallic) * coating * curve(fresnel(c, eta))
    axis = np.sqrt(np.abs((eta - 1) / (eta + 1)))
    s = _read(dielectric.reshape(16, 16, 16), no, roughness, axis)[:, None]
    layer = coating * e * (f0_user + (1 - f0_user) * s)
    through = np.clip(1 - layer.max(-1, keepdims=True), 0, 1) * (1 - metallic)
    return np.maximum(base, 0) * through * ni[:, None] / np.pi, glossy * rough
