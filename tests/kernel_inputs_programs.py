# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of surfaces for the small scene of kernel_inputs.py, one for each kind of closure, written by hand.

How trees of nodes become programs is native/program_compile.cpp's, and tested with it.
"""

from __future__ import annotations

import cotorra_native
import numpy as np

from kernel_parity import Scene
from kernel_source import constants, dtype_of

# Kinds of closures that are drawn from; each has a program, in this order.
KINDS = tuple(name for name in cotorra_native.shader_closures() if name != 'emission')
# What of the ops the programs use; a shader that runs no others leaves the rest out.
GROUPS = ('GROUP_PROGRAM', 'GROUP_SURFACES', 'GROUP_EMISSIONS', 'GROUP_MATH', 'GROUP_VECTOR')
GROUPS += ('GROUP_COORDINATES', 'GROUP_POINT')

SIN = 14  # mode of the op math
UNIT = 1 << 16  # and its bit: the result is clamped to 0 ... 1


def number(name: str) -> int:
    return cotorra_native.shader_ops()[name][0]


class _Code:
    """Words of programs, and the numbers that they refer to; one set of registers for each program."""

    def __init__(self) -> None:
        self.words: list[int] = []
        self.numbers: list[float] = []
        self.registers = 0

    def constant(self, *values: float) -> int:
        known = constants()
        self.numbers += values
        vector = known['REFERENCE_VECTOR'] if len(values) == 3 else 0
        return known['REFERENCE_CONSTANT'] | vector | (len(self.numbers) - len(values))

    def op(self, name: str, mode: int, *references: int) -> int:
        """Writes an instruction and returns the reference to its result."""
        known = constants()
        op, result, arguments = cotorra_native.shader_ops()[name]
        assert len(references) == len(arguments)
        vector, place = result == 'v', self.registers
        self.registers += 3 if vector else 1
        head = op | (known['PROGRAM_VECTOR'] if vector else 0) | len(references) << known['PROGRAM_COUNT_SHIFT']
        self.words += [head | place << known['PROGRAM_RESULT_SHIFT'], mode, *references]
        return place | (known['REFERENCE_VECTOR'] if vector else 0)


def add_programs(scene: Scene) -> int:
    """Appends a material for each of KINDS, whose closure varies from point to point; returns the first.

    Each is drawn half of the time, beside a diffuse closure.
    """
    known, rng = constants(), np.random.default_rng(5)
    code = _Code()
    first = len(scene.arrays['materials'])
    materials = np.zeros(len(KINDS), dtype_of('Material'))
    materials['flags'] = known['MATERIAL_PROGRAM'] | known['MATERIAL_DIFFUSE'] | known['MATERIAL_SPECULAR']
    materials['alpha'] = 1.0
    programs = np.zeros(len(KINDS), dtype_of('MaterialProgram'))
    rows = np.zeros(2 * len(KINDS), dtype_of('ClosureRow'))
    for k, name in enumerate(KINDS):
        kind, arguments = cotorra_native.shader_closures()[name]
        code.registers = 0
        begin = len(code.words)
        # A number of 0 ... 1 and a colour that follow the position, and the surface's normal.
        x = code.op('component', 0, code.op('position', 0))
        wave = code.op('math', SIN | UNIT, x, code.constant(0.0), code.constant(0.0))
        share = code.op('mix_f', 0, wave, code.constant(0.2), code.constant(0.8))
        color = code.op('combine', 0, share, wave, code.constant(0.5))
        normal = code.op('normal', 0)
        end = len(code.words)
        references = [color if a == 'v' else share for a in arguments]
        # All but the first vectors of a closure without layers are its normal and tangent.
        for place, a in enumerate(arguments):
            if name == 'principled':
                if place in (known['PRINCIPLED_NORMAL'], known['PRINCIPLED_COAT_NORMAL']):
                    references[place] = normal
                elif place in (known['PRINCIPLED_IOR'], known['PRINCIPLED_COAT_IOR'], known['PRINCIPLED_FILM_IOR']):
                    references[place] = code.constant(rng.uniform(1.2, 1.8))
            elif a == 'v' and place >= (4 if name == 'metallic' else 1):
                references[place] = normal
            elif a == 'f' and place >= 2 and name in ('glass', 'refraction'):
                references[place] = code.constant(1.45)
        programs['surface'][k] = begin, end, 2 * k, 2
        rows[2 * k] = kind, 0, color, len(code.words)
        code.words += references
        rows[2 * k + 1] = known['CLOSURE_DIFFUSE'], 0, code.constant(0.5, 0.4, 0.3), len(code.words)
        code.words += [color, code.constant(0.0), normal]
    for part in ('emission', 'transparency'):
        programs[part] = programs['surface']
        programs[part]['closures'] = 0
        programs[part]['result'] = color  # the same registers in all

    arrays = scene.arrays
    arrays['materials'] = np.concatenate([arrays['materials'], materials])
    arrays['models'] = np.concatenate([arrays['models'], np.zeros(len(KINDS), arrays['models'].dtype)])
    arrays['programs'] = np.concatenate([arrays['programs'], programs])
    arrays['program_code'] = np.array(code.words, np.uint32)
    arrays['program_closures'] = rows
    arrays['program_constants'] = np.array(code.numbers, np.float32)
    infos = np.zeros(len(arrays['instances']), dtype_of('InstanceInfo'))
    infos['location'], infos['color'] = rng.normal(size=(2, len(infos), 3))
    infos['alpha'], infos['random'] = rng.random((2, len(infos)))
    arrays['instance_infos'] = infos
    scene.data['camera_window'] = -0.5, -0.5, 1.0, 1.0
    for name in 'xyz':
        scene.data['camera_space'][name] = rng.normal(size=4)
    return first
