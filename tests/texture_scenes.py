# SPDX-License-Identifier: GPL-3.0-or-later
"""Textured planes as NumPy arrays, rendered by the native module without Blender; and images in double precision.

The reference is written from what is said here of a slot, not from the kernels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from cotorra import native
from cotorra.export import buffers as b

from shaders import Op, Sketch, Value

F32, U32, I32 = np.float32, np.uint32, np.int32
SIZE = 48  # of a picture, pixels
ASIDE = 0.0013  # of the camera, metres: no pixel lies on the diagonal of a square, which belongs to two triangles
NUMBERS = ('metallic', 'roughness', 'ior', 'specular_level', 'alpha')  # inputs that are no colours
ADD, MULTIPLY, GREATER_THAN = 0, 2, 16  # as the nodes Math and Vector Math count them
TANGENT, OBJECT, WORLD = range(3)  # spaces of normal maps
LUMINANCE = np.array((0.2126390, 0.7151687, 0.0721923))  # of Rec.709, as Cycles has it


@dataclass(frozen=True)
class Slot:
    """One use of an image: texels at mapping_s . (x, y, z, 1), mapping_t . (x, y, z, 1), then scale and offset.

    channel: RGB, R, G, B, A or LUMINANCE. coordinates: an op that needs no arguments, or 'uv' of layer `uv_layer`.
    threshold: the channel is 1 above and 0 below, if there is one. unassociate: colours are divided by alpha.
    """

    image: int = 0
    channel: str = 'RGB'
    coordinates: str = 'uv'
    uv_layer: int = 0
    mapping_s: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    mapping_t: tuple[float, ...] = (0.0, 1.0, 0.0, 0.0)
    interpolation: int = b.INTERPOLATION_LINEAR
    extension: int = b.EXTENSION_REPEAT
    unassociate: bool = False
    threshold: float | None = None
    scale: Value = 1.0
    offset: Value = 0.0

    def color(self, sketch: Sketch) -> Op:
        uv = self.coordinates == 'uv'
        at = sketch.op('attribute', self.uv_layer) if uv else sketch.op(self.coordinates)
        s, t = self.mapping_s, self.mapping_t
        at = sketch.op('affine', at, s[:3], t[:3], 0.0, (s[3], t[3], 0.0))
        mode = self.interpolation | self.extension << 2 | self.unassociate << 6
        if self.channel == 'A':
            value = sketch.op('splat', sketch.op('image_f', at, self.image, 0.0, 0.0, mode=mode))
        else:
            value = sketch.op('image_v', at, self.image, 0.0, 0.0, mode=mode)
        if self.channel == 'LUMINANCE':
            value = sketch.op('splat', sketch.op('luminance', value))
        elif self.channel in ('R', 'G', 'B'):
            value = sketch.op('splat', sketch.op('component', value, mode='RGB'.index(self.channel)))
        if self.threshold is not None:
            number = sketch.op('component', value)
            value = sketch.op('splat', sketch.op('math', number, self.threshold, 0.0, mode=GREATER_THAN))
        value = sketch.op('vector_math_v', value, self.scale, 0.0, 0.0, mode=MULTIPLY)
        return sketch.op('vector_math_v', value, self.offset, 0.0, 0.0, mode=ADD)

    def number(self, sketch: Sketch) -> Op:
        return sketch.op('component', self.color(sketch))


@dataclass(frozen=True)
class NormalMap:
    """A normal map with the tangents of layer 0."""

    slot: Slot
    strength: float = 1.0
    space: int = TANGENT

    def color(self, sketch: Sketch) -> Op:
        return sketch.op('normal_map', self.slot.color(sketch), self.strength, 0.0, mode=self.space)


@dataclass(frozen=True)
class Made:
    """Materials and their shaders, one each."""

    materials: b.Materials
    shaders: tuple[b.Shader, ...]


def materials(count: int = 1, emission_sampling: list[int] | None = None, **values: list[Any]) -> Made:
    """Lambertian materials of albedo 0.8; `values` are inputs of Principled, an entry a material: a value or a Slot, or
    None for what a new node has."""
    made = []
    for row in range(count):
        sketch = Sketch()
        inputs = {name: column[row] for name, column in ({'ior': [1.0] * count} | values).items()}
        inputs = {name: value for name, value in inputs.items() if value is not None}
        for name, value in inputs.items():
            if isinstance(value, (Slot, NormalMap)):
                inputs[name] = value.number(sketch) if name in NUMBERS else value.color(sketch)
        sketch.principled(**inputs)
        made.append(sketch.shader())
    table = b.Materials(
        pass_index=np.zeros(count, I32),
        emission_sampling=np.array(emission_sampling or [1] * count, U32),
        shader=np.arange(count, dtype=I32),
    )
    return Made(table, tuple(made))


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


def scene(meshes: tuple[b.Mesh, ...], made: Made, **values: Any) -> b.SceneBuffers:
    values.setdefault('instances', instances(len(meshes)))
    values.setdefault('lights', lights())
    values.setdefault('material_slots', np.arange(len(made.shaders), dtype=U32))
    values.setdefault('world', b.World())
    return b.SceneBuffers(meshes=meshes, materials=made.materials, shaders=made.shaders, **values)


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
