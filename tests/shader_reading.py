# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shaders without the native module, and evaluates those of their ops that only compute.

The numbers of the ops come from the kernels' own list; what the other ops compute is tested with the kernels.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
from cotorra import compat, shader
from cotorra.export.images import ImageTable
from cotorra.export.nodes import Trees
from cotorra.log import Log
from cotorra.shader.explain import CLOSURE_ARGUMENTS
from cotorra.shader.ops import Kind, Op, Tables

from flat_scenes import node

LIST = Path(__file__).resolve().parent.parent / 'kernels' / 'program' / 'ops.inc'
ROW = re.compile(r'^PROGRAM_OP\(\w+, (\w+), (\d+)u, (\w+), (\w*), (\w*) *\)', re.MULTILINE)

# Types of the arguments of closures, in the order of CLOSURE_ARGUMENTS.
CLOSURES = {
    'emission': 'v',
    'transparent': 'v',
    'holdout': '',
    'diffuse': 'vfv',
    'translucent': 'vv',
    'glossy': 'vfffvv',
    'metallic': 'vvvvfffvvff',
    'glass': 'vffvff',
    'refraction': 'vffv',
    'sheen': 'vfv',
    'toon': 'vffv',
    'principled': 'vfffvffvffffvffvffffvvffvvffff',
}


def op_tables() -> Tables:
    ops = {row[0]: Op(int(row[1]), row[3], row[4]) for row in ROW.findall(LIST.read_text())}
    return Tables(ops, {name: Kind(number, types) for number, (name, types) in enumerate(CLOSURES.items())})


TABLES = op_tables()
OP_NAMES = {op.number: name for name, op in TABLES.ops.items()}
CLOSURE_NAMES = {kind.number: name for name, kind in TABLES.closures.items()}


@dataclass
class Read:
    """A shader, and what was said while it was read."""

    draft: shader.Draft
    warnings: list[str]
    log: Log

    @property
    def shader(self) -> shader.Draft:
        return self.draft.shader

    @property
    def ops(self) -> list[str]:
        return [OP_NAMES[number] for number in self.draft.shader.ops.tolist()]

    @property
    def closures(self) -> list[str]:
        return [CLOSURE_NAMES[number] for number in self.draft.shader.closures['kind'].tolist()]

    def modes(self, name: str) -> list[int]:
        found = zip(self.ops, self.draft.shader.modes.tolist(), strict=True)
        return [mode for op, mode in found if op == name]

    def argument(self, row: int, name: str) -> int:
        """The reference of a closure's argument."""
        kind = CLOSURE_NAMES[int(self.shader.closures[row]['kind'])]
        return int(
            self.shader.closure_args[self.shader.closures[row]['first_arg'] + CLOSURE_ARGUMENTS[kind].index(name)]
        )


def read(owner: bpy.types.ID, frame: int = 1, view_layer: Callable | None = None) -> Read:
    warnings: list[str] = []
    log = Log()
    trees = Trees(log.checkpoint, warnings.append)
    scene = shader.Scene(ImageTable(log, frame), view_layer or (lambda name: (0.0, 0.0, 0.0, 0.0)))
    return Read(shader.shaders_of(owner, trees, scene, warnings.append, TABLES), warnings, log)


def new_material(name: str = 'Material') -> tuple[bpy.types.Material, bpy.types.Node]:
    """A material with an Emission at its output, and that node."""
    material = bpy.data.materials.new(name)
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new('ShaderNodeEmission'), tree.nodes.new('ShaderNodeOutputMaterial')
    tree.links.new(emission.outputs[0], output.inputs['Surface'])
    return material, emission


def link(start: bpy.types.NodeSocket, end: bpy.types.NodeSocket) -> None:
    start.id_data.links.new(start, end)


def emitted(kind: str, output: int | str = 0, **values: object) -> tuple[bpy.types.Material, bpy.types.Node]:
    """A material that emits what a node shows."""
    material, emission = new_material()
    made = node(material.node_tree, kind, **values)
    link(made.outputs[output], emission.inputs['Color'])
    return material, made


