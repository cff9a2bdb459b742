# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of a shader, as lines of columns: its folded programs, what is constant, what was left out, its cost.

Words are words.py's; shaders are compiled, and the time is taken, by the native module.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..export.buffers import SceneBuffers, Shader
from .ops import Tables, tables
from .words import (
    ARGUMENTS,
    CLOSURE_ARGUMENTS,
    OFF_AT_0,
    ONLY_WITH,
    SIGNS,
    TOLD_APART,
    closure_words,
    op_words,
    operation,
    unused,
)

WIDTH = 120
COLUMN_MAX = 36  # a name that is longer moves what follows in its own line alone
MADE = '(compiler)'  # in a node's place

Cells = tuple[str, ...]
Value = int | float | tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Section:
    """A title, and rows of cells in columns; the last cell may be long."""

    title: str
    rows: tuple[Cells, ...] = ()

    def lines(self, width: int = WIDTH) -> list[str]:
        found = [self.title]
        count = max(map(len, self.rows), default=0)
        sizes = [0] * count
        for row in self.rows:
            for index, cell in enumerate(row[:-1]):
                sizes[index] = max(sizes[index], min(len(cell), COLUMN_MAX))
        for row in self.rows:
            head = '  '.join(['', *(cell.ljust(size) for cell, size in zip(row[:-1], sizes, strict=False)), ''])
            parts = textwrap.wrap(row[-1], max(width - len(head), 40), break_long_words=False, break_on_hyphens=False)
            found += [(head + part).rstrip() for part in parts[:1] or ['']]
            found += [' ' * (sum(sizes[: len(row) - 1]) + 2 * len(row)) + part for part in parts[1:]]
        return found


@dataclass(frozen=True, slots=True)
class Explanation:
    """title: names the owner. sections: in the order to read."""

    title: str
    sections: tuple[Section, ...]

    def text(self, width: int = WIDTH) -> str:
        lines = [self.title]
        for section in self.sections:
            lines += ['', *section.lines(width)]
        return '\n'.join(lines)


def folded(
    title: str,
    found: dict[str, Any],
    buffers: SceneBuffers,
    notes: Iterable[str] = (),
    warnings: Sequence[str] = (),
) -> Explanation:
    """What the native module tells (`Scene.explain`) of the first shader of the buffers.

    notes: of its draft, on what was left out before. warnings: what was said when it was read.
    """
    shader = buffers.shaders[0]
    names = _Names(shader, buffers)
    sections = [_cost(shader, found), *(_part(part, found[part], names) for part in PARTS)]
    constants = tuple(
        (names.label(op), names.op(shader.ops[op], shader.modes[op]), f'= {_constant(value)}')
        for op, value in found['folded']
    )
    if constants:
        sections.append(Section('Constant, computed once', constants))
    dropped = [(note,) for note in notes]
    for row, why in found['dropped']:
        words = closure_words(names.kinds[int(shader.closures[row]['kind'])], int(shader.closures[row]['mode']))
        dropped.append((f'"{names.closure_label(row)}" ({words}): its {("weight", "alpha", "colour")[why]} is 0',))
    if dropped:
        sections.append(Section('Left out, since it counts for nothing', tuple(dropped)))
    if warnings:
        sections.append(Section('Messages', tuple((text,) for text in warnings)))
    return Explanation(title, tuple(sections))


def unfolded(shader: Shader, ops: Tables | None = None) -> Section:
    """The shader as it was read: all ops, and the closures that are summed. ops: the native module's, if not given."""
    names = _Names(shader, None, ops)
    rows = []
    at = 0
    for index, (number, mode) in enumerate(zip(shader.ops.tolist(), shader.modes.tolist(), strict=True)):
        op = names.tables.ops[names.ops[number]]
        refs = shader.args[at : at + len(op.arguments)].tolist()
        at += len(op.arguments)
        values = [_referred(shader, ref, letter) for ref, letter in zip(refs, op.arguments, strict=True)]
        rows.append(names.line(index, names.ops[number], mode, values, index))
    for index, row in enumerate(shader.closures):
        name = names.kinds[int(row['kind'])]
        letters = names.tables.closures[name].arguments
        first = int(row['first_arg'])
        refs = shader.closure_args[first : first + len(letters)].tolist()
        values = [_referred(shader, ref, letter) for ref, letter in zip(refs, letters, strict=True)]
        rows.append(names.closure(name, int(row['mode']), _referred(shader, int(row['weight']), 'v'), values, index))
    count = f'{_count(len(shader.ops), "op")}, {_count(len(shader.closures), "closure")}'
    return Section(f'As read: {count}', tuple(rows))


PARTS = ('surface', 'emission', 'transparency')


def _cost(shader: Shader, found: dict[str, Any]) -> Section:
    programs = [found[part] for part in PARTS if _is_program(found[part])]
    if not programs:
        title = 'Cost: none a point, all of it is constant'
    else:
        nanoseconds = sum(program['nanoseconds'] for program in programs)
        title = f'Cost: {_time(nanoseconds)} a point, measured now on one thread of this CPU; closures not counted'
    kept = {line[3] for program in programs for line in program['instructions']} - {-1}
    folded_ops = len(found['folded'])
    rest = len(shader.ops) - folded_ops - len(kept)
    counts = [f'{_count(len(kept), "op is", "ops are")} computed at each point', f'{folded_ops} constant']
    if rest > 0:
        counts.append(f'{rest} equal to others or not needed')
    return Section(title, ((f'of {_count(len(shader.ops), "op")} as read, {", ".join(counts)}',),))


