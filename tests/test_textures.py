# SPDX-License-Identifier: GPL-3.0-or-later
"""Images on surfaces, through the whole native engine: texels, filters, slots and coordinates against NumPy in double.

Normal maps are in test_normal_maps.py, transparency in test_transparency.py; Blender's nodes are the exporter's.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from cotorra import native
from cotorra.export import buffers as b

from shaders import Sketch
from texture_scenes import (
    LUMINANCE,
    Slot,
    camera,
    centres,
    decode,
    filtered,
    instances,
    lights,
    materials,
    numbers,
    plane,
    render,
    scene,
)

CLOSEST, LINEAR, CUBIC = b.INTERPOLATION_CLOSEST, b.INTERPOLATION_LINEAR, b.INTERPOLATION_CUBIC
EXTENSIONS = (b.EXTENSION_REPEAT, b.EXTENSION_EXTEND, b.EXTENSION_CLIP, b.EXTENSION_MIRROR)
# A float's error of a coordinate, 1e-7 of a few units, times the width of the image and the step between its texels.
TOLERANCE = 2e-5


def noise(kind: type = np.uint8, height: int = 5, width: int = 7, channels: int = 4, srgb: bool = False) -> b.Image:
    rng = np.random.default_rng(channels + 10 * np.dtype(kind).itemsize)
    values = rng.random((height, width, channels))
    if np.dtype(kind).kind == 'u':
        values = values * np.iinfo(kind).max
    return b.Image('noise', values.astype(kind), srgb)


def emitted(image: b.Image, record: Slot, mesh: b.Mesh | None = None, **values: object) -> np.ndarray:
    """What a plane looks like that emits what the slot reads."""
    made = materials(base_color=[0.0], emission=[record])
    meshes = (plane(uv=(-1.3, 2.6)) if mesh is None else mesh,)
    return render(scene(meshes, made, images=(image,), **values))['combined'][..., :3]


def uv_of_pixels(low: float = -1.3, high: float = 2.6) -> tuple[np.ndarray, np.ndarray]:
    x, y = centres()
    return low + (x + 1.0) / 2.0 * (high - low), low + (y + 1.0) / 2.0 * (high - low)


@pytest.mark.parametrize('interpolation', (CLOSEST, LINEAR, CUBIC), ids=('closest', 'linear', 'cubic'))
@pytest.mark.parametrize('extension', EXTENSIONS, ids=('repeat', 'extend', 'clip', 'mirror'))
def test_filters_and_extensions(interpolation: int, extension: int) -> None:
    image = noise(np.float32)
    seen = emitted(image, Slot(interpolation=interpolation, extension=extension))
    s, t = uv_of_pixels()
    expected = filtered(image, s, t, interpolation, extension)[..., :3]
    wrong = np.abs(seen - expected).max(axis=-1) > TOLERANCE
    # Within its rounding a coordinate falls on either side of a texel's edge.
    edge = np.minimum(*(np.abs(v * n - np.rint(v * n)) for v, n in ((s, 7), (t, 5)))) < 1e-5
    assert not (wrong & ~edge).any()


@pytest.mark.parametrize('channels', (1, 2, 3, 4))
@pytest.mark.parametrize('kind', (np.uint8, np.uint16, np.float16, np.float32), ids=lambda kind: kind.__name__)
def test_depths_and_channels(kind: type, channels: int) -> None:
    image = noise(kind, channels=channels)
    s, t = uv_of_pixels()
    expected = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)
    assert emitted(image, Slot()) == pytest.approx(expected[..., :3], abs=TOLERANCE)
    alpha = emitted(image, Slot(channel='A'))
    assert alpha == pytest.approx(np.repeat(expected[..., 3:], 3, axis=-1), abs=TOLERANCE)


def test_half_floats_of_all_sizes() -> None:
    """Subnormal numbers, zero, the largest; infinity and NaN become numbers."""
    values = np.array([0.0, 6e-8, 3e-5, 6.2e-5, 1.0, 1.5, 1000.0, 65504.0], np.float16)
    image = b.Image('half', np.repeat(values.reshape(1, -1, 1), 3, axis=2))
    seen = emitted(image, Slot(interpolation=CLOSEST), plane())
    x, _ = centres()
    expected = values.astype(float)[np.floor((x + 1.0) / 2.0 * len(values)).astype(int)]
    assert np.abs(seen[..., 0] - expected).max() <= 6e-8
    wild = b.Image('wild', np.array([np.inf, -np.inf, np.nan, 1.0], np.float16).reshape(1, 4, 1))
    assert np.isfinite(emitted(wild, Slot(), plane())).all()
    wild = b.Image('wild', np.array([np.inf, -np.inf, np.nan, 1.0], np.float32).reshape(1, 4, 1))
    assert np.isfinite(emitted(wild, Slot(), plane())).all()


def test_srgb_is_decoded_after_filtering() -> None:
    image = noise(np.uint8, srgb=True)
    s, t = uv_of_pixels()
    expected = decode(filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)[..., :3])
    assert emitted(image, Slot()) == pytest.approx(expected, abs=TOLERANCE)
    alpha = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)[..., 3]
    assert emitted(image, Slot(channel='A'))[..., 0] == pytest.approx(alpha, abs=TOLERANCE)


def test_colour_is_divided_by_alpha_after_filtering() -> None:
    image = noise(np.uint8, srgb=True)
    image.pixels[2, 3] = 0  # nothing there to divide
    s, t = uv_of_pixels()
    texel = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)
    straight = decode(texel[..., :3] / texel[..., 3:])
    seen = emitted(image, Slot(unassociate=True))
    assert seen == pytest.approx(straight, rel=2e-4, abs=TOLERANCE)


def test_channel_threshold_scale_offset() -> None:
    image = noise(np.float32)
    s, t = uv_of_pixels()
    texel = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)
    scale, offset = (2.0, -1.0, 0.5), (0.25, 1.5, 0.0)
    single = {'R': 0, 'G': 1, 'B': 2, 'A': 3}
    for channel, index in single.items():
        expected = texel[..., index, None] * scale + offset
        assert emitted(image, Slot(channel=channel, scale=scale, offset=offset)) == pytest.approx(expected, abs=1e-4)
    grey = (texel[..., :3] @ LUMINANCE)[..., None]
    assert emitted(image, Slot(channel='LUMINANCE')) == pytest.approx(np.repeat(grey, 3, -1), abs=TOLERANCE)
    clear = np.abs(grey - 0.5) > 1e-4
    step = emitted(image, Slot(channel='LUMINANCE', threshold=0.5, scale=3.0, offset=1.0))
    assert (step == np.where(grey < 0.5, 1.0, 4.0))[np.repeat(clear, 3, -1)].all()


def test_mapping_and_uv_layers() -> None:
    image = noise(np.float32)
    first = plane().uv
    mesh = replace(plane(), uv=np.concatenate([first, first[:, ::-1] * F(2.0, -3.0) + F(0.25, 0.5)]).astype(np.float32))
    record = Slot(uv_layer=1, mapping_s=(0.5, 0.25, 7.0, 0.125), mapping_t=(-0.5, 1.5, 7.0, 0.25))
    x, y = centres()
    u, v = (x + 1.0) / 2.0, (y + 1.0) / 2.0
    u, v = v * 2.0 + 0.25, u * -3.0 + 0.5
    s, t = 0.5 * u + 0.25 * v + 0.125, -0.5 * u + 1.5 * v + 0.25
    expected = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)[..., :3]
    layers = {'uv_layers': ('', 'second', 'third'), 'attribute_layers': ('', 'second', 'third')}
    assert emitted(image, record, mesh, **layers) == pytest.approx(expected, abs=TOLERANCE)
    beyond = emitted(image, Slot(uv_layer=2, interpolation=CLOSEST), mesh, **layers)
    assert beyond == pytest.approx(np.broadcast_to(numbers(image)[0, 0, :3], beyond.shape), abs=1e-6)


def F(*values: float) -> np.ndarray:
    return np.array(values, np.float32)


@pytest.mark.parametrize('shared', (False, True), ids=('flattened', 'instanced'))
def test_generated_object_and_world_coordinates(shared: bool) -> None:
    """On a mesh that was moved to world space, and on one that is instanced: a scale, a turn and a shift."""
    image = noise(np.float32)
    transform = np.array([[0.0, -2.0, 0.0, 0.1], [2.0, 0.0, 0.0, -0.2], [0.0, 0.0, 1.0, 0.3]], np.float32)
    full = np.vstack([transform, [0, 0, 0, 1]])
    back = np.linalg.inv(full)[:3]
    far = transform + np.array([[0, 0, 0, 50.0]] * 3, np.float32)
    frames = [transform, far] if shared else [transform]
    count = len(frames)
    placed = instances(
        count,
        np.stack(frames),
        mesh=np.zeros(count, np.uint32),
        material_base=np.zeros(count, np.uint32),
    )
    mesh = replace(plane(), generated=(plane().positions * 0.5 + 0.5).astype(np.float32))
    x, y = centres()
    world = np.stack([x, y, np.full_like(x, 0.3)], axis=-1)
    own = world @ back[:, :3].T + back[:, 3]
    coordinates = {
        'position': world,
        'object_position': own,
        'generated': own * 0.5 + 0.5,
    }
    for kind, p in coordinates.items():
        record = Slot(coordinates=kind, mapping_s=(0.5, 0.1, 0.3, 0.2), mapping_t=(0.2, 0.7, -0.4, 0.1))
        s = p @ (0.5, 0.1, 0.3) + 0.2
        t = p @ (0.2, 0.7, -0.4) + 0.1
        expected = filtered(image, s, t, LINEAR, b.EXTENSION_REPEAT)[..., :3]
        seen = emitted(image, record, mesh, instances=placed)
        assert seen == pytest.approx(expected, abs=TOLERANCE), kind


@pytest.mark.parametrize('bad', (np.nan, np.inf, -np.inf, 1e30, -3e38, 1e9))
def test_coordinates_that_are_no_numbers_or_huge(bad: float) -> None:
    for interpolation, extension in itertools.product((CLOSEST, LINEAR, CUBIC), EXTENSIONS):
        mesh = replace(plane(), uv=np.full((4, 2), bad, np.float32))
        seen = emitted(noise(), Slot(interpolation=interpolation, extension=extension), mesh)
        assert np.isfinite(seen).all() and seen.max() <= 1.0


def test_every_input_is_read() -> None:
    """Two halves of a plane, one textured with what the other has as constants, look alike to the last bits."""
    image = b.Image('values', np.array([[[0.2, 0.4, 0.6, 0.3]]], np.float32))
    names = {'base_color': 'RGB', 'metallic': 'A', 'roughness': 'G'}
    names |= {'specular_tint': 'RGB', 'specular_level': 'B', 'emission': 'RGB'}
    color = (0.2, 0.4, 0.6)
    constants = {'base_color': color, 'specular_tint': color, 'emission': color}
    constants |= {'metallic': 0.3, 'roughness': 0.4, 'specular_level': 0.6}
    made = materials(
        2,
        **{name: [Slot(channel=channel), constants[name]] for name, channel in names.items()},
        ior=[Slot(channel='R', offset=1.3), 1.5],
    )
    sun = lights(((0.3, 0.2, -1.0), 3.0))
    passes = ('combined', 'diffuse_color', 'emission')
    seen = [
        render(
            scene((plane(),), made, material_slots=np.array([k], np.uint32), images=(image,), lights=sun), passes=passes
        )
        for k in (0, 1)
    ]
    for name in passes:
        assert seen[0][name] == pytest.approx(seen[1][name], rel=1e-5), name
    assert seen[0]['combined'].max() > 0.1


def test_passes_show_textured_values() -> None:
    image = noise(np.float32)
    made = materials(base_color=[Slot()], emission=[Slot()])
    seen = render(scene((plane(),), made, images=(image,)), passes=('combined', 'diffuse_color', 'emission'))
    expected = filtered(image, *uv_of_pixels(0.0, 1.0), LINEAR, b.EXTENSION_REPEAT)[..., :3]
    assert seen['diffuse_color'] == pytest.approx(expected, abs=TOLERANCE)
    assert seen['emission'] == pytest.approx(expected, abs=TOLERANCE)


@pytest.mark.parametrize('kind', (np.uint8, np.uint16, np.float16, np.float32), ids=lambda kind: kind.__name__)
@pytest.mark.parametrize('interpolation', (CLOSEST, LINEAR, CUBIC), ids=('closest', 'linear', 'cubic'))
def test_surfaces_read_what_emission_reads(kind: type, interpolation: int) -> None:
    """Surfaces read many points at once, emission one at a time; some texels of floats are brighter than 1."""
    images = tuple(noise(kind, channels=channels, srgb=srgb) for channels in (3, 4) for srgb in (False, True))
    if kind is np.float32:
        images = tuple(replace(image, pixels=image.pixels * 3.0) for image in images)
    for extension, (number, image) in itertools.product(EXTENSIONS, enumerate(images)):
        slot = Slot(image=number, interpolation=interpolation, extension=extension, unassociate=number > 1)
        made = materials(base_color=[slot], emission=[slot])
        mesh = plane(uv=(-1.3, 2.6))
        seen = render(scene((mesh,), made, images=images), passes=('combined', 'diffuse_color', 'emission'))
        assert seen['diffuse_color'] == pytest.approx(seen['emission'], rel=1e-5, abs=1e-6), (image.srgb, extension)
        assert np.ptp(seen['emission']) > 0.1


def test_textured_emission_lights_the_scene() -> None:
    """A checker of light above a floor: light sampling with bounces, bounces alone, and Direct agree."""
    pattern = np.zeros((4, 4, 3), np.float32)
    pattern[::2, ::2] = (9.0, 4.0, 1.0)
    image = b.Image('checker', pattern)
    above = replace(plane(-0.5, 0.5, z=0.6), triangles=plane().triangles[:, ::-1].copy(), name='lamp')
    above = replace(above, corners=above.triangles)
    closest = Slot(interpolation=CLOSEST)
    view = camera(size=8, height=0.5)

    def floor(sampled: int, integrator: str) -> np.ndarray:
        made = materials(2, emission_sampling=[0, sampled], emission=[0.0, closest])
        return render(
            scene((plane(-3, 3), above), made, images=(image,)),
            view,
            samples=4096,
            integrator=integrator,
            max_bounces=1,
        )['combined'][..., :3]

    both, alone, direct = floor(1, 'PATH'), floor(0, 'PATH'), floor(1, 'DIRECT')
    assert both.mean(axis=(0, 1)) == pytest.approx(alone.mean(axis=(0, 1)), rel=0.01)
    assert np.abs(both - alone).max() < 0.08 * both.max()
    # By hand: irradiance of the four lit squares at the pixel nearest the middle.
    lit = np.array([(x + 0.125, y + 0.125) for x in (-0.5, 0.0) for y in (-0.5, 0.0)])
    grid = (np.arange(32) + 0.5) / 32 * 0.25 - 0.125
    q = (lit[:, None, None, :] + np.stack(np.meshgrid(grid, grid), -1)).reshape(-1, 2)
    x, y = centres(size=8)
    at = np.stack([x[4, 4], y[4, 4]])
    d2 = ((q - at) ** 2).sum(axis=1) + 0.36
    form = (0.36 / d2**2).sum() * (0.25 / 32) ** 2
    assert direct[4, 4] == pytest.approx(np.array((9.0, 4.0, 1.0)) * 0.8 / np.pi * form, rel=0.02)


def test_emission_from_one_side() -> None:
    """As importers make it; and the light on a floor, by light sampling and by bounces."""
    sketch = Sketch()
    front = sketch.op('math', 1.0, sketch.op('backfacing'), 0.0, mode=1)
    sketch.closure('emission', (4.0, 2.0, 1.0), weight=sketch.op('splat', front))
    one_sided = replace(materials(), shaders=(sketch.shader(),))
    above = render(scene((plane(),), one_sided), camera(size=4))['combined'][..., :3]
    assert above == pytest.approx(np.broadcast_to((4.0, 2.0, 1.0), above.shape), rel=1e-6)
    under = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, -5]], np.float32)
    below = render(scene((plane(),), one_sided), replace(camera(size=4), transform=under))['combined'][..., :3]
    assert not below.any()

    down = replace(plane(-0.5, 0.5, z=0.6), triangles=plane().triangles[:, ::-1].copy(), name='lamp')
    down = replace(down, corners=down.triangles)
    up = plane(-0.5, 0.5, z=0.6)

    def floor(lamp: b.Mesh, sampled: int) -> float:
        made = materials(2, emission_sampling=[0, sampled])
        made = replace(made, shaders=(made.shaders[0], sketch.shader()))
        view = camera(size=4, height=0.5)
        settings = {'samples': 4096, 'integrator': 'PATH', 'max_bounces': 1}
        return float(render(scene((plane(-3, 3), lamp), made), view, **settings)['combined'][..., 0].mean())

    assert floor(down, 1) == pytest.approx(floor(down, 0), rel=0.02) and floor(down, 1) > 0.1
    assert floor(up, 1) == floor(up, 0) == 0.0


def test_no_image_no_feature() -> None:
    image = noise()
    unused = materials(2, base_color=[0.8, Slot()])
    seen = render(scene((plane(),), unused, images=(image,), material_slots=np.zeros(1, np.uint32)))
    assert not {'programs', 'transparency'} & set(seen['stats']['features'])
    used = materials(base_color=[Slot()])
    assert 'programs' in render(scene((plane(),), used, images=(image,)))['stats']['features']


def test_pixels_are_shared_and_counted() -> None:
    image = noise(np.float32, 64, 32)
    odd = b.Image('odd', np.zeros((3, 3, 3), np.uint8))  # 27 bytes: copied, since kernels read words
    made = materials(base_color=[Slot()], emission=[Slot(1)])
    built = native.load().Scene(scene((plane(),), made, images=(image, odd)), threads=1, embree=native.embree_library())
    stats = built.stats()
    assert stats['images'] == 2 and stats['image_bytes'] == image.pixels.nbytes + 27
    assert stats['memory_bytes'] >= stats['bvh_bytes'] + stats['image_bytes']


@pytest.mark.parametrize(
    'pixels, words',
    [
        (np.zeros((2, 2), np.uint8), 'dimensions'),
        (np.zeros((2, 2, 5), np.uint8), 'channels'),
        (np.zeros((0, 2, 4), np.uint8), 'sides'),
        (np.zeros((2, 2, 4), np.float64), 'float64'),
        (np.zeros((2, 2, 4), np.int8), 'int8'),
        (np.zeros((2, 4, 4), np.uint8)[:, ::2], 'C-contiguous'),
    ],
)
def test_wrong_images_are_named(pixels: np.ndarray, words: str) -> None:
    made = materials(base_color=[Slot()])
    with pytest.raises(ValueError, match=f"image 'wrong'.*{words}"):
        render(scene((plane(),), made, images=(b.Image('wrong', pixels),)))
