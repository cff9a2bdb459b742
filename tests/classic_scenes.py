# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes as the native module takes them, without Blender, for tests of integrators against closed forms.

What Blender's data become is tested with the exporter.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from cotorra import native
from cotorra.export import buffers

import shaders

F32, U32, I32 = np.float32, np.uint32, np.int32
LIGHT_TYPES = {'POINT': buffers.LIGHT_POINT, 'SUN': buffers.LIGHT_SUN, 'SPOT': buffers.LIGHT_SPOT}


@dataclass(frozen=True)
class Material:
    """A Principled material, white and matt by default."""

    base_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    metallic: float = 0.0
    roughness: float = 1.0
    ior: float = 1.5
    specular_level: float = 0.0
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    transmission: float = 0.0
    alpha: float = 1.0
    model: dict[str, Any] = field(default_factory=dict)  # fields of MaterialModels


GLASS = Material(roughness=0.0, specular_level=0.5, transmission=1.0)
MIRROR = Material(roughness=0.0, metallic=1.0)
# What material.cotorra is when nobody touched it (material_settings.py).
MODEL = {'ka': 1.0, 'kd': 1.0 / np.pi, 'ks': 0.5, 'shininess': 32.0, 'toon_steps': 2, 'specular_color': (1, 1, 1)}
MODEL |= {'f82_tint': (1, 1, 1), 'toon_lit': (1, 1, 1), 'toon_shade': (0, 0, 0)}


@dataclass(frozen=True)
class Shape:
    """Triangles in world space with one material; flat, or with a normal at each vertex."""

    positions: np.ndarray
    triangles: np.ndarray
    material: Material = Material()
    normals: np.ndarray | None = None


@dataclass(frozen=True)
class Lamp:
    kind: str
    strength: tuple[float, float, float] = (1.0, 1.0, 1.0)
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    towards: tuple[float, float, float] = (0.0, 0.0, -1.0)
    size: float = 0.0


def quad(corner: Any, x: Any, y: Any, material: Material = Material()) -> Shape:
    """A parallelogram; its front is where x goes counter-clockwise to y."""
    corner, x, y = (np.array(value, float) for value in (corner, x, y))
    return Shape(np.array([corner, corner + x, corner + x + y, corner + y]), np.array([[0, 1, 2], [0, 2, 3]]), material)


def box(low: Any, high: Any, material: Material = Material()) -> Shape:
    """A closed box, its fronts outside."""
    low, high = np.array(low, float), np.array(high, float)
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [[f[0], f[1], f[2]] for f in faces] + [[f[0], f[2], f[3]] for f in faces]
    return Shape(low + corners * (high - low), np.array(triangles), material)


def sphere(centre: Any, radius: float, material: Material = Material(), segments: int = 96) -> Shape:
    """A smooth sphere of longitudes and latitudes, its front outside."""
    rings = segments // 2
    phi = np.linspace(0.0, 2.0 * np.pi, segments, endpoint=False)
    theta = np.linspace(0.0, np.pi, rings + 1)
    normals = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(segments)),
        ],
        axis=-1,
    )
    index = np.arange((rings + 1) * segments).reshape(rings + 1, segments)
    a, b = index[:-1], index[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    flat = normals.reshape(-1, 3)
    return Shape(np.array(centre) + radius * flat, triangles, material, flat)


def camera(
    size: tuple[int, int], position: Any, look: Any, up: Any = (0.0, 1.0, 0.0), window: float = 1.0, **changes: Any
) -> buffers.Camera:
    """An orthographic camera that looks along `look`, `window` metres high; filter_width 0 puts rays at the centres."""
    z = -np.array(look, float) / np.linalg.norm(look)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(z, x), z, np.array(position, float)], axis=1).astype(F32)
    half = 0.5 * window
    wide = half * size[0] / size[1]
    region = (0, 0, *size)
    made = buffers.Camera('ORTHO', frame, (-wide, wide, -half, half), (0.0, 1e4), size, region, 0.0)
    return replace(made, **changes)


def _models(materials: list[Material]) -> buffers.MaterialModels | None:
    if not any(material.model for material in materials):
        return None
    columns = {}
    for name, kind in buffers.MaterialModels.__annotations__.items():
        values = [(MODEL | material.model).get(name, 0) for material in materials]
        wide = name in ('specular_color', 'f0', 'f82_tint', 'conductor_n', 'conductor_k', 'toon_lit', 'toon_shade')
        if wide or name == 'absorption':
            values = [np.broadcast_to(value, 3) for value in values]
        columns[name] = np.array(values, U32 if kind == 'U32' else F32)
    return buffers.MaterialModels(**columns)


