# SPDX-License-Identifier: GPL-3.0-or-later
"""The border between Blender and the native module: frozen dataclasses of NumPy arrays.

Nothing here knows `bpy`, and nothing past here does: `cotorra_native` reads these attributes by name and checks them.
All arrays are C-contiguous; lengths are metres, colours scene-linear, matrices row-major and applied to column vectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]
I32 = NDArray[np.int32]

# Bits of `Instances.visibility`, `Lights.visibility` and `World.visibility` (kernels/scene_types.h, VISIBLE_*).
VISIBLE_CAMERA, VISIBLE_DIFFUSE, VISIBLE_GLOSSY = 1, 2, 4
VISIBLE_TRANSMISSION, VISIBLE_VOLUME, VISIBLE_SHADOW = 8, 16, 32
VISIBLE_RAYCAST = 64  # of instances alone

LIGHT_POINT, LIGHT_SUN, LIGHT_SPOT, LIGHT_AREA = 0, 1, 2, 3

# How ops filter images, and what lies outside 0 to 1.
INTERPOLATION_CLOSEST, INTERPOLATION_LINEAR, INTERPOLATION_CUBIC = range(3)
EXTENSION_REPEAT, EXTENSION_EXTEND, EXTENSION_CLIP, EXTENSION_MIRROR = range(4)

# One closure of a shader: its kind, its mode, a `v` reference to its weight, and where its arguments begin.
CLOSURE = np.dtype([('kind', np.uint32), ('mode', np.uint32), ('weight', np.int32), ('first_arg', np.uint32)])


@dataclass(frozen=True, slots=True)
class Shader:
    """What a node tree computes: N ops on earlier values, and the weighted closures whose sum it shows.

    Values are of two types, `f` (one float) and `v` (three). A reference to one is the index of the op that makes it,
    or ~i for constant i; of that, an `f` reads the first component. Numbers, types and modes: kernels/program/ops.inc.

    name:         of the material, light or world, for messages.
    ops:          (N,) uint32 numbers of `cotorra_native.shader_ops()`.
    modes:        (N,) uint32 what the op does; part of the program's shape.
    args:         (A,) int32 references, the arguments of all ops one after the other.
    constants:    (C, 3) float32.
    closures:     (K,) CLOSURE; kinds are the numbers of `cotorra_native.shader_closures()`.
    closure_args: (B,) int32 references.
    labels:       name of the node that each op came from.
    closure_labels: name of the node that each closure came from.
    tables:       (T,) float32 look-up tables; ops take offsets into it as constants.
    """

    name: str
    ops: U32
    modes: U32
    args: I32
    constants: F32
    closures: NDArray[np.void]
    closure_args: I32
    labels: tuple[str, ...]
    tables: F32
    closure_labels: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute of a mesh that shaders look up.

    layer:      index into `SceneBuffers.attribute_layers`.
    domain:     'POINT' (n = V vertices), 'CORNER' (n = C corners) or 'FACE' (n = T, one per triangle).
    components: of the attribute itself, 1 to 4: as a number it is x where there are two, else the mean of x, y, z.
    values:     (n, 4) float32: a number in x, y and z, a vector with 0 for what it lacks, alpha 1 where there is none.
    """

    layer: int
    domain: str
    components: int
    values: F32


@dataclass(frozen=True, slots=True)
class Mesh:
    """One triangle mesh in object space.

    name:      of the object data, for messages.
    positions: (V, 3) float32; the buffer it views holds 4 bytes more at least (Embree reads 16 bytes at each vertex).
    triangles: (T, 3) uint32 vertex indices.
    corners:   (T, 3) uint32 corner indices, or None where neither uv nor corner normals are there.
    normals:   None (flat), or (V, 3) float32 where `normals_domain` is 'POINT', (C, 3) where it is 'CORNER'.
    uv:        (L * C, 2) float32, the first L layers of `SceneBuffers.uv_layers` one after the other, or None. L is as
               many as the mesh's materials ask for, at least 1 (the active render UV map); a layer beyond is 0, 0.
    slots:     (T,) uint32 material slot of each triangle, or None where all are 0.
    tangents:  (K * C, 4) float32 MikkTSpace tangent in object space and its sign (bitangent = sign * cross(normal,
               tangent)), the first K layers of `SceneBuffers.tangent_layers` one after the other; a tangent of 0, 0, 0
               or of a layer beyond leaves the normal as it is. None where no material of the mesh has a normal map.
    generated: (V, 3) float32 generated coordinates (0 to 1 over the undeformed mesh's texture space), or None where no
               material of the mesh asks for them.
    attributes: those that shaders of the mesh ask for, UV maps apart; of the others that it has none, all is 0 and
               alpha 1.
    """

    name: str
    positions: F32
    triangles: U32
    corners: U32 | None = None
    normals: F32 | None = None
    normals_domain: str = 'FACE'
    uv: F32 | None = None
    slots: U32 | None = None
    tangents: F32 | None = None
    generated: F32 | None = None
    attributes: tuple[Attribute, ...] = ()


