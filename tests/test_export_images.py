# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files, packed files, generated images and sequences become arrays of their own depth, the lowest row first.

What is expected of alpha and colour was measured with Cycles 5.2.3. Which inputs read images is tested elsewhere.
"""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from cotorra.export import image_files
from cotorra.export.buffers import SceneBuffers
from cotorra.export.images import ImageTable, image_path, sequence_frame
from cotorra.log import Log

from scenes import build
from scenes.materials import constants
from scenes.textured import lookups, show, textured

TYPES = {'uint8': 'uint8', 'uint16': 'uint16', 'float16': 'half', 'float32': 'float'}
ENDINGS = {'uint8': 'png', 'uint16': 'png', 'float16': 'exr', 'float32': 'exr'}


def texels(channels: int, dtype: type = np.uint8, height: int = 3, width: int = 2) -> np.ndarray:
    """Numbers that are all different, the lowest row first."""
    count = height * width * channels
    numbers = (np.arange(count) * 5 + 1).reshape(height, width, channels)
    return (numbers / count if np.dtype(dtype).kind == 'f' else numbers).astype(dtype)


def write(path: Path, pixels: np.ndarray) -> Path:
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, TYPES[pixels.dtype.name])
    spec.attribute('oiio:UnassociatedAlpha', 1)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(np.ascontiguousarray(pixels[::-1])), file.geterror()
    file.close()
    return path


def loaded(path: Path, space: str = 'Non-Color', alpha: str = 'STRAIGHT') -> bpy.types.Image:
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = space
    image.alpha_mode = alpha
    return image


def shown(*images: bpy.types.Image) -> tuple[SceneBuffers, list[str]]:
    materials = []
    for image in images:
        material, node = textured()
        node.image = image
        materials.append(material)
    return show(*materials)


# ---- Depth, channels, rows.


@pytest.mark.parametrize('dtype', [np.uint8, np.uint16, np.float16, np.float32])
@pytest.mark.parametrize('channels', [1, 3, 4])
def test_pixels_keep_their_depth(dtype: type, channels: int, tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(channels, dtype)
    path = write(tmp_path / f'image.{ENDINGS[np.dtype(dtype).name]}', pixels)
    buffers, warnings = shown(loaded(path))
    [image] = buffers.images
    assert image.pixels.dtype == dtype and image.pixels.flags.c_contiguous and not image.srgb and not warnings
    np.testing.assert_array_equal(image.pixels, pixels)


def test_gray_with_alpha(tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(2)
    [image] = shown(loaded(write(tmp_path / 'image.png', pixels)))[0].images
    np.testing.assert_array_equal(image.pixels, pixels)


def test_more_than_four_channels(tmp_path: Path) -> None:
    """As in Cycles: the first four."""
    build.new_scene()
    pixels = texels(6, np.float32)
    [image] = shown(loaded(write(tmp_path / 'image.tif', pixels)))[0].images
    np.testing.assert_array_equal(image.pixels, pixels[:, :, :4])


# ---- Alpha.


@pytest.mark.parametrize(
    ('space', 'alpha', 'multiplied'),
    [
        ('sRGB', 'STRAIGHT', True),
        ('sRGB', 'PREMUL', False),
        ('sRGB', 'CHANNEL_PACKED', False),
        ('Non-Color', 'STRAIGHT', False),
    ],
)
@pytest.mark.parametrize('dtype', [np.uint8, np.uint16])
def test_alpha_modes(space: str, alpha: str, multiplied: bool, dtype: type, tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(4, dtype)
    [image] = shown(loaded(write(tmp_path / 'image.png', pixels), space, alpha))[0].images
    expected = pixels.copy()
    if multiplied:
        wide = pixels.astype(np.uint64)
        expected[:, :, :3] = wide[:, :, :3] * wide[:, :, 3:] // np.iinfo(dtype).max
    np.testing.assert_array_equal(image.pixels, expected)


def test_alpha_that_is_ignored_is_left_out(tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(4)
    [image] = shown(loaded(write(tmp_path / 'image.png', pixels), 'sRGB', 'NONE'))[0].images
    np.testing.assert_array_equal(image.pixels, pixels[:, :, :3])


def test_float_alpha_is_multiplied(tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(4, np.float32)
    [image] = shown(loaded(write(tmp_path / 'image.tif', pixels), 'Linear Rec.709'))[0].images
    np.testing.assert_allclose(image.pixels[:, :, :3], pixels[:, :, :3] * pixels[:, :, 3:], rtol=1e-6)


# ---- Colour spaces.


@pytest.mark.parametrize(
    ('space', 'srgb'), [('sRGB', True), ('Non-Color', False), ('Linear Rec.709', False), ('scene_linear', False)]
)
def test_colors_that_are_kept_as_they_are(space: str, srgb: bool, tmp_path: Path) -> None:
    build.new_scene()
    path = write(tmp_path / 'image.png', texels(3))
    image = loaded(path)
    try:
        image.colorspace_settings.name = space
    except TypeError:
        pytest.skip(f'this Blender has no colour space {space}')
    [image] = shown(image)[0].images
    assert image.srgb == srgb and image.pixels.dtype == np.uint8


def test_colors_of_other_spaces_are_converted(tmp_path: Path) -> None:
    """Linear Rec.2020 to Rec.709 by the matrix of ITU-R BT.2087-0, inverted; to half floats, as in Cycles."""
    build.new_scene()
    pixels = texels(4)
    image = loaded(write(tmp_path / 'image.png', pixels), 'Linear Rec.2020', 'CHANNEL_PACKED')
    buffers, warnings = shown(image)
    [found] = buffers.images
    matrix = np.linalg.inv([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
    assert found.pixels.dtype == np.float16 and not found.srgb and not warnings
    expected = np.concatenate([pixels[:, :, :3] / 255.0 @ matrix.T, pixels[:, :, 3:] / 255.0], axis=2)
    np.testing.assert_allclose(found.pixels, expected, atol=2e-3)  # half floats, a matrix of four digits


def test_space_that_cannot_be_converted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build.new_scene()
    monkeypatch.setenv('OCIO', str(tmp_path / 'nothing.ocio'))
    image = loaded(write(tmp_path / 'image.png', texels(3)), 'Linear Rec.2020')
    buffers, [warning] = shown(image)
    assert buffers.images[0].pixels.dtype == np.uint8
    assert warning.startswith(
        'Image "image.png": colour space "Linear Rec.2020" cannot be converted to "Linear Rec.709" ('
    )


# ---- One copy.


def test_two_images_of_one_file_are_one(tmp_path: Path) -> None:
    build.new_scene()
    path = write(tmp_path / 'image.png', texels(3))
    first, second, other = loaded(path), loaded(path), loaded(path, 'sRGB')
    assert first != second
    assert len(shown(first, second, other)[0].images) == 2  # other is read as another colour space


# ---- Packed and generated.


@pytest.mark.parametrize('dtype', [np.uint8, np.float32])
def test_packed(dtype: type, tmp_path: Path) -> None:
    build.new_scene()
    pixels = texels(4, dtype)
    path = write(tmp_path / f'image.{ENDINGS[np.dtype(dtype).name]}', pixels)
    first, second = loaded(path), loaded(path)
    for image in (first, second):
        image.pack()
    path.unlink()
    buffers, warnings = shown(first, second)
    [image] = buffers.images
    assert not warnings
    np.testing.assert_array_equal(image.pixels, pixels)


@pytest.mark.parametrize('ending', ['png', 'jpg'])
def test_packed_bytes_are_decoded_once(ending: str, tmp_path: Path) -> None:
    """By us: Blender, which is not asked for their size, does not decode them for nothing."""
    build.new_scene()
    image = loaded(write(tmp_path / f'image.{ending}', texels(3, height=16, width=16)))
    image.pack()
    image.buffers_free()
    assert not image.has_data
    buffers, warnings = shown(image)
    assert buffers.images[0].pixels.shape == (16, 16, 3) and not warnings and not image.has_data


def test_files_are_decoded_by_other_threads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    threads = set()
    read = image_files.OpenImage.read

    def noted(file: image_files.OpenImage) -> object:
        threads.add(threading.current_thread())
        return read(file)

    monkeypatch.setattr(image_files.OpenImage, 'read', noted)
    build.new_scene()
    paths = [write(tmp_path / f'{index}.png', texels(3) + np.uint8(index)) for index in range(4)]
    buffers, warnings = shown(*map(loaded, paths))
    assert threading.current_thread() not in threads and not warnings
    for index, image in enumerate(buffers.images):
        np.testing.assert_array_equal(image.pixels, texels(3) + np.uint8(index))


def test_packed_rubbish() -> None:
    build.new_scene()
    image = bpy.data.images.new('Rubbish', 2, 2)
    image.pack(data=b'no image at all', data_len=15)
    image.source = 'FILE'
    buffers, [warning] = shown(image)
    assert constants(buffers, 1)['base_color'] == [1, 0, 1] and not buffers.images
    assert warning.startswith('Material "Material": node "Image Texture": image "Rubbish" cannot be read from')
    assert 'cotorra-' not in warning  # no name of a passing file


@pytest.mark.parametrize('is_float', [False, True])
def test_generated(is_float: bool) -> None:
    build.new_scene()
    image = bpy.data.images.new('Made', 2, 3, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = 'Non-Color'
    pixels = texels(4, np.float32 if is_float else np.uint8)
    image.pixels.foreach_set((pixels if is_float else pixels / 255).astype(np.float32).ravel())
    [found] = shown(image)[0].images
    assert found.pixels.dtype == pixels.dtype and found.name == 'Made'
    np.testing.assert_array_equal(found.pixels, pixels)


# ---- Sequences and tiles.


@pytest.mark.parametrize(
    ('frame', 'start', 'count', 'offset', 'cyclic', 'expected'),
    [
        (1, 1, 10, 0, False, 1),
        (5, 1, 10, 0, False, 5),
        (5, 3, 10, 20, False, 23),
        (50, 1, 10, 0, False, 10),
        (-5, 1, 10, 0, False, 0),
        (11, 1, 10, 0, True, 1),
        (10, 1, 10, 0, True, 10),
        (0, 1, 10, 0, True, 10),
        (7, 1, 0, 3, False, 0),
    ],
)
def test_sequence_frame(frame: int, start: int, count: int, offset: int, cyclic: bool, expected: int) -> None:
    class User:
        frame_start, frame_duration, frame_offset, use_cyclic = start, count, offset, cyclic

    assert sequence_frame(User, frame) == expected


def test_sequence(tmp_path: Path) -> None:
    scene = build.new_scene()
    for number in (8, 9, 10):
        write(tmp_path / f'v2_frame_{number:03}.png', np.full((1, 1, 3), number, np.uint8))
    image = loaded(tmp_path / 'v2_frame_008.png')
    image.source = 'SEQUENCE'
    material, node = textured()
    node.image = image
    node.image_user.frame_start, node.image_user.frame_duration, node.image_user.frame_offset = 1, 3, 7
    for frame, number in ((1, 8), (3, 10), (4, 10)):
        scene.frame_set(frame)
        buffers, warnings = show(material)
        assert buffers.images[0].pixels[0, 0, 0] == number and not warnings
    scene.frame_set(0)
    buffers, [warning] = show(material)
    assert not buffers.images and warning.endswith(f'image "{image.name}" has no file at "{tmp_path}/v2_frame_007.png"')


def test_sequence_without_a_number(tmp_path: Path) -> None:
    build.new_scene()
    image = loaded(write(tmp_path / 'still.png', texels(3)))
    image.source = 'SEQUENCE'
    assert image_path(image, 7) == str(tmp_path / 'still.png')


def tiles(folder: Path) -> bpy.types.Image:
    image = loaded(write(folder / 'tile.1001.png', texels(3)))
    write(folder / 'tile.1002.png', texels(3) + 1)
    image.source = 'TILED'
    image.filepath = str(folder / 'tile.<UDIM>.png')
    image.tiles.new(1002)
    return image


def test_tiles_are_images_of_their_own(tmp_path: Path) -> None:
    build.new_scene()
    buffers, warnings = shown(tiles(tmp_path))
    missing, first, second = (image.pixels for image in buffers.images)
    assert missing.tolist() == [[[255, 0, 255]]]  # outside of all tiles
    np.testing.assert_array_equal(first, texels(3))
    np.testing.assert_array_equal(second, texels(3) + 1)
    assert not warnings


def test_tiles_show_the_first_where_projected(tmp_path: Path) -> None:
    build.new_scene()
    material, node = textured()
    node.image, node.projection = tiles(tmp_path), 'BOX'
    buffers, warnings = show(material)
    [image] = buffers.images
    np.testing.assert_array_equal(image.pixels, texels(3))
    assert warnings == [f'Image "{node.image.name}": UDIM tiles are not supported yet: the first is shown']


# ---- Files that are broken.


@pytest.mark.parametrize('how', ['empty', 'text', 'cut', 'folder'])
def test_broken_file_is_magenta(how: str, tmp_path: Path) -> None:
    build.new_scene()
    path = write(tmp_path / 'image.png', texels(3, height=64, width=64))
    image = loaded(path)
    whole = path.read_bytes()
    if how == 'folder':
        path.unlink()
        path.mkdir()
    else:
        path.write_bytes({'empty': b'', 'text': b'no image', 'cut': whole[: len(whole) // 2]}[how])
    buffers, [warning] = shown(image)
    assert constants(buffers, 1)['base_color'] == [1, 0, 1] and not buffers.images
    assert warning.startswith('Material "Material": node "Image Texture": image "image.png" ') and str(path) in warning


def test_damaged_jpeg_is_shown_as_far_as_it_goes(tmp_path: Path) -> None:
    """As in Cycles: its library reads on."""
    build.new_scene()
    path = write(tmp_path / 'image.jpg', texels(3, height=64, width=64))
    image = loaded(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 3 // 4])
    buffers, [warning] = shown(image)
    assert lookups(buffers)[0].image == 0 and buffers.images[0].pixels.shape == (64, 64, 3)
    assert warning.startswith('Image "image.jpg" is damaged (')


def test_a_blender_without_openimageio_shows_its_own_pixels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Distributions' may have none: files are then read by Blender, and what cannot be is named."""
    monkeypatch.setattr(image_files, 'available', lambda: False)
    build.new_scene()
    image = bpy.data.images.new('Saved', 2, 2)
    image.pixels = [0.2, 0.4, 0.6, 1.0] * 4
    image.filepath_raw, image.file_format = str(tmp_path / 'saved.png'), 'PNG'
    image.save()
    loaded = bpy.data.images.load(str(tmp_path / 'saved.png'))
    log = Log()
    table = ImageTable(log, 1)
    user = SimpleNamespace()
    found = table.load(loaded, user)
    assert not isinstance(found, str), found
    assert (table.images[found.index].pixels == np.array((51, 102, 153, 255), np.uint8)).all()
    missing = table.load_file(str(tmp_path / 'saved.png'))
    assert missing == 'image "saved.png" cannot be read: this Blender has no OpenImageIO'
