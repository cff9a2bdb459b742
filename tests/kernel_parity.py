# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one piece of kernel code, written once, as C++ on the CPU and as GLSL on a Vulkan device, over the same inputs.

What is run, and how far results may differ, is the table of kernel_cases.py.
"""

from __future__ import annotations

import ctypes
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

import kernel_source as kernels
from native_build import BUILD, build
from spirv_calls import specialized
from vulkan import Buffer, Runner

COUNT = 16384
ALL_FEATURES = 0xFFFFFFFF
Draw = Callable[[np.random.Generator, int], np.ndarray]


@dataclass(frozen=True)
class Tolerance:
    """How far a float may differ, and why it must.

    ulp:      units in the last place of a vector's largest component; or else
    absolute: an amount that is allowed anyway.
    typical:  ULP that 99 of 100 inputs keep, where the bound above is for rare ones.
    """

    ulp: int
    reason: str
    absolute: float = 0.0
    typical: float = np.inf


EXACT = Tolerance(0, 'integers, + - * / and sqrt are rounded alike on both')


@dataclass(frozen=True)
class Case:
    """A row of the table.

    body:      statements in the kernels' common language. Inputs are there under their names as constants, outputs as
               variables to assign, `scene` where asked for.
    inputs:    name -> (kernel type, how to draw n values of it).
    outputs:   name -> kernel type; flags are written as uint.
    program:   the body calls ops of shading programs.
    groups:    names of the groups of ops (program/ops.h) that the body's programs need; the shader has no others.
    ops:       names of ops that the body calls by their numbers.
    tolerance: of all float outputs; `tolerances` names those that differ from it.
    """

    name: str
    body: str
    inputs: dict[str, tuple[str, Draw]]
    outputs: dict[str, str]
    tolerance: Tolerance = EXACT
    tolerances: dict[str, Tolerance] = field(default_factory=dict)
    scene: bool = False
    program: bool = False
    groups: tuple[str, ...] = ()
    ops: tuple[str, ...] = ()

    def record(self, fields: Sequence[tuple[str, str]]) -> np.dtype:
        return kernels.record_dtype(tuple((kind, name, 1) for kind, name in fields))[0]

    @property
    def input_fields(self) -> list[tuple[str, str]]:
        return [(kind, name) for name, (kind, _) in self.inputs.items()]

    @property
    def output_fields(self) -> list[tuple[str, str]]:
        return [(kind, name) for name, kind in self.outputs.items()]

    def draw(self, count: int = COUNT) -> np.ndarray:
        """Inputs by a seed that belongs to the name, so that no row changes another's."""
        rng = np.random.default_rng(zlib.crc32(self.name.encode()))
        values = np.zeros(count, self.record(self.input_fields))
        for name, (_, draw) in self.inputs.items():
            values[name] = draw(rng, count)
        return values


@dataclass
class Scene:
    """A SceneData with everything that it refers to: `arrays` by name of the reference in SceneData or in a mesh.

    nested: arrays of records that themselves hold references: name -> [(index, field, array)].
    """

    data: np.ndarray
    arrays: dict[str, np.ndarray]
    nested: dict[str, list[tuple[int, str, np.ndarray]]]

    def place(self, put: Callable[[np.ndarray], int], count: int) -> int:
        """Puts every array where `put` says and returns the address of `count` SceneData that refer to them."""
        data = self.data.copy()
        for name, array in self.arrays.items():
            array = array.copy()
            for index, member, target in self.nested.get(name, ()):
                array[member][index] = put(target)
            data[name] = put(array)
        return put(np.repeat(data, count))  # a case may change its own


# ---- Source text

_INCLUDES = ''.join(kernels.include(header) for header in kernels.HEADERS)
_PROGRAM_INCLUDES = ''.join(kernels.include(header) for header in kernels.PROGRAM_HEADERS)


def _struct(name: str, fields: Sequence[tuple[str, str]]) -> str:
    return f'struct {name} {{ {" ".join(f"{kind} {field};" for kind, field in fields)} }};\n'