@dataclass(frozen=True, slots=True)
class InstanceInfo:
    """What the node Object Info shows beside location and pass index: only there if a shader asks for it.

    color:  (I, 4) float32 of the object, alpha last.
    random: (I,) float32 0 to 1, as Cycles hashes it.
    """

    color: F32
    random: F32


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
    attributes:    (A, I, 4) float32, one for each of `SceneBuffers.instance_layers`; None where there are none.
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
    info: InstanceInfo | None = None
    attributes: F32 | None = None


@dataclass(frozen=True, slots=True)
class Linking:
    """Which of the L lights and I instances light which instances, and which instances shadow them.

    receiver:    (I,) uint32 below 64: the set of objects that the instance is lit with.
    blocker:     (I,) uint32 below 24: the set of objects that it shadows with.
    light_sets:  (L + I, 2) uint32 of each light, then of each instance, which may emit: the sets that it lights, one a
                 bit, the lowest first.
    shadow_sets: (L + I,) uint32 the sets that shadow it; all 32 bits set where nothing is linked.
    """

    receiver: U32
    blocker: U32
    light_sets: U32
    shadow_sets: U32


@dataclass(frozen=True, slots=True)
class Image:
    """One image, once in memory however many materials use it, in the depth of its file.

    name:   for messages.
    pixels: (H, W, C) uint8 or uint16 (the largest number is 1), float16 or float32; row 0 is the lowest. C = 1: grey;
            2: grey and alpha; 3: RGB; 4: RGBA. Without alpha it is 1, without colours they are the grey. Colours are
            stored as Cycles stores them: multiplied by alpha, save for data and for "Channel Packed".
    srgb:   colours are sRGB-encoded, in the working space's primaries; to be decoded after filtering, as Cycles does.
    """

    name: str
    pixels: NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float16] | F32
    srgb: bool = False


@dataclass(frozen=True, slots=True)
class MaterialModels:
    """Reflection models of the M materials, named and described as in material_settings.py.

    Enumerations count the lists of choices.py from 0. What a material's model does not use has any value.
    """

    model: U32  # (M,)
    normalized: U32  # (M,) 0 or 1
    distribution: U32  # (M,)
    masking: U32  # (M,)
    fresnel: U32  # (M,)
    f0_mode: U32  # (M,)
    split: U32  # (M,)
    oren_nayar_form: U32  # (M,)
    toon_steps: U32  # (M,) at least 2
    kd: F32  # (M,)
    ks: F32  # (M,)
    shininess: F32  # (M,)
    oren_nayar_sigma: F32  # (M,) radians
    ka: F32  # (M,)
    kr: F32  # (M,)
    kt: F32  # (M,)
    specular_color: F32  # (M, 3)
    f0: F32  # (M, 3)
    f82_tint: F32  # (M, 3)
    conductor_n: F32  # (M, 3)
    conductor_k: F32  # (M, 3)
    toon_lit: F32  # (M, 3)
    toon_shade: F32  # (M, 3)
    absorption: F32  # (M, 3) 1/m


@dataclass(frozen=True, slots=True)
class Materials:
    """M materials. Entry 0 is the default material of objects without one.

    emission_sampling: 1 = sampled as a light, 0 = only found by rays.
    shader: index into `SceneBuffers.shaders`, -1 for the default grey: a new Principled BSDF.
    models: None where all are Principled and the integrator needs none of their parameters.
    """

    pass_index: I32  # (M,)
    emission_sampling: U32  # (M,)
    shader: I32  # (M,)
    names: tuple[str, ...] = ()
    models: MaterialModels | None = None


