# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's copy of an image is the truth: painted, generated, packed, reloaded, of another colour space; as Cycles.

Each case is rendered by both engines on a few pixels. Formats and depths of files are tested in test_export_images.py.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest

import flat_scenes
from flat_scenes import Flat, flat, shown

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='what is expected was measured with Cycles 5.2'),
]

SIZE = 4
RED, GREEN, BLUE = (0.7, 0.1, 0.2, 1.0), (0.1, 0.6, 0.3, 1.0), (0.2, 0.3, 0.9, 1.0)
CLEAR = (0.8, 0.4, 0.2, 0.5)


def write(path: Path, color: tuple[float, ...], dtype: str = 'uint8') -> str:
    """A file of one colour; alpha is not multiplied in where the format leaves it open."""
    spec = oiio.ImageSpec(SIZE, SIZE, 4, dtype)
    spec.attribute('oiio:UnassociatedAlpha', 1)
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image(np.full((SIZE, SIZE, 4), color, np.float32))
    out.close()
    return str(path)


def load(folder: Path, color: tuple[float, ...] = RED) -> bpy.types.Image:
    image = bpy.data.images.load(write(folder / 'image.png', color))
    assert len(image.pixels)  # Blender has it in memory
    return image


def paint(image: bpy.types.Image, color: tuple[float, ...]) -> None:
    image.pixels.foreach_set(list(color) * (SIZE * SIZE))
    image.update()


def show(made: Flat, image: bpy.types.Image, alpha: bool) -> None:
    texture = made.node('TexImage', image=image)
    made.link(texture.outputs['Color'], made.emission.inputs['Color'])
    if alpha:
        mix = made.node('MixShader')
        made.link(texture.outputs['Alpha'], mix.inputs[0])
        made.link(made.node('BsdfTransparent').outputs[0], mix.inputs[1])
        made.link(made.emission.outputs[0], mix.inputs[2])
        made.link(mix.outputs[0], made.output.inputs[0])


# ---- One history each; the colour that is to be seen is in the name.


def painted_green(folder: Path) -> bpy.types.Image:
    image = load(folder)
    paint(image, GREEN)
    return image


def painted_and_packed_green(folder: Path) -> bpy.types.Image:
    image = painted_green(folder)
    image.pack()
    return image


def packed_and_painted_green(folder: Path) -> bpy.types.Image:
    image = load(folder)
    image.pack()
    paint(image, GREEN)
    return image


def packed_green_while_the_file_is_red(folder: Path) -> bpy.types.Image:
    image = load(folder, GREEN)
    image.pack()
    write(folder / 'image.png', RED)
    return image


def packed_green_without_file(folder: Path) -> bpy.types.Image:
    image = load(folder, GREEN)
    image.pack()
    (folder / 'image.png').unlink()
    return image


def green_on_disk(folder: Path) -> bpy.types.Image:
    image = load(folder)
    write(folder / 'image.png', GREEN)
    return image


def reloaded_green(folder: Path) -> bpy.types.Image:
    image = load(folder, GREEN)
    paint(image, RED)
    image.reload()
    return image


def saved_green(folder: Path) -> bpy.types.Image:
    image = painted_green(folder)
    image.save()
    return image


def another_path_green(folder: Path) -> bpy.types.Image:
    image = load(folder)
    image.filepath = write(folder / 'other.png', GREEN)
    return image


def painted_green_without_file(folder: Path) -> bpy.types.Image:
    image = painted_green(folder)
    (folder / 'image.png').unlink()
    return image


def generated_green(folder: Path) -> bpy.types.Image:
    image = bpy.data.images.new('Made', SIZE, SIZE)
    paint(image, GREEN)
    return image


def generated_tiles_green(folder: Path) -> bpy.types.Image:
    image = bpy.data.images.new('Made', SIZE, SIZE, tiled=True)
    paint(image, GREEN)
    return image


def backslashes_green(folder: Path) -> bpy.types.Image:
    image = load(folder, GREEN)
    image.filepath = image.filepath.replace('/', '\\')
    return image


def library_green(folder: Path) -> bpy.types.Image:
    """A path that is relative to the library."""
    image = load(folder, GREEN)
    image.filepath = '//image.png'
    bpy.data.libraries.write(str(folder / 'library.blend'), {image}, fake_user=True, path_remap='NONE')
    bpy.data.images.remove(image)
    with bpy.data.libraries.load(str(folder / 'library.blend'), link=True) as (found, wanted):
        wanted.images = found.images
    return wanted.images[0]


HISTORIES = (
    *(painted_green, painted_and_packed_green, packed_and_painted_green, packed_green_while_the_file_is_red),
    *(packed_green_without_file, green_on_disk, reloaded_green, saved_green, another_path_green),
    *(painted_green_without_file, generated_green, generated_tiles_green, backslashes_green, library_green),
)


