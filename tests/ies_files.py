# SPDX-License-Identifier: GPL-3.0-or-later
"""Small IES files, made up by us, of each photometric type and symmetry.

What is to be read of them is said in test_ies.py.
"""

from __future__ import annotations

from collections.abc import Sequence


def ies_text(
    vertical: Sequence[float],
    horizontal: Sequence[float],
    candela: Sequence[Sequence[float]],
    kind: int = 1,
    tilt: str = 'NONE',
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> str:
    """An LM-63 file; candela: a row for each horizontal angle. factors: multiplier, ballast, ballast-lamp."""
    multiplier, ballast, lamp = factors
    rows = [' '.join(f'{number:g}' for number in row) for row in (vertical, horizontal, *candela)]
    head = ['IESNA:LM-63-1995', '[TEST] made up', f'TILT={tilt}']
    if tilt == 'INCLUDE':
        head += ['1', '3', '0 45 90', '1 0.9 0.8']
    lamps = f'1 1000 {multiplier:g} {len(vertical)} {len(horizontal)} {kind} 2 0.1 0.1 0'
    return '\n'.join([*head, lamps, f'{ballast:g} {lamp:g} 50', *rows, ''])


# A half that is mirrored, uneven angles, strong to one side.
STREET = ies_text(
    (0, 10, 25, 45, 60, 75, 90, 120, 180),
    (0, 20, 45, 90, 135, 180),
    [
        [100 + 40 * h, 130 + 50 * h, 200, 260 + 10 * h * v, 300 - 50 * v, 120, 40, 10, 5]
        for h, v in zip((5, 4, 3, 2, 1, 0), (1, 2, 3, 3, 2, 1), strict=True)
    ],
)

# A full turn whose ends differ, and neither pole.
ROUND = ies_text(
    (30, 60, 90, 140), (0, 120, 240, 360), [[300, 100, 250, 80], [50, 400, 20, 300], [90] * 4, [10, 500, 60, 200]]
)
