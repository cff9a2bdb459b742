# SPDX-License-Identifier: GPL-3.0-or-later
"""Movies as image textures: the frame that is shown by frame, start, length, offset and cycle, beside Cycles' pictures.

The movie is made here, of six frames of one grey each. Sequences of files are test_export_images.py's.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra.export.image_files import ImageError
from cotorra.export.images import ImageTable
from cotorra.export.movies import read_frame
from cotorra.log import Log

from flat_scenes import Flat, assert_as_cycles, flat, shown
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

SIZE = (32, 16)
FRAMES = 6


@pytest.fixture(scope='module')
def movie(tmp_path_factory: pytest.TempPathFactory, engine: None) -> Path:
    """Six frames, 36 bytes brighter each."""
    folder = tmp_path_factory.mktemp('movie')
    scene = build.new_scene()
    for number in range(1, FRAMES + 1):
        image = bpy.data.images.new('Grey', *SIZE)
        image.pixels.foreach_set(np.tile(np.float32([*3 * (number * 36 / 255,), 1.0]), SIZE[0] * SIZE[1]))
        image.filepath_raw, image.file_format = str(folder / f'{number}.png'), 'PNG'
        image.save()
    strip = scene.sequence_editor_create().strips.new_image('Greys', str(folder / '1.png'), 1, 1)
    for number in range(2, FRAMES + 1):
        strip.elements.append(f'{number}.png')
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE, 100
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.view_settings.view_transform = 'Standard'
    if hasattr(render.image_settings, 'media_type'):
        render.image_settings.media_type = 'VIDEO'
    render.image_settings.file_format = 'FFMPEG'
    render.ffmpeg.format, render.ffmpeg.codec, render.ffmpeg.constant_rate_factor = 'MPEG4', 'H264', 'LOSSLESS'
    render.filepath, render.use_file_extension = str(folder / 'greys.mp4'), False
    bpy.ops.render.render(animation=True)
    return folder / 'greys.mp4'


def playing(movie: Path, start: int = 1, length: int = FRAMES, offset: int = 0, cyclic: bool = False) -> Flat:
    """A square that shines with the movie."""
    scene = flat()
    texture = scene.node('TexImage')
    texture.image = bpy.data.images.load(str(movie))
    user = texture.image_user
    user.frame_start, user.frame_duration, user.frame_offset, user.use_cyclic = start, length, offset, cyclic
    user.use_auto_refresh = True
    scene.link(texture.outputs['Color'], scene.emission.inputs['Color'])
    return scene


def test_frames_are_read_by_number(movie: Path) -> None:
    for frame, number in ((3, 3), (1, 1), (FRAMES, FRAMES), (2, 2), (-4, 1), (0, 1), (99, FRAMES)):
        pixels, damage = read_frame(str(movie), frame, False).read()
        assert pixels.shape == (SIZE[1], SIZE[0], 4) and pixels.dtype == np.uint8 and not damage
        assert np.abs(pixels[..., :3].astype(int) - number * 36).max() <= 2, frame  # YUV has fewer steps


@pytest.mark.parametrize(
    'user',
    [
        {},
        {'start': 3},
        {'length': 4},
        {'offset': 2},
        {'offset': -2},
        {'length': 3, 'cyclic': True},
        {'start': 2, 'length': 4, 'offset': 1, 'cyclic': True},
        {'length': 100},
    ],
    ids=str,
)
def test_a_movie_shows_the_frame_that_cycles_shows(user: dict[str, object], movie: Path, tmp_path: Path) -> None:
    scene = playing(movie, **user).scene
    for frame in (-1, 1, 4, 9):
        scene.frame_set(frame)
        assert_as_cycles(tmp_path, which=f'frame {frame}')


def test_an_animation_shows_each_frame_also_where_data_are_kept(movie: Path, tmp_path: Path) -> None:
    scene = playing(movie).scene
    scene.render.use_persistent_data = True
    seen = []
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
        color, warnings = shown('COTORRA', tmp_path)
        assert not warnings
        seen.append(color[0])
    assert (np.diff(seen) > 0.01).all()


def test_frames_that_are_no_longer_shown_are_let_go(movie: Path) -> None:
    texture = playing(movie).tree.nodes['Image Texture']
    table = ImageTable(Log(), 1)
    for frame in range(1, FRAMES + 1):
        table = table.for_next(Log(), frame)
        table.load(texture.image, texture.image_user)
        assert len(table.images) <= 2


def test_what_is_no_movie_is_named(tmp_path: Path) -> None:
    path = tmp_path / 'broken.mp4'
    path.write_bytes(b'no movie at all')
    with pytest.raises(ImageError, match='Blender can read|cannot be read'):
        read_frame(str(path), 1, False)
    scene = playing(path)
    color, warnings = shown('COTORRA', tmp_path)
    assert tuple(color) == (1.0, 0.0, 1.0) and 'broken.mp4' in warnings[0], (scene.tree.name, warnings)
