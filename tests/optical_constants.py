# SPDX-License-Identifier: GPL-3.0-or-later
"""Published optical constants in the visible, and how numbers for red, green and blue are made of them.

The presets hold the results; tests/test_presets.py compares. Nothing of this is needed to render.
"""

from __future__ import annotations

import math

import numpy as np

# Wavelength (µm), n and k. Johnson and Christy, Phys. Rev. B 6, 4370 (1972): copper, silver, gold; Johnson and Christy,
# Phys. Rev. B 9, 5056 (1974): titanium, chromium, iron; Rakić, Appl. Opt. 34, 4755 (1995): aluminium. Taken from the
# database refractiveindex.info (public domain), pages "Johnson" and "Rakic" of each element.
NOBLE = (0.3815, 0.3974, 0.4133, 0.4305, 0.4509, 0.4714, 0.4959, 0.5209, 0.5486, 0.5821, 0.6168, 0.6595, 0.7045, 0.756)
TRANSITION = (0.381, 0.397, 0.413, 0.431, 0.451, 0.471, 0.496, 0.521, 0.549, 0.582, 0.617, 0.659, 0.704, 0.756, 0.821)
METALS = {
    'gold': (
        NOBLE,
        (1.46, 1.47, 1.46, 1.45, 1.38, 1.31, 1.04, 0.62, 0.43, 0.29, 0.21, 0.14, 0.13, 0.14),
        (1.933, 1.952, 1.958, 1.948, 1.914, 1.849, 1.833, 2.081, 2.455, 2.863, 3.272, 3.697, 4.103, 4.542),
    ),
    'silver': (
        NOBLE,
        (0.05, 0.05, 0.05, 0.04, 0.04, 0.05, 0.05, 0.05, 0.06, 0.05, 0.06, 0.05, 0.04, 0.03),
        (1.864, 2.070, 2.275, 2.462, 2.657, 2.869, 3.093, 3.324, 3.586, 3.858, 4.152, 4.483, 4.838, 5.242),
    ),
    'copper': (
        NOBLE,
        (1.33, 1.32, 1.28, 1.25, 1.24, 1.25, 1.22, 1.18, 1.02, 0.70, 0.30, 0.22, 0.21, 0.24),
        (2.045, 2.116, 2.207, 2.305, 2.397, 2.483, 2.564, 2.608, 2.577, 2.704, 3.205, 3.747, 4.205, 4.665),
    ),
    'iron': (
        TRANSITION,
        (2.12, 2.24, 2.35, 2.48, 2.59, 2.67, 2.74, 2.86, 2.95, 2.94, 2.88, 2.92, 2.86, 2.87, 2.94),
        (2.50, 2.58, 2.65, 2.71, 2.77, 2.82, 2.88, 2.91, 2.93, 2.99, 3.05, 3.10, 3.19, 3.28, 3.39),
    ),
    'titanium': (
        TRANSITION,
        (1.99, 2.08, 2.14, 2.21, 2.27, 2.32, 2.36, 2.44, 2.54, 2.60, 2.67, 2.76, 2.86, 3.00, 3.21),
        (2.93, 2.95, 2.98, 3.01, 3.04, 3.10, 3.19, 3.30, 3.43, 3.58, 3.72, 3.84, 3.96, 4.01, 4.01),
    ),
    'chromium': (
        TRANSITION,
        (1.92, 2.00, 2.08, 2.19, 2.33, 2.51, 2.75, 2.94, 3.18, 3.22, 3.17, 3.09, 3.05, 3.08, 3.20),
        (2.74, 2.83, 2.93, 3.04, 3.14, 3.24, 3.30, 3.33, 3.33, 3.30, 3.30, 3.34, 3.39, 3.42, 3.48),
    ),
    'aluminium': (
        (0.36466, 0.41328, 0.4428, 0.47687, 0.5166, 0.56357, 0.61993, 0.65225, 0.68881, 0.72932, 0.77491),
        (0.39877, 0.52135, 0.6079, 0.7278, 0.8734, 1.0728, 1.366, 1.5724, 1.8301, 2.1606, 2.6154),
        (4.3957, 5.0008, 5.3676, 5.7781, 6.2418, 6.7839, 7.4052, 7.7354, 8.0601, 8.3565, 8.4914),
    ),
}

# n² = 1 + sum of b λ² / (λ² - c), λ in µm, as (b, c).
SELLMEIER = {
    # Daimon and Masumura, Appl. Opt. 46, 3811 (2007), at 20 °C
    'water': (
        (0.5684027565, 0.005101829712),
        (0.1726177391, 0.01821153936),
        (0.02086189578, 0.02620722293),
        (0.1130748688, 10.69792721),
    ),
    # Peter, Z. Phys. 15, 358 (1923)
    'diamond': ((0.3306, 0.1750**2), (4.3356, 0.1060**2)),
    # Malitson and Dodge, J. Opt. Soc. Am. 62, 1405 (1972): synthetic sapphire, ordinary ray
    'ceramic': ((1.4313493, 0.0726631**2), (0.65054713, 0.1193242**2), (5.3414021, 18.028251**2)),
    # Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116, 585 (2009): PMMA
    'plastic': ((1.1819, 0.011313),),
    # SCHOTT, data sheet of N-BK7
    'glass': ((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)),
}
HELIUM_D = 0.58756  # µm, the line that catalogues of glass state n at

# CIE standard illuminant D65 at 380, 390 ... 780 nm.
D65 = np.array(
    (
        *(49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811),
        *(109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062, 89.5991),
        *(87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856),
        *(75.087, 63.5927, 46.4182, 66.8054, 63.3828),
    )
)
WAVELENGTHS = np.arange(380.0, 781.0, 10.0)
# Linear Rec. 709 from CIE XYZ (IEC 61966-2-1).
REC709 = np.array(((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570)))


def color_matching() -> np.ndarray:
    """CIE 1931 x, y, z at WAVELENGTHS by the sums of Gaussians of Wyman, Sloan and Shirley (JCGT 2, 2013), eq. 4."""
    lobes = (
        ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
        ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
        ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
    )

    def lobe(height: float, middle: float, left: float, right: float) -> np.ndarray:
        width = np.where(WAVELENGTHS < middle, left, right)
        return height * np.exp(-0.5 * ((WAVELENGTHS - middle) / width) ** 2)

    return np.stack([sum(lobe(*parameters) for parameters in curve) for curve in lobes])


def rgb(wavelengths: tuple[float, ...], values: tuple[float, ...]) -> np.ndarray:
    """A spectrum (µm) as linear Rec. 709 under D65, scaled so that 1 everywhere gives 1, 1, 1."""
    weights = REC709 @ (color_matching() * D65)
    spectrum = np.interp(WAVELENGTHS / 1000.0, wavelengths, values)
    return weights @ spectrum / weights.sum(axis=1)


def refraction(name: str, wavelength: float = HELIUM_D) -> float:
    square = wavelength * wavelength
    return math.sqrt(1.0 + sum(b * square / (square - c) for b, c in SELLMEIER[name]))
