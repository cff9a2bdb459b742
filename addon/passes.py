# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes: which ones a view layer asks for, and how the native module's pixels get into them.

What a pass holds is decided by the kernels; here are only names, channels and copies.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from . import compat, lamps
from .export.buffers import PASSES as NATIVE_CHANNELS

LIGHT_GROUP_PREFIX = 'Combined_'
SAMPLE_COUNT = 'Debug Sample Count'


@dataclass(frozen=True, slots=True)
class RenderPass:
    """A pass of Blender (named as in 5.2) and the native pass that fills it; `flag` is the view layer's switch."""

    name: str
    native: str
    channels: str
    kind: str
    flag: str


PASSES = (
    RenderPass('Depth', 'depth', 'Z', 'VALUE', 'use_pass_z'),
    RenderPass('Position', 'position', 'XYZ', 'VECTOR', 'use_pass_position'),
    RenderPass('Normal', 'normal', 'XYZ', 'VECTOR', 'use_pass_normal'),
    RenderPass('UV', 'uv', 'UVA', 'VECTOR', 'use_pass_uv'),
    RenderPass('Object Index', 'object_index', 'X', 'VALUE', 'use_pass_object_index'),
    RenderPass('Material Index', 'material_index', 'X', 'VALUE', 'use_pass_material_index'),
    RenderPass('Diffuse Color', 'diffuse_color', 'RGB', 'COLOR', 'use_pass_diffuse_color'),
    RenderPass('Emission', 'emission', 'RGB', 'COLOR', 'use_pass_emit'),
    RenderPass('Environment', 'environment', 'RGB', 'COLOR', 'use_pass_environment'),
    RenderPass('Shadow', 'shadow', 'RGB', 'COLOR', 'use_pass_shadow'),
    RenderPass('Ambient Occlusion', 'ao', 'RGB', 'COLOR', 'use_pass_ambient_occlusion'),
)

# As PASSES, but their switches are our own: in `view_layer.cotorra`.
OWN_PASSES = (
    RenderPass('Cotorra D', 'term_d', 'X', 'VALUE', 'use_pass_distribution'),
    RenderPass('Cotorra G', 'term_g', 'X', 'VALUE', 'use_pass_masking'),
    RenderPass('Cotorra F', 'term_f', 'RGB', 'COLOR', 'use_pass_fresnel'),
    RenderPass('Cotorra Noise', 'noise', 'X', 'VALUE', 'use_pass_noise'),
    RenderPass('Cotorra Health', 'health', 'XYZ', 'VECTOR', 'use_pass_health'),
)

# As those, with Cycles' switch for what its denoiser is shown (`view_layer.cycles.denoising_store_passes`).
DENOISING_PASSES = (
    RenderPass('Denoising Albedo', 'denoising_albedo', 'RGB', 'COLOR', 'denoising_store_passes'),
    RenderPass('Denoising Normal', 'denoising_normal', 'XYZ', 'VECTOR', 'denoising_store_passes'),
)
NOISY_IMAGE = 'Noisy Image'  # Combined as it was before it was denoised
UNWEIGHTED_IMAGE = 'Unweighted Image'  # the plain mean, where fireflies count less in Combined

# Native passes that hold light, beside the light groups.
LIGHT_PASSES = frozenset({'combined', 'unweighted', 'emission', 'environment'})

# Switches of a view layer that Blender's file keeps but that no pass of Cotorra answers yet, with their names.
NOT_RENDERED = {
    'use_pass_mist': 'Mist',
    'use_pass_vector': 'Vector',
    'use_pass_diffuse_direct': 'Diffuse Direct',
    'use_pass_diffuse_indirect': 'Diffuse Indirect',
    'use_pass_glossy_direct': 'Glossy Direct',
    'use_pass_glossy_indirect': 'Glossy Indirect',
    'use_pass_glossy_color': 'Glossy Color',
    'use_pass_transmission_direct': 'Transmission Direct',
    'use_pass_transmission_indirect': 'Transmission Indirect',
    'use_pass_transmission_color': 'Transmission Color',
    'use_pass_subsurface_direct': 'Subsurface Direct',
    'use_pass_subsurface_indirect': 'Subsurface Indirect',
    'use_pass_subsurface_color': 'Subsurface Color',
    'use_pass_cryptomatte_object': 'Cryptomatte Object',
    'use_pass_cryptomatte_material': 'Cryptomatte Material',
    'use_pass_cryptomatte_asset': 'Cryptomatte Asset',
}


def requested(
    view_layer: bpy.types.ViewLayer, denoised: bool, reweighted: bool = False
) -> Iterator[tuple[str, str, str]]:
    """Name, channels and kind of each pass that the view layer asks for; `denoised`, `reweighted`: its picture will
    be."""
    yield 'Combined', 'RGBA', 'COLOR'
    for entry in PASSES:
        if getattr(view_layer, entry.flag, False):
            yield compat.pass_name(entry.name), entry.channels, entry.kind
    if wants_sample_count(view_layer):
        yield SAMPLE_COUNT, 'X', 'VALUE'
    for entry in OWN_PASSES:
        if getattr(view_layer.cotorra, entry.flag):
            yield entry.name, entry.channels, entry.kind
    if denoised:
        yield NOISY_IMAGE, 'RGBA', 'COLOR'
    if reweighted:
        yield UNWEIGHTED_IMAGE, 'RGBA', 'COLOR'
    for entry in DENOISING_PASSES:
        if getattr(getattr(view_layer, 'cycles', None), entry.flag, False):
            yield entry.name, entry.channels, entry.kind
    for group in view_layer.lightgroups:
        yield LIGHT_GROUP_PREFIX + group.name, 'RGB', 'COLOR'
    for name in dict.fromkeys(lamps.pass_names(view_layer).values()):
        yield name, 'RGB', 'COLOR'


