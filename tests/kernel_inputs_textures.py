# SPDX-License-Identifier: GPL-3.0-or-later
"""Images and what goes with them, for the small scene of kernel_inputs.py; noise, not pictures."""

from __future__ import annotations

import numpy as np

from kernel_parity import Scene
from kernel_source import constants, dtype_of

# Width, height, channels and texels of each image.
IMAGES = ((5, 3, 4, np.uint8), (7, 4, 3, np.uint16), (4, 6, 2, np.float16), (1, 2, 1, np.float32))


def _images(rng: np.random.Generator) -> tuple[np.ndarray, list[tuple[int, str, np.ndarray]]]:
    records, nested = np.zeros(len(IMAGES), dtype_of('Texture')), []
    for index, (width, height, channels, kind) in enumerate(IMAGES):
        values = rng.random(width * height * channels)
        if np.dtype(kind).kind == 'u':
            values *= np.iinfo(kind).max
        data = values.astype(kind).tobytes()
        words = np.frombuffer(data + bytes(-len(data) % 4), np.uint32)
        nested.append((index, 'texels', words))
        records[index]['width'], records[index]['height'], records[index]['channels'] = width, height, channels
        records[index]['format'], records[index]['srgb'] = index, index == 0
    return records, nested


def add_textures(scene: Scene, rng: np.random.Generator, corners: int, vertices: int) -> None:
    """Gives a scene images, meshes that have tangents and generated coordinates, and materials without programs."""
    known = constants()
    images, texels = _images(rng)
    scene.arrays['textures'], scene.nested['textures'] = images, texels
    scene.data['texture_count'], scene.data['uv_layer_count'] = len(images), 2
    scene.data['camera_spread'], scene.data['camera_near'] = 0.001, 0.125

    programs = np.zeros(len(scene.arrays['materials']), dtype_of('MaterialProgram'))
    for part in ('surface', 'emission', 'transparency'):
        programs[part]['first'] = known['NO_PROGRAM']
    scene.arrays['programs'] = programs

    meshes = scene.arrays['meshes']
    more = np.zeros(len(meshes), dtype_of('MeshTextures'))
    more['corner_count'], more['uv_layers'], more['tangent_layers'] = corners, 2, 1
    more['uv_layers'][0], more['tangent_layers'][0] = 0, 0
    more['attribute_words'] = 2
    more['moved'] = np.arange(len(meshes)) % 2
    for name in ('x_axis', 'y_axis', 'z_axis', 'normal_x', 'normal_y', 'normal_z'):
        more[name] = rng.normal(size=(len(meshes), 3))
    meshes['flags'][1:] |= known['MESH_HAS_GENERATED']
    scene.arrays['mesh_textures'] = more
    scene.nested['mesh_textures'] = [
        (index, name, array)
        for index in range(len(meshes))
        for name, array in (
            ('tangents', rng.normal(size=(corners, 4)).astype(np.float32)),
            ('generated', rng.random((vertices, 3)).astype(np.float32)),
            ('attributes', rng.random((corners, 4)).astype(np.float32)),
            ('attribute_table', np.array([index % 4 | 3 << known['ATTRIBUTE_COMPONENTS_SHIFT'], 0], np.uint32)),
        )
    ]
    spaces = np.zeros(len(scene.arrays['instances']), dtype_of('ObjectSpace'))
    for name in 'xyz':
        spaces[name] = rng.normal(size=(len(spaces), 4))
    scene.arrays['object_spaces'] = spaces
