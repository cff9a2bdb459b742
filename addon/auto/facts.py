# SPDX-License-Identifier: GPL-3.0-or-later
"""What the exported scene tells without a render: what can make caustics, how small the lamps are, what lets through.

It reads SceneBuffers. What cannot be told from constants is left to the pilot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..export.buffers import LIGHT_AREA, LIGHT_SUN, SceneBuffers, Shader
from ..shader.ops import Tables, tables
from ..shader.words import CLOSURE_ARGUMENTS

# A surface that reflects less throws no caustic that counts: what glossy paint and plastic do, at 4 %.
CASTS = 0.1
# Paths that must meet a lamp by way of a mirror, by chance, for a pilot to have seen such light.
HITS = 10.0


@dataclass(frozen=True, slots=True)
class Caster:
    """A surface that may throw caustics. kind: 'glass' or 'mirror'. roughness: None where it varies."""

    shader: int
    name: str
    kind: str
    roughness: float | None


@dataclass(frozen=True, slots=True)
class Lamp:
    """What shines. part: of all directions, in which it is seen from the middle of the scene."""

    name: str
    part: float


@dataclass(frozen=True, slots=True)
class Facts:
    """present: limits that can make a difference (RenderSettings' names)."""

    casters: tuple[Caster, ...]
    lamps: tuple[Lamp, ...]
    present: frozenset[str]


def facts(buffers: SceneBuffers, ops: Tables | None = None) -> Facts:
    """ops: the native module's, if not given."""
    known = ops or tables()
    used = sorted({int(index) for index in buffers.materials.shader[np.unique(buffers.material_slots)] if index >= 0})
    casters = tuple(caster for index in used for caster in casters_of(buffers.shaders[index], index, known))
    present = {'max_bounces', 'diffuse_bounces', 'glossy_bounces'}
    closures = [(index, name, values) for index in used for name, values in closures_of(buffers.shaders[index], known)]
    if any(transmits(name, values) for _, name, values in closures) or buffers.materials.models is not None:
        present.add('transmission_bounces')
    if any(lets_through(name, values) for _, name, values in closures):
        present.add('transparent_bounces')
    return Facts(casters, lamps_of(buffers, known), frozenset(present))


def undetected(found: Facts, paths: int, reflective: bool, refractive: bool) -> tuple[Caster, Lamp] | None:
    """A surface and a lamp whose caustic so many paths would most likely miss; None where there is none.

    A path finds the light of a lamp behind a mirror by the lamp's part of all directions, or by the surface's lobe:
    where it is rough, the lamp is sampled, and what counts is that the surface turns it to the eye. A GGX lobe of
    alpha = roughness² fills about alpha² / 4 of all directions (half of it lies within alpha of its middle, Walter et
    al. 2007).

    reflective, refractive: whether such caustics are rendered at all.
    """
    rendered = {'mirror': reflective, 'glass': refractive}
    for caster in found.casters:
        if caster.roughness is None or not rendered[caster.kind]:
            continue
        lobe = caster.roughness**4 / 4.0
        for lamp in found.lamps:
            seen = max(lamp.part, lobe)
            if 0.0 < seen and paths * seen < HITS:
                return caster, lamp
    return None


def closures_of(shader: Shader, known: Tables) -> Iterator[tuple[str, dict[str, float | None]]]:
    """Each closure that counts, with its arguments by name: numbers, the greatest of a colour's; None what varies."""
    names = {kind.number: name for name, kind in known.closures.items()}

    def value(reference: int) -> float | None:
        return None if reference >= 0 else float(np.max(shader.constants[~reference]))

    for row in shader.closures:
        if value(int(row['weight'])) == 0.0:
            continue
        name = names[int(row['kind'])]
        first = int(row['first_arg'])
        arguments = shader.closure_args[first : first + len(known.closures[name].arguments)].tolist()
        yield name, dict(zip(CLOSURE_ARGUMENTS[name], map(value, arguments), strict=True))


def transmits(name: str, values: dict[str, float | None]) -> bool:
    return name in ('glass', 'refraction', 'translucent') or values.get('transmission', 0.0) != 0.0


def lets_through(name: str, values: dict[str, float | None]) -> bool:
    return name in ('transparent', 'holdout') or (name == 'principled' and values['alpha'] != 1.0)


def casters_of(shader: Shader, index: int, known: Tables) -> Iterator[Caster]:
    for name, values in closures_of(shader, known):
        roughness = values.get('roughness')
        if name in ('glass', 'refraction'):
            yield Caster(index, shader.name, 'glass', roughness)
        elif name in ('glossy', 'metallic'):
            yield Caster(index, shader.name, 'mirror', roughness)
        elif name == 'principled':
            if _beyond(values['transmission'], CASTS):
                yield Caster(index, shader.name, 'glass', roughness)
            if _beyond(values['metallic'], CASTS):
                yield Caster(index, shader.name, 'mirror', roughness)


def _beyond(value: float | None, limit: float) -> bool:
    return value is None or value >= limit


def lamps_of(buffers: SceneBuffers, known: Tables) -> tuple[Lamp, ...]:
    """What shines and may be met by a ray, as seen from the middle of the objects: lamps, meshes, the sky's sun."""
    lights, centres = buffers.lights, centres_of(buffers)
    middle = centres.mean(axis=0) if len(centres) else np.zeros(3)
    found = []
    for index in range(len(lights.type)):
        kind, size = lights.type[index], float(lights.size[index])
        if not lights.use_mis[index] or not np.any(lights.strength[index]):
            continue
        if kind == LIGHT_SUN:
            part = sun_part(size)
        else:
            area = np.pi * size**2
            if kind == LIGHT_AREA:
                axes = np.linalg.norm(lights.transform[index, :, :2], axis=0)
                other = size if lights.size_y is None else float(lights.size_y[index])
                area = size * other * float(axes[0] * axes[1])
            part = seen_part(area, lights.transform[index, :, 3] - middle)
        name = lights.names[index] if index < len(lights.names) else f'{index}'
        found.append(Lamp(name, part))
    if buffers.world.sun[3] > 0.0:
        found.append(Lamp(buffers.world.name, sun_part(buffers.world.sun[3])))
    for instance, area in emitters_of(buffers, known):
        names = buffers.instances.names
        name = names[min(instance, len(names) - 1)] if names else f'{instance}'
        found.append(Lamp(name, seen_part(area, centres[instance] - middle)))
    return tuple(found)


def sun_part(angle: float) -> float:
    """The part of all directions within a cone of that full angle, radians."""
    return 0.5 * (1.0 - float(np.cos(0.5 * angle)))


def seen_part(area: float, away: np.ndarray) -> float:
    """The part of all directions that an area (m²) which faces one takes, so far away (m)."""
    return float(min(area / (4.0 * np.pi * max(float((away**2).sum()), 1e-12)), 0.5))


def centres_of(buffers: SceneBuffers) -> np.ndarray:
    """Of each instance's box, (I, 3)."""
    objects = buffers.instances
    boxes = [
        0.5 * (mesh.positions.min(axis=0) + mesh.positions.max(axis=0)) if len(mesh.positions) else np.zeros(3)
        for mesh in buffers.meshes
    ]
    if not len(objects.mesh):
        return np.zeros((0, 3))
    local = np.stack(boxes)[objects.mesh]
    return np.einsum('irc,ic->ir', objects.transform[:, :, :3], local) + objects.transform[:, :, 3]


def emitters_of(buffers: SceneBuffers, known: Tables) -> Iterator[tuple[int, float]]:
    """Instances that shine, with the area that does: half of it, as a closed mesh shows one side."""
    shining = [any(emits(*entry) for entry in closures_of(shader, known)) for shader in buffers.shaders]
    of_material = np.array([index >= 0 and shining[index] for index in buffers.materials.shader.tolist()], bool)
    objects = buffers.instances
    of_slot = of_material[buffers.material_slots]
    for instance in range(len(objects.mesh)):
        base, count = int(objects.material_base[instance]), int(objects.material_count[instance])
        if not of_slot[base : base + count].any():
            continue
        mesh = buffers.meshes[objects.mesh[instance]]
        slots = np.zeros(len(mesh.triangles), np.int64) if mesh.slots is None else np.minimum(mesh.slots, count - 1)
        corners = mesh.positions[mesh.triangles[of_slot[base + slots]]] @ objects.transform[instance, :, :3].T
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        yield instance, 0.25 * float(np.linalg.norm(sides, axis=1).sum())


def emits(name: str, values: dict[str, float | None]) -> bool:
    return (name == 'emission' and values['color'] != 0.0) or values.get('emission', 0.0) != 0.0
