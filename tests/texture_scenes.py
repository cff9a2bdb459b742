# SPDX-License-Identifier: GPL-3.0-or-later
"""Textured planes as NumPy arrays, rendered by the native module without Blender; and images in double precision.

The reference is written from what addon/export/buffers.py says of slots, not from the kernels.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from cotorra import native
from cotorra.export import buffers as b

F32, U32, I32 = np.float32, np.uint32, np.int32
SIZE = 48  # of a picture, pixels
ASIDE = 0.0013  # of the camera, metres: no pixel lies on the diagonal of a square, which belongs to two triangles
INPUTS = b.TEXTURED_INPUTS
LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


def slot(image: int = 0, **values: Any) -> np.ndarray:
    """One slot: the image's colours by the first UV layer, linear, repeated."""
    record = np.zeros(1, b.TEXTURE_SLOT)
    record['mapping_s'], record['mapping_t'] = (1, 0, 0, 0), (0, 1, 0, 0)
    record['scale'], record['threshold'] = 1.0, np.nan
    record['image'], record['interpolation'] = image, b.INTERPOLATION_LINEAR
    for name, value in values.items():
        record[name] = value
    return record


def textures(slots: list[np.ndarray], inputs: list[dict[str, int]], **normal: Any) -> b.MaterialTextures:
    """What materials read: for each a dictionary from the name of an input to its slot."""
    table = np.full((len(inputs), len(INPUTS)), -1, I32)
    for material, entry in enumerate(inputs):
        for name, index in entry.items():
            table[material, INPUTS.index(name)] = index
    count = len(inputs)
    return b.MaterialTextures(
        slots=np.concatenate(slots) if slots else np.zeros(0, b.TEXTURE_SLOT),
        inputs=table,
        normal_strength=np.full(count, normal.get('strength', 1.0), F32),
        normal_tangent=np.zeros(count, U32),
        normal_space=np.full(count, normal.get('space', b.NORMAL_TANGENT), U32),
    )


def materials(count: int = 1, **values: Any) -> b.Materials:
    """Lambertian materials of albedo 0.8; `values` replace arrays."""
    arrays = {
        'base_color': np.full((count, 3), 0.8, F32),
        'metallic': np.zeros(count, F32),
        'roughness': np.full(count, 0.5, F32),
        'ior': np.ones(count, F32),
        'specular_level': np.full(count, 0.5, F32),
        'specular_tint': np.ones((count, 3), F32),
        'emission': np.zeros((count, 3), F32),
        'alpha': np.ones(count, F32),
        'multi_ggx': np.ones(count, U32),
        'pass_index': np.zeros(count, I32),
        'emission_sampling': np.ones(count, U32),
    }
    for name, value in values.items():
        like = arrays.get(name)
        arrays[name] = value if like is None or isinstance(value, tuple) else np.asarray(value, like.dtype)
    return b.Materials(**arrays)


def plane(low: float = -1.0, high: float = 1.0, z: float = 0.0, uv: tuple[float, float] = (0.0, 1.0)) -> b.Mesh:
    """A square that looks up; its UV run from uv[0] to uv[1] in both directions."""
    positions = np.zeros((5, 3), F32)  # a vertex more, so that the buffer is padded
    positions[:4] = [[low, low, z], [high, low, z], [high, high, z], [low, high, z]]
    near, far = uv
    return b.Mesh(
        name='plane',
        positions=positions[:4],
        triangles=np.array([[0, 1, 2], [0, 2, 3]], U32),
        corners=np.array([[0, 1, 2], [0, 2, 3]], U32),
        uv=np.array([[near, near], [far, near], [far, far], [near, far]], F32),
    )


def instances(count: int = 1, transform: np.ndarray | None = None, **values: Any) -> b.Instances:
    """Objects that show mesh 0, 1 and so on, with material slots 0, 1 and so on."""
    frame = np.broadcast_to(np.eye(3, 4, dtype=F32), (count, 3, 4)) if transform is None else transform
    return replace(
        b.Instances(
            mesh=np.arange(count, dtype=U32),
            transform=np.ascontiguousarray(frame, F32),
            material_base=np.arange(count, dtype=U32),
            material_count=np.ones(count, U32),
            pass_index=np.zeros(count, I32),
            visibility=np.full(count, 63, U32),
            light_group=np.full(count, -1, I32),
            terminator=np.zeros(count, F32),
        ),
        **values,
    )


def lights(*suns: tuple[tuple[float, float, float], float]) -> b.Lights:
    """Suns without a size: (direction of travel, irradiance)."""
    count = len(suns)
    transform = np.zeros((count, 3, 4), F32)
    for k, (direction, _) in enumerate(suns):
        z = -np.array(direction, float) / np.linalg.norm(direction)
        x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
        x /= np.linalg.norm(x)
        transform[k, :, 0], transform[k, :, 1], transform[k, :, 2] = x, np.cross(z, x), z
    return b.Lights(
        type=np.full(count, b.LIGHT_SUN, U32),
        strength=np.array([[e] * 3 for _, e in suns], F32).reshape(count, 3),
        transform=transform,
        size=np.zeros(count, F32),
        spot_size=np.ones(count, F32),
        spot_blend=np.ones(count, F32),
        soft_falloff=np.ones(count, U32),
        normalize=np.ones(count, U32),
        cast_shadow=np.ones(count, U32),
        use_mis=np.ones(count, U32),
        max_bounces=np.full(count, 1024, U32),
        visibility=np.full(count, 63, U32),
        light_group=np.full(count, -1, I32),
    )


