# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures for people: tone, colors of an error, joining and writing, by NumPy and OpenImageIO, which Blender has.

No figure of error is computed here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..metrics import Image

Bytes = NDArray[np.uint8]  # (h, w, 3), sRGB

# Ends and steps of two scales of color. Of a magnitude: black over violet and orange to a pale yellow, so that the
# luminance rises all the way. Of a sign: blue, white, red.
HEAT = ((0.0, (2, 2, 12)), (0.25, (84, 16, 109)), (0.5, (187, 55, 84)), (0.75, (249, 142, 9)), (1.0, (252, 255, 180)))
SIGN = (
    (0.0, (18, 60, 140)),
    (0.25, (84, 150, 205)),
    (0.5, (247, 247, 247)),
    (0.75, (222, 112, 90)),
    (1.0, (140, 18, 36)),
)
# The heat map's ends, of the relative error: 1 % and 100 %, in logarithms.
HEAT_LOW, HEAT_HIGH = 0.01, 1.0
GAP = 4  # pixels between pictures that stand beside each other
BAD = (255, 0, 255)  # a pixel that is not finite


def displayed(image: Image, white: float) -> Bytes:
    """Divided by `white`, clipped and encoded as sRGB; no view transform, so no hue moves. What is bad stands out."""
    finite = np.isfinite(image).all(axis=2)
    linear = np.clip(np.where(finite[..., None], image, 0.0) / white, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    shown = np.round(255.0 * encoded).astype(np.uint8)
    shown[~finite] = BAD
    return shown


def colored(values: NDArray[np.floating], scale: Sequence[tuple[float, tuple[int, int, int]]]) -> Bytes:
    """Colors (h, w, 3) of values from 0 to 1 by a scale; NaN stands out."""
    places = [place for place, _ in scale]
    clipped = np.clip(np.nan_to_num(values), 0.0, 1.0)
    channels = [np.interp(clipped, places, [color[channel] for _, color in scale]) for channel in range(3)]
    shown = np.round(np.stack(channels, axis=-1)).astype(np.uint8)
    shown[np.isnan(values)] = BAD
    return shown


def heat(error: NDArray[np.floating]) -> Bytes:
    """A relative error, from HEAT_LOW (dark) to HEAT_HIGH (bright), in logarithms."""
    with np.errstate(divide='ignore'):
        share = np.log(np.maximum(error, 1e-30) / HEAT_LOW) / np.log(HEAT_HIGH / HEAT_LOW)
    return colored(np.where(np.isnan(error), np.nan, share), HEAT)


def signed(difference: NDArray[np.floating], limit: float) -> Bytes:
    """A difference from −limit (blue) to limit (red)."""
    return colored(0.5 + 0.5 * difference / limit, SIGN)


def round_limit(difference: NDArray[np.floating]) -> float:
    """A round limit that holds 99 % of a difference, so that two pictures can be compared."""
    finite = np.abs(difference[np.isfinite(difference)])
    widest = float(np.percentile(finite, 99)) if finite.size else 1.0
    return next((s for s in (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5) if s >= widest), 1.0)


def side_by_side(parts: Sequence[Bytes], gap: int = GAP) -> Bytes:
    """Parts of one height beside each other, with white between."""
    height = parts[0].shape[0]
    between = np.full((height, gap, 3), 255, np.uint8)
    joined = [between if index % 2 else parts[index // 2] for index in range(2 * len(parts) - 1)]
    return np.concatenate(joined, axis=1)


def wiped(picture: Bytes, size: tuple[int, int], share: float) -> Bytes:
    """Of three pictures side by side, the first left of `share` of the width and the second right of it; the third.

    size: (width, height) of each; what is above them are titles: those of the first two come below each other.
    """
    width, height = size
    strip = picture.shape[0] - height
    first, second, third = (picture[:, start : start + width] for start in range(0, 3 * (width + GAP), width + GAP))
    cut = round(min(max(share, 0.0), 1.0) * width)
    joined = np.concatenate((first[strip:, :cut], second[strip:, cut:]), axis=1)
    if 0 < cut < width:
        joined[:, cut - 1 : cut + 1] = 255 - joined[:, cut - 1 : cut + 1] // 2  # light on whatever is there
    left = np.concatenate((first[:strip], second[:strip], joined))
    right = np.concatenate((third[:strip], np.full((strip, width, 3), 255, np.uint8), third[strip:]))
    return side_by_side((left, right))


def titled(picture: Bytes, texts: Sequence[tuple[int, str]], height: int = 22) -> Bytes:
    """A white strip above, with texts that begin at the given columns; without, where OpenImageIO has no fonts."""
    import OpenImageIO as oiio

    strip = np.full((height, picture.shape[1], 3), 255, np.uint8)
    canvas = oiio.ImageBuf(strip)
    for column, text in texts:
        if not oiio.ImageBufAlgo.render_text(
            canvas, column + 2, round(0.75 * height), text, round(0.62 * height), '', (0.1, 0.1, 0.1)
        ):
            oiio.geterror()
            return picture
    return np.concatenate((np.asarray(canvas.get_pixels(oiio.UINT8)).reshape(strip.shape), picture))


def write(path: Path, picture: Bytes, quality: int = 90) -> None:
    """A PNG or JPEG by the name's end. OSError where it cannot be written."""
    import OpenImageIO as oiio

    out = oiio.ImageOutput.create(str(path))
    if out is None:
        raise OSError(f'{path}: {oiio.geterror()}')
    spec = oiio.ImageSpec(picture.shape[1], picture.shape[0], 3, oiio.UINT8)
    if path.suffix == '.jpg':
        spec.attribute('Compression', f'jpeg:{quality}')
    if not out.open(str(path), spec) or not out.write_image(np.ascontiguousarray(picture)):
        raise OSError(f'{path}: {out.geterror()}')
    out.close()


def jpeg(picture: Bytes, quality: int = 88) -> bytes:
    with tempfile.TemporaryDirectory(prefix='cotorra-') as folder:
        path = Path(folder) / 'picture.jpg'
        write(path, picture, quality)
        return path.read_bytes()
