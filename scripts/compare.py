# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares two float EXR images: prints the figures of `addon/metrics.py`, draws both and their difference.

Nothing is rendered here. Alone:  python scripts/compare.py A.exr B.exr [-o DIFFERENCE.png]   (B is the reference)
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from cotorra.metrics import TILE, TILE_FLOOR, Image, Reference, SameImage, image_error, same_image


def read_exr(path: Path | str) -> tuple[Image, dict[str, str | float | int]]:
    """Red, green and blue of the first part, (h, w, 3) float32, and the file's attributes."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OSError(f'{path}: {oiio.geterror()}')
    spec = source.spec()
    names = list(spec.channelnames)
    # A multilayer file calls them Layer.Combined.R and so on.
    chosen = [next((i for i, name in enumerate(names) if name.split('.')[-1] == c), None) for c in 'RGB']
    if None in chosen:
        raise ValueError(f'{path}: no channels R, G and B in {names}')
    pixels = source.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    attributes = {a.name: a.value for a in spec.extra_attribs if isinstance(a.value, str | float | int)}
    source.close()
    if pixels is None:
        raise OSError(f'{path}: {source.geterror()}')
    return np.ascontiguousarray(pixels[:, :, chosen]), attributes


def displayed(image: Image, white: float) -> Image:
    """For looking only: divided by `white`, clipped and encoded as sRGB; no view transform, so no hue moves."""
    linear = np.clip(np.nan_to_num(image, posinf=white) / white, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def draw(path: Path, a: Image, b: Image, same: SameImage, names: tuple[str, str], title: str = '') -> None:
    """A and B beside each other; below, the signed difference of pixels and of tiles, each with its scale."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    height, width = b.shape[:2]
    white = max(float(np.nanpercentile(np.where(np.isfinite(b), b, np.nan), 99)), 1e-12)
    figure = Figure(figsize=(14, 14 * height / width + 2.2), dpi=100, layout='constrained')
    FigureCanvasAgg(figure)
    grid = figure.subplots(2, 2)
    for axes, image, name in ((grid[0, 0], a, names[0]), (grid[0, 1], b, names[1])):
        axes.imshow(displayed(image, white), interpolation='nearest')
        axes.set_title(f'{name} (white = {white:.3g})')

    # Pixels: (A − B) as a share of what is shown as white; tiles: what the criterion looks at, in percent of the tile.
    pixels = np.nan_to_num((a - b).mean(axis=2)) / white
    # The scale is round, so that two figures can be compared, and just wide enough for 99 % of the pixels.
    widest = float(np.percentile(np.abs(pixels), 99))
    scale = next((s for s in (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5) if s >= widest), 1.0)
    shown = grid[1, 0].imshow(pixels * 100, cmap='RdBu_r', vmin=-100 * scale, vmax=100 * scale, interpolation='nearest')
    grid[1, 0].set_title(f'pixels: {names[0]} − {names[1]}, magnified {1 / scale:.0f} times')
    figure.colorbar(shown, ax=grid[1, 0], orientation='horizontal', label='% of white', shrink=0.8)
    percent = 300 * same.limit
    tiles = same.tiles.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width] * 100
    shown = grid[1, 1].imshow(tiles, cmap='RdBu_r', vmin=-percent, vmax=percent, interpolation='nearest')
    grid[1, 1].set_title(f'tiles of {TILE}×{TILE}: {same.within:.2%} within {same.limit:.0%}, total {same.total:+.3%}')
    figure.colorbar(shown, ax=grid[1, 1], orientation='horizontal', label='% of the tile', shrink=0.8)
    for axes in grid.flat:
        axes.set_xticks([])
        axes.set_yticks([])
    if title:
        figure.suptitle(title)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def describe(same: SameImage) -> str:
    """The criterion's outcome in two lines."""
    worst, x, y = same.worst
    known = same.total_noise > 0  # a single image tells nothing of its noise
    noise = f', beyond that and beyond noise {same.beyond_noise:.2%}' if known else ''
    return (
        f'tiles within {same.limit:.0%}: {same.within:.2%}{noise}; total {same.total:+.3%}'
        + (f' ± {same.total_noise:.3%}' if known else '')
        + f'\nworst tile {worst:+.2%} at ({x}, {y}); '
        + (f'noise of a tile {same.noise:.2%}; ' if known else '')
        + f'{same.dark:.2%} of tiles darker than {TILE_FLOOR:g} of the mean; {same.bad} bad pixels'
    )


def main(arguments: list[str] | None = None) -> int:
    """Exit status 0: the same image by the criterion; 1: not; 2: not to be read."""
    parser = argparse.ArgumentParser(prog='compare.py', description='Compare two float EXR images.')
    parser.add_argument('image', type=Path)
    parser.add_argument('reference', type=Path)
    parser.add_argument('-o', '--output', type=Path, help='PNG of both and their difference (needs matplotlib)')
    options = parser.parse_args(arguments)
    try:
        a, b = read_exr(options.image)[0], read_exr(options.reference)[0]
        same = same_image(Reference.from_image(a), Reference.from_image(b))
        error = image_error(a, Reference.from_image(b))
    except (OSError, ValueError) as problem:
        print(f'compare.py: {problem}', file=sys.stderr)
        return 2
    print(describe(same))
    print(f'relMSE {error.relmse:.3e}, without the worst 0.1 % of pixels {error.trimmed:.3e}; MSE {error.mse:.3e}')
    if options.output:
        draw(options.output, a, b, same, (options.image.stem, options.reference.stem))
    return 0 if same.holds() else 1


if __name__ == '__main__':
    sys.exit(main())
