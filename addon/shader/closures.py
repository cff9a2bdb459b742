# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes as a flat sum of weighted closures: Mix and Add Shader share out weights, all others add a row.

What a closure looks like is in the kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import NamedTuple

import bpy

from .feeds import Constant, Contexts, Fed
from .nodes_input import LIGHT_PATH
from .reader import HERE, NUMBERS, Node, Reader
from .support import NOT_SUPPORTED
from .tree import COMPARE, Builder, Ref

DISTRIBUTIONS = ('GGX', 'MULTI_GGX', 'BECKMANN', 'ASHIKHMIN_SHIRLEY')
PHYSICAL_CONDUCTOR = 1 << 8
# Outputs of Light Path, and a node, that a sample of a light knows nothing of: by what kind of bounce a ray came. Rays
# of perfect mirrors and glass are never weighed against a sample.
KNOWN_TO_RAYS = frozenset(
    (
        *('Is Diffuse Ray', 'Is Glossy Ray', 'Is Reflection Ray', 'Is Transmission Ray', 'Ambient Occlusion'),
        *('Diffuse Depth', 'Glossy Depth', 'Transparent Depth', 'Transmission Depth'),
    )
)

# Adds the rows of a node, given its weight (three numbers).
Closure = Callable[[Node, Ref], None]
CLOSURES: dict[str, Closure] = {}


def closure(*types: str) -> Callable[[Closure], Closure]:
    """Registers the function that reads shader nodes of these types."""

    def register(function: Closure) -> Closure:
        CLOSURES.update(dict.fromkeys(types, function))
        return function

    return register


# ---- The sum.


class Part(NamedTuple):
    """What an input for shaders shows: a shader, or a value, which is emitted. The same one twice is equal."""

    socket: bpy.types.NodeSocket
    contexts: Contexts
    fed: Fed | Constant


def read_closures(reader: Reader, socket: bpy.types.NodeSocket) -> None:
    """Add the closures of all that is mixed and added to what arrives at an input for shaders.

    Each node is read once, with the sum of the weights of all ways that lead to it.
    """
    root = _part(reader, socket, ())
    if root is None:
        return
    builder = reader.builder
    shares = _shares(reader, root)
    weights = {root: builder.constant(1.0)}
    for part, below in reversed(shares.items()):  # those that share out before those that get
        weight = weights[part]
        for inner, share in below:
            mine = builder.multiply(weight, share)
            weights[inner] = builder.add(weights[inner], mine) if inner in weights else mine
    kept = _kept_of_holdouts(reader, weights)
    for part, below in reversed(shares.items()):
        if below:
            continue
        weight = weights[part]
        if kept is not None and not _is(part, 'ShaderNodeHoldout'):
            weight = builder.multiply(weight, kept)
        _read(reader, part, builder.splat(weight))
    _warn_of_kinds(reader)


def _is(part: Part, kind: str) -> bool:
    return isinstance(part.fed, Fed) and part.fed.node.bl_idname == kind


def _kept_of_holdouts(reader: Reader, weights: dict[Part, Ref]) -> Ref | None:
    """The factor of all that is no holdout; None: it is 1.

    A surface whose holdouts have the weight 1 is nothing else to the camera, whatever is added to them (Cycles). Where
    shaders are only mixed, there is nothing else then.
    """
    builder = reader.builder
    held = [weight for part, weight in weights.items() if _is(part, 'ShaderNodeHoldout')]
    if not held or reader.kind != 'material' or not any(_is(part, 'ShaderNodeAddShader') for part in weights):
        return None
    total = reduce(builder.add, held)
    known = builder.constant_of(total)
    if known is not None and known[0] != 1.0:
        return None
    camera = builder.emit('light_path', mode=LIGHT_PATH.index('Is Camera Ray'))
    if known is None:
        zero, one = builder.constant(0.0), builder.constant(1.0)
        camera = builder.multiply(camera, builder.emit('math', total, one, zero, mode=COMPARE))
    return builder.one_minus(camera)


