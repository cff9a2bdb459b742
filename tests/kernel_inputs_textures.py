# SPDX-License-Identifier: GPL-3.0-or-later
"""Images, slots and what goes with them, for the small scene of kernel_inputs.py; noise, not pictures."""

from __future__ import annotations

import numpy as np

from kernel_parity import Scene
from kernel_source import constants, dtype_of

# Width, height, channels and texels of each image.
IMAGES = ((5, 3, 4, np.uint8), (7, 4, 3, np.uint16), (4, 6, 2, np.float16), (1, 2, 1, np.float32))
SLOTS = 24


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


def _slots(rng: np.random.Generator) -> np.ndarray:
    slots = np.zeros(SLOTS, dtype_of('TextureSlot'))
    for name in ('mapping_s', 'mapping_t'):
        slots[name] = rng.normal(size=(SLOTS, 4))
    slots['scale'], slots['offset'] = rng.normal(size=(2, SLOTS, 3))
    slots['threshold'] = np.where(rng.random(SLOTS) < 0.3, 0.5, 1e30)
    slots['image'] = np.arange(SLOTS) % len(IMAGES)
    for name, count in (('channel', 6), ('coordinates', 4), ('uv_layer', 3), ('interpolation', 3), ('extension', 4)):
        slots[name] = rng.integers(0, count, SLOTS)
    slots['flags'] = rng.integers(0, 2, SLOTS)
    slots['lookup'] = np.arange(SLOTS)
    slots[1::4] = slots[::4]  # the same texel, another use
    slots['channel'][1::4], slots['scale'][1::4] = constants()['CHANNEL_G'], 1.0
    return slots


def add_textures(scene: Scene, rng: np.random.Generator, corners: int, vertices: int) -> None:
    """Gives a scene images and slots, meshes that have tangents and generated coordinates, materials that read them."""
    known = constants()
    images, texels = _images(rng)
    scene.arrays['textures'], scene.nested['textures'] = images, texels
    scene.arrays['texture_slots'] = _slots(rng)

    materials = scene.arrays['materials']
    count = len(materials)
    materials['flags'][:-1] |= known['MATERIAL_TEXTURED'] | known['MATERIAL_TRANSPARENT']
    inputs = np.zeros(count, dtype_of('MaterialInputs'))
    for name in inputs.dtype.names[:9]:
        inputs[name] = rng.integers(-1, SLOTS, count)
    inputs['normal'][:2] = 0, 5
    inputs['normal_strength'] = rng.choice((1.0, 0.4, 2.0), count)
    inputs['tangent_layer'], inputs['normal_space'] = rng.integers(0, 2, count), np.arange(count) % 3
    scene.arrays['material_inputs'] = inputs

    meshes = scene.arrays['meshes']
    more = np.zeros(len(meshes), dtype_of('MeshTextures'))
    more['corner_count'], more['uv_layers'], more['tangent_layers'] = corners, 2, 1
    more['uv_layers'][0], more['tangent_layers'][0] = 0, 0
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
        )
    ]
    spaces = np.zeros(len(scene.arrays['instances']), dtype_of('ObjectSpace'))
    for name in 'xyz':
        spaces[name] = rng.normal(size=(len(spaces), 4))
    scene.arrays['object_spaces'] = spaces