def varying(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """A number that no one folds."""
    return node(tree, 'NewGeometry').outputs['Backfacing']


# ---- A small interpreter.


def step_of(mode: int) -> np.ndarray:
    """How far aside, in pixels along both axes, an op is asked for."""
    width = float(np.array(mode & 0xFFFF, np.uint16).view(np.float16))
    return width * np.array({0: (0, 0), 1: (1, 0), 2: (0, 1)}[mode >> 30])


@dataclass
class Values:
    """Evaluates a shader for one shading point.

    given: what ops show that do not only compute, by name; functions of the step aside and the arguments, or values.
    """

    read: Read
    given: dict[str, object] = field(default_factory=dict)
    found: list[np.ndarray] = field(default_factory=list)

    def __post_init__(self) -> None:
        made, at = self.read.draft.shader, 0
        for number, mode in zip(made.ops.tolist(), made.modes.tolist(), strict=True):
            name = OP_NAMES[number]
            op = TABLES.ops[name]
            refs = made.args[at : at + len(op.arguments)].tolist()
            at += len(op.arguments)
            args = [self.value(ref, letter) for ref, letter in zip(refs, op.arguments, strict=True)]
            if name in self.given:
                given = self.given[name]
                shown = given(step_of(mode), *args) if callable(given) else given
            elif name == 'curve_f':
                shown = _curve(made.tables, *args)
            else:
                shown = COMPUTED[name](mode, *args)
            self.found.append(np.broadcast_to(np.asarray(shown, np.float64), (3,)))

    def value(self, ref: int, letter: str) -> np.ndarray | float:
        row = self.found[ref] if ref >= 0 else self.read.draft.shader.constants[~ref].astype(np.float64)
        return float(row[0]) if letter == 'f' else row

    def closure(self, row: int, name: str) -> np.ndarray | float:
        """An argument of a closure."""
        kind = CLOSURE_NAMES[int(self.read.draft.shader.closures[row]['kind'])]
        letter = CLOSURES[kind][CLOSURE_ARGUMENTS[kind].index(name)]
        return self.value(self.read.argument(row, name), letter)

    def weight(self, row: int) -> np.ndarray:
        return self.value(int(self.read.draft.shader.closures[row]['weight']), 'v')

    def emission(self) -> np.ndarray:
        """The sum of all that is emitted."""
        total = np.zeros(3)
        for row, name in enumerate(self.read.closures):
            if name == 'emission':
                total = total + self.weight(row) * self.closure(row, 'color')
        return total


LUMINANCE = np.array((0.2126390, 0.7151687, 0.0721923))

MATH = {
    0: lambda a, b, c: a + b,
    1: lambda a, b, c: a - b,
    2: lambda a, b, c: a * b,
    3: lambda a, b, c: a / b if b else 0.0,
    12: lambda a, b, c: min(a, b),
    13: lambda a, b, c: max(a, b),
    14: lambda a, b, c: np.floor(a + 0.5),
    15: lambda a, b, c: float(a < b),
    16: lambda a, b, c: float(a > b),
    18: lambda a, b, c: abs(a),
    20: lambda a, b, c: np.floor(a),
    32: lambda a, b, c: np.trunc(a),
    36: lambda a, b, c: a * b + c,
}
VECTOR_MATH = {
    0: lambda a, b, c, s: a + b,
    1: lambda a, b, c, s: a - b,
    2: lambda a, b, c, s: a * b,
    4: lambda a, b, c, s: np.cross(a, b),
    7: lambda a, b, c, s: a @ b,
    10: lambda a, b, c, s: a * s,
    11: lambda a, b, c, s: a / np.linalg.norm(a),
    26: lambda a, b, c, s: a * b + c,
}
BLENDS = {0: lambda a, b: b, 1: lambda a, b: a + b, 2: lambda a, b: a * b}


def _math(mode: int, a: float, b: float, c: float) -> float:
    found = MATH[mode & 0xFFFF](a, b, c)
    return min(max(found, 0.0), 1.0) if mode >> 16 else found


def _mix(mode: int, factor: object, a: object, b: object) -> object:
    factor = np.clip(factor, 0.0, 1.0) if mode & 1 else factor
    return a + factor * (b - a)


def _mix_color(mode: int, factor: float, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    factor = min(max(factor, 0.0), 1.0) if mode & 256 else factor
    found = a + factor * (BLENDS[mode & 255](a, b) - a)
    return np.clip(found, 0.0, 1.0) if mode & 512 else found


def _curve(tables: np.ndarray, value: float, table: float, low: float, high: float, factor: float) -> float:
    at = min(max((value - low) / (high - low), 0.0), 1.0)
    return value + factor * (np.interp(at * 256.0, np.arange(257), tables[int(table) :][:257]) - value)


COMPUTED: dict[str, Callable] = {
    'splat': lambda mode, a: a,
    'luminance': lambda mode, a: LUMINANCE @ a,
    'average': lambda mode, a: a.mean(),
    'component': lambda mode, a: a[mode],
    'combine': lambda mode, x, y, z: (x, y, z),
    'combine_color': lambda mode, x, y, z: (x, y, z),
    'math': _math,
    'vector_math_v': lambda mode, *args: VECTOR_MATH[mode](*args),
    'vector_math_f': lambda mode, *args: VECTOR_MATH[mode](*args),
    'clamp_f': lambda mode, value, low, high: min(max(value, low), high),
    'mix_f': _mix,
    'mix_v': _mix,
    'mix_color': _mix_color,
    'invert': lambda mode, color, factor: color + factor * (1.0 - 2.0 * color),
    'affine': lambda mode, v, x, y, z, moved: np.array((x @ v, y @ v, z @ v)) + moved,
}