def wants_sample_count(view_layer: bpy.types.ViewLayer) -> bool:
    """Our own switch, or the one of Cycles, so that a file made for Cycles gives the passes it gave."""
    if view_layer.cotorra.use_pass_sample_count:
        return True
    cycles = getattr(view_layer, 'cycles', None)
    return bool(getattr(cycles, 'pass_debug_sample_count', False))


def missing(view_layer: bpy.types.ViewLayer) -> list[str]:
    """Names of the passes that the view layer asks for and that stay away."""
    names = [name for flag, name in NOT_RENDERED.items() if getattr(view_layer, flag, False)]
    return names + [f'AOV {aov.name}' for aov in view_layer.aovs]


def register(
    engine: bpy.types.RenderEngine,
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    denoised: bool,
    reweighted: bool,
) -> None:
    """Answer `update_render_passes`: the render result and the compositor's sockets are made from this."""
    for name, channels, kind in requested(view_layer, denoised, reweighted):
        engine.register_pass(scene, view_layer, name, len(channels), channels, kind)


def native_sources(
    result: bpy.types.RenderResult, light_groups: tuple[str, ...], lamp_passes: dict[str, int]
) -> dict[str, str]:
    """Native pass for each pass of the result's first layer; passes that nothing fills are left out.

    lamp_passes: the native number of each pass that shows a lamp alone.
    """
    known = {compat.pass_name(entry.name): entry.native for entry in PASSES}
    known |= {entry.name: entry.native for entry in (*OWN_PASSES, *DENOISING_PASSES)}
    known |= {name: f'light:{number}' for name, number in lamp_passes.items()}
    known['Combined'] = known[NOISY_IMAGE] = 'combined'
    known[UNWEIGHTED_IMAGE] = 'unweighted'
    known[SAMPLE_COUNT] = 'sample_count'
    for index, group in enumerate(light_groups):
        known[LIGHT_GROUP_PREFIX + group] = f'lightgroup:{index}'
    return {entry.name: known[entry.name] for entry in result.layers[0].passes if entry.name in known}


@dataclass(frozen=True, slots=True)
class Film:
    """What becomes of light, and of normals, on their way into a pass.

    exposure: factor on the passes that are light.
    white:    where Combined is compressed by Reinhard's curve, the luminance that becomes 1.
    view:     from the world to the camera's space, in whose directions Cycles shows normals to a denoiser.
    """

    exposure: float = 1.0
    white: float | None = None
    view: np.ndarray | None = None

    def develop(self, native: str, pixels: np.ndarray) -> None:
        """Apply it in place to a native pass."""
        if self.exposure != 1.0 and (native in LIGHT_PASSES or native not in NATIVE_CHANNELS):
            pixels[..., :3] *= np.float32(self.exposure)
        if native == 'denoising_normal' and self.view is not None:
            pixels[...] = pixels @ self.view.T
        if native in ('combined', 'unweighted') and self.white is not None:
            reinhard(pixels[..., :3], self.white)


def write(
    session: Any,
    result: bpy.types.RenderResult,
    sources: dict[str, str],
    samples: int,
    film: Film,
    only: str | None = None,
) -> None:
    """Copy the session's pixels, as they are now, into the passes of the result's first layer.

    samples:  that a pixel takes at most; the sample count is written as a part of it, as Cycles does.
    only:     the one pass to write, for a picture in between.
    Row 0 is the bottom on both sides. A result with several views gets the same pixels in each.
    """
    pixels: dict[str, np.ndarray] = {}
    for target in result.layers[0].passes:
        native = sources.get(target.name)
        if native is None or only not in (None, target.name):
            continue
        if native not in pixels:
            out = read(session, result, native)
            if native == 'sample_count':
                out /= np.float32(samples)
            film.develop(native, out)
            pixels[native] = out
        target.rect.foreach_set(pixels[native].reshape(-1))


def read(session: Any, result: bpy.types.RenderResult, native: str) -> np.ndarray:
    """The state of a native pass, (height, width, channels)."""
    out = np.zeros((result.resolution_y, result.resolution_x, NATIVE_CHANNELS.get(native, 3)), np.float32)
    session.read(native, out)
    return out


def write_combined(result: bpy.types.RenderResult, pixels: np.ndarray, film: Film) -> None:
    """Put another picture into Combined; `pixels`, which are changed, are as the session's."""
    film.develop('combined', pixels)
    for target in result.layers[0].passes:
        if target.name == 'Combined':
            target.rect.foreach_set(pixels.reshape(-1))


def reinhard(pixels: np.ndarray, white: float) -> None:
    """Compress colors in place (Reinhard et al. 2002, eq. 4): luminance L becomes L (1 + L / white²) / (1 + L)."""
    luminance = np.maximum(pixels @ np.array((0.2126, 0.7152, 0.0722), np.float32), 0.0)
    pixels *= ((1.0 + luminance / np.float32(white * white)) / (1.0 + luminance))[..., None]
