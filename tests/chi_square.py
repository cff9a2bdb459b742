# SPDX-License-Identifier: GPL-3.0-or-later
"""Pearson's chi-square test, for samples against the density that they claim.

The cells are the caller's: an integral over each cell times the number of samples is what is expected there.
"""

from __future__ import annotations

import math

import numpy as np


def p_value(observed: np.ndarray, expected: np.ndarray, least: float = 25.0) -> float:
    """Probability of a worse agreement by chance; cells that expect few are pooled to one that expects `least`."""
    order = np.argsort(expected)
    observed, expected = observed[order], np.maximum(expected[order], 0)
    pool = int(np.searchsorted(np.cumsum(expected), least)) + 1
    observed = np.append(observed[pool:], observed[:pool].sum())
    expected = np.append(expected[pool:], expected[:pool].sum())
    freedom = len(expected) - 1
    statistic = ((observed - expected) ** 2 / expected).sum()
    # Its tail by the normal distribution of its cube root (Wilson & Hilferty 1931).
    z = ((statistic / freedom) ** (1 / 3) - (1 - 2 / (9 * freedom))) / math.sqrt(2 / (9 * freedom))
    return 0.5 * math.erfc(z / math.sqrt(2))


def sidak(level: float, tests: int) -> float:
    """The level of one test out of several that together fail by chance with probability `level`."""
    return 1 - (1 - level) ** (1 / tests)
