# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of materials that a picture may do without: lobes of Principled, and what only bends or roughens.

It finds them in SceneBuffers and makes the same scene without some of them. Which of them count is told by a pilot.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..export.buffers import SceneBuffers, Shader
from ..shader.ops import Tables, tables
from ..shader.tree import BENT_NORMAL, NORMALS, OWN_NORMAL
from ..shader.words import CLOSURE_ARGUMENTS

# What may be left out, and how it is called: an argument of a closure that is off at 0. Those of Principled that come
# first are lobes of their own.
PARTS = {
    'coat': 'coat',
    'sheen': 'sheen',
    'film_thickness': 'film',
    'specular_level': 'specular layer',
    'anisotropic': 'anisotropy',
    'anisotropy': 'anisotropy',
    'diffuse_roughness': 'diffuse roughness',
}
NORMAL = 'normal'  # bump and normal maps: the surface's own normal instead
BENT = 'normal detail'


@dataclass(frozen=True, slots=True)
class Part:
    """shader, closure: indices. argument: of the closure, by its name. weight: None where it varies."""

    shader: int
    closure: int
    argument: str
    name: str
    weight: float | None

    @property
    def words(self) -> str:
        return f'{PARTS.get(self.argument, BENT)} of "{self.name}"'


def parts_of(buffers: SceneBuffers, kept: frozenset[str] = frozenset(), known: Tables | None = None) -> list[Part]:
    """All that may be left out, what counts least first as far as its weight tells.

    kept: names of materials that must stay as they are. known: the native module's tables, if not given.
    """
    known = known or tables()
    names = {kind.number: name for name, kind in known.closures.items()}
    own_normal = known.ops['normal'].number
    used = np.unique(buffers.material_slots)
    owners: dict[int, set[str]] = {}
    kept_shaders = set()  # of materials that do not reflect as their nodes say
    other_models = buffers.materials.models
    for index in used.tolist():
        if other_models is not None and other_models.model[index] != 0:
            kept_shaders.add(int(buffers.materials.shader[index]))
        name = buffers.materials.names[index] if index < len(buffers.materials.names) else ''
        owners.setdefault(int(buffers.materials.shader[index]), set()).add(name)
    found = []
    for index, named in owners.items():
        if index < 0 or named & kept or index in kept_shaders:
            continue
        shader = buffers.shaders[index]
        for row, closure in enumerate(shader.closures):
            kind = names[int(closure['kind'])]
            arguments = CLOSURE_ARGUMENTS[kind]
            first = int(closure['first_arg'])
            for place, argument in enumerate(arguments):
                reference = int(shader.closure_args[first + place])
                if argument in PARTS:
                    weight = None if reference >= 0 else float(shader.constants[~reference][0])
                    # The specular layer of a metal is no layer.
                    if weight != 0.0 and not (argument == 'specular_level' and _always(shader, first, 'metallic')):
                        found.append(Part(index, row, argument, shader.name, weight))
                elif argument == NORMAL and place == NORMALS.get(kind):
                    bent = reference >= 0 and shader.ops[reference] != own_normal
                    if bent and not int(closure['mode']) & OWN_NORMAL:
                        found.append(Part(index, row, argument, shader.name, None))
    return sorted(found, key=lambda part: (part.weight is None, abs(part.weight or 0.0), part.shader, part.closure))


def _always(shader: Shader, first: int, argument: str) -> bool:
    reference = int(shader.closure_args[first + CLOSURE_ARGUMENTS['principled'].index(argument)])
    return reference < 0 and float(shader.constants[~reference][0]) == 1.0


def without(buffers: SceneBuffers, parts: Sequence[Part], known: Tables | None = None) -> SceneBuffers:
    """The same scene without these parts of its materials."""
    known = known or tables()
    shaders = list(buffers.shaders)
    for index in {part.shader for part in parts}:
        shaders[index] = _shader_without(shaders[index], [part for part in parts if part.shader == index], known)
    return replace(buffers, shaders=tuple(shaders))


def _shader_without(shader: Shader, parts: Sequence[Part], known: Tables) -> Shader:
    names = {kind.number: name for name, kind in known.closures.items()}
    arguments, closures = shader.closure_args.copy(), shader.closures.copy()
    constants = np.concatenate([shader.constants, np.zeros((1, 3), np.float32)])
    nothing = ~len(shader.constants)
    ops, modes, labels = shader.ops, shader.modes, shader.labels
    if any(part.argument == NORMAL for part in parts):
        ops = np.append(ops, np.uint32(known.ops['normal'].number)).astype(np.uint32)
        modes = np.append(modes, np.uint32(0)).astype(np.uint32)
        labels = (*labels, '')
    for part in parts:
        closure = closures[part.closure]
        first, known_arguments = int(closure['first_arg']), CLOSURE_ARGUMENTS[names[int(closure['kind'])]]
        left = len(ops) - 1 if part.argument == NORMAL else nothing
        if part.argument == NORMAL and int(closure['mode']) & BENT_NORMAL:
            # What a displacement does stays.
            left = arguments[first + len(known_arguments)]
            closure['mode'] ^= BENT_NORMAL | OWN_NORMAL
        arguments[first + known_arguments.index(part.argument)] = left
    shown = replace(shader, ops=ops, modes=modes, labels=labels, constants=constants)
    return replace(shown, closures=closures, closure_args=arguments)


def work(buffers: SceneBuffers) -> int:
    """What compiling a scene anew and building its BVH costs, in paths: one a triangle, one for four texels.

    A path takes about a microsecond, as does a triangle of a BVH; texels are copied.
    """
    triangles = sum(len(mesh.triangles) for mesh in buffers.meshes)
    return triangles + sum(image.pixels.shape[0] * image.pixels.shape[1] for image in buffers.images) // 4


def needless(parts: Sequence[Part], suffices: Callable[[list[Part]], bool], probes: int) -> list[Part]:
    """The parts that can be left out together: all, or the halves that suffice beside what was found before.

    suffices: whether a list can be left out. probes: how often it may be asked.
    """
    found: list[Part] = []
    groups = [list(parts)] if parts else []
    while groups and probes > 0:
        group = groups.pop(0)
        probes -= 1
        if suffices(found + group):
            found += group
        elif len(group) > 1:
            middle = (len(group) + 1) // 2
            groups += [group[:middle], group[middle:]]
    return found
