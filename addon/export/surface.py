# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shader nodes as closures: Principled, BSDFs that it can express, Emission, Background, Transparent, Mix, Add.

Inputs are constants or images (texture_nodes.py). What cannot be rendered is reported with its material, and something
sensible stands in for it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import bpy

from .closures import Bsdf, Closure, add, diffuse, mask, scale
from .images import ImageTable, image_path, is_blenders
from .nodes import Constant, Input, Source, Trees, source
from .readings import UnreadError
from .sockets import as_color, as_float, own_value
from .texture_nodes import MISSING_IMAGE, TextureReader, read_normal
from .textures import BLACK, WHITE, Color, NormalMap, Texture, affine, constant, multiply

# F82 metals state their edge tint at 82°, where cos θ = 1/7; this is Schlick's (1 - cos θ)^5 there.
F82_SCHLICK = (6.0 / 7.0) ** 5

# Inputs that change the picture when they are not 0, and are not rendered yet.
PRINCIPLED_LEFT_OUT = (
    'Thin Wall',
    'Diffuse Roughness',
    'Subsurface Weight',
    'Anisotropic',
    'Coat Weight',
    'Sheen Weight',
    'Thin Film Thickness',
)


@dataclass(slots=True)
class Reader:
    """Reads one owner's tree (a material, light or world) and gathers what it cannot render, for one message an owner.

    back:      1 to read a surface as its back faces show it, 0 as its front faces do (Backfacing of node Geometry).
    images:    where images go that inputs read; None where constants alone will do.
    refracts:  whether glass is rendered; else it is left out.
    asks_side: whether the tree asked for that.
    left_out:  such as 'Transmission Weight'.
    unread:    such as 'Roughness (node "Noise Texture", 0.5 is used)'.
    """

    trees: Trees
    warn: Callable[[str], None]
    back: float = 0.0
    images: ImageTable | None = None
    refracts: bool = False
    asks_side: bool = False
    left_out: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)
    textures: TextureReader = field(init=False)

    def __post_init__(self) -> None:
        self.trees = self.trees.of(self.warn)
        self.textures = TextureReader(self.trees, self.images, self.warn)
        self.textures.readings.ways['closure'] = (CLOSURES, self._closure)

    def closure(self, found: Source) -> Closure:
        return self.textures.readings.read('closure', found)

    def _closure(self, found: Source) -> Closure:
        read = CLOSURES.get(found.node.type)
        if read is None or (read is _glass and not self.refracts):
            self.warn(f'node "{found.node.name}" ({found.node.bl_label}) is not supported yet: grey is used instead')
            return Closure(weight=1.0, bsdf=Bsdf())
        return read(self, found, found.inputs())

    def number_map(self, target: Input) -> float | Texture:
        """A number, which may vary with an image; where it is not understood, the socket's own value."""
        try:
            value = self.textures.value(target)
        except UnreadError as unread:
            node, output = unread.source.node, unread.source.output
            if node.type == 'NEW_GEOMETRY' and output.name == 'Backfacing':
                self.asks_side = True
                return self.back
            return self._own_number(target, node)
        return value.offset[0] if value.lookup is None else value

    def number(self, target: Input) -> float:
        """A number where no image can be used."""
        value = self.number_map(target)
        if isinstance(value, Texture):
            return self._own_number(target, source(self.trees, target).node)
        return value

    def color_map(self, target: Input, unread: Color | None = None) -> Color | Texture:
        """A colour, which may vary with an image; where it is not understood, `unread`, or the socket's own value."""
        try:
            value = self.textures.value(target)
        except UnreadError as found:
            return self._own_color(target, found.source.node, unread)
        return value.offset if value.lookup is None else value

    def color(self, target: Input) -> Color:
        """A colour where no image can be used."""
        value = self.color_map(target)
        if isinstance(value, Texture):
            return self._own_color(target, source(self.trees, target).node, None)
        return value

    def normal_map(self, inputs: dict[str, Input], name: str = 'Normal') -> NormalMap | None:
        """The normal map at an input; what bends the normal otherwise is left out."""
        while name in inputs:
            try:
                return read_normal(self.textures, inputs[name])
            except UnreadError as unread:
                self.left_out.append(name)
                name, inputs = 'Normal', unread.source.inputs() if unread.source.node.type == 'BUMP' else {}
        return None

    def _own_number(self, target: Input, node: bpy.types.Node) -> float:
        own = as_float(own_value(target.socket))
        self.unread.append(f'{target.socket.name} (node "{node.name}", {own:.3g} is used)')
        return own

    def _own_color(self, target: Input, node: bpy.types.Node, unread: Color | None) -> Color:
        if node.type in ('TEX_IMAGE', 'TEX_ENVIRONMENT') and image_problem(node.image):
            own = MISSING_IMAGE
        else:
            own = unread if unread is not None else as_color(own_value(target.socket))
        shown = ' '.join(f'{part:.3g}' for part in own)
        self.unread.append(f'{target.socket.name} (node "{node.name}", {shown} is used)')
        return own

    def leave_out(self, inputs: dict[str, Input], *names: str) -> None:
        """Note those of the inputs that would change the picture."""
        for name in names:
            if name not in inputs:  # 4.5 has fewer
                continue
            try:
                value = self.textures.value(inputs[name])
            except UnreadError:
                value = None
            if value is None or value.lookup is not None or value.offset[0] != 0.0:
                self.left_out.append(name)

    def leave_out_linked(self, inputs: dict[str, Input], name: str) -> None:
        """Note an input whose own value means nothing, such as a normal, if a node feeds it."""
        if name in inputs and isinstance(source(self.trees, inputs[name]), Source):
            self.left_out.append(name)

    def report(self) -> None:
        """Say once, for the whole tree, what is not rendered."""
        parts = [f'{", ".join(dict.fromkeys(self.left_out))} left out'] if self.left_out else []
        if self.unread:
            parts.append(f'inputs that are no constants: {", ".join(dict.fromkeys(self.unread))}')
        if parts:
            self.warn(f'not supported yet: {"; ".join(parts)}')


