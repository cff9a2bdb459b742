# SPDX-License-Identifier: GPL-3.0-or-later
"""What integrator AUTO leaves out of materials: which parts there are, the scene without them, and what it decides.

The scenes are arrays; how node trees become shaders is tested elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cotorra import auto, choices, native
from cotorra.auto import models
from cotorra.export import buffers as b
from cotorra.export.buffers import RenderSettings

from shaders import Sketch
from texture_scenes import F32, I32, U32, Made, camera, instances, lights, plane, scene

MODELS = frozenset({'models'})


def made(*shaders: b.Shader, names: tuple[str, ...] = ()) -> b.SceneBuffers:
    """Planes beside each other, a material each, under a sun."""
    count = len(shaders)
    frames = np.broadcast_to(np.eye(3, 4, dtype=F32), (count, 3, 4)).copy()
    frames[:, 0, 3] = 2.0 * np.arange(count) - (count - 1)
    table = b.Materials(
        pass_index=np.zeros(count, I32),
        emission_sampling=np.ones(count, U32),
        shader=np.arange(count, dtype=I32),
        names=names,
    )
    sun = lights(((0.3, 0.1, -1.0), 3.0))
    planes = tuple(plane() for _ in shaders)
    return scene(planes, Made(table, shaders), instances=instances(count, frames), lights=sun)


def shader(name: str = 'Paint', **values: object) -> b.Shader:
    sketch = Sketch()
    sketch.principled(**values)
    return sketch.shader(name)


def bent() -> b.Shader:
    """A normal that noise bends."""
    sketch = Sketch()
    place = sketch.op('position')
    normal = sketch.op('vector_math_v', sketch.op('normal'), place, 0.0, 0.0, mode=0)
    sketch.principled(normal=normal)
    return sketch.shader('Bent')


def test_the_parts_of_materials():
    """Those whose weight is 0 are none; what counts least comes first."""
    found = models.parts_of(
        made(shader(coat=0.5, sheen=0.01), shader('Steel', metallic=1.0, anisotropic=0.2, specular_level=0.5), bent())
    )
    assert [(part.name, part.argument) for part in found] == [
        ('Paint', 'sheen'),
        ('Steel', 'anisotropic'),
        ('Paint', 'specular_level'),
        ('Paint', 'coat'),
        ('Bent', 'specular_level'),
        ('Bent', 'normal'),
    ]
    assert found[0].words == 'sheen of "Paint"' and found[-1].words == 'normal detail of "Bent"'


def test_materials_that_are_switched_off_have_none():
    built = made(shader(coat=0.5), shader('Other', coat=0.2), names=('Car', 'Boat'))
    assert {part.shader for part in models.parts_of(built)} == {0, 1}
    assert {part.shader for part in models.parts_of(built, frozenset({'Car'}))} == {1}


def test_a_scene_without_parts_is_the_one_that_never_had_them():
    """Compiled, both are the same: the same constants, and the same lobes."""
    module = native.load()
    built = made(shader(coat=0.5, sheen=0.2, film_thickness=300.0), bent())
    bare = models.without(built, models.parts_of(built))
    plain = made(shader(specular_level=0.0), shader('Bent', specular_level=0.0))
    found, wanted = (module.Scene(entry, bvh=False) for entry in (bare, plain))
    for index in range(2):
        assert found.explain(index)['surface'] == wanted.explain(index)['surface']
        assert found.constants(index) == wanted.constants(index)
    assert models.parts_of(built) and not models.parts_of(bare), 'what it was made from is as it was'


def test_halves_are_looked_at_where_the_whole_does_not_do():
    asked = []

    def suffices(parts: list[int]) -> bool:
        asked.append(list(parts))
        return 5 not in parts

    assert sorted(models.needless([1, 2, 3, 4, 5, 6], suffices, 20)) == [1, 2, 3, 4, 6]
    assert asked[:3] == [[1, 2, 3, 4, 5, 6], [1, 2, 3], [1, 2, 3, 4, 5, 6]]
    asked.clear()
    assert models.needless([1, 2, 3, 4, 5, 6], suffices, 2) == [1, 2, 3] and len(asked) == 2
    assert models.needless([], suffices, 20) == []


def chosen(built: b.SceneBuffers, tolerance: float = 0.01, passes: tuple[str, ...] = ('combined',)) -> auto.Choice:
    module = native.load()

    def build(entry: b.SceneBuffers):
        return module.Scene(entry, threads=2, embree=native.embree_library())

    pilot = auto.Pilot(module, build(built), camera(2.0, 64), lambda: None, build)
    asked = RenderSettings(samples=4096, threads=2, passes=passes)
    materials = auto.Materials(built, tuple(auto.parts_of(built)))
    return auto.choose(pilot, camera(2.0, 64), asked, auto.facts(built), tolerance, MODELS, materials)


@pytest.mark.parametrize(('sheen', 'left_out'), [(1e-3, True), (1.0, False)])
def test_a_lobe_that_nobody_sees_is_left_out(sheen, left_out):
    """The specular layer, at 4 %, is beyond a tolerance of 1 % under a sun; a sheen of a thousandth is not."""
    found = chosen(made(shader(sheen=sheen, sheen_roughness=0.3, roughness=0.3)))
    row = next(row for row in found.rows if row.key == 'models')
    assert ('sheen of "Paint"' in row.chosen) == left_out == (found.scene is not None), row
    assert 'specular layer' not in row.chosen
    if left_out:
        assert found.difference.high <= 0.01
        assert found.settings == RenderSettings(samples=4096, threads=2)


def test_what_a_pass_shows_stays():
    """Terms are those of all lobes."""
    built = made(shader(sheen=1e-3))
    assert chosen(built).scene is not None
    assert chosen(built, passes=('combined', 'term_f')).scene is None


def test_work_counts_triangles_and_texels():
    built = made(shader(), shader())
    image = b.Image('i', np.zeros((8, 4, 4), np.uint8))
    assert models.work(built) == 4 and models.work(replace(built, images=(image,))) == 12


def test_every_row_has_a_switch_and_words():
    keys = [key for key, _, _ in choices.AUTO_ROWS]
    assert len(set(keys)) == len(keys) and all(name and text for _, name, text in choices.AUTO_ROWS)
