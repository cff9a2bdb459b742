# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures what a layer of microfibers does in Cycles: the table that native/tools/sheen_table.inc holds.

Run it to write the table again. How Cycles came to it: Zeltner, Burley & Chiang 2022, by simulation.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import cycles_bsdf as cycles

NODES = 32  # of the cosine toward the viewer, fastest, and of the roughness; both uniform over 0 to 1
SUNS = np.array(
    (
        *((1, 0, 0.05), (1, 0, 1), (0.3, 0, 1), (1, 1, 0.3), (0.5, 1, 0.5)),
        *((0.3, 0.5, 1), (1, -0.3, 0.2), (1, 0, -0.3), (0.2, 1, 0.2), (1, 0.7, -0.1)),
    ),
    float,
)
SUNS /= np.linalg.norm(SUNS, axis=1, keepdims=True)
SMOOTHEST = 1e-3  # Cycles takes no cloth for smoother
STEEPEST = 0.5 / (NODES - 1)  # the cosine of the facets that stand in for those seen edge-on
FILE = Path(__file__).resolve().parent.parent / 'native' / 'tools' / 'sheen_table.inc'


def solve(direction: np.ndarray, shown: np.ndarray) -> tuple[float, float, float]:
    """Albedo, A and B of a facet, from f cos under suns in its frame, whose x leans toward the viewer.

    f cos = albedo z A^2 / (pi l^2) with l = (A x + B z)^2 + (A y)^2 + z^2, so sqrt(z / (pi f cos)) is linear in
    A / sqrt(albedo), 2 B / sqrt(albedo) and (B^2 + 1) / (A sqrt(albedo)).
    """
    seen = (direction[:, 2] > 1e-3) & (shown > 1e-12)
    if seen.sum() < 4:
        return 0.0, 0.0, 0.0
    x, y, z = direction[seen].T
    root = np.sqrt(z / (np.pi * shown[seen]))
    terms = np.stack([x * x + y * y, x * z, z * z], -1) / root[:, None]
    p, q, r = np.linalg.lstsq(terms, np.ones(len(root)), rcond=None)[0]
    lean = q / (2.0 * p)
    a = 1.0 / np.sqrt(r / p - lean * lean)
    return (a / p) ** 2, a, a * lean


def measure(cosine: np.ndarray, roughness: np.ndarray) -> np.ndarray:
    """(count, 3): albedo, A and B of as many facets, a square number."""
    sine = np.sqrt(1.0 - cosine**2)
    facet = np.zeros(len(cosine), [('color', 'f4', 3), ('roughness', 'f4')])
    facet['color'], facet['roughness'] = 1.0, roughness
    shader = cycles.Shader(
        'ShaderNodeBsdfSheen', {'color': 'Color', 'roughness': 'Roughness'}, {'distribution': 'MICROFIBER'}
    )
    normals = np.stack([sine, 0.0 * sine, cosine], -1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'sheen.exr'
        shown = np.stack(
            [cycles.render(facet, normals, path, sun=sun, shader=shader)['Combined'][:, 0] for sun in SUNS]
        )
    frames = [np.array([(-c, 0.0, s), (0.0, -1.0, 0.0), (s, 0.0, c)]) for c, s in zip(cosine, sine, strict=True)]
    found = [solve(SUNS @ frame.T, shown[:, k].astype(float)) for k, frame in enumerate(frames)]
    return np.array(found)


def table() -> np.ndarray:
    """(3, NODES, NODES): albedo, A and B by roughness and cosine. Where too little is reflected to tell, no albedo."""
    axis = np.linspace(0.0, 1.0, NODES)
    cosines, roughnesses = axis.copy(), axis.copy()
    cosines[0], roughnesses[0] = STEEPEST, SMOOTHEST
    y, x = np.meshgrid(roughnesses, cosines, indexing='ij')
    found = measure(x.ravel(), y.ravel()).reshape(NODES, NODES, 3)
    # What lies between two nodes is linear, which leads to those at the ends.
    found[:, 0] = 2.0 * found[:, 0] - found[:, 1]
    near = SMOOTHEST * (NODES - 1)
    found[0] = (found[0] - near * found[1]) / (1.0 - near)
    found[..., 0] = np.where(found[..., 0] < 5e-6, 0.0, found[..., 0])
    for row in range(NODES - 2, -1, -1):
        dark = found[row, :, :1] == 0.0
        found[row, :, 1:] = np.where(dark, found[row + 1, :, 1:], found[row, :, 1:])
    return np.moveaxis(found, -1, 0)


def write() -> None:
    lines = ['// SPDX-License-Identifier: GPL-3.0-or-later', '// Written by tests/sheen_table.py.']
    for name, values in zip(('Albedo', 'A', 'B'), table(), strict=True):
        lines.append(f'// {name}')
        numbers = [f'{value:.6g}' for value in values.ravel()]
        numbers = [number if '.' in number or 'e' in number else f'{number}.0' for number in numbers]
        lines += [' '.join(f'{number}f,' for number in numbers[i : i + 10]) for i in range(0, len(numbers), 10)]
    FILE.write_text('\n'.join(lines) + '\n')


if __name__ == '__main__':
    write()