def image_problem(image: bpy.types.Image | None) -> str | None:
    """Why an image cannot be read, or None. Its file is looked for, not opened."""
    if image is None:
        return 'no image is chosen'
    if image.source != 'FILE' or image.packed_file is not None or is_blenders(image):
        return None
    return None if os.path.isfile(image_path(image)) else f'image "{image.name}" has no file at "{image.filepath}"'


def warn_missing_images(tree: bpy.types.NodeTree, warn: Callable[[str], None]) -> None:
    for node in tree.nodes:
        problem = image_problem(node.image) if node.type in ('TEX_IMAGE', 'TEX_ENVIRONMENT') else None
        if problem:
            warn(f'node "{node.name}": {problem}')


def read_closure(reader: Reader, target: Input | None) -> Closure:
    """The closure that arrives at a Surface or Shader input; black if nothing is linked."""
    if target is None:
        return Closure()
    found = source(reader.trees, target)
    if isinstance(found, Input):
        return Closure()
    if isinstance(found, Constant) or found.output.type != 'SHADER':
        return Closure(emission=reader.color_map(target))  # a colour or number that is linked to a shader shines
    return reader.closure(found)


# ---- One function per node. Values are clamped as Cycles clamps them.


def _principled(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    alpha = _saturate(reader.number_map(inputs['Alpha']))
    bsdf = Bsdf(
        base_color=_not_negative(reader.color_map(inputs['Base Color'])),
        metallic=_saturate(reader.number_map(inputs['Metallic'])),
        roughness=_saturate(reader.number_map(inputs['Roughness'])),
        ior=_at_least(reader.number_map(inputs['IOR']), 1e-5),
        specular_level=_at_least(reader.number_map(inputs['Specular IOR Level']), 0.0),
        specular_tint=_not_negative(reader.color_map(inputs['Specular Tint'])),
        multi_ggx=node.node.distribution == 'MULTI_GGX',
        normal=reader.normal_map(inputs),
        transmission=_transmission(reader, inputs),
    )
    _warn_rough_glass(reader, node, bsdf)
    emission = _emitted(reader, inputs['Emission Color'], inputs['Emission Strength'], unread=BLACK)
    reader.leave_out(inputs, *PRINCIPLED_LEFT_OUT)
    shown = Closure(0.0, emission, 1.0, bsdf)
    if isinstance(alpha, Texture):
        return replace(shown, cover=alpha)
    return replace(scale(shown, alpha), transparency=1.0 - alpha)


def _transmission(reader: Reader, inputs: dict[str, Input]) -> float:
    if reader.refracts:
        return _saturate(reader.number(inputs['Transmission Weight']))
    reader.leave_out(inputs, 'Transmission Weight')
    return 0.0


def _warn_rough_glass(reader: Reader, node: Source, bsdf: Bsdf) -> None:
    # As smooth as a mirror to the kernels (MIRROR_ALPHA2).
    if bsdf.transmission > 0.0 and (isinstance(bsdf.roughness, Texture) or bsdf.roughness**4 > 2e-10):
        reader.warn(f'node "{node.node.name}": rough glass lets light through as if it were smooth')


def _glass(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    """A Glass BSDF: Principled with all of it transmitted, whose base colour is what two surfaces tint."""
    color = _not_negative(reader.color(inputs['Color']))
    if color != WHITE:
        reader.warn(f'node "{node.node.name}" (Glass BSDF): what it reflects is not tinted')
    reader.leave_out(inputs, 'Thin Film Thickness')
    bsdf = Bsdf(
        base_color=tuple(part * part for part in color),
        roughness=_saturate(reader.number_map(inputs['Roughness'])),
        ior=_at_least(reader.number_map(inputs['IOR']), 1e-5),
        normal=reader.normal_map(inputs),
        transmission=1.0,
    )
    _warn_rough_glass(reader, node, bsdf)
    return Closure(weight=1.0, bsdf=bsdf)


def _emitted(reader: Reader, color: Input, strength: Input, unread: Color | None = None) -> Color | Texture:
    """Colour × strength, of which one may be a texture. unread: see `Reader.color_map`."""
    factor = reader.number_map(strength)
    if factor == 0.0:
        return BLACK
    shown = reader.color_map(color, unread)
    if isinstance(factor, Texture) and isinstance(shown, Texture):
        factor = reader.number(strength)
    values = (value if isinstance(value, Texture) else constant(value) for value in (factor, shown))
    product = multiply(*values)
    return product.offset if product.lookup is None else product


def _diffuse(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    reader.leave_out(inputs, 'Roughness')
    color = _not_negative(reader.color_map(inputs['Color']))
    return Closure(weight=1.0, bsdf=diffuse(color, reader.normal_map(inputs)))


def _metallic(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    if node.node.fresnel_type == 'F82':
        color, tint = _not_negative(reader.color_map(inputs['Base Color'])), reader.color_map(inputs['Edge Tint'])
    else:
        reader.warn(f'node "{node.node.name}": physical conductors are not supported yet: grey metal is used')
        color, tint = (0.6, 0.6, 0.6), WHITE
    reader.leave_out(inputs, 'Anisotropy', 'Thin Film Thickness')
    return _metal(reader, node, inputs, color, _not_negative(tint))


def _glossy(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    """A Glossy BSDF has no Fresnel term: F82 with the edge tint that keeps the colour at 82°, exact for white only."""
    color = _saturate_color(reader.color_map(inputs['Color']))
    if color != WHITE:
        reader.warn(f'node "{node.node.name}" (Glossy BSDF) is rendered as a metal: brighter at grazing angles')
    reader.leave_out(inputs, 'Anisotropy')
    if isinstance(color, Texture):
        return _metal(reader, node, inputs, color, WHITE)  # the tint is no affine function of the colour
    return _metal(reader, node, inputs, color, tuple(part / (part + (1.0 - part) * F82_SCHLICK) for part in color))


def _metal(
    reader: Reader, node: Source, inputs: dict[str, Input], color: Color | Texture, tint: Color | Texture
) -> Closure:
    distribution = node.node.distribution
    if distribution not in ('GGX', 'MULTI_GGX'):
        reader.warn(f'node "{node.node.name}": distribution {distribution} is not supported yet: GGX is used')
    bsdf = Bsdf(
        base_color=color,
        metallic=1.0,
        roughness=_saturate(reader.number_map(inputs['Roughness'])),
        specular_tint=tint,
        multi_ggx=distribution == 'MULTI_GGX',
        normal=reader.normal_map(inputs),
    )
    return Closure(weight=1.0, bsdf=bsdf)


def _emission(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    return Closure(emission=_emitted(reader, inputs['Color'], inputs['Strength']))


def _transparent(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    color = reader.color(inputs['Color'])
    if max(color) - min(color) > 1e-6:
        reader.warn(f'node "{node.node.name}": coloured transparency is not supported yet: its brightness is used')
    return Closure(transparency=_saturate(as_float(color)))


def _mix(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    share, first, second = (Input(socket, node.contexts) for socket in node.node.inputs[:3])
    factor = _saturate(reader.number_map(share))
    if factor in (0.0, 1.0):
        return read_closure(reader, second if factor == 1.0 else first)
    a, b = read_closure(reader, first), read_closure(reader, second)
    cover = factor if isinstance(factor, Texture) else constant(factor)
    if a.is_clear and (isinstance(factor, Texture) or b.cover is not None):
        return mask(b, cover, _naming(reader, node))
    if b.is_clear and (isinstance(factor, Texture) or a.cover is not None):
        return mask(a, affine(cover, -1.0, 1.0), _naming(reader, node))
    factor = reader.number(share)
    return add(scale(a, 1.0 - factor), scale(b, factor), _naming(reader, node))


def _add(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    first, second = (Input(socket, node.contexts) for socket in node.node.inputs[:2])
    return add(read_closure(reader, first), read_closure(reader, second), _naming(reader, node))


CLOSURES: dict[str, Callable[[Reader, Source, dict[str, Input]], Closure]] = {
    'BSDF_PRINCIPLED': _principled,
    'BSDF_DIFFUSE': _diffuse,
    'BSDF_METALLIC': _metallic,
    'BSDF_GLOSSY': _glossy,
    'BSDF_GLASS': _glass,
    'EMISSION': _emission,
    'BACKGROUND': _emission,
    'BSDF_TRANSPARENT': _transparent,
    'MIX_SHADER': _mix,
    'ADD_SHADER': _add,
}


def _naming(reader: Reader, node: Source) -> Callable[[str], None]:
    return lambda text: reader.warn(f'node "{node.node.name}": {text}')


# Values that vary are clamped where they are looked up, by the kernels.


def _saturate(value: float | Texture) -> float | Texture:
    return value if isinstance(value, Texture) else min(max(value, 0.0), 1.0)


def _at_least(value: float | Texture, least: float) -> float | Texture:
    return value if isinstance(value, Texture) else max(value, least)


def _not_negative(color: Color | Texture) -> Color | Texture:
    return color if isinstance(color, Texture) else tuple(max(part, 0.0) for part in color)


def _saturate_color(color: Color | Texture) -> Color | Texture:
    return color if isinstance(color, Texture) else tuple(_saturate(part) for part in color)
