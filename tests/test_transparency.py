# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that let rays through, against closed forms: what the camera sees, shadows, the film's alpha, limits.

All through the native module; the scenes are planes above one another.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cotorra.export import buffers as b

from texture_scenes import (
    F32,
    U32,
    Slot,
    camera,
    centres,
    filtered,
    instances,
    lights,
    materials,
    plane,
    render,
    scene,
)

SUN = lights(((0.0, 0.0, -1.0), np.pi))  # a white Lambertian surface that faces it has radiance 1
SMALL = camera(0.9, 16)


def layers(alphas: list[float], colors: list[float], **values: object) -> b.SceneBuffers:
    """Planes at heights 0, 0.1, 0.2 and so on, from below."""
    count = len(alphas)
    made = materials(count, alpha=alphas, base_color=[[c] * 3 for c in colors])
    values.setdefault('lights', SUN)
    return scene(tuple(plane(z=0.1 * k) for k in range(count)), made, **values)


def mean(made: b.SceneBuffers, **settings: object) -> tuple[float, float]:
    """Mean of the picture's first channel, and of its alpha."""
    settings = {'samples': 256} | settings
    pixels = render(made, SMALL, **settings)['combined']
    return float(pixels[..., 0].mean()), float(pixels[..., 3].mean())


@pytest.mark.parametrize('alpha', (0.0, 0.25, 0.5, 0.9, 1.0))
def test_one_layer_over_a_floor(alpha: float) -> None:
    """The camera sees alpha of the layer and the rest of the floor, which gets the rest of the light."""
    radiance, film = mean(layers([1.0, alpha], [0.8, 0.5]))
    assert radiance == pytest.approx(alpha * 0.5 + (1.0 - alpha) * 0.8 * (1.0 - alpha), rel=2e-3)
    assert film == 1.0


def test_layers_multiply() -> None:
    """Each layer dims the light of those below, and is met once: four of them over a floor."""
    alphas, colors = [1.0, 0.3, 0.2, 0.4, 0.1], [0.8, 0.0, 0.0, 0.0, 0.0]
    kept = np.prod(1.0 - np.array(alphas[1:]))
    radiance, _ = mean(layers(alphas, colors), samples=1024)
    assert radiance == pytest.approx(0.8 * kept**2, rel=1e-2)


def test_layers_of_one_mesh_are_independent() -> None:
    """Two layers that are one object: the same alpha must not mean the same choice."""
    one = plane(z=0.2)
    two = replace(
        plane(),
        positions=np.concatenate([one.positions, plane(z=0.4).positions, np.zeros((1, 3), F32)])[:8],
        triangles=np.concatenate([one.triangles, one.triangles + U32(4)]),
        corners=np.concatenate([one.corners, one.corners]),
    )
    made = materials(2, alpha=[1.0, 0.5], base_color=[[0.8] * 3, [0.0] * 3])
    radiance, _ = mean(scene((plane(), two), made, lights=SUN), samples=1024)
    assert radiance == pytest.approx(0.8 * 0.25 * 0.25, rel=2e-2)


def test_shadows_are_smooth() -> None:
    """A shadow ray takes what is left of its light along: behind glass that the camera misses there is no noise."""
    hidden = instances(2, visibility=np.array([63, b.VISIBLE_SHADOW], U32))
    pixels = render(layers([1.0, 0.5], [0.8, 0.5], instances=hidden), SMALL, samples=4)['combined']
    assert pixels[..., :3] == pytest.approx(np.full((16, 16, 3), 0.4), rel=1e-5)


def test_alpha_from_an_image() -> None:
    rng = np.random.default_rng(3)
    image = b.Image('holes', rng.random((4, 4, 4)).astype(np.float32))
    made = materials(2, base_color=[0.8, 0.5], alpha=[1.0, Slot(channel='A')])
    view = camera(size=16)
    pixels = render(scene((plane(), plane(z=0.1)), made, images=(image,), lights=SUN), view, samples=1024)['combined'][
        ..., 0
    ]
    x, y = centres(size=16)
    alpha = filtered(image, (x + 1) / 2, (y + 1) / 2, b.INTERPOLATION_LINEAR, b.EXTENSION_REPEAT)[..., 3]
    expected = alpha * 0.5 + (1.0 - alpha) ** 2 * 0.8
    # One number in 1024 of each pixel, stratified.
    assert np.abs(pixels - expected).max() < 0.01
    assert pixels.mean() == pytest.approx(expected.mean(), rel=1e-3)


def test_an_image_without_holes_is_opaque() -> None:
    full = b.Image('full', np.full((4, 4, 4), 255, np.uint8))
    made = scene((plane(),), materials(alpha=[Slot(channel='A')]), images=(full,))
    assert 'transparency' not in render(made)['stats']['features']
    clipped = materials(alpha=[Slot(channel='A', extension=b.EXTENSION_CLIP)])
    made = scene((plane(uv=(-1.0, 2.0)),), clipped, images=(full,))
    seen = render(made, camera(size=9), samples=16, transparent_film=True)
    assert 'transparency' in seen['stats']['features']
    alpha = seen['combined'][..., 3]
    assert (alpha[3:6, 3:6] == 1.0).all() and alpha.sum() == 9.0


