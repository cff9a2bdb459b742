# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra explain`: what each material of a file became, without rendering or exporting anything else of it.

It reads one material at a time onto a square of its own; words and columns are addon/shader/explain.py's.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from . import arguments, choices, native
from .opening import open_scene, require_source
from .terminal import WRONG_ARGUMENTS, CommandError

if TYPE_CHECKING:
    import bpy

    from .export.buffers import SceneBuffers
    from .shader.explain import Explanation


# ---- The command.


def add_command(commands: Any) -> None:
    """Adds `explain` to the command line's commands."""
    line = commands.add_parser(
        'explain',
        help='print what materials became',
        description='Prints, for each material of a .blend file or of a demo, the program that its node tree became: '
        'instructions, closures, constants, what was left out and why, and what it costs at each point.',
    )
    arguments.add_source(line)
    line.add_argument('--material', action='append', metavar='NAME', help='this one alone; may be given several times')
    line.add_argument('--read', action='store_true', help='print the ops as they were read, before folding, as well')


def run(options: argparse.Namespace) -> None:
    """All that `cotorra explain` does; the text goes to stdout. Raises CommandError."""
    if options.file is not None:
        require_source(options.file)
    scene = open_scene(options.file, options.demo)
    import bpy

    found = [material for material in bpy.data.materials if not material.is_grease_pencil]
    wanted = options.material or []
    known = {material.name for material in found}
    for name in wanted:
        if name not in known:
            names = ', '.join(f'"{other}"' for other in sorted(known)) or 'none'
            raise CommandError(f'there is no material "{name}"; there are: {names}', WRONG_ARGUMENTS)
    if wanted:
        found = [material for material in found if material.name in wanted]
    failed = []
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for index, material in enumerate(sorted(found, key=lambda material: material.name)):
        try:
            text = explain_material(material, scene, depsgraph, options.read).text()
        except ValueError as problem:  # the native module's: it names the shader
            failed.append(material.name)
            text = f'Material "{material.name}": {problem}'
        print(text if index == 0 else f'\n\n{text}', flush=True)
    if failed:
        raise CommandError(f'not compiled: {", ".join(failed)}')


# ---- One material.


def explain_material(
    material: bpy.types.Material, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, read: bool = False
) -> Explanation:
    """What a material became. read: with its ops as they were read. Raises ValueError where it cannot be compiled."""
    from .shader.explain import Explanation, Section, folded, unfolded

    warnings: list[str] = []
    buffers, notes = material_buffers(material.evaluated_get(depsgraph), scene, depsgraph, warnings)
    found = native.load().Scene(buffers, bvh=False).explain(0)
    told = folded(f'Material "{material.name}"', found, buffers, notes, warnings)
    sections = told.sections
    override = scene.cotorra.use_model_override
    model = (scene.cotorra.model_override if override else material.cotorra).model
    if model != 'PRINCIPLED':
        name = next(name for identifier, name, _ in choices.MODELS if identifier == model)
        sections = (Section(f'Cotorra Model: {name}{", the override of the scene" if override else ""}'), *sections)
    if read:
        sections += (unfolded(buffers.shaders[0]),)
    return Explanation(told.title, sections)


def material_buffers(
    material: bpy.types.Material, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, warnings: list[str]
) -> tuple[SceneBuffers, tuple[str, ...]]:
    """The material on a square that has all the layers that it asks for; and the notes of its draft.

    warnings: takes what is said of the material and its images.
    """
    from . import shader
    from .export import layers
    from .export.attributes import view_layer_value
    from .export.images import ImageTable
    from .export.nodes import Trees
    from .log import Log

    log = Log(lambda level, text: warnings.append(text))
    images = ImageTable(log, scene.frame_current)
    view_layer = depsgraph.view_layer_eval

    def attribute(name: str) -> tuple[float, float, float, float]:
        return view_layer_value(depsgraph.scene_eval, view_layer, name)

    read_with = shader.Scene(images, attribute, occlusion_distance=shader.occlusion_distance(scene))
    trees = Trees(log.checkpoint, warnings.append)
    draft = shader.shaders_of(material, trees, read_with, warnings.append)
    needed = layers.plan([], [draft], [0])
    return square(draft.resolved(needed.numbers), needed, tuple(images.images)), draft.notes


def square(shown: Any, needed: Any, images: tuple) -> SceneBuffers:
    """A square of one metre that shows a shader; its UV maps and attributes go from 0 to 1."""
    from .export.buffers import Attribute, Instances, Lights, Materials, Mesh, SceneBuffers, World

    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    padded = np.zeros((5, 3), np.float32)  # Embree reads on behind the last vertex
    padded[:4, :2] = corners
    positions = padded[:4]
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    tangent = np.tile(np.array([1, 0, 0, 1], np.float32), (4 * max(len(needed.tangent_layers), 1), 1))
    values = np.ones((4, 4), np.float32)
    values[:, :2] = corners
    of_instances = needed.instance_layers
    attributes = tuple(
        Attribute(layer, 'POINT', 3, values)
        for layer in range(len(needed.uv_layers), len(needed.attribute_layers))
        if layer not in of_instances
    )
    mesh = Mesh(
        'square',
        positions,
        triangles,
        corners=triangles,
        uv=np.tile(corners, (len(needed.uv_layers), 1)),
        tangents=tangent,
        generated=positions,
        attributes=attributes,
    )
    transform = np.eye(4, dtype=np.float32)[None, :3].copy()
    one, zero = np.ones(1, np.uint32), np.zeros(1, np.uint32)
    instances = Instances(
        mesh=zero,
        transform=transform,
        material_base=zero,
        material_count=one,
        pass_index=np.zeros(1, np.int32),
        visibility=np.full(1, 63, np.uint32),
        light_group=np.full(1, -1, np.int32),
        terminator=np.zeros(1, np.float32),
        attributes=np.ones((len(of_instances), 1, 4), np.float32) if of_instances else None,
    )
    none = np.zeros(0, np.uint32)
    numbers = np.zeros(0, np.float32)
    lights = Lights(
        type=none,
        strength=np.zeros((0, 3), np.float32),
        transform=np.zeros((0, 3, 4), np.float32),
        size=numbers,
        spot_size=numbers,
        spot_blend=numbers,
        soft_falloff=none,
        normalize=none,
        cast_shadow=none,
        use_mis=none,
        max_bounces=none,
        visibility=none,
        light_group=np.zeros(0, np.int32),
    )
    return SceneBuffers(
        meshes=(mesh,),
        instances=instances,
        materials=Materials(pass_index=np.zeros(1, np.int32), emission_sampling=one, shader=np.zeros(1, np.int32)),
        material_slots=zero,
        lights=lights,
        world=World(),
        images=images,
        uv_layers=needed.uv_layers,
        tangent_layers=needed.tangent_layers,
        shaders=(shown,),
        attribute_layers=needed.attribute_layers,
        instance_layers=of_instances,
    )