def _body(case: Case, index: str, scene: str) -> str:
    """The part that both languages share: unpack, run, pack."""
    lines = [f'  {kind} {name} = LOAD(case_in, {index}).{name};' for kind, name in case.input_fields]
    lines += [f'  {kind} {name};' for kind, name in case.output_fields]
    if case.scene:
        lines.append(f'  {scene};')
    lines.append(f'  {case.body}')
    lines += [f'  case_out.v[{index}].{name} = {name};' for _, name in case.output_fields]
    return '\n'.join(lines) + '\n'


def glsl(case: Case) -> str:
    """The compute shader of a case."""
    layout = 'layout(buffer_reference, scalar, buffer_reference_align = 8)'
    headers = _INCLUDES + (_PROGRAM_INCLUDES if case.program else '')
    choice = ''
    if case.groups or not case.program:  # drivers take minutes to compile every op where none is run
        mask = sum(kernels.constants()[group] for group in case.groups)
        choice = (
            f'#define PROGRAM_GROUP(BIT) (((BIT) & {mask:#x}u) != 0u)\n#define PROGRAM_VARIANT(BIT) ((BIT) != 0u)\n'
        )
    return (
        f'{choice}{headers}{_struct("CaseIn", case.input_fields)}{_struct("CaseOut", case.output_fields)}'
        'BUFFER_REF(CaseIn, CaseInBuffer)\n'
        f'{layout} writeonly buffer CaseOutBuffer {{ CaseOut v[]; }};\n'
        'layout(push_constant, scalar) uniform Push {\n'
        '  CaseInBuffer case_in; CaseOutBuffer case_out; SceneData scenes; uint case_count;\n};\n'
        'void main() {\n  if (gl_GlobalInvocationID.x >= case_count) return;\n'
        f'{_body(case, "gl_GlobalInvocationID.x", "SceneData scene = scenes + int(gl_GlobalInvocationID.x)")}}}\n'
    )


def cpp(cases: Sequence[Case], features: int) -> str:
    """One C++ library for all cases, a function of C's each, with the features that are given compiled in."""
    parts = [
        '#include <cstdint>\n',
        f'namespace cotorra {{ constexpr std::uint32_t KERNEL_FEATURES = {features:#x}u; }}\n',
        _INCLUDES,
        _PROGRAM_INCLUDES,
        'namespace cotorra {\n',
    ]
    for case in cases:
        body = _body(case, 'case_i', 'SceneData scene = scenes[case_i]')
        parts.append(
            f'namespace {case.name}_case {{\n'
            f'{_struct("CaseIn", case.input_fields)}{_struct("CaseOut", case.output_fields)}'
            'BUFFER_REF(CaseIn, CaseInBuffer)\n'
            'struct CaseOutBuffer { CaseOut *v; };\n'
            f'extern "C" void {case.name}_run(CaseInBuffer case_in, CaseOutBuffer case_out,\n'
            '    [[maybe_unused]] const SceneData *scenes, uint case_count) {\n'
            f'for (uint case_i = 0u; case_i < case_count; ++case_i) {{\n{body}}}\n}}\n}}\n'
        )
    return ''.join(parts) + '}\n'


# ---- Running


def build_cpu(cases: Sequence[Case], features: int) -> ctypes.CDLL:
    """The library of all cases for the CPU."""
    name = f'kernel_cases_{features:x}'
    source = BUILD / f'{name}.cpp'
    source.parent.mkdir(parents=True, exist_ok=True)
    source.write_text(cpp(cases, features))
    # Some outputs stay unset in branches that their flag output tells of; the comparison reads them as given.
    return build(name, [source], ['-O1', '-g0', '-Wno-maybe-uninitialized'])


