# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shader nodes as closures: Principled, Diffuse, Metallic, Glossy, Emission, Background, Transparent, Mix, Add.

Only constants are read. What cannot be rendered is reported with its material, and something sensible stands in for it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from .closures import BLACK, WHITE, Bsdf, Closure, Color, add, diffuse, scale
from .nodes import Input, Source, Trees, as_color, as_float, constant, own_value, source

# What Cycles shows where an image file cannot be read.
MISSING_IMAGE = (1.0, 0.0, 1.0)

# F82 metals state their edge tint at 82°, where cos θ = 1/7; this is Schlick's (1 - cos θ)^5 there.
F82_SCHLICK = (6.0 / 7.0) ** 5

# Inputs that change the picture when they are not 0, and are not rendered yet.
PRINCIPLED_LEFT_OUT = (
    'Thin Wall',
    'Diffuse Roughness',
    'Subsurface Weight',
    'Anisotropic',
    'Transmission Weight',
    'Coat Weight',
    'Sheen Weight',
    'Thin Film Thickness',
)


@dataclass(slots=True)
class Reader:
    """Reads one owner's tree (a material, light or world) and gathers what it cannot render, for one message an owner.

    back:      1 to read a surface as its back faces show it, 0 as its front faces do (Backfacing of node Geometry).
    asks_side: whether the tree asked for that.
    left_out:  such as 'Transmission Weight'.
    unread:    such as 'Roughness (node "Noise Texture", 0.5 is used)'.
    """

    trees: Trees
    warn: Callable[[str], None]
    back: float = 0.0
    asks_side: bool = False
    left_out: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)

    def number(self, target: Input) -> float:
        value = constant(self.trees, target)
        if not isinstance(value, Source):
            return as_float(value)
        if value.node.type == 'NEW_GEOMETRY' and value.output.name == 'Backfacing':
            self.asks_side = True
            return self.back
        own = as_float(own_value(target.socket))
        self.unread.append(f'{target.socket.name} (node "{value.node.name}", {own:.3g} is used)')
        return own

    def color(self, target: Input, unread: Color | None = None) -> Color:
        """A colour; where it is no constant, `unread`, or the socket's own value if that is None."""
        value = constant(self.trees, target)
        if not isinstance(value, Source):
            return as_color(value)
        if value.node.type in ('TEX_IMAGE', 'TEX_ENVIRONMENT') and image_problem(value.node.image):
            own = MISSING_IMAGE
        else:
            own = unread if unread is not None else as_color(own_value(target.socket))
        shown = ' '.join(f'{part:.3g}' for part in own)
        self.unread.append(f'{target.socket.name} (node "{value.node.name}", {shown} is used)')
        return own

    def leave_out(self, inputs: dict[str, Input], *names: str) -> None:
        """Note those of the inputs that would change the picture."""
        for name in names:
            if name not in inputs:  # 4.5 has fewer
                continue
            value = constant(self.trees, inputs[name])
            if isinstance(value, Source) or as_float(value) != 0.0:
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
    if image.source != 'FILE' or image.packed_file is not None:
        return None
    path = bpy.path.abspath(image.filepath, library=image.library)
    return None if os.path.isfile(path) else f'image "{image.name}" has no file at "{image.filepath}"'


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
    read = CLOSURES.get(found.node.type)
    if read is None:
        reader.warn(f'node "{found.node.name}" ({found.node.bl_label}) is not supported yet: grey is used instead')
        return Closure(weight=1.0, bsdf=Bsdf())
    return read(reader, found, found.inputs())


# ---- One function per node. Values are clamped as Cycles clamps them.