def _warn_of_kinds(reader: Reader) -> None:
    """Names light that samples of lights cannot tell, as in Cycles: how much of it is found depends on how often lights
    are sampled.
    """
    if reader.kind == 'light':
        return  # hardly met by rays: what samples are told is all there is to see
    asked = set()
    for name, mode in reader.builder.behind(reader.builder.emitted):
        if name == 'light_path':
            asked.add(LIGHT_PATH[mode])
        elif name == 'ao':
            asked.add('Ambient Occlusion')
    names = ', '.join(sorted(asked & KNOWN_TO_RAYS))
    if not names:
        return
    if reader.kind == 'world':
        reader.warn(f'background by {names}: surfaces of several shaders may be brighter or darker than in Cycles')
    else:
        reader.warn(f'emission by {names}: what it lights may be brighter or darker than in Cycles')


def _shares(reader: Reader, root: Part) -> dict[Part, list[tuple[Part, Ref]]]:
    """All parts and what each hands on to which parts; a part stands before those that it is handed on by."""
    found: dict[Part, list[tuple[Part, Ref]]] = {}
    way: dict[Part, list[tuple[Part, Ref]]] = {}
    waiting: list[tuple[Part, bool]] = [(root, False)]
    while waiting:
        part, ready = waiting.pop()
        if ready:
            found[part] = way.pop(part)
        elif part not in found and part not in way:
            below = way[part] = [(inner, share) for inner, share in _below(reader, part) if inner not in way]
            waiting.append((part, True))
            waiting += [(inner, False) for inner, _ in below]
    return found


def _part(reader: Reader, socket: bpy.types.NodeSocket, contexts: Contexts) -> Part | None:
    fed = reader.feeds.feeding(socket, contexts)
    if fed is None:
        return None
    if isinstance(fed, Fed):
        return Part(fed.socket, fed.contexts, fed)
    return Part(socket, contexts, fed)


def _below(reader: Reader, part: Part) -> list[tuple[Part, Ref]]:
    """What a Mix or Add Shader hands on to; parts without a weight are not read at all."""
    fed = part.fed
    if isinstance(fed, Constant) or fed.node.bl_idname not in ('ShaderNodeMixShader', 'ShaderNodeAddShader'):
        return []
    builder = reader.builder
    node = reader.node(fed.node, fed.contexts)
    shares = [builder.constant(1.0)] * 2
    if fed.node.bl_idname == 'ShaderNodeMixShader':
        label, builder.label = builder.label, reader.feeds.name(fed.node)
        factor = builder.saturate(node.f('Fac'))
        shares = [builder.one_minus(factor), factor]
        builder.label = label
    found = []
    for name, share in zip(('Shader', 'Shader_001'), shares, strict=True):
        known = builder.constant_of(share)
        inner = _part(reader, node.sockets[name], fed.contexts)
        if inner is not None and known is not None and known[0] == 0.0:
            left = f'"{reader.feeds.name(inner.fed.node)}"' if isinstance(inner.fed, Fed) else 'a value'
            builder.notes.append(f'{left}: its share in node "{reader.feeds.name(fed.node)}" is 0')
        elif inner is not None:
            found.append((inner, share))
    return found


def _read(reader: Reader, part: Part, weight: Ref) -> None:
    """A part that shares nothing out."""
    fed, builder = part.fed, reader.builder
    if isinstance(fed, Constant):
        kind = 'VALUE' if isinstance(fed.value, (int, float)) else 'VECTOR'
        _emit(builder, weight, reader.typed(fed.value, kind, True, part.socket))
        return
    if fed.socket.type != 'SHADER':
        color = reader.output(fed, HERE)
        if color is not None:
            _emit(builder, weight, builder.splat(color) if fed.socket.type in NUMBERS else color)
        return
    node = reader.node(fed.node, fed.contexts)
    builder.label = reader.feeds.name(fed.node)
    kind = fed.node.bl_idname
    if kind in CLOSURES:
        CLOSURES[kind](node, weight)
    elif kind not in ('ShaderNodeMixShader', 'ShaderNodeAddShader'):
        node.warn(f'{NOT_SUPPORTED.get(kind, "this node is not supported yet")}: left out')
    builder.label = ''