def run_cpu(library: ctypes.CDLL, case: Case, inputs: np.ndarray, scene: Scene) -> np.ndarray:
    """The outputs of a case on the CPU, a record for each input."""
    kept: list[np.ndarray] = []

    def put(array: np.ndarray) -> int:
        kept.append(np.ascontiguousarray(array))
        return kept[-1].ctypes.data

    outputs = np.zeros(len(inputs), case.record(case.output_fields))
    pointers = [
        ctypes.c_void_p(put(inputs)),
        ctypes.c_void_p(outputs.ctypes.data),
        ctypes.c_void_p(scene.place(put, len(inputs))),
    ]
    getattr(library, f'{case.name}_run')(*pointers, ctypes.c_uint32(len(inputs)))
    return outputs


def run_vulkan(runner: Runner, case: Case, inputs: np.ndarray, scene: Scene, features: int) -> np.ndarray:
    """The outputs of a case on the Vulkan device; the features are a specialization constant of its shader.

    It is set, and functions that nothing calls are taken out, before the driver sees the shader, as the device does it
    with its stages: of a row that calls one function of all headers, that is most.
    """
    kept: list[Buffer] = []

    def put(array: np.ndarray) -> int:
        kept.append(runner.upload(array))
        return kept[-1].address

    dtype = case.record(case.output_fields)
    input_address = put(inputs)
    output_address = put(np.zeros(len(inputs), dtype))
    output = kept[-1]
    spirv = kernels.compile_glsl(f'case_{case.name}', glsl(case))
    code = specialized(np.fromfile(spirv, np.uint32), features)
    runner.run(case.name, code, [input_address, output_address, scene.place(put, len(inputs))], len(inputs))
    return output.data.view(dtype).copy()


# ---- Comparing


def leaves(dtype: np.dtype) -> list[tuple[str, ...]]:
    """Paths to the members of a record type that are no records themselves."""
    result: list[tuple[str, ...]] = []
    for name in dtype.names:
        inner = dtype.fields[name][0]
        result += [(name, *path) for path in leaves(inner)] if inner.names else [(name,)]
    return result


def distance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How far each value or vector of `a` is from that of `b`, in units in the last place of its largest component."""
    a, b = a.reshape(len(a), -1).astype(np.float64), b.reshape(len(b), -1).astype(np.float64)
    largest = np.maximum(np.abs(a), np.abs(b)).max(axis=1).astype(np.float32)
    return np.abs(a - b).max(axis=1) / np.spacing(np.maximum(largest, np.finfo(np.float32).tiny))


def differences(case: Case, inputs: np.ndarray, cpu: np.ndarray, gpu: np.ndarray) -> list[str]:
    """What differs by more than the case allows, the worst of each output, in words."""
    found = []
    for path in leaves(cpu.dtype):
        a, b = cpu, gpu
        for name in path:
            a, b = a[name], b[name]
        label = '.'.join(path)
        allowed = case.tolerances.get(label, case.tolerance)
        if a.dtype.kind == 'f':
            finite = (np.isfinite(a) & np.isfinite(b)).reshape(len(a), -1).all(axis=1)
            if not finite.all():
                bad = int(finite.argmin())
                found.append(f'{label} is not finite: CPU {a[bad]}, Vulkan {b[bad]}, input {bad} {inputs[bad]}')
                continue
            far = distance(a, b)
            if (common := np.quantile(far, 0.99)) > allowed.typical:
                found.append(f'{label}: 99 of 100 differ by up to {common:.0f} ULP; {allowed.typical:g} are allowed')
            wrong = (far > allowed.ulp) & (
                np.abs(a.astype(np.float64) - b).reshape(len(a), -1).max(axis=1) > allowed.absolute
            )
        else:
            far = (a != b).reshape(len(a), -1).any(axis=1).astype(np.float64)
            wrong = far > 0
        if wrong.any():
            worst = int(np.where(wrong, far, -1.0).argmax())
            found.append(
                f'{label}: {int(wrong.sum())} of {len(a)} differ, at worst by {far[worst]:.0f} ULP ({allowed.ulp} and '
                f'{allowed.absolute:g} absolute are allowed): CPU {a[worst]}, Vulkan {b[worst]}, '
                f'input {worst} {inputs[worst]}'
            )
    return found
