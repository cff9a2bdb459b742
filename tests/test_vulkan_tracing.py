# SPDX-License-Identifier: GPL-3.0-or-later
"""Both builds of the Vulkan device's tracing, the BVH of our own and ray queries, meet what Embree meets.

Scenes that are hard to trace, small otherwise. Pictures of whole scenes are test_vulkan_device.py's.
"""

from __future__ import annotations

import dataclasses
from types import ModuleType

import bpy
import numpy as np
import pytest
from mathutils import Matrix

import vulkan_jobs
from scenes import build
from vulkan_jobs import compare, job_of

pytestmark = pytest.mark.usefixtures('engine')

SEEN = ('combined', 'position', 'normal', 'uv', 'object_index')
PYRAMID = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0.3, 0.2, 1.5)]
SIDES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (3, 2, 1, 0)]


def same(job: vulkan_jobs.Job) -> dict[str, np.ndarray]:
    """The device's passes, after they were compared with the CPU's."""
    cpu, gpu = job.render('CPU')[0], job.render('VULKAN')[0]
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], job.fragile(name), name)
    return gpu


def lit_scene(at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> bpy.types.Scene:
    """A camera that looks down at a floor, and a sun; what stands on it the test says."""
    scene = build.new_scene()
    build.world(scene, (0.3, 0.4, 0.5))
    build.camera(scene, clip_end=1000.0).matrix_world = (
        Matrix.Translation(at) @ Matrix.Translation((0.0, -7.0, 6.0)) @ (Matrix.Rotation(0.85, 4, 'X'))
    )
    build.light(scene, 'SUN', energy=3.0).rotation_euler = (0.5, 0.3, 0.0)
    floor = build.mesh_object(scene, 'Floor')
    floor.matrix_world = Matrix.Translation(at) @ Matrix.Scale(6.0, 4)
    return scene


def test_instances_of_all_shapes(module: ModuleType, tracing: str) -> None:
    """Mirrored, stretched, sheared, tiny, flat and far away; flat ones have no inside, and nobody meets them."""
    scene = lit_scene()
    shared = build.mesh('Pyramid', PYRAMID, SIDES)
    shapes = [
        Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0)),
        Matrix.Diagonal((0.3, 0.9, 1.8, 1.0)) @ Matrix.Rotation(0.7, 4, 'X'),
        Matrix(((1.0, 0.8, 0.0, 0.0), (0.0, 0.7, 0.3, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))),
        Matrix.Diagonal((-0.5, -0.7, -0.9, 1.0)) @ Matrix.Translation((0.0, 0.0, -1.5)),
        Matrix.Diagonal((1.0, 1.0, 0.0, 1.0)),
        Matrix.Diagonal((0.0, 0.0, 0.0, 1.0)),
        Matrix.Diagonal((1e-15, 1e-15, 1e-15, 1.0)),
        Matrix.Translation((1e30, 0.0, 0.0)),
    ]
    for index, shape in enumerate(shapes):
        obj = build.link(scene, f'Shown {index}', shared)
        obj.matrix_world = Matrix.Translation((2.0 * (index % 4) - 3.0, 2.8 * (index // 4) - 1.5, 0.05)) @ shape
        obj.pass_index = index + 1
    gpu = same(job_of(module, scene, integrator='PATH', passes=SEEN, ray_tracing=tracing))
    assert {0, 1, 2, 3, 4} <= set(gpu['object_index'].ravel().tolist())


@pytest.mark.parametrize('limit', [3, 8, 1000])
def test_a_stack_of_panes(module: ModuleType, tracing: str, limit: int) -> None:
    """Each of them is crossed once, by the ray of the camera and by those to the sun."""
    scene = lit_scene()
    shared = build.mesh('Pane')
    shared.materials.append(build.material('Pane', Base_Color=(0.9, 0.5, 0.2, 1.0), Alpha=0.3))
    for index in range(10):
        pane = build.link(scene, f'Pane {index}', shared)
        pane.matrix_world = Matrix.Translation((0.1 * index, 0.0, 0.1 + 0.2 * index)) @ Matrix.Scale(2.0, 4)
    job = job_of(module, scene, integrator='PATH', samples=16, transparent_bounces=limit, ray_tracing=tracing)
    same(job)


@pytest.mark.parametrize('far', [1e3, 1e5])
def test_far_from_the_origin(module: ModuleType, tracing: str, far: float) -> None:
    """Floats are coarse there, 8 mm at 100 km: pictures flip more, but stay the same on the whole."""
    at = (far, -0.7 * far, 0.3 * far)
    scene = lit_scene(at)
    shared = build.mesh('Pyramid', PYRAMID, SIDES)
    for index in range(3):
        obj = build.link(scene, f'Shown {index}', shared)
        obj.matrix_world = Matrix.Translation(at) @ Matrix.Translation((2.5 * index - 2.5, 0.0, 0.05))
    job = job_of(module, scene, integrator='DIRECT', samples=16, ray_tracing=tracing)
    cpu, gpu = job.render('CPU')[0]['combined'], job.render('VULKAN')[0]['combined']
    assert np.isfinite(gpu).all()
    assert gpu.mean() == pytest.approx(cpu.mean(), rel=0.005)


def test_which_rays_see_an_object(module: ModuleType, tracing: str) -> None:
    """Masks hold for meshes in world space and for instances."""
    scene = lit_scene()
    shared = build.mesh('Pyramid', PYRAMID, SIDES)
    hidden = ('visible_camera', 'visible_shadow', 'visible_diffuse', 'visible_glossy')
    for index, name in enumerate(hidden * 2):
        data = shared if index < 4 else build.mesh('Own', PYRAMID, SIDES)
        obj = build.link(scene, f'Shown {index}', data)
        obj.location = (2.4 * (index % 4) - 3.6, 3.0 * (index // 4) - 1.5, 0.05)
        setattr(obj, name, False)
    same(job_of(module, scene, integrator='PATH', passes=SEEN, ray_tracing=tracing))


@pytest.mark.parametrize('empty', [False, True])
def test_nothing_to_meet(module: ModuleType, tracing: str, empty: bool) -> None:
    """A scene without objects, or with one that has no triangle: the world alone."""
    scene = build.new_scene()
    build.camera(scene)
    build.world(scene, (0.2, 0.4, 0.6))
    if empty:
        build.mesh_object(scene, 'Empty', vertices=[(0, 0, 0), (1, 0, 0)], faces=[])
    gpu = same(job_of(module, scene, integrator='PATH', ray_tracing=tracing))
    # Exact but for the rounding of a pixel's sum and mean in float32.
    assert np.allclose(gpu['combined'][..., :3], (0.2, 0.4, 0.6), rtol=1e-5)


@pytest.mark.parametrize('shown', [1, 2])
def test_vertices_that_are_no_numbers(module: ModuleType, tracing: str, shown: int) -> None:
    """Nobody meets their triangles, the mesh's others are there. (The exporter would have moved them.)"""
    scene = lit_scene()
    grid = build.grid(8)
    for index in range(shown):
        build.link(scene, f'Grid {index}', grid).location = (2.5 * index - 1.0, 0.0, 0.5)
    job = job_of(module, scene, integrator='DIRECT', passes=SEEN, ray_tracing=tracing)
    mesh = next(k for k, made in enumerate(job.buffers.meshes) if len(made.triangles) == 128)
    positions = job.buffers.meshes[mesh].positions.copy()
    for vertex, (axis, number) in {20: (0, np.nan), 33: (1, np.nan), 44: (2, np.inf), 60: (1, -np.inf)}.items():
        positions[vertex, axis] = number
    meshes = list(job.buffers.meshes)
    meshes[mesh] = dataclasses.replace(meshes[mesh], positions=positions)
    buffers = dataclasses.replace(job.buffers, meshes=tuple(meshes))
    same(vulkan_jobs.Job(module, buffers, job.camera, job.settings))


@pytest.mark.parametrize('shown', [1, 2])
def test_more_triangles_than_a_bottom_level_has(module: ModuleType, tracing: str, shown: int) -> None:
    """Of meshes in world space, and of shared ones."""
    scene = lit_scene()
    grid = build.grid(1030)  # 2 121 800 triangles
    for index in range(shown):
        obj = build.link(scene, f'Grid {index}', grid)
        obj.matrix_world = Matrix.Translation((0.0, 0.0, 1.0 + index)) @ Matrix.Rotation(0.2 - 0.5 * index, 4, 'X')
    same(job_of(module, scene, integrator='DIRECT', samples=1, passes=SEEN, ray_tracing=tracing))


def test_out_of_memory_names_the_acceleration_structure(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """The scene fits, what is built over it does not."""
    vulkan_jobs.require(module, 'HARDWARE')
    scene = lit_scene()
    build.link(scene, 'Grid', build.grid(300))
    session = job_of(module, scene, ray_tracing='HARDWARE').session('VULKAN')
    monkeypatch.setenv('COTORRA_VULKAN_MEMORY', str(70 << 20))
    session.start()
    with pytest.raises(module.DeviceError, match=r'MiB for the acceleration structure do not fit beside the \d+ MiB'):
        while not session.wait(1.0):
            pass


def test_the_choice_is_kept_or_refused(module: ModuleType) -> None:
    """A processor is not asked for hardware unless the user wants it."""
    scene = lit_scene()
    job = job_of(module, scene, samples=1)
    assert job.render('VULKAN')[1]['isa'] == 'software'
    (device,) = module.devices()
    if device['ray_query']:
        assert job.render('VULKAN', ray_tracing='HARDWARE')[1]['isa'] == 'ray query'
    else:
        with pytest.raises(module.DeviceError, match='no Vulkan device can be used; llvmpipe.*: it has no ray queries'):
            job.session('VULKAN', ray_tracing='HARDWARE')