# ---- Emission and transparency.


def _emit(builder: Builder, weight: Ref, color: Ref) -> None:
    _note_light(builder, weight, color)
    builder.closure('emission', weight, color)


def _note_light(builder: Builder, weight: Ref, color: Ref) -> None:
    if builder.constant_of(color) != (0.0, 0.0, 0.0):
        builder.emitted += (weight, color)


@closure('ShaderNodeEmission', 'ShaderNodeBackground')
def _emission(node: Node, weight: Ref) -> None:
    _emit(node.builder, weight, node.builder.scale(node.v('Color'), node.f('Strength')))


@closure('ShaderNodeBsdfTransparent')
def _transparent(node: Node, weight: Ref) -> None:
    node.builder.closure('transparent', weight, node.v('Color'))


@closure('ShaderNodeBsdfRayPortal')
def _portal(node: Node, weight: Ref) -> None:
    node.warn_nearest()
    _transparent(node, weight)


@closure('ShaderNodeHoldout')
def _holdout(node: Node, weight: Ref) -> None:
    node.builder.closure('holdout', weight)


# ---- Reflection and refraction.


@closure('ShaderNodeBsdfDiffuse')
def _diffuse(node: Node, weight: Ref) -> None:
    node.builder.closure('diffuse', weight, node.v('Color'), node.f('Roughness'), node.normal())


@closure('ShaderNodeBsdfTranslucent')
def _translucent(node: Node, weight: Ref) -> None:
    node.builder.closure('translucent', weight, node.v('Color'), node.normal())


@closure('ShaderNodeBsdfAnisotropic')
def _glossy(node: Node, weight: Ref) -> None:
    numbers = map(node.f, ('Roughness', 'Anisotropy', 'Rotation'))
    args = (node.v('Color'), *numbers, node.normal(), _tangent(node, 'Anisotropy'))
    node.builder.closure('glossy', weight, *args, mode=_distribution(node))


@closure('ShaderNodeBsdfMetallic')
def _metallic(node: Node, weight: Ref) -> None:
    is_physical = node.node.fresnel_type == 'PHYSICAL_CONDUCTOR'
    zero = node.constant(0.0)
    colors = [zero if is_physical else node.v(name) for name in ('Base Color', 'Edge Tint')]
    optics = [node.v(name) if is_physical else zero for name in ('IOR', 'Extinction')]
    numbers = map(node.f, ('Roughness', 'Anisotropy', 'Rotation'))
    args = (*colors, *optics, *numbers, node.normal(), _tangent(node, 'Anisotropy'), *_film(node))
    mode = _distribution(node) | (PHYSICAL_CONDUCTOR if is_physical else 0)
    node.builder.closure('metallic', weight, *args, mode=mode)


@closure('ShaderNodeBsdfGlass')
def _glass(node: Node, weight: Ref) -> None:
    args = (node.v('Color'), node.f('Roughness'), node.f('IOR'), node.normal(), *_film(node))
    node.builder.closure('glass', weight, *args, mode=_distribution(node))


@closure('ShaderNodeBsdfRefraction')
def _refraction(node: Node, weight: Ref) -> None:
    args = (node.v('Color'), node.f('Roughness'), node.f('IOR'), node.normal())
    node.builder.closure('refraction', weight, *args, mode=_distribution(node))


@closure('ShaderNodeBsdfSheen')
def _sheen(node: Node, weight: Ref) -> None:
    args = (node.v('Color'), node.f('Roughness'), node.normal())
    node.builder.closure('sheen', weight, *args, mode=('ASHIKHMIN', 'MICROFIBER').index(node.node.distribution))


