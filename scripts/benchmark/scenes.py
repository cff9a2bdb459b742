# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be rendered: the demos, scenes by others where they are at hand, .blend files, meshes of the sync test.

`find` runs anywhere and needs no Blender; `build` and `strip_textures` run in Blender. No measuring here.
"""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path

from cotorra.choices import DEMOS

ROOT = Path(__file__).resolve().parent.parent.parent
OPEN = ROOT.parent / 'shared' / 'scenes' / 'open'

# The demos that mean the same to Cycles: it knows no reflection model but Principled.
SAME_IN_CYCLES = ('three_lights', 'box_room', 'material_grid')


@dataclass(frozen=True, slots=True)
class SceneSource:
    """A scene by name. kind: 'demo', 'open', 'blend', 'grid' (number: triangles), 'instances' (number of them) or
    'materials'."""

    name: str
    kind: str
    path: str = ''
    number: int = 0

    def digest(self) -> str:
        """Changes when what is rendered may have changed."""
        demos = ROOT / 'addon' / 'demos'
        files = {
            'demo': sorted(demos.glob('*.py')),
            'blend': [Path(self.path)],
        }.get(self.kind, [])
        if self.kind == 'open':
            folder = OPEN / self.name
            files = [OPEN / 'load.py', *sorted(path for path in folder.rglob('*') if path.is_file())]
        if self.kind == 'grid' or self.kind == 'instances':
            files = [Path(__file__)]
        state = hashlib.sha256(repr(self).encode())
        for file in files:
            state.update(file.read_bytes())
        return state.hexdigest()


def open_names() -> list[str]:
    """Scenes by others that are here; an empty list where the folder is not."""
    if not (OPEN / 'load.py').is_file():
        return []
    text = (OPEN / 'load.py').read_text()
    lines = text.splitlines()
    return [lines[i + 1].split('(')[0].removeprefix('def ') for i, line in enumerate(lines) if line == '@scene']


def find(name: str) -> SceneSource:
    """Raises ValueError naming what there is."""
    if name.endswith('.blend'):
        if not Path(name).is_file():
            raise ValueError(f'{name}: no such file')
        return SceneSource(Path(name).stem, 'blend', str(Path(name).resolve()))
    if name in DEMOS:
        return SceneSource(name, 'demo')
    if name in open_names():
        return SceneSource(name, 'open')
    there = ', '.join((*DEMOS, *open_names()))
    raise ValueError(f'no scene is called {name}; there are {there}, and any .blend file')


def build(source: SceneSource) -> None:
    """Makes it the open file of the running Blender."""
    import bpy

    if source.kind == 'blend':
        bpy.ops.wm.open_mainfile(filepath=source.path, load_ui=False)
    elif source.kind == 'open':
        sys.path.insert(0, str(OPEN))
        import load

        load.load(source.name)
    elif source.kind == 'demo':
        from cotorra import demos

        demos.build(source.name)
    elif source.kind == 'materials':
        from benchmark import materials

        materials.surfaces()
    else:
        build_grid(source)


def build_grid(source: SceneSource) -> None:
    """A wavy smooth surface of `number` triangles, or `number` instances of one small mesh, under one sun."""
    import bpy
    import numpy as np

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    triangles = source.number if source.kind == 'grid' else 20_000
    side = round((triangles / 2) ** 0.5)
    x, y = np.meshgrid(np.linspace(-1, 1, side + 1, dtype=np.float32), np.linspace(-1, 1, side + 1, dtype=np.float32))
    z = 0.05 * np.sin(20 * x) * np.cos(17 * y)
    corner = np.arange((side + 1) * side).reshape(side, side + 1)[:, :-1].reshape(-1)
    quads = np.stack((corner, corner + 1, corner + side + 2, corner + side + 1), axis=1).astype(np.int32)

    mesh = bpy.data.meshes.new('Grid')
    mesh.vertices.add(x.size)
    mesh.vertices.foreach_set('co', np.stack((x, y, z), axis=-1).reshape(-1).astype(np.float32))
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set('vertex_index', quads.reshape(-1))
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set('loop_start', np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.uv_layers.new(name='UVMap').uv.foreach_set('vector', np.tile(np.float32([0, 0, 1, 0, 1, 1, 0, 1]), len(quads)))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()

    shown = bpy.data.objects.new('Grid', mesh)
    scene.collection.objects.link(shown)
    if source.kind == 'instances':
        # One instance on each vertex of a parent: objects of their own would cost Blender more than any engine.
        columns = int(np.ceil(source.number**0.5))
        places = np.zeros((source.number, 3), np.float32)
        places[:, 0] = 2 * (np.arange(source.number) % columns + 0.5) / columns - 1
        places[:, 1] = 2 * (np.arange(source.number) // columns + 0.5) / columns - 1
        points = bpy.data.meshes.new('Places')
        points.vertices.add(source.number)
        points.vertices.foreach_set('co', places.reshape(-1))
        parent = bpy.data.objects.new('Places', points)
        parent.instance_type = 'VERTS'
        scene.collection.objects.link(parent)
        shown.parent = parent
        shown.scale = (0.8 / columns,) * 3
    sun = bpy.data.objects.new('Sun', bpy.data.lights.new('Sun', 'SUN'))
    sun.rotation_euler = (0.6, 0.4, 0)
    camera = bpy.data.objects.new('Camera', bpy.data.cameras.new('Camera'))
    camera.location = (0, 0, 3)
    scene.collection.objects.link(sun)
    scene.collection.objects.link(camera)
    scene.camera = camera


def strip_textures() -> list[str]:
    """Cuts the links into Principled BSDFs and the world, so that what is left are constants; tells what was cut."""
    import bpy

    cut = []
    for owner in (*bpy.data.materials, *bpy.data.worlds):
        tree = owner.node_tree
        if tree is None:
            continue
        kinds = {'BSDF_PRINCIPLED', 'BACKGROUND'}
        links = [link for link in tree.links if link.to_node.type in kinds]
        for link in links:
            cut.append(f'{owner.name}: {link.to_socket.name}')
            tree.links.remove(link)
    return cut
