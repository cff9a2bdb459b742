# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking and shadow linking beside Cycles: lamps and emitting meshes, few and many, on CPU and Vulkan.

What becomes of linking on the way into the native module, where a picture tells too little, is looked at there.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import cotorra_native
import numpy as np
import pytest
from cotorra import export, native
from cotorra.log import Log

from light_scenes import assert_as_cycles, ball, box, corner, hang, square
from scenes import build
from vulkan_jobs import TRACINGS, compare, job_of, opened, require

KINDS = ('receiver', 'blocker')


def room() -> bpy.types.Scene:
    scene = corner()
    box(scene)
    ball(scene, Base_Color=(0.9, 0.9, 0.9, 1.0), Metallic=1.0, Roughness=0.2)
    hang(scene, 'POINT', (1.5, -2.0, 2.5), energy=60.0, shadow_soft_size=0.3).name = 'Key'
    hang(scene, 'AREA', (-1.5, -1.5, 2.5), size=1.0, energy=40.0)
    return scene


def link(scene: bpy.types.Scene, light: str, kind: str, **states: str) -> bpy.types.Collection:
    """Link a light to objects by name, each 'INCLUDE' or 'EXCLUDE'."""
    collection = bpy.data.collections.new(f'{light} {kind}')
    for name, state in states.items():
        collection.objects.link(scene.objects[name])
        collection.collection_objects[-1].light_linking.link_state = state
    setattr(bpy.data.objects[light].light_linking, f'{kind}_collection', collection)
    return collection


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('state', ['INCLUDE', 'EXCLUDE'])
def test_a_lamp(kind: str, state: str, engine: None, tmp_path: Path) -> None:
    scene = room()
    link(scene, 'Key', kind, Cube=state)
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize('kind', KINDS)
def test_a_mesh_that_emits(kind: str, engine: None, tmp_path: Path) -> None:
    scene = room()
    panel = square(scene, 'Panel', 0.8, build.material('Panel', Emission_Color=(1, 1, 1, 1), Emission_Strength=8.0))
    panel.location = (0.0, -1.0, 2.2)
    link(scene, 'Panel', kind, Cube='EXCLUDE', Sphere='EXCLUDE')
    assert_as_cycles(scene, tmp_path)


