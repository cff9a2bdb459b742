# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the flat arrays of a shader: ops on earlier values, each equal one once, and weighted closures.

It knows neither nodes nor Blender: reader.py reads the trees. Folding constants is the native module's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..export.buffers import CLOSURE, F32, Shader
from .ops import Tables

# A value: the index of the op that makes it, or ~i of a constant.
Ref = int
Triple = tuple[float, float, float]

SHIFT_BIT = 30  # of the modes of ops that read the shading point: 1 a step along x, 2 along y, bits 0 to 15 its width


class Named(NamedTuple):
    """A constant whose number is known only when all shaders are read. kind: 'layer' or 'tangent'; name: a layer's."""

    kind: str
    name: str


@dataclass(frozen=True, slots=True)
class Draft:
    """A shader whose layers are names still.

    named: the constants that stand for layers, by their index.
    uses:  names of the ops, which tell what meshes and instances have to bring.
    notes: what was left out since it counts for nothing, for people.
    """

    shader: Shader
    named: tuple[tuple[int, Named], ...]
    uses: frozenset[str]
    notes: tuple[str, ...] = ()

    def layers(self, kind: str) -> set[str]:
        return {named.name for _, named in self.named if named.kind == kind}

    @property
    def key(self) -> tuple:
        """What is equal in equal trees, whatever their nodes are called."""
        shader = self.shader
        arrays = (
            shader.ops,
            shader.modes,
            shader.args,
            shader.constants,
            shader.closures,
            shader.closure_args,
            shader.tables,
        )
        return (*(array.tobytes() for array in arrays), self.named)

    def resolved(self, numbers: dict[Named, int]) -> Shader:
        """The shader with the numbers of its layers."""
        for index, named in self.named:
            self.shader.constants[index] = numbers[named]
        return self.shader


# Where the normal stands among the arguments of closures, and the bits of their modes that tell that it is the
# surface's own, bent by a displacement, or bent further from that one.
NORMALS = {
    'translucent': 1,
    'diffuse': 2,
    'sheen': 2,
    'glass': 3,
    'refraction': 3,
    'toon': 3,
    'glossy': 4,
    'principled': 4,
    'metallic': 7,
}
OWN_NORMAL = 1 << 16
BENT_NORMAL = 1 << 17  # it is bent from there; the surface's own stands after the arguments