def scene(meshes: tuple[b.Mesh, ...], made: b.Materials, **values: Any) -> b.SceneBuffers:
    values.setdefault('instances', instances(len(meshes)))
    values.setdefault('lights', lights())
    values.setdefault('material_slots', np.arange(len(made.metallic), dtype=U32))
    values.setdefault('world', b.World())
    return b.SceneBuffers(meshes=meshes, materials=made, **values)


def camera(half: float = 1.0, size: int = SIZE, height: float = 5.0) -> b.Camera:
    """From above, orthographic, every sample at the centre of its pixel."""
    transform = np.eye(3, 4, dtype=F32)
    transform[0, 3], transform[2, 3] = ASIDE, height
    window = (-half, half, -half, half)
    return b.Camera('ORTHO', transform, window, (0.01, 100.0), (size, size), (0, 0, size, size), filter_width=1e-6)


def centres(half: float = 1.0, size: int = SIZE) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the pixels of `camera`, in metres."""
    at = ((np.arange(size) + 0.5) / size * 2.0 - 1.0) * half
    return np.meshgrid(at + ASIDE, at)


def render(made: b.SceneBuffers, seen_by: b.Camera | None = None, **settings: Any) -> dict[str, np.ndarray]:
    """The passes that were asked for; Combined is always among them."""
    module = native.load()
    seen_by = camera() if seen_by is None else seen_by
    passes = settings.setdefault('passes', ('combined',))
    settings = {'integrator': 'DIRECT', 'samples': 1} | settings
    built = module.Scene(made, threads=1, embree=native.embree_library())
    session = module.Session(built, seen_by, b.RenderSettings(**settings))
    session.start()
    assert session.wait(300.0)
    result = {}
    for name in passes:
        shape = (seen_by.region[3], seen_by.region[2], b.PASSES.get(name, 3))
        result[name] = np.zeros(shape, F32)
        session.read(name, result[name])
    result['stats'] = session.stats()
    return result


# ---- Images, in double precision


def numbers(image: b.Image) -> np.ndarray:
    """(H, W, 4) RGBA."""
    p = image.pixels
    values = p.astype(np.float64) / np.iinfo(p.dtype).max if p.dtype.kind == 'u' else p.astype(np.float64)
    grey = values.shape[2] <= 2
    rgb = np.repeat(values[:, :, :1], 3, axis=2) if grey else values[:, :, :3]
    alpha = values[:, :, -1:] if values.shape[2] in (2, 4) else np.ones_like(rgb[:, :, :1])
    return np.concatenate([rgb, alpha], axis=2)


def _index(i: np.ndarray, n: int, extension: int) -> np.ndarray:
    """Where texel i is read; n stands for nowhere."""
    if extension == b.EXTENSION_REPEAT:
        return np.mod(i, n)
    if extension == b.EXTENSION_EXTEND:
        return np.clip(i, 0, n - 1)
    if extension == b.EXTENSION_CLIP:
        return np.where((i >= 0) & (i < n), i, n)
    m = np.mod(i, 2 * n)
    return np.where(m < n, m, 2 * n - 1 - m)


def filtered(image: b.Image, s: np.ndarray, t: np.ndarray, interpolation: int, extension: int) -> np.ndarray:
    """(..., 4) RGBA at s, t."""
    texels = np.pad(numbers(image), ((0, 1), (0, 1), (0, 0)))
    h, w = image.pixels.shape[:2]
    x, y = s * w, t * h
    if interpolation == b.INTERPOLATION_CLOSEST:
        taps = [(0, np.ones_like(x))], [(0, np.ones_like(y))]
    else:
        x, y = x - 0.5, y - 0.5
        taps = tuple(_taps(v - np.floor(v), interpolation) for v in (x, y))
    total = np.zeros((*x.shape, 4))
    for dx, wx in taps[0]:
        for dy, wy in taps[1]:
            column = _index(np.floor(x).astype(int) + dx, w, extension)
            row = _index(np.floor(y).astype(int) + dy, h, extension)
            total += texels[row, column] * (wx * wy)[..., None]
    return total


def _taps(f: np.ndarray, interpolation: int) -> list[tuple[int, np.ndarray]]:
    """Offsets and weights about the texel below; the cubic one is the uniform B-spline by its pieces."""
    if interpolation == b.INTERPOLATION_LINEAR:
        return [(0, 1.0 - f), (1, f)]

    def spline(d: np.ndarray) -> np.ndarray:
        d = np.abs(d)
        return np.where(d < 1.0, 2.0 / 3.0 - d**2 + d**3 / 2.0, np.where(d < 2.0, (2.0 - d) ** 3 / 6.0, 0.0))

    return [(k, spline(f - k)) for k in (-1, 0, 1, 2)]


def decode(c: np.ndarray) -> np.ndarray:
    """sRGB to linear, IEC 61966-2-1."""
    return np.where(c < 0.04045, c / 12.92, ((np.maximum(c, 0.04045) + 0.055) / 1.055) ** 2.4)
