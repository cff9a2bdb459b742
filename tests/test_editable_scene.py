# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that are each a little changed: what is taken over from the one before gives the bits of one built anew.

No Blender here; what an edit in Blender changes in the arrays is told in test_sync.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cotorra import native
from cotorra.export import buffers as b

from texture_scenes import F32, I32, U32, camera, instances, lights, materials, plane, scene

SIZE = 24


def bumpy(number: int, height: float = 0.0) -> b.Mesh:
    """A square of 2 x 24 x 24 triangles, moved up by `height`."""
    made = plane(-0.4, 0.4, height)
    steps = np.linspace(-0.4, 0.4, 25, dtype=F32)
    x, y = np.meshgrid(steps, steps)
    padded = np.zeros(x.size * 3 + 1, F32)
    positions = padded[:-1].reshape(-1, 3)
    positions[:] = np.stack([x.ravel(), y.ravel(), height + 0.05 * np.sin(9.0 * x.ravel() + number)], axis=1)
    first = (np.arange(24)[:, None] * 25 + np.arange(24)).reshape(-1, 1)
    quads = (first + np.array([0, 1, 26, 25])).astype(U32)
    triangles = np.ascontiguousarray(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    return replace(made, name=f'bumpy {number}', positions=positions, triangles=triangles, corners=None, uv=None)


def moved(count: int, **shift: tuple[float, float, float]) -> b.Instances:
    """Instances of `count` meshes, one each, `shift` by 'i' and its number: where each is."""
    made = instances(count)
    transform = made.transform.copy()
    for i in range(count):
        transform[i, :, 3] = shift.get(f'i{i}', (0.6 * i - 0.6, 0.1 * i, 0.2 * i))
    return replace(made, transform=transform)


def base() -> b.SceneBuffers:
    meshes = tuple(bumpy(i) for i in range(3))
    colors = materials(3, base_color=[[0.8, 0.2, 0.2], [0.2, 0.8, 0.2], [0.2, 0.2, 0.8]])
    lamp = lights(((0.0, 0.0, -1.0), 3.0))
    return scene(meshes, colors, instances=moved(3), lights=lamp, world=b.World((0.2, 0.2, 0.3)))


def changed_mesh(a: b.SceneBuffers) -> b.SceneBuffers:
    return replace(a, meshes=(a.meshes[0], bumpy(7, 0.1), a.meshes[2]))


def changed_material(a: b.SceneBuffers) -> b.SceneBuffers:
    other = materials(3, base_color=[[0.1, 0.9, 0.2], [0.2, 0.8, 0.2], [0.2, 0.2, 0.8]], alpha=[1.0, 0.4, 1.0])
    return replace(a, materials=other.materials, shaders=other.shaders)


def one_more(a: b.SceneBuffers) -> b.SceneBuffers:
    """Another mesh before the others, and two instances of one of them."""
    objects = moved(5)
    objects = replace(objects, mesh=np.array([0, 1, 2, 3, 3], U32), material_base=np.array([0, 1, 2, 0, 1], U32))
    return replace(a, meshes=(bumpy(9), *a.meshes), instances=objects)


EDITS: dict[str, Callable[[b.SceneBuffers], b.SceneBuffers]] = {
    'nothing': lambda a: a,
    'moved': lambda a: replace(a, instances=moved(3, i1=(0.1, -0.3, 0.4))),
    'mirrored': lambda a: replace(a, instances=replace(a.instances, transform=a.instances.transform * F32(-1.0))),
    'flat': lambda a: replace(
        a, instances=replace(a.instances, transform=a.instances.transform * np.array([1, 1, 0, 1], F32))
    ),
    'mesh': changed_mesh,
    'material': changed_material,
    'lamp': lambda a: replace(a, lights=replace(a.lights, strength=a.lights.strength * F32(2.0))),
    'world': lambda a: replace(a, world=b.World((0.9, 0.1, 0.1))),
    'removed': lambda a: replace(a, meshes=a.meshes[1:], instances=replace(moved(2), material_count=np.ones(2, U32))),
    'more': one_more,
    'hidden': lambda a: replace(
        a, instances=replace(a.instances, visibility=np.array([63, b.VISIBLE_DIFFUSE, 63], U32))
    ),
}


def built(buffers: b.SceneBuffers, previous: Any = None, editable: bool = True) -> Any:
    embree = native.embree_library()
    return native.load().Scene(buffers, embree=embree, editable=editable, previous=previous)


def picture(made: Any) -> np.ndarray:
    settings = b.RenderSettings(samples=4, integrator='PATH')
    session = native.load().Session(made, camera(1.2, SIZE, 2.0), settings)
    session.start()
    assert session.wait(60.0)
    out = np.zeros((SIZE, SIZE, 4), F32)
    session.read('combined', out)
    return out


@pytest.mark.parametrize('edit', EDITS)
def test_an_edit_gives_the_bits_of_a_scene_built_anew(edit: str) -> None:
    before = base()
    first = built(before)
    shown = picture(first)
    assert shown[..., :3].std() > 0.05
    after = EDITS[edit](before)
    found = picture(built(after, first))
    assert (found == picture(built(after))).all()
    # The one from before stays as it was.
    assert (picture(first) == shown).all()
    assert ((found == shown).all()) == (edit == 'nothing')
    # And one that is not editable shows the same, but for roundings of its other spaces.
    assert np.abs(found - picture(built(after, editable=False))).mean() < 0.02


def test_edits_follow_one_another_and_leave_nothing_behind() -> None:
    """The BVH's memory is that of the scene at hand, however many came before."""
    before = base()
    made = built(before)
    size = made.stats()['bvh_bytes']
    for number in range(30):
        before = replace(before, meshes=(bumpy(number), *before.meshes[1:]))
        made = built(before, made)
    # While the last was built, the one before was still there, which shares all but one mesh.
    assert made.stats()['bvh_bytes'] < 1.6 * size
    assert (picture(made) == picture(built(before))).all()


def test_what_is_taken_over_is_not_built_again() -> None:
    """Of many meshes one changes: that takes a small part of the time, counted against building all of them."""
    parts = tuple(bumpy(i) for i in range(200))
    objects = replace(moved(200), material_base=np.zeros(200, U32))
    all_of_them = scene(parts, materials(), instances=objects)
    first = built(all_of_them)
    one = replace(all_of_them, meshes=(bumpy(500), *parts[1:]))
    spent = [built(one, first).stats()['build_seconds'] for _ in range(5)]
    anew = [built(one).stats()['build_seconds'] for _ in range(5)]
    assert min(spent) < 0.5 * min(anew)


def test_a_mesh_of_the_same_numbers_in_other_memory_is_another() -> None:
    """Known by memory, not by name: equal arrays elsewhere are read and checked again."""
    before = base()
    first = built(before)
    broken = before.meshes[1].triangles.copy()
    broken[3, 1] = 1_000_000
    with pytest.raises(ValueError, match=r"mesh 'bumpy 1': triangles\[10\] = 1000000"):
        built(
            replace(before, meshes=(before.meshes[0], replace(before.meshes[1], triangles=broken), before.meshes[2])),
            first,
        )


def test_all_but_known_meshes_is_still_checked() -> None:
    before = base()
    with pytest.raises(ValueError, match='light_group'):
        built(replace(before, instances=replace(before.instances, light_group=np.zeros(2, I32))), built(before))
