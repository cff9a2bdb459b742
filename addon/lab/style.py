# SPDX-License-Identifier: GPL-3.0-or-later
"""Colors and markers of series, the same in print and on the page.

Colors are told apart by people with any color vision (Okabe and Ito 2008, "Color Universal Design").
"""

from __future__ import annotations

from typing import Any

from .. import choices
from .plan import Series

COLORS = {
    'PATH': '#0072b2',
    'DIRECT': '#009e73',
    'WHITTED': '#7b3fa0',
    'AO': '#56b4e9',
    'TOON': '#8a7a00',
    'AUTO': '#e69f00',
    'CYCLES': '#d55e00',
    'EEVEE': '#cc79a7',
}
MARKERS = {'PATH': 'o', 'DIRECT': 's', 'WHITTED': '^', 'AO': 'v', 'TOON': 'P', 'AUTO': '*', 'CYCLES': 'D', 'EEVEE': 'X'}
# Models in place of the materials take the integrator's color, the later in the list the lighter; a graphics card's
# and an adaptive one are darker.
MODEL_LIGHT, DEVICE_LIGHT, ADAPTIVE_LIGHT = 0.6, -0.35, -0.25


def kind(series: Series) -> str:
    return series.integrator if series.engine == 'COTORRA' else series.engine


def color_of(series: Series) -> str:
    red, green, blue = (int(COLORS[kind(series)][place : place + 2], 16) for place in (1, 3, 5))
    models = [identifier for identifier, _, _ in choices.MODELS]
    shift = MODEL_LIGHT * (models.index(series.model) + 1) / len(models) if series.model else 0.0
    shift += DEVICE_LIGHT * (series.device != 'CPU') + ADAPTIVE_LIGHT * series.adaptive
    end = 255 if shift > 0.0 else 0
    return '#' + ''.join(f'{round(value + abs(shift) * (end - value)):02x}' for value in (red, green, blue))


def marker_of(series: Series) -> dict[str, Any]:
    """matplotlib's words; what is denoised is hollow."""
    color = color_of(series)
    return {
        'marker': MARKERS[kind(series)],
        'markersize': 5.5,
        'color': color,
        'markeredgewidth': 1.3,
        'markeredgecolor': color,
        'markerfacecolor': 'white' if series.denoised else color,
    }