def _materials(shapes: list[Shape]) -> buffers.Materials:
    """Material number i has shader number i."""
    count = len(shapes)
    return buffers.Materials(
        pass_index=np.zeros(count, I32),
        emission_sampling=np.ones(count, U32),
        shader=np.arange(count, dtype=I32),
        models=_models([shape.material for shape in shapes]),
    )


def _shader(material: Material) -> buffers.Shader:
    names = ('base_color', 'metallic', 'roughness', 'ior', 'specular_level', 'emission', 'transmission', 'alpha')
    return shaders.principled(multi_ggx=False, **{name: getattr(material, name) for name in names})


def _lights(lamps: list[Lamp]) -> buffers.Lights:
    count = len(lamps)
    frames = np.zeros((count, 3, 4), F32)
    for frame, lamp in zip(frames, lamps, strict=True):
        z = -np.array(lamp.towards, float) / np.linalg.norm(lamp.towards)
        x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
        x /= np.linalg.norm(x)
        frame[:] = np.stack([x, np.cross(z, x), z, lamp.position], axis=1)
    on = {name: np.ones(count, U32) for name in ('soft_falloff', 'normalize', 'cast_shadow', 'use_mis')}
    return buffers.Lights(
        type=np.array([LIGHT_TYPES[lamp.kind] for lamp in lamps], U32),
        strength=np.array([lamp.strength for lamp in lamps], F32).reshape(count, 3),
        transform=frames,
        size=np.array([lamp.size for lamp in lamps], F32),
        spot_size=np.full(count, 1.0, F32),
        spot_blend=np.zeros(count, F32),
        max_bounces=np.full(count, 1024, U32),
        visibility=np.full(count, 63, U32),
        light_group=np.full(count, -1, I32),
        **on,
    )


def exported(
    shapes: list[Shape], lamps: list[Lamp] | None = None, world: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> buffers.SceneBuffers:
    """The shapes as the exporter would hand them over, each an object with its own material."""
    meshes = []
    for number, shape in enumerate(shapes):
        padded = np.zeros((len(shape.positions) + 2, 3), F32)
        padded[: len(shape.positions)] = shape.positions
        normals = None if shape.normals is None else shape.normals.astype(F32)
        domain = 'FACE' if normals is None else 'POINT'
        meshes.append(
            buffers.Mesh(
                name=f'shape {number}',
                positions=padded[: len(shape.positions)],
                triangles=shape.triangles.astype(U32),
                normals=normals,
                normals_domain=domain,
            )
        )
    count = len(shapes)
    instances = buffers.Instances(
        mesh=np.arange(count, dtype=U32),
        transform=np.broadcast_to(np.eye(3, 4, dtype=F32), (count, 3, 4)).copy(),
        material_base=np.arange(count, dtype=U32),
        material_count=np.ones(count, U32),
        pass_index=np.zeros(count, I32),
        visibility=np.full(count, 63, U32),
        light_group=np.full(count, -1, I32),
        terminator=np.zeros(count, F32),
    )
    return buffers.SceneBuffers(
        meshes=tuple(meshes),
        instances=instances,
        materials=_materials(shapes),
        shaders=tuple(_shader(shape.material) for shape in shapes),
        material_slots=np.arange(count, dtype=U32),
        lights=_lights(lamps or []),
        world=buffers.World(color=world),
    )


def scene(*contents: Any, **world: Any) -> Any:
    """As `exported`, as a native scene."""
    return native.load().Scene(exported(*contents, **world), threads=1, embree=native.embree_library())


def session(made: Any, view: buffers.Camera, integrator: str, **settings: Any) -> Any:
    """A finished render."""
    values = {'samples': 1, 'threads': 1} | settings
    run = native.load().Session(made, view, buffers.RenderSettings(integrator=integrator, **values))
    run.start()
    assert run.wait(120.0)
    return run


def read(run: Any, view: buffers.Camera, name: str = 'combined') -> np.ndarray:
    """A pass of a render, row 0 the bottom."""
    out = np.zeros((view.region[3], view.region[2], buffers.PASSES[name]), F32)
    run.read(name, out)
    return out


def render(made: Any, view: buffers.Camera, integrator: str, **settings: Any) -> np.ndarray:
    return read(session(made, view, integrator, **settings), view)