def test_many_lamps_with_groups_of_objects(engine: None, tmp_path: Path) -> None:
    """More than are sampled each; a child collection is excluded, one of its objects is included all the same."""
    scene = room()
    for i in range(9):
        lamp = hang(scene, 'POINT', (i * 0.5 - 2.0, -1.0, 1.6), energy=8.0, shadow_soft_size=0.1)
        lamp.name = f'Lamp{i}'
        link(scene, lamp.name, KINDS[i % 2], **{('Cube', 'Sphere', 'Wall')[i % 3]: ('INCLUDE', 'EXCLUDE')[i // 5]})
    both = link(scene, 'Key', 'receiver', Cube='INCLUDE')
    child = bpy.data.collections.new('Child')
    both.children.link(child)
    both.collection_children[0].light_linking.link_state = 'EXCLUDE'
    for name in ('Cube', 'Sphere'):
        child.objects.link(scene.objects[name])
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize('kind', KINDS)
def test_an_empty_collection(kind: str, engine: None, tmp_path: Path) -> None:
    scene = room()
    link(scene, 'Key', kind)
    assert_as_cycles(scene, tmp_path)


@pytest.mark.parametrize('kind', KINDS)
def test_instancers_are_lit_and_shadow_but_link_nothing(kind: str, engine: None, tmp_path: Path) -> None:
    """A lamp of a collection that an empty shows, and a cube that another shows."""
    scene = room()
    lamp = hang(scene, 'POINT', (0.5, -1.5, 2.0), energy=40.0, shadow_soft_size=0.2)
    empty = build.collection_instance(scene, 'Lamps', [lamp])
    shown = build.collection_instance(scene, 'Cubes', [scene.objects['Cube']])
    shown.location = (0.6, -0.8, 0.0)
    link(scene, lamp.name, kind, **{shown.name: 'EXCLUDE'})
    link(scene, empty.name, kind, Sphere='INCLUDE')
    assert_as_cycles(scene, tmp_path)


def test_what_is_not_linked_has_none(engine: None) -> None:
    scene = room()
    job = job_of(native.load(), scene)
    assert job.buffers.linking is None
    assert 'light linking' not in job.render('CPU')[1]['features']


@pytest.mark.parametrize(('integrator', 'told'), [('TOON', 1), ('PATH', 0)])
def test_toon_says_that_it_links_nothing(integrator: str, told: int, engine: None) -> None:
    scene = room()
    link(scene, 'Key', 'receiver', Cube='INCLUDE')
    scene.cotorra.integrator = integrator
    depsgraph, log = bpy.context.evaluated_depsgraph_get(), Log()
    export.export_scene(depsgraph, depsgraph.scene_eval, depsgraph.view_layer_eval, log)
    assert len([text for text in log.texts('WARNING') if 'Toon leaves out light linking' in text]) == told


def test_sets_are_few(engine: None) -> None:
    """Objects that are linked alike are of one set, however many there are."""
    scene = room()
    link(scene, 'Key', 'receiver', Cube='INCLUDE', Sphere='INCLUDE')
    link(scene, 'Key', 'blocker', Cube='EXCLUDE')
    linking = job_of(native.load(), scene).buffers.linking
    assert sorted(set(linking.receiver.tolist())) == [0, 1] and sorted(set(linking.blocker.tolist())) == [0, 1]
    assert (linking.light_sets == 0xFFFFFFFF).all(axis=1).sum() == len(linking.light_sets) - 1


def test_more_sets_than_there_are_bits_are_named(engine: None) -> None:
    scene = corner()
    for i in range(26):
        square(scene, f'Pane{i}', 0.1, build.material('Grey'))
        hang(scene, 'POINT', (0.1 * i, 0.0, 2.0), energy=1.0).name = f'Lamp{i}'
        link(scene, f'Lamp{i}', 'blocker', **{f'Pane{i}': 'INCLUDE'})
    log = Log()
    export.export_scene(bpy.context.evaluated_depsgraph_get(), scene, bpy.context.view_layer, log)
    assert sum('shadow linking knows 24 kinds' in text for _, text in log.messages) == 4


def test_wrong_sets_are_refused(engine: None) -> None:
    scene = room()
    link(scene, 'Key', 'receiver', Cube='INCLUDE')
    buffers = job_of(native.load(), scene).buffers
    buffers.linking.blocker[0] = 24
    with pytest.raises(ValueError, match=r'linking.blocker\[0\] = 24, must be below 24'):
        cotorra_native.Scene(buffers, 0, native.embree_library())


module = pytest.fixture(scope='module')(opened)


@pytest.mark.parametrize('tracing', TRACINGS)
def test_a_graphics_card_links_alike(tracing: str, module, engine: None) -> None:
    require(module, tracing)
    scene = room()
    link(scene, 'Key', 'receiver', Cube='EXCLUDE')
    link(scene, 'Area', 'blocker', Sphere='INCLUDE')
    panel = square(scene, 'Panel', 0.8, build.material('Panel', Emission_Color=(1, 1, 1, 1), Emission_Strength=8.0))
    panel.location = (0.0, -1.0, 2.2)
    link(scene, 'Panel', 'blocker', Cube='EXCLUDE')
    bounces = dict.fromkeys(('max_bounces', 'diffuse_bounces', 'glossy_bounces'), 1)
    job = job_of(module, scene, integrator='PATH', samples=8, ray_tracing=tracing, **bounces)
    cpu, gpu = (job.render(device)[0]['combined'] for device in ('CPU', 'VULKAN'))
    assert np.isfinite(cpu).all()
    compare(cpu, gpu, job.fragile('combined'), 'linked lights')
