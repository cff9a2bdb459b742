# SPDX-License-Identifier: GPL-3.0-or-later
"""A shader as text, as it was read: ops with the nodes they came from, and the closures that are summed.

What is left after folding, and what it costs, the native module tells.
"""

from __future__ import annotations

import numpy as np

from ..export.buffers import Shader
from .ops import Op, Tables, tables
from .reader import enum_numbers
from .tree import SHIFT_BIT

# Modes that are the operation of a node, and the bits that are.
OPERATIONS = {
    'math': ('ShaderNodeMath', 'operation', 0xFFFF),
    'vector_math_v': ('ShaderNodeVectorMath', 'operation', 0xFFFF),
    'vector_math_f': ('ShaderNodeVectorMath', 'operation', 0xFFFF),
    'mix_color': ('ShaderNodeMix', 'blend_type', 0xFF),
    'mapping': ('ShaderNodeMapping', 'vector_type', 0xFF),
    'map_range_f': ('ShaderNodeMapRange', 'interpolation_type', 0xFF),
    'map_range_v': ('ShaderNodeMapRange', 'interpolation_type', 0xFF),
    'gradient_f': ('ShaderNodeTexGradient', 'gradient_type', 0xFF),
}
LAYERS = frozenset(('attribute', 'attribute_alpha', 'attribute_fac'))

CLOSURE_ARGUMENTS = {
    'emission': ('color',),
    'transparent': ('color',),
    'holdout': (),
    'diffuse': ('color', 'roughness', 'normal'),
    'translucent': ('color', 'normal'),
    'glossy': ('color', 'roughness', 'anisotropy', 'rotation', 'normal', 'tangent'),
    'metallic': (
        *('base', 'edge', 'ior', 'extinction', 'roughness', 'anisotropy', 'rotation', 'normal', 'tangent'),
        *('film_thickness', 'film_ior'),
    ),
    'glass': ('color', 'roughness', 'ior', 'normal', 'film_thickness', 'film_ior'),
    'refraction': ('color', 'roughness', 'ior', 'normal'),
    'sheen': ('color', 'roughness', 'normal'),
    'toon': ('color', 'size', 'smooth', 'normal'),
    'principled': (
        *('base', 'metallic', 'roughness', 'ior', 'normal', 'diffuse_roughness', 'subsurface', 'subsurface_radius'),
        *('subsurface_scale', 'subsurface_ior', 'subsurface_anisotropy', 'specular_level', 'specular_tint'),
        *('anisotropic', 'rotation', 'tangent', 'transmission', 'coat', 'coat_roughness', 'coat_ior', 'coat_tint'),
        *('coat_normal', 'sheen', 'sheen_roughness', 'sheen_tint', 'emission', 'film_thickness', 'film_ior'),
        *('thin_wall', 'alpha'),
    ),
}


def explain(shader: Shader, layers: tuple[str, ...] = (), ops: Tables | None = None) -> str:
    """The shader in lines of text. layers: `SceneBuffers.attribute_layers`. ops: the native module's, if not given."""
    known = ops or tables()
    by_number = {op.number: (name, op) for name, op in known.ops.items()}
    kinds = {kind.number: (name, kind) for name, kind in known.closures.items()}
    lines = [f'{shader.name}: {_count(len(shader.ops), "op")}, {_count(len(shader.closures), "closure")}']
    at = 0
    for index, (number, mode, label) in enumerate(
        zip(shader.ops.tolist(), shader.modes.tolist(), shader.labels, strict=True)
    ):
        name, op = by_number[number]
        end = at + len(op.arguments)
        text = f'{name}{_mode(name, mode)}{_arguments(shader, op, name, shader.args[at:end], layers)}'
        lines.append(f'  {_name(index)} = {text:<60} {label}'.rstrip())
        at = end
    for row in shader.closures:
        name, kind = kinds[int(row['kind'])]
        first = int(row['first_arg'])
        refs = shader.closure_args[first : first + len(kind.arguments)].tolist()
        values = [_value(shader, ref, letter) for ref, letter in zip(refs, kind.arguments, strict=True)]
        named = [f'{arg} {value}' for arg, value in zip(CLOSURE_ARGUMENTS[name], values, strict=True)]
        mode = f' (mode {row["mode"]})' if row['mode'] else ''
        lines.append(f'  + {_value(shader, int(row["weight"]), "v")} x {name}{mode}: {", ".join(named)}'.rstrip(': '))
    return '\n'.join(lines)


def _count(number: int, noun: str) -> str:
    return f'{number} {noun}{"" if number == 1 else "s"}'


def _name(index: int) -> str:
    return f'%{index}'


def _arguments(shader: Shader, op: Op, name: str, refs: np.ndarray, layers: tuple[str, ...]) -> str:
    values = [_value(shader, ref, letter) for ref, letter in zip(refs.tolist(), op.arguments, strict=True)]
    if name in LAYERS and layers and refs[0] < 0:
        layer = layers[int(shader.constants[~refs[0]][0])]
        values[0] = repr(layer.lstrip('\x01')) if layer else 'the active UV map'
    return f'({", ".join(values)})'


def _value(shader: Shader, ref: int, letter: str) -> str:
    if ref >= 0:
        return _name(ref)
    row = shader.constants[~ref].tolist()
    if letter == 'f' or row[0] == row[1] == row[2]:
        return f'{row[0]:.6g}'
    return '[' + ' '.join(f'{part:.6g}' for part in row) + ']'


def _mode(name: str, mode: int) -> str:
    shift, mode = mode >> SHIFT_BIT, mode & ((1 << SHIFT_BIT) - 1)
    aside = ''
    if shift:
        width = float(np.array(mode & 0xFFFF, np.uint16).view(np.float16))
        aside, mode = f' {width:.3g} {" xy"[shift]} aside', mode & ~0xFFFF
    if name in OPERATIONS:
        kind, member, mask = OPERATIONS[name]
        words = {number: word.lower() for word, number in enum_numbers(kind, member).items()}
        rest = f' +{mode & ~mask:#x}' if mode & ~mask else ''
        return f'.{words.get(mode & mask, mode)}{rest}{aside}'
    return f'.{mode}{aside}' if mode else aside
