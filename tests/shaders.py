# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders of a few ops and closures, for scenes that tests make without Blender's nodes.

How node trees are read is tested elsewhere; the arrays are the builder's of addon/shader/tree.py.
"""

from __future__ import annotations

from typing import NamedTuple

from cotorra.export.buffers import Shader
from cotorra.shader.ops import Tables, tables
from cotorra.shader.tree import Builder


class Op(NamedTuple):
    """A value that is computed."""

    ref: int


Value = Op | float | tuple[float, ...]

# The arguments of a Principled closure in their order, as a new node has them. None: the surface's own normal.
PRINCIPLED: dict[str, Value | None] = {
    'base_color': (0.8, 0.8, 0.8),
    'metallic': 0.0,
    'roughness': 0.5,
    'ior': 1.5,
    'normal': None,
    'diffuse_roughness': 0.0,
    'subsurface': 0.0,
    'subsurface_radius': (1.0, 0.2, 0.1),
    'subsurface_scale': 0.05,
    'subsurface_ior': 1.4,
    'subsurface_anisotropy': 0.0,
    'specular_level': 0.5,
    'specular_tint': (1.0, 1.0, 1.0),
    'anisotropic': 0.0,
    'rotation': 0.0,
    'tangent': 0.0,
    'transmission': 0.0,
    'coat': 0.0,
    'coat_roughness': 0.03,
    'coat_ior': 1.5,
    'coat_tint': (1.0, 1.0, 1.0),
    'coat_normal': None,
    'sheen': 0.0,
    'sheen_roughness': 0.5,
    'sheen_tint': (1.0, 1.0, 1.0),
    'emission': (0.0, 0.0, 0.0),
    'film_thickness': 0.0,
    'film_ior': 1.33,
    'thin_wall': 0.0,
    'alpha': 1.0,
}


class Sketch:
    """A shader in the making. known: the ops of another module than the one that is installed."""

    def __init__(self, known: Tables | None = None) -> None:
        self.builder = Builder(known or tables())

    def ref(self, value: Value) -> int:
        if isinstance(value, Op):
            return value.ref
        return self.builder.constant(tuple(map(float, value)) if hasattr(value, '__len__') else float(value))

    def op(self, name: str, *args: Value, mode: int = 0) -> Op:
        return Op(self.builder.emit(name, *map(self.ref, args), mode=mode))

    def closure(self, name: str, *args: Value, weight: Value = 1.0, mode: int = 0) -> None:
        self.builder.closure(name, self.ref(weight), *map(self.ref, args), mode=mode)

    def principled(self, weight: Value = 1.0, multi_ggx: bool = True, **values: Value) -> None:
        unknown = values.keys() - PRINCIPLED.keys()
        assert not unknown, f'Principled has no {unknown}'
        args = [self.op('normal') if value is None else value for value in (PRINCIPLED | values).values()]
        self.closure('principled', *args, weight=weight, mode=int(multi_ggx))

    def shader(self, name: str = 'shader') -> Shader:
        return self.builder.draft(name).shader


def principled(known: Tables | None = None, **values: Value) -> Shader:
    """A shader of one Principled closure with constants."""
    sketch = Sketch(known)
    sketch.principled(**values)
    return sketch.shader()


# ---- Reading shaders.


# A constant is three numbers; what is computed is the name of its op.
Seen = tuple[float, ...] | str


class Closure(NamedTuple):
    """A row of a shader's sum."""

    name: str
    mode: int
    weight: Seen
    args: tuple[Seen, ...]


def closures(shader: Shader) -> list[Closure]:
    """The sum that a shader shows, as it was read from its tree: nothing is folded."""
    kinds = {kind.number: (name, len(kind.arguments)) for name, kind in tables().closures.items()}
    found = []
    for row in shader.closures:
        name, count = kinds[row['kind']]
        first = int(row['first_arg'])
        args = shader.closure_args[first : first + count].tolist()
        weight = _seen(shader, int(row['weight']))
        found.append(Closure(name, int(row['mode']), weight, tuple(_seen(shader, ref) for ref in args)))
    return found


def calls(shader: Shader) -> list[tuple[str, int, tuple[Seen, ...]]]:
    """The ops of a shader in order: name, mode, arguments."""
    counts = {op.number: len(op.arguments) for op in tables().ops.values()}
    found, at = [], 0
    for index, (number, mode) in enumerate(zip(shader.ops.tolist(), shader.modes.tolist(), strict=True)):
        refs = shader.args[at : at + counts[number]].tolist()
        at += counts[number]
        found.append((_seen(shader, index), mode, tuple(_seen(shader, ref) for ref in refs)))
    return found


def ops(shader: Shader) -> set[str]:
    """The names of the ops of a shader."""
    return {name for name, _, _ in calls(shader)}


def _seen(shader: Shader, ref: int) -> Seen:
    names = {op.number: name for name, op in tables().ops.items()}
    return names[shader.ops[ref]] if ref >= 0 else tuple(shader.constants[~ref].tolist())


def emission_ops(explained: dict[str, object]) -> list[str]:
    """Names of the ops by which a shader's emission is computed (Scene.explain), none where it is constant."""
    emission = explained['emission']
    return [op for op, *_ in emission['instructions']] if isinstance(emission, dict) else []