def _part(part: str, found: Any, names: _Names) -> Section:
    title = part.capitalize()
    if _is_program(found):
        lines = found['instructions']
        rows = [names.line(index, op, mode, values, source) for index, (op, mode, values, source) in enumerate(lines)]
        rows += [names.closure(*row) for row in found['closures']]
        if not found['closures']:
            rows.append(('=', '', '', _value(found['result'])))
        sizes = f'{_count(len(lines), "instruction")}, {_count(found["registers"], "register")}'
        return Section(f'{title}: {sizes}, {_time(found["nanoseconds"])} a point', tuple(rows))
    if part != 'surface':
        return Section(f'{title}: {"none" if not any(found) else _constant(found) + " everywhere"}')
    if found is None:
        return Section(f'{title}: none, it reflects nothing')
    values = dict(found)
    name = values.pop('closure')
    shown = ', '.join(f'{_spoken(key)} {_constant(value)}' for key, value in values.items())
    return Section(f'{title}: {name} of constants', ((shown,),))


class _Names:
    """Numbers of one shader as words. buffers: where layers and images have their names; None: they stay numbers."""

    def __init__(self, shader: Shader, buffers: SceneBuffers | None, ops: Tables | None = None) -> None:
        self.shader, self.buffers = shader, buffers
        self.tables = ops or tables()
        self.ops = {op.number: name for name, op in self.tables.ops.items()}
        self.kinds = {kind.number: name for name, kind in self.tables.closures.items()}

    def label(self, op: int) -> str:
        return MADE if op < 0 else self.shader.labels[op] or '-'

    def closure_label(self, row: int) -> str:
        labels = self.shader.closure_labels
        return MADE if row < 0 else (labels[row] if row < len(labels) and labels[row] else '-')

    def op(self, number: int, mode: int) -> str:
        return op_words(self.ops[int(number)], int(mode))

    def line(self, index: int, name: str, mode: int, values: Sequence[Value], source: int) -> Cells:
        """One instruction: number, node, what it does, with what."""
        return f'%{index}', self.label(source), op_words(name, mode), self.arguments(name, mode, values)

    def arguments(self, name: str, mode: int, values: Sequence[Value]) -> str:
        members = ARGUMENTS.get(name, '').split()
        hidden = unused(name, mode)
        shown = [
            (member, self.named(name, member, value))
            for member, value in zip(members, values, strict=True)
            if member not in hidden
        ]
        if name in ('math', 'vector_math_v'):
            sign = SIGNS.get(operation(name, mode))
            texts = [text for _, text in shown]
            return f'{texts[0]} {sign} {texts[1]}' if sign is not None else ', '.join(texts)
        if len(shown) == 1:
            return shown[0][1]
        return ', '.join(f'{_spoken(member)} {text}' for member, text in shown)

    def named(self, op: str, member: str, value: Value) -> str:
        """A value, or the name of the layer or image whose number it is."""
        if self.buffers is None or isinstance(value, (int, tuple)):
            return _value(value)
        index = int(value)
        if member == 'image' and index < len(self.buffers.images):
            return f'"{self.buffers.images[index].name}"'
        if member != 'layer':
            return _value(value)
        layers = self.buffers.attribute_layers
        if op in ('uv_tangent', 'normal_map'):
            layers = tuple(self.buffers.uv_layers[layer] for layer in self.buffers.tangent_layers)
        name = layers[index] if index < len(layers) else str(index)
        return f'"{name.lstrip(chr(1))}"' if name else 'the active UV map'

    def closure(self, name: str, mode: int, weight: Value, values: Sequence[Value], row: int) -> Cells:
        """One closure: a sign, node, what it is, with what; arguments that mean nothing are not told."""
        known = dict(zip(CLOSURE_ARGUMENTS[name], values, strict=True))
        hidden = set(TOLD_APART.get(name, ())) | {
            key for key, value in known.items() if key in OFF_AT_0 and _is_0(value)
        }
        for key, others in ONLY_WITH.items():
            if any(other in known and _is_0(known[other]) for other in others):
                hidden.add(key)
        if name == 'metallic':
            hidden |= {'base', 'edge'} if mode & 256 else {'ior', 'extinction'}
        shown = ', '.join(f'{_spoken(key)} {_value(value)}' for key, value in known.items() if key not in hidden)
        share = '' if weight == 1.0 or weight == (1.0, 1.0, 1.0) else f'{_value(weight)} × '
        return '+', self.closure_label(row), share + closure_words(name, mode), shown


def _is_program(found: object) -> bool:
    return isinstance(found, dict) and 'instructions' in found


def _referred(shader: Shader, ref: int, letter: str) -> Value:
    if ref >= 0:
        return ref
    row = shader.constants[~ref].tolist()
    return row[0] if letter == 'f' else tuple(row)


def _is_0(value: Value) -> bool:
    return not isinstance(value, int) and not any(value if isinstance(value, tuple) else (value,))


def _value(value: Value) -> str:
    return f'%{value}' if isinstance(value, int) else _constant(value)


def _constant(value: float | tuple[float, ...]) -> str:
    """A number; three are one where they are the same."""
    parts = value if isinstance(value, tuple) else (value,)
    if len(set(parts)) == 1:
        return f'{parts[0]:.4g}'
    return f'({" ".join(f"{part:.3g}" for part in parts)})'


def _spoken(member: str) -> str:
    return member.replace('_', ' ')


def _time(nanoseconds: float) -> str:
    number, unit = (nanoseconds / 1000.0, 'µs') if nanoseconds >= 1000.0 else (nanoseconds, 'ns')
    return f'{number:.{0 if number >= 10.0 else 1}f} {unit}'


def _count(number: int, noun: str, nouns: str = '') -> str:
    return f'{number} {noun if number == 1 else nouns or noun + "s"}'