@pytest.mark.parametrize('shared', (False, True), ids=('flattened', 'instanced'))
def test_film_alpha(shared: bool) -> None:
    """A camera ray that passes everything leaves the film transparent; premultiplied, as Blender wants it."""
    made = layers([0.25], [0.8])
    if shared:
        far = np.eye(3, 4, dtype=F32)
        far[0, 3] = 50.0
        frames = np.stack([np.eye(3, 4, dtype=F32), far])
        placed = instances(2, frames, mesh=np.zeros(2, U32), material_base=np.zeros(2, U32))
        made = replace(made, instances=placed)
    pixels = render(made, SMALL, samples=1024, transparent_film=True)['combined']
    assert pixels[..., 3].mean() == pytest.approx(0.25, rel=2e-3)
    assert pixels[..., 0].mean() == pytest.approx(0.25 * 0.8, rel=2e-3)
    assert mean(replace(made, world=b.World((1.0, 1.0, 1.0))), transparent_film=True)[1] == pytest.approx(
        0.25, rel=1e-2
    )


def test_emission_shows_as_much_as_alpha() -> None:
    """A lamp of alpha 0.5: half as bright to the camera, and half as much light on the floor."""
    lamp = replace(plane(-0.2, 0.2, 0.5), triangles=plane().triangles[:, ::-1].copy())
    view = camera(0.1, 8, 0.4)

    def floor(alpha: float, sampled: int, integrator: str = 'DIRECT') -> float:
        made = materials(
            2,
            alpha=[1.0, alpha],
            emission=[[0.0] * 3, [5.0] * 3],
            emission_sampling=[0, sampled],
            base_color=[[0.8] * 3, [0.0] * 3],
        )
        pixels = render(scene((plane(-3, 3), lamp), made), view, samples=2048, integrator=integrator, max_bounces=1)[
            'combined'
        ]
        return float(pixels[..., 0].mean())

    full = floor(1.0, 1)
    assert floor(0.5, 1) == pytest.approx(0.5 * full, rel=5e-3)
    assert floor(0.5, 0, 'PATH') == pytest.approx(0.5 * full, rel=2e-2)
    assert floor(0.5, 1, 'PATH') == pytest.approx(0.5 * full, rel=1e-2)
    radiance, _ = mean(scene((plane(),), materials(alpha=[0.5], emission=[[5.0] * 3], base_color=[[0.0] * 3])))
    assert radiance == pytest.approx(2.5, rel=2e-3)


def test_bounces_pass_too() -> None:
    """A furnace: a white floor under a dark layer of alpha 0.5 and a white world; a third of the light comes down."""
    made = layers([1.0, 0.5], [1.0, 0.0], lights=lights(), world=b.World((1.0, 1.0, 1.0)))
    made = replace(made, meshes=(plane(-50, 50), plane(-50, 50, 0.1)))
    radiance, _ = mean(made, integrator='PATH', samples=512, max_bounces=8, diffuse_bounces=8)
    # Seen through the layer (0.5), where half of the world arrives.
    assert radiance == pytest.approx(0.25, rel=1e-2)


@pytest.mark.parametrize('limit', (1, 3, 4, 7, 8, 300))
def test_limit_of_transparent_surfaces(limit: int) -> None:
    """Four layers of alpha 0 over a floor, which the camera's ray crosses, and the one to the sun again."""
    seen, film = mean(layers([1.0] + [0.0] * 4, [0.8] + [0.0] * 4), transparent_bounces=limit, samples=4)
    assert seen == pytest.approx(0.8 if limit >= 8 else 0.0) and film == 1.0
    # To the background: as many as are allowed may be passed.
    empty = layers([0.0] * 4, [0.0] * 4, world=b.World((1.0, 1.0, 1.0)))
    seen, _ = mean(empty, transparent_bounces=limit, samples=4)
    assert seen == pytest.approx(1.0 if limit >= 4 else 0.0)
    _, film = mean(empty, transparent_bounces=limit, samples=4, transparent_film=True)
    assert film == pytest.approx(0.0 if limit >= 4 else 1.0)


def test_layers_behind_do_not_count() -> None:
    """What lies behind the surface that stops the ray was perhaps asked, but not passed."""
    opaque_on_top = layers([0.0] * 6 + [1.0], [0.0] * 6 + [0.8])
    assert mean(opaque_on_top, transparent_bounces=1, samples=4)[0] == pytest.approx(0.8)


def test_same_bits_on_any_threads() -> None:
    made = layers([1.0, 0.5, 0.3], [0.8, 0.5, 0.2], world=b.World((0.2, 0.3, 0.4)))
    pictures = [
        render(made, camera(0.9, 70), samples=5, threads=threads, integrator='PATH')['combined'] for threads in (1, 4)
    ]
    assert (pictures[0] == pictures[1]).all()


def test_a_shadow_ray_is_dimmed_once_by_each_triangle() -> None:
    """Embree's packets of rays that spread ask of some triangles twice."""
    frame = np.eye(3, 4, dtype=F32)[None].copy()
    frame[0, :, 3] = 0.3, 0.2, 1.0
    lamp = replace(SUN, type=np.zeros(1, U32), transform=frame)
    picture = render(layers([1.0, 0.4], [0.8, 0.0], lights=lamp), SMALL, samples=16, passes=('combined', 'shadow'))
    # Between that of the floor and that of the layer, which nothing stands above.
    assert picture['shadow'].min() > 0.599 and picture['shadow'].max() <= 1.0
