# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles as a measuring instrument: renders one facet a pixel, each with its own material and orientation.

Facets float in a plane of pixels under an orthographic camera that looks along -Z, so the viewer is toward +Z; they
cast no shadows and are seen by the camera only. It knows nothing of Cotorra.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
from mathutils import Vector

# Material attributes -> sockets of the Principled BSDF.
SOCKETS = {
    'base_color': 'Base Color',
    'metallic': 'Metallic',
    'specular_tint': 'Specular Tint',
    'roughness': 'Roughness',
    'ior': 'IOR',
    'specular_level': 'Specular IOR Level',
}


@dataclass(frozen=True)
class Shader:
    """A node of Blender's, the attribute that each of its sockets reads, its other settings and constant sockets."""

    node: str
    sockets: dict[str, str]
    settings: dict[str, object] = field(default_factory=dict)
    constants: dict[str, float] = field(default_factory=dict)


def _material(shader: Shader, facet: np.ndarray) -> bpy.types.Material:
    material = bpy.data.materials.new('facets')
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new('ShaderNodeOutputMaterial')
    bsdf = tree.nodes.new(shader.node)
    for name, value in shader.settings.items():
        setattr(bsdf, name, value)
    for name, value in shader.constants.items():
        bsdf.inputs[name].default_value = value
    tree.links.new(bsdf.outputs[0], output.inputs['Surface'])
    for name, socket in shader.sockets.items():
        node = tree.nodes.new('ShaderNodeAttribute')
        node.attribute_name = f'facet_{name}'  # 'color' alone would be the object's
        tree.links.new(node.outputs['Vector' if facet[name].ndim == 2 else 'Fac'], bsdf.inputs[socket])
    return material


def _facets(facet: np.ndarray, names: list[str], normals: np.ndarray, side: int, back: bool) -> bpy.types.Mesh:
    """One square a pixel, each tilted about the pixel's centre; `back`: it turns its back to the viewer."""
    count = side * side
    y, x = np.divmod(np.arange(count), side)
    corner = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])[:: -1 if back else 1]
    xy = np.stack([x, y], -1)[:, None, :] + 0.5 + corner[None]
    z = -(normals[:, None, :2] * corner[None]).sum(-1) / normals[:, None, 2]
    mesh = bpy.data.meshes.new('facets')
    mesh.from_pydata(
        np.concatenate([xy, z[..., None]], -1).reshape(-1, 3).tolist(), [], np.arange(4 * count).reshape(-1, 4).tolist()
    )
    for name in names:
        values = np.ascontiguousarray(facet[name], np.float32)
        kind = 'FLOAT_VECTOR' if values.ndim == 2 else 'FLOAT'
        attribute = mesh.attributes.new(f'facet_{name}', kind, 'FACE')
        attribute.data.foreach_set('vector' if values.ndim == 2 else 'value', values.ravel())
    return mesh


def render(
    facet: np.ndarray,
    normals: np.ndarray,
    path: Path,
    sun: np.ndarray | None = None,
    samples: int = 1,
    distribution: str = 'MULTI_GGX',
    shader: Shader | None = None,
    back: bool = False,
) -> dict[str, np.ndarray]:
    """Radiance and passes of each facet, (count, 3) each, under a sun of irradiance 1 toward `sun` or in a white world.

    facet: materials with the fields that `shader` reads (Principled's SOCKETS by default), a square number of them.
    normals: (count, 3), z above 0, on the viewer's side, which is the facets' back where `back` is set.
    """
    shader = shader or Shader('ShaderNodeBsdfPrincipled', SOCKETS, {'distribution': distribution})
    side = round(len(facet) ** 0.5)
    assert side * side == len(facet)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    mesh = _facets(facet, list(shader.sockets), normals, side, back)
    mesh.materials.append(_material(shader, facet))
    thing = bpy.data.objects.new('facets', mesh)
    for ray in ('diffuse', 'glossy', 'transmission', 'volume_scatter', 'shadow'):
        setattr(thing, f'visible_{ray}', False)
    scene.collection.objects.link(thing)

    world = bpy.data.worlds.new('world')
    world.node_tree.nodes['Background'].inputs['Strength'].default_value = 0.0 if sun is not None else 1.0
    world.node_tree.nodes['Background'].inputs['Color'].default_value = (1, 1, 1, 1)
    world.cycles.sampling_method = 'NONE'
    scene.world = world
    if sun is not None:
        light = bpy.data.lights.new('sun', 'SUN')
        light.energy, light.angle, light.use_shadow = 1.0, 0.0, False
        lamp = bpy.data.objects.new('sun', light)
        # A lamp shines along its -Z.
        lamp.rotation_euler = Vector(sun).to_track_quat('Z', 'Y').to_euler()
        scene.collection.objects.link(lamp)

    camera = bpy.data.cameras.new('camera')
    camera.type, camera.ortho_scale, camera.clip_end = 'ORTHO', float(side), 1000.0
    eye = bpy.data.objects.new('camera', camera)
    eye.location = (side / 2, side / 2, 500.0)
    scene.collection.objects.link(eye)
    scene.camera = eye

    render_settings = scene.render
    render_settings.engine = 'CYCLES'
    render_settings.resolution_x = render_settings.resolution_y = side
    render_settings.threads_mode, render_settings.threads = 'FIXED', 2
    render_settings.filepath = str(path)
    image = render_settings.image_settings
    image.media_type = 'MULTI_LAYER_IMAGE'
    image.file_format, image.color_depth = 'OPEN_EXR_MULTILAYER', '32'
    layer = scene.view_layers[0]
    for name in ('diffuse_color', 'glossy_color', 'diffuse_direct', 'glossy_direct'):
        setattr(layer, f'use_pass_{name}', True)
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
    cycles.max_bounces = 0 if sun is not None else 1
    cycles.light_sampling_threshold = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    # One sample in the middle of each pixel.
    cycles.pixel_filter_type, cycles.filter_width = 'GAUSSIAN', 0.01
    bpy.ops.render.render(write_still=True)
    return _read(path)


def _read(path: Path) -> dict[str, np.ndarray]:
    image = oiio.ImageInput.open(str(path))
    result: dict[str, dict[str, np.ndarray]] = {}
    part = 0
    while image.seek_subimage(part, 0):
        pixels = image.read_image(part, 0, 0, image.spec().nchannels, 'float')[::-1]
        for i, channel in enumerate(image.spec().channelnames):
            *_, name, axis = channel.split('.')
            result.setdefault(name, {})[axis] = pixels[..., i].ravel()
        part += 1
    return {name: np.stack([axes[a] for a in 'RGB'], -1) for name, axes in result.items() if 'R' in axes}