def _principled(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    alpha = _saturate(reader.number(inputs['Alpha']))
    bsdf = Bsdf(
        base_color=_not_negative(reader.color(inputs['Base Color'])),
        metallic=_saturate(reader.number(inputs['Metallic'])),
        roughness=_saturate(reader.number(inputs['Roughness'])),
        ior=max(reader.number(inputs['IOR']), 1e-5),
        specular_level=max(reader.number(inputs['Specular IOR Level']), 0.0),
        specular_tint=_not_negative(reader.color(inputs['Specular Tint'])),
        multi_ggx=node.node.distribution == 'MULTI_GGX',
    )
    strength = reader.number(inputs['Emission Strength'])
    emission = BLACK
    if strength != 0.0:
        # A texture that lights parts of a surface must not make all of it shine.
        emission = tuple(part * strength for part in reader.color(inputs['Emission Color'], unread=BLACK))
    reader.leave_out(inputs, *PRINCIPLED_LEFT_OUT)
    reader.leave_out_linked(inputs, 'Normal')
    return Closure(1.0 - alpha, tuple(part * alpha for part in emission), alpha, bsdf)


def _diffuse(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    reader.leave_out(inputs, 'Roughness')
    reader.leave_out_linked(inputs, 'Normal')
    return Closure(weight=1.0, bsdf=diffuse(_not_negative(reader.color(inputs['Color']))))


def _metallic(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    if node.node.fresnel_type == 'F82':
        color, tint = _not_negative(reader.color(inputs['Base Color'])), reader.color(inputs['Edge Tint'])
    else:
        reader.warn(f'node "{node.node.name}": physical conductors are not supported yet: grey metal is used')
        color, tint = (0.6, 0.6, 0.6), WHITE
    reader.leave_out(inputs, 'Anisotropy', 'Thin Film Thickness')
    reader.leave_out_linked(inputs, 'Normal')
    return _metal(reader, node, inputs, color, _not_negative(tint))


def _glossy(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    """A Glossy BSDF has no Fresnel term: F82 with the edge tint that keeps the colour at 82°, exact for white only."""
    color = tuple(_saturate(part) for part in reader.color(inputs['Color']))
    if color != WHITE:
        reader.warn(f'node "{node.node.name}" (Glossy BSDF) is rendered as a metal: brighter at grazing angles')
    reader.leave_out(inputs, 'Anisotropy')
    reader.leave_out_linked(inputs, 'Normal')
    return _metal(reader, node, inputs, color, tuple(part / (part + (1.0 - part) * F82_SCHLICK) for part in color))


def _metal(reader: Reader, node: Source, inputs: dict[str, Input], color: Color, tint: Color) -> Closure:
    distribution = node.node.distribution
    if distribution not in ('GGX', 'MULTI_GGX'):
        reader.warn(f'node "{node.node.name}": distribution {distribution} is not supported yet: GGX is used')
    bsdf = Bsdf(
        base_color=color,
        metallic=1.0,
        roughness=_saturate(reader.number(inputs['Roughness'])),
        specular_tint=tint,
        multi_ggx=distribution == 'MULTI_GGX',
    )
    return Closure(weight=1.0, bsdf=bsdf)


def _emission(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    strength = reader.number(inputs['Strength'])
    return Closure(emission=tuple(part * strength for part in reader.color(inputs['Color'])))


def _transparent(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    color = reader.color(inputs['Color'])
    if max(color) - min(color) > 1e-6:
        reader.warn(f'node "{node.node.name}": coloured transparency is not supported yet: its brightness is used')
    return Closure(transparency=_saturate(as_float(color)))


def _mix(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    share, first, second = (Input(socket, node.groups) for socket in node.node.inputs[:3])
    factor = _saturate(reader.number(share))
    a = scale(read_closure(reader, first), 1.0 - factor) if factor < 1.0 else Closure()
    b = scale(read_closure(reader, second), factor) if factor > 0.0 else Closure()
    return add(a, b, _naming(reader, node))


def _add(reader: Reader, node: Source, inputs: dict[str, Input]) -> Closure:
    first, second = (Input(socket, node.groups) for socket in node.node.inputs[:2])
    return add(read_closure(reader, first), read_closure(reader, second), _naming(reader, node))


CLOSURES: dict[str, Callable[[Reader, Source, dict[str, Input]], Closure]] = {
    'BSDF_PRINCIPLED': _principled,
    'BSDF_DIFFUSE': _diffuse,
    'BSDF_METALLIC': _metallic,
    'BSDF_GLOSSY': _glossy,
    'EMISSION': _emission,
    'BACKGROUND': _emission,
    'BSDF_TRANSPARENT': _transparent,
    'MIX_SHADER': _mix,
    'ADD_SHADER': _add,
}


def _naming(reader: Reader, node: Source) -> Callable[[str], None]:
    return lambda text: reader.warn(f'node "{node.node.name}": {text}')


def _saturate(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _not_negative(color: Color) -> Color:
    return tuple(max(part, 0.0) for part in color)