@pytest.mark.parametrize('history', HISTORIES, ids=lambda history: history.__name__)
def test_the_green_one_is_shown(history: Callable[[Path], bpy.types.Image], tmp_path: Path) -> None:
    made = flat()
    show(made, history(tmp_path), alpha=False)
    mine, warnings = shown('COTORRA', tmp_path)
    theirs, _ = shown('CYCLES', tmp_path)
    np.testing.assert_allclose(mine, theirs, atol=2e-3)
    assert mine[1] == max(mine)
    assert [text for text in warnings if 'UDIM' not in text] == []


# ---- Alpha and colour spaces of what Blender holds.


def painted_bytes(folder: Path, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    return prepared(bpy.data.images.load(write(folder / 'image.png', RED)), color, space, mode)


def painted_floats(folder: Path, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    return prepared(bpy.data.images.load(write(folder / 'image.exr', RED, 'float')), color, space, mode)


def made_floats(folder: Path, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    return prepared(bpy.data.images.new('Made', SIZE, SIZE, float_buffer=True), color, space, mode)


def prepared(image: bpy.types.Image, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    image.alpha_mode = mode
    if space is not None:
        image.colorspace_settings.name = space
    assert len(image.pixels)
    paint(image, color)
    return image


def packed_floats(folder: Path, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    image = made_floats(folder, color, space, mode)
    image.pack()
    return image


def packed_16_bits(folder: Path, color: tuple[float, ...], space: str | None, mode: str) -> bpy.types.Image:
    image = bpy.data.images.load(write(folder / 'image.png', color, 'uint16'))
    image.pack()
    image.alpha_mode = mode
    if space is not None:
        image.colorspace_settings.name = space
    return image


KINDS = (painted_bytes, painted_floats, made_floats, packed_floats, packed_16_bits)


@pytest.mark.parametrize('alpha', [False, True], ids=['color', 'alpha'])
@pytest.mark.parametrize('mode', ['STRAIGHT', 'PREMUL', 'CHANNEL_PACKED', 'NONE'])
@pytest.mark.parametrize('kind', KINDS, ids=lambda kind: kind.__name__)
def test_alpha(kind: Callable[..., bpy.types.Image], mode: str, alpha: bool, tmp_path: Path) -> None:
    made = flat()
    show(made, kind(tmp_path, CLEAR, None, mode), alpha)
    # Half of 255 is 127 or 128.
    flat_scenes.assert_as_cycles(tmp_path, tolerance=1 / 255)


@pytest.mark.parametrize('alpha', [False, True], ids=['color', 'alpha'])
@pytest.mark.parametrize('mode', ['STRAIGHT', 'PREMUL', 'CHANNEL_PACKED', 'NONE'])
@pytest.mark.parametrize('space', ['Non-Color', 'sRGB', 'ACEScg'])
def test_grey_with_alpha(space: str, mode: str, alpha: bool, tmp_path: Path) -> None:
    made = flat()
    path = str(tmp_path / 'grey.png')
    spec = oiio.ImageSpec(SIZE, SIZE, 2, 'uint8')
    spec.channelnames, spec.alpha_channel = ('Y', 'A'), 1
    spec.attribute('oiio:UnassociatedAlpha', 1)
    out = oiio.ImageOutput.create(path)
    out.open(path, spec)
    out.write_image(np.full((SIZE, SIZE, 2), (0.4, 0.6), np.float32))
    out.close()
    image = bpy.data.images.load(path)
    image.alpha_mode, image.colorspace_settings.name = mode, space
    texture = made.node('TexImage', image=image)
    made.link(texture.outputs['Color'], made.emission.inputs['Color'])
    if alpha:
        made.link(texture.outputs['Alpha'], made.emission.inputs['Strength'])
    flat_scenes.assert_as_cycles(tmp_path)


@pytest.mark.parametrize('space', ['Non-Color', 'Linear Rec.709', 'sRGB', 'ACEScg', 'AgX Base sRGB'])
@pytest.mark.parametrize('kind', KINDS, ids=lambda kind: kind.__name__)
def test_color_space(kind: Callable[..., bpy.types.Image], space: str, tmp_path: Path) -> None:
    made = flat()
    show(made, kind(tmp_path, GREEN, space, 'STRAIGHT'), alpha=False)
    flat_scenes.assert_as_cycles(tmp_path)


@pytest.mark.parametrize('value', [float('nan'), float('inf'), -float('inf')])
def test_pixels_that_are_no_numbers(value: float, tmp_path: Path) -> None:
    made = flat()
    image = bpy.data.images.new('Made', SIZE, SIZE, float_buffer=True)
    paint(image, (value, 0.25, 0.5, 1.0))
    show(made, image, alpha=False)
    color, warnings = shown('COTORRA', tmp_path)
    assert color.tolist() == [0.0, 0.25, 0.5]
    assert warnings == ['Image "Made": some of its pixels are no finite numbers: 0 is used']