@closure('ShaderNodeBsdfToon')
def _toon(node: Node, weight: Ref) -> None:
    args = (node.v('Color'), node.f('Size'), node.f('Smooth'), node.normal())
    node.builder.closure('toon', weight, *args, mode=('DIFFUSE', 'GLOSSY').index(node.node.component))


@closure('ShaderNodeBsdfPrincipled')
def _principled(node: Node, weight: Ref) -> None:
    builder = node.builder
    # Before 5.2 there was no Thin Wall.
    thin_wall = node.f('Thin Wall') if 'Thin Wall' in node.sockets else node.constant(0.0)
    subsurface = node.f('Subsurface Weight')
    # A thin wall scatters what it does not reflect to both of its sides, which is all there is to it.
    walls = builder.constant_of(thin_wall)
    is_thin = walls is not None and walls[0] > 0.0
    if not is_thin and builder.constant_of(subsurface) != (0.0, 0.0, 0.0):
        node.warn('subsurface scattering is not supported yet: the surface is diffuse')
    emission = builder.scale(node.v('Emission Color'), node.f('Emission Strength'))
    _note_light(builder, weight, emission)
    args = (
        node.v('Base Color'),
        node.f('Metallic'),
        node.f('Roughness'),
        node.f('IOR'),
        node.normal(),
        node.f('Diffuse Roughness'),
        subsurface,
        node.v('Subsurface Radius'),
        node.f('Subsurface Scale'),
        node.f('Subsurface IOR'),
        node.f('Subsurface Anisotropy'),
        node.f('Specular IOR Level'),
        node.v('Specular Tint'),
        node.f('Anisotropic'),
        node.f('Anisotropic Rotation'),
        _tangent(node, 'Anisotropic'),
        node.f('Transmission Weight'),
        node.f('Coat Weight'),
        node.f('Coat Roughness'),
        node.f('Coat IOR'),
        node.v('Coat Tint'),
        node.normal('Coat Normal'),
        node.f('Sheen Weight'),
        node.f('Sheen Roughness'),
        node.v('Sheen Tint'),
        emission,
        *_film(node),
        thin_wall,
        node.f('Alpha'),
    )
    builder.closure('principled', weight, *args, mode=int(node.node.distribution == 'MULTI_GGX'))


def _distribution(node: Node) -> int:
    return DISTRIBUTIONS.index(node.node.distribution)


def _tangent(node: Node, anisotropy: str) -> Ref:
    """The tangent, which nothing reads where there is no anisotropy."""
    known = node.builder.constant_of(node.f(anisotropy))
    if known is not None and known[0] == 0.0:
        return node.constant(0.0)
    tangent = node.linked('Tangent')
    return node.emit('geometry_tangent') if tangent is None else tangent


def _film(node: Node) -> tuple[Ref, Ref]:
    """A thin film; 4.5 has it on fewer nodes."""
    if not node.has('Thin Film Thickness'):
        return node.constant(0.0), node.constant(1.33)
    return node.f('Thin Film Thickness'), node.f('Thin Film IOR')


# ---- What has no closure of its own yet: the nearest, and a message.


@closure('ShaderNodeSubsurfaceScattering')
def _subsurface(node: Node, weight: Ref) -> None:
    node.warn_nearest()
    node.builder.closure('diffuse', weight, node.v('Color'), node.constant(0.0), node.normal())


@closure('ShaderNodeBsdfHair', 'ShaderNodeBsdfHairPrincipled')
def _hair(node: Node, weight: Ref) -> None:
    node.warn_nearest()
    is_colored = node.has('Color')  # melanin and absorption are none
    color = node.v('Color') if is_colored else node.constant(HAIR)
    node.builder.closure('diffuse', weight, color, node.constant(0.0), node.normal())


HAIR = (0.2, 0.1, 0.05)  # a brown that stands for hair whose colour is not given as such
