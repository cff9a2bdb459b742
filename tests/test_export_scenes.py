# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes by others go through the export whole; they are not part of the project, so these tests may skip.

What single parts become is told by the other test_export files.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
import pytest
from cotorra.export import export_camera, export_scene
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log

OPEN = Path(__file__).resolve().parent.parent.parent / 'shared' / 'scenes' / 'open'
NAMES = (
    'alpha_modes cornell_box dungeon fox geonodes hair helmet instancing lamp morph normal_maps '
    'spaceship spheres transmission veach_mis zoo'
).split()


@pytest.fixture(scope='module')
def loader() -> ModuleType:
    path = OPEN / 'load.py'
    if not path.is_file():
        pytest.skip('../shared/scenes/open is not there')
    if bpy.app.version < (5, 0, 0):
        pytest.skip('the loader of ../shared/scenes/open needs Blender 5')
    spec = importlib.util.spec_from_file_location('open_scenes', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize('name', NAMES)
def test_scene(loader: ModuleType, name: str) -> None:
    loader.load(name, (64, 36))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    log = Log()
    buffers = export_scene(depsgraph, depsgraph.scene_eval, depsgraph.view_layer_eval, log)
    camera = export_camera(depsgraph.scene_eval, depsgraph.scene_eval.camera, log)
    assert camera is not None and not log.texts('ERROR')
    check(buffers)
    assert np.array_equal(shown_triangles(buffers), blender_triangles(depsgraph))


def check(buffers: SceneBuffers) -> None:
    """Everything that the native module relies on."""
    instances, slots = buffers.instances, buffers.material_slots
    assert (instances.mesh < len(buffers.meshes)).all()
    assert (instances.material_count >= 1).all()
    assert (instances.material_base + instances.material_count <= len(slots)).all()
    assert (slots < len(buffers.materials.names)).all()
    for mesh in buffers.meshes:
        assert np.isfinite(mesh.positions).all() and mesh.triangles.max() < len(mesh.positions)
        if mesh.normals is not None:
            lengths = np.linalg.norm(mesh.normals, axis=1)
            assert lengths.min() > 0.7 and lengths.max() < 1.5
        entries = mesh.corners if mesh.normals_domain == 'CORNER' else mesh.triangles
        assert mesh.normals is None or entries.max() < len(mesh.normals)
        assert mesh.uv is None or mesh.corners.max() < len(mesh.uv)
    for index, count in zip(instances.mesh, instances.material_count, strict=True):
        mesh = buffers.meshes[index]
        assert mesh.slots is None or mesh.slots.max() < count
    for values in (instances.transform, buffers.lights.transform, buffers.lights.strength, buffers.world.color):
        assert np.isfinite(values).all()


def shown_triangles(buffers: SceneBuffers) -> np.ndarray:
    counts = np.array([len(mesh.triangles) for mesh in buffers.meshes], np.int64)
    return np.sort(counts[buffers.instances.mesh])


def blender_triangles(depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """The same count by the plain way: instance by instance."""
    counts = [
        len(item.object.data.loop_triangles)
        for item in depsgraph.object_instances
        if item.show_self and isinstance(item.object.data, bpy.types.Mesh)
    ]
    return np.sort([count for count in counts if count])
