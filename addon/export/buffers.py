# SPDX-License-Identifier: GPL-3.0-or-later
"""The border between Blender and the native module: frozen dataclasses of NumPy arrays.

Nothing here knows `bpy`, and nothing past here does: `cotorra_native` reads these attributes by name and checks them.
All arrays are C-contiguous; lengths are metres, colours scene-linear, matrices row-major and applied to column vectors.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]
I32 = NDArray[np.int32]

# Bits of `Instances.visibility`, `Lights.visibility` and `World.visibility` (kernels/scene_types.h, VISIBLE_*).
VISIBLE_CAMERA, VISIBLE_DIFFUSE, VISIBLE_GLOSSY = 1, 2, 4
VISIBLE_TRANSMISSION, VISIBLE_VOLUME, VISIBLE_SHADOW = 8, 16, 32

LIGHT_POINT, LIGHT_SUN, LIGHT_SPOT = 0, 1, 2


@dataclass(frozen=True, slots=True)
class Mesh:
    """One triangle mesh in object space.

    name:      of the object data, for messages.
    positions: (V, 3) float32; the buffer it views holds 4 bytes more at least (Embree reads 16 bytes at each vertex).
    triangles: (T, 3) uint32 vertex indices.
    corners:   (T, 3) uint32 corner indices, or None where neither uv nor corner normals are there.
    normals:   None (flat), or (V, 3) float32 where `normals_domain` is 'POINT', (C, 3) where it is 'CORNER'.
    uv:        (C, 2) float32 of the active render UV map, or None.
    slots:     (T,) uint32 material slot of each triangle, or None where all are 0.
    colors:    colour attributes by name, (V, 4) or (C, 4) float32; kept for materials that read them.
    """

    name: str
    positions: F32
    triangles: U32
    corners: U32 | None = None
    normals: F32 | None = None
    normals_domain: str = 'FACE'
    uv: F32 | None = None
    slots: U32 | None = None
    colors: dict[str, F32] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Instances:
    """The objects of the scene, I of them; each shows one mesh.

    mesh:          (I,) uint32 index into `SceneBuffers.meshes`.
    transform:     (I, 3, 4) float32 object-to-world.
    material_base: (I,) uint32 first entry in `SceneBuffers.material_slots`.
    material_count:(I,) uint32 slots of the object, at least 1.
    pass_index:    (I,) int32.
    visibility:    (I,) uint32 VISIBLE_* bits.
    light_group:   (I,) int32 index into `SceneBuffers.light_groups`, -1 for none.
    terminator:    (I,) float32 Cycles' shadow terminator geometry offset, 0 to 1 (0 = off).
    names:         object names by instance, for messages; may be shorter than I (objects of one parent share the last).
    """

    mesh: U32
    transform: F32
    material_base: U32
    material_count: U32
    pass_index: I32
    visibility: U32
    light_group: I32
    terminator: F32
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Materials:
    """M materials: the Principled BSDF's constants. Entry 0 is the default material of objects without one.

    emission is colour × strength. emission_sampling: 1 = sampled as a light, 0 = only found by rays.
    emission_sides: 1 = the front of a face emits, 2 = its back, 3 = both; None = both everywhere.
    """

    base_color: F32  # (M, 3)
    metallic: F32  # (M,)
    roughness: F32  # (M,)
    ior: F32  # (M,)
    specular_level: F32  # (M,)
    specular_tint: F32  # (M, 3)
    emission: F32  # (M, 3)
    alpha: F32  # (M,)
    multi_ggx: U32  # (M,) 1 = Multiscatter GGX, 0 = GGX
    pass_index: I32  # (M,)
    emission_sampling: U32  # (M,)
    emission_sides: U32 | None = None  # (M,)
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Lights:
    """L lamps in Blender's units; the native module derives radiance (blender-facts.md, 'Lights').

    strength: (L, 3) colour × temperature colour × energy × 2^exposure.
    transform:(L, 3, 4) float32 object-to-world, scale and shear included.
    size:     (L,) radius in metres (point, spot) or angle in radians (sun).
    """

    type: U32  # (L,) LIGHT_*
    strength: F32
    transform: F32
    size: F32
    spot_size: F32  # (L,) full cone angle, radians
    spot_blend: F32  # (L,)
    soft_falloff: U32  # (L,) 0 or 1
    normalize: U32  # (L,) 0 or 1
    cast_shadow: U32  # (L,) 0 or 1
    use_mis: U32  # (L,) 0 or 1: may be met by rays (Cycles' "Multiple Importance")
    max_bounces: U32  # (L,)
    visibility: U32  # (L,)
    light_group: I32  # (L,)
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class World:
    """The background: one colour (already × strength), and which rays see it."""

    color: tuple[float, float, float] = (0.0, 0.0, 0.0)
    visibility: int = 63
    light_group: int = -1


@dataclass(frozen=True, slots=True)
class SceneBuffers:
    """A whole scene, ready for `cotorra_native.Scene`.

    material_slots: (S,) uint32 indices into materials; instance i owns [material_base, material_base + material_count).
    light_groups:   names, in the order that `light_group` indexes.
    """

    meshes: tuple[Mesh, ...]
    instances: Instances
    materials: Materials
    material_slots: U32
    lights: Lights
    world: World
    light_groups: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole or an orthographic camera, and the part of its picture that is rendered.

    kind:       'PERSP' or 'ORTHO'.
    transform:  (3, 4) float32 camera-to-world without scale; the camera looks along its -Z.
    window:     left, right, bottom, top of the whole picture on the plane z = -1 (PERSP) or in metres (ORTHO).
    clip:       near and far along the viewing axis, metres.
    resolution: width and height of the whole picture in pixels.
    region:     x0, y0, width, height of the rendered part in pixels, y upwards.
    filter_width: of the Blackman-Harris pixel filter, in pixels (Blender's default 1.5).
    """

    kind: str
    transform: F32
    window: tuple[float, float, float, float]
    clip: tuple[float, float]
    resolution: tuple[int, int]
    region: tuple[int, int, int, int]
    filter_width: float = 1.5


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """What to render.

    integrator: 'DIRECT' or 'PATH'. max_bounces counts all, the others their kind; DIRECT ignores them.
    passes:     native pass names, see PASSES; 'combined' is always there.
    threads:    0 = all.
    measure_tracing: trace every ray a second time, alone, to tell how much of the time is Embree's; for benchmarks.
    """

    integrator: str = 'DIRECT'
    samples: int = 64
    seed: int = 0
    max_bounces: int = 12
    diffuse_bounces: int = 4
    glossy_bounces: int = 4
    transparent_bounces: int = 8
    adaptive: bool = False
    noise_threshold: float = 0.01
    adaptive_min_samples: int = 0
    transparent_film: bool = False
    threads: int = 0
    passes: tuple[str, ...] = ('combined',)
    measure_tracing: bool = False


# Native pass name -> channels. 'lightgroup:N' (3 channels) is the N-th light group.
PASSES = {
    'combined': 4,
    'depth': 1,
    'position': 3,
    'normal': 3,
    'uv': 3,
    'object_index': 1,
    'material_index': 1,
    'diffuse_color': 3,
    'emission': 3,
    'environment': 3,
    'shadow': 3,
    'sample_count': 1,
}