@dataclass(frozen=True, slots=True)
class Lights:
    """L lamps in Blender's units; the native module derives radiance (blender-facts.md, 'Lights').

    strength: (L, 3) colour × temperature colour × energy × 2^exposure; the emission of `shader` is a factor.
    transform:(L, 3, 4) float32 object-to-world, scale and shear included.
    size:     (L,) radius in metres (point, spot), angle in radians (sun), or width before the transform (area).
    size_y and what follows it: None where there is no area light.
    falloff and what follows it (light_settings.py): None where all lamps fall off and end as Blender's do.
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
    falloff: U32 | None = None  # (L,) counts choices.FALLOFFS; a sun's is PHYSICAL
    range: F32 | None = None  # (L,) metres
    polynomial: F32 | None = None  # (L, 3) c0, c1, c2
    spot_edge: U32 | None = None  # (L,) counts choices.SPOT_EDGES; BLENDER for all but spots
    inner_angle: F32 | None = None  # (L,) radians from the axis, at most outer_angle
    outer_angle: F32 | None = None  # (L,) radians from the axis
    pass_index: I32 | None = None  # (L,) N of the pass 'light:N' that shows the lamp alone, -1 for none
    shader: I32 | None = None  # (L,) index into SceneBuffers.shaders, -1 for none; None: none has one
    size_y: F32 | None = None  # (L,) the other width
    spread: F32 | None = None  # (L,) full angle within which it shines, radians
    ellipse: U32 | None = None  # (L,) 0 or 1


@dataclass(frozen=True, slots=True)
class World:
    """The background, and which rays see it.

    color:  radiance; the emission of `shader` is a factor.
    shader: index into `SceneBuffers.shaders`, -1 for none.
    name:   for messages.
    resolution: cells around of the table by which a world that varies is sampled; 0: as its images, -1: none.
    max_bounces: last bounce that it lights.
    sun: direction to a disc that the sky shows, and the angle across it; 0: none that is sampled by itself.
    """

    color: tuple[float, float, float] = (0.0, 0.0, 0.0)
    visibility: int = 63
    light_group: int = -1
    shader: int = -1
    name: str = ''
    resolution: int = 0
    max_bounces: int = 1024
    sun: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True, slots=True)
class SceneBuffers:
    """A whole scene, ready for `cotorra_native.Scene`.

    material_slots: (S,) uint32 indices into materials; instance i owns [material_base, material_base + material_count).
    light_groups:   names, in the order that `light_group` indexes.
    images:         those that shaders read.
    uv_layers:      names of the UV maps in use, '' = each mesh's active render one, which comes first.
    tangent_layers: the UV maps (indices into uv_layers) that normal maps take their tangents from.
    shaders:        each equal one once.
    attribute_layers: what the ops `attribute*` look up: first `uv_layers`, then `Mesh.attributes`, then
                    `Instances.attributes`. A UV map is (u, v, 0) and u as a number. Names that begin with a control
                    character are made up by export/attributes.py.
    instance_layers: indices into attribute_layers of those with one value for each instance.
    linking:        None where every light lights everything.
    """

    meshes: tuple[Mesh, ...]
    instances: Instances
    materials: Materials
    material_slots: U32
    lights: Lights
    world: World
    light_groups: tuple[str, ...] = ()
    images: tuple[Image, ...] = ()
    uv_layers: tuple[str, ...] = ('',)
    tangent_layers: tuple[int, ...] = ()
    shaders: tuple[Shader, ...] = ()
    attribute_layers: tuple[str, ...] = ('',)
    instance_layers: tuple[int, ...] = ()
    linking: Linking | None = None


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole or an orthographic camera, and the part of its picture that is rendered.

    kind:       'PERSP' or 'ORTHO'.
    transform:  (3, 4) float32 camera-to-world without scale; the camera looks along its -Z.
    window:     left, right, bottom, top of the whole picture on the plane z = -1 (PERSP) or in metres (ORTHO).
    clip:       near and far along the viewing axis, metres.
    resolution: width and height of the whole picture in pixels.
    region:     x0, y0, width, height of the rendered part in pixels, y upwards.
    filter:     the pixel filter, as Cycles names and defines them: 'BLACKMAN_HARRIS', 'GAUSSIAN' or 'BOX'.
    filter_width: in pixels: half a Blackman-Harris', a third of a Gauss', all of a box's support.
    """

    kind: str
    transform: F32
    window: tuple[float, float, float, float]
    clip: tuple[float, float]
    resolution: tuple[int, int]
    region: tuple[int, int, int, int]
    filter_width: float = 1.5
    filter: str = 'BLACKMAN_HARRIS'


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """What to render.

    integrator: one of choices.INTEGRATORS. max_bounces counts all, the others their kind; only PATH reads them.
    clamp_direct, clamp_indirect: most that a contribution brings, the mean of its channels; 0: no limit. For DIRECT and
        PATH. filter_glossy: as Cycles has it, 0: none.
    reweighting: how strictly fireflies are held back in 'combined', see properties.py; 0: it is the plain mean, which
        'unweighted' is in any case. white: radiance that is shown as white, from which on samples are looked at.
    sharing: samples count for every pixel whose filter reaches them (kernels/sharing.h), in 'combined' alone; not where
        the filter is so narrow that it reaches none, or farther than 1.5 pixels, nor with reweighting.
    light_threshold: light below which shadow rays are traced at random, 0: all are. For DIRECT and PATH.
    ambient_color to outline_object: as in properties.py.
    spread_after: samples after which Session.spread is told how many each pixel takes, at most `samples`; 0: all take
        all. A power of two, or a multiple of 32.
    passes:     native pass names, see PASSES; 'combined' is always there.
    threads:    0 = all.
    device:     one of choices.DEVICES; device_index: of cotorra_native.devices(), -1: the first that can be used.
    ray_tracing: one of choices.RAY_TRACINGS, on a graphics card.
    cache:      folder for compiled kernels of graphics cards; empty: none is kept.
    health:     count bad samples with where they came to be, on the CPU: `bad_samples` of Session.stats().
    firefly_limit: radiance that a bounce brings from which on it is counted as a firefly.
    measure_tracing: trace every ray a second time, alone, to tell how much of the time is Embree's; for benchmarks.
    """

    integrator: str = 'PATH'
    samples: int = 64
    seed: int = 0
    max_bounces: int = 12
    diffuse_bounces: int = 4
    glossy_bounces: int = 4
    transmission_bounces: int = 12
    transparent_bounces: int = 8
    clamp_direct: float = 0.0
    clamp_indirect: float = 0.0
    filter_glossy: float = 0.0
    light_threshold: float = 0.0
    reweighting: float = 0.0
    white: float = 1.0
    sharing: bool = False
    reflective_caustics: bool = True
    refractive_caustics: bool = True
    adaptive: bool = False
    noise_threshold: float = 0.01
    adaptive_min_samples: int = 0
    spread_after: int = 0
    transparent_film: bool = False
    threads: int = 0
    passes: tuple[str, ...] = ('combined',)
    measure_tracing: bool = False
    health: bool = False
    firefly_limit: float = 1e30
    device: str = 'CPU'
    device_index: int = -1
    ray_tracing: str = 'AUTO'
    cache: str = ''
    ambient_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    ambient_strength: float = 0.0
    use_ambient_occlusion: bool = False
    ao_distance: float = 10.0
    whitted_depth: int = 8
    whitted_threshold: float = 0.003
    use_transparent_shadows: bool = False
    toon_outline: bool = True
    outline_width: float = 0.3
    outline_color: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outline_normal: bool = True
    outline_depth: bool = True
    outline_object: bool = True


# Native pass name -> channels. 'lightgroup:N' (3 channels) is the N-th light group, 'light:N' the N-th lamp alone. The
# terms are sums over the lamps above the surface, each toward the lamp's centre, without shadows. 'noise' is the error
# of each pixel as adaptive sampling estimates it (kernels/film.h).
PASSES = {
    'combined': 4,
    'unweighted': 4,
    'depth': 1,
    'position': 3,
    'normal': 3,
    'uv': 3,
    'object_index': 1,
    'material_index': 1,
    'diffuse_color': 3,
    'denoising_albedo': 3,
    'denoising_normal': 3,
    'emission': 3,
    'environment': 3,
    'shadow': 3,
    'ao': 3,
    'sample_count': 1,
    'noise': 1,
    'health': 3,
    'term_d': 1,
    'term_g': 1,
    'term_f': 3,
}