@dataclass(slots=True)
class Builder:
    """Gathers the ops, constants, tables and closures of one shader."""

    tables: Tables
    label: str = ''  # of the node that is read at present
    own_normal: Ref | None = None  # the surface's normal, where a displacement bends it
    _ops: list[int] = field(default_factory=list)
    _modes: list[int] = field(default_factory=list)
    _args: list[int] = field(default_factory=list)
    _labels: list[str] = field(default_factory=list)
    _known: dict[tuple, Ref] = field(default_factory=dict)
    _rows: list[Triple | Named] = field(default_factory=list)
    _constants: dict[object, Ref] = field(default_factory=dict)
    _tables: dict[bytes, int] = field(default_factory=dict)
    _table_parts: list[F32] = field(default_factory=list)
    _table_size: int = 0
    _closures: list[tuple[int, int, Ref, tuple[Ref, ...]]] = field(default_factory=list)
    _closure_labels: list[str] = field(default_factory=list)
    emitted: list[Ref] = field(default_factory=list)  # light of closures, and how much each of them counts
    notes: list[str] = field(default_factory=list)  # as in Draft

    def emit(self, name: str, *args: Ref, mode: int = 0) -> Ref:
        """The value of an op; an earlier one where it is the same."""
        key = (name, mode, args)
        found = self._known.get(key)
        if found is None:
            op = self.tables.ops[name]
            assert len(args) == len(op.arguments), f'{name} takes {op.arguments}'
            found = self._known[key] = len(self._ops)
            self._ops.append(op.number)
            self._modes.append(mode)
            self._args += args
            self._labels.append(self.label)
        return found

    def constant(self, value: float | Triple) -> Ref:
        """A constant; a number stands in all three components."""
        found = self._constants.get(value)
        if found is None:
            row = value if isinstance(value, tuple) else (value, value, value)
            found = self._constants.get(row)
            if found is None:
                found = self._constants[row] = ~len(self._rows)
                self._rows.append(row)
            self._constants[value] = found
        return found

    def named(self, kind: str, name: str) -> Ref:
        """The number of a layer, which is given when all shaders are read."""
        row = Named(kind, name)
        found = self._constants.get(row)
        if found is None:
            found = self._constants[row] = ~len(self._rows)
            self._rows.append(row)
        return found

    def constant_of(self, ref: Ref) -> Triple | None:
        """The value of a constant, None for what has to be computed."""
        row = self._rows[~ref] if ref < 0 else None
        return None if isinstance(row, Named) else row

    def table(self, values: F32) -> Ref:
        """The place of a look-up table; equal ones stand there once."""
        key = values.tobytes()
        if key not in self._tables:
            self._tables[key] = self._table_size
            self._table_parts.append(values.ravel())
            self._table_size += values.size
        return self.constant(float(self._tables[key]))

    def closure(self, name: str, weight: Ref, *args: Ref, mode: int = 0) -> None:
        kind = self.tables.closures[name]
        assert len(args) == len(kind.arguments), f'{name} takes {kind.arguments}'
        place = NORMALS.get(name)
        if place is not None and self.own_normal is not None:
            if args[place] == self.own_normal:
                mode |= OWN_NORMAL
            else:
                mode |= BENT_NORMAL
                args = (*args, self.own_normal)
        self._closures.append((kind.number, mode, weight, args))
        self._closure_labels.append(self.label)

    def behind(self, refs: Iterable[Ref]) -> Iterator[tuple[str, int]]:
        """The ops that values are made by, near ones first: their names and modes."""
        wanted = set(refs)
        for (name, mode, args), ref in reversed(self._known.items()):
            if ref in wanted:
                wanted.update(args)
                yield name, mode

    # ---- Arithmetic on numbers that may be constants; what is no constant is left to the native module.

    def splat(self, ref: Ref) -> Ref:
        return ref if ref < 0 else self.emit('splat', ref)  # a constant number stands in all components

    def math(self, operation: int, a: Ref, b: Ref) -> Ref:
        return self.emit('math', a, b, self.constant(0.0), mode=operation)

    def multiply(self, a: Ref, b: Ref) -> Ref:
        x, y = self.constant_of(a), self.constant_of(b)
        if x is not None and y is not None:
            return self.constant(x[0] * y[0])
        if x is not None and x[0] == 1.0:
            return b
        if y is not None and y[0] == 1.0:
            return a
        return self.math(MULTIPLY, a, b)

    def add(self, a: Ref, b: Ref) -> Ref:
        x, y = self.constant_of(a), self.constant_of(b)
        if x is not None and y is not None:
            return self.constant(x[0] + y[0])
        return self.math(ADD, a, b)

    def saturate(self, ref: Ref) -> Ref:
        value = self.constant_of(ref)
        if value is None:
            return self.emit('clamp_f', ref, self.constant(0.0), self.constant(1.0))
        return self.constant(min(max(value[0], 0.0), 1.0))

    def one_minus(self, ref: Ref) -> Ref:
        value = self.constant_of(ref)
        if value is None:
            return self.math(SUBTRACT, self.constant(1.0), ref)
        return self.constant(1.0 - value[0])

    def scale(self, vector: Ref, factor: Ref) -> Ref:
        """A vector or colour times a number."""
        zero = self.constant(0.0)
        x, y = self.constant_of(vector), self.constant_of(factor)
        if y is not None and y[0] == 1.0:
            return vector
        if x is not None and y is not None:
            return self.constant(tuple(part * y[0] for part in x))
        return self.emit('vector_math_v', vector, zero, zero, factor, mode=VECTOR_SCALE)

    # ---- The arrays.

    def draft(self, name: str) -> Draft:
        named = tuple((index, row) for index, row in enumerate(self._rows) if isinstance(row, Named))
        rows = [(0.0, 0.0, 0.0) if isinstance(row, Named) else row for row in self._rows] if named else self._rows
        constants = np.array(rows, np.float32).reshape(-1, 3)
        constants[~np.isfinite(constants)] = 0.0
        closure_args: list[Ref] = []
        closures = []
        for kind, mode, weight, args in self._closures:
            closures.append((kind, mode, weight, len(closure_args)))
            closure_args += args
        shader = Shader(
            name=name,
            ops=np.array(self._ops, np.uint32),
            modes=np.array(self._modes, np.uint32),
            args=np.array(self._args, np.int32),
            constants=constants,
            closures=np.array(closures, CLOSURE),
            closure_args=np.array(closure_args, np.int32),
            labels=tuple(self._labels),
            tables=np.concatenate(self._table_parts) if self._table_parts else np.zeros(0, np.float32),
            closure_labels=tuple(self._closure_labels),
        )
        return Draft(shader, named, frozenset(name for name, _, _ in self._known), tuple(self.notes))


def finite(value: float | Triple) -> bool:
    return all(map(math.isfinite, value)) if isinstance(value, tuple) else math.isfinite(value)


# Numbers of Blender's enumerations of the nodes Math and Vector Math.
ADD, SUBTRACT, MULTIPLY, DIVIDE = range(4)
COMPARE = 35
VECTOR_ADD, VECTOR_SUBTRACT, VECTOR_MULTIPLY = 0, 1, 2
VECTOR_REFLECT, VECTOR_DOT, VECTOR_SCALE, VECTOR_NORMALIZE = 6, 7, 10, 11
