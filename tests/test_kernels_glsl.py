# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kernel header is GLSL too, and its records lie in memory alike in both languages.

That both languages also compute the same is tests/test_kernels_lavapipe.py's.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import kernel_source as kernels
from native_build import BUILD, build, build_objects

STEM = pytest.mark.parametrize('header', kernels.EVERY_HEADER, ids=lambda path: path.stem)


@STEM
def test_header_compiles_as_glsl(header: Path) -> None:
    kernels.compile_glsl(f'header_{header.stem}', f'{kernels.include(header)}void main() {{}}\n')


def cpp_source(name: str, code: str) -> Path:
    """Writes a C++ file for code that needs every feature on."""
    source = BUILD / f'{name}.cpp'
    source.parent.mkdir(parents=True, exist_ok=True)
    features = 'namespace cotorra { constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu; }'
    source.write_text(f'#include <cstddef>\n#include <cstdint>\n{features}\n{code}')
    return source


@pytest.mark.every(4)  # that it includes what it needs is seen in GLSL; all of them are compiled together elsewhere
@STEM
def test_header_compiles_alone_as_cpp(header: Path) -> None:
    source = cpp_source(f'header_{header.stem}', kernels.include(header))
    build_objects('headers', [source], ('-O0', '-g0'))


RECORDS = {header: list(kernels.structs_of(header)) for header in kernels.EVERY_HEADER if kernels.structs_of(header)}


@pytest.fixture(scope='module')
def spirv_layouts() -> dict[str, dict[str, int]]:
    """Offsets by field of each record in scalar-layout buffers, and its size under '', as glslang has them."""
    body, main = ''.join(map(kernels.include, RECORDS)), ''
    names = [name for listed in RECORDS.values() for name in listed]
    for i, name in enumerate(names):
        by_address = name in kernels.records_by_address()
        # In a runtime array the record's size stands in SPIR-V too, as the array's stride; that of a record which is
        # handed on by its address is the step from one to the next.
        array = '' if by_address else '[]'
        body += f'layout(set = 0, binding = {i}, scalar) buffer Probe{i} {{ {name} probe{i}{array}; }};\n'
        main += f'probe{i} = probe{i} + 1;' if by_address else f'{name} copy{i} = probe{i}[0]; probe{i}[1] = copy{i};'
    spirv = kernels.compile_glsl('layouts', f'{body}void main() {{ {main} }}\n')
    listing = kernels.run_tool('spirv-dis', '--raw-id', str(spirv))
    steps = iter(re.findall(r'OpIAdd %\d+ %\d+ (%\d+)', listing))
    return {name: _layout_in(listing, i, name, steps) for i, name in enumerate(names)}


def _layout_in(listing: str, index: int, name: str, steps: Iterator[str]) -> dict[str, int]:
    """The layout of the record in buffer `index` of a disassembled module."""
    if name in kernels.records_by_address():
        (record,) = re.findall(rf'OpName (%\d+) "{name}"', listing)
        (stride,) = re.findall(rf'{next(steps)} = OpConstant %\d+ (\d+)', listing)
    else:
        (variable,) = re.findall(rf'OpMemberName (%\d+) 0 "probe{index}"', listing)
        (array,) = re.findall(rf'{variable} = OpTypeStruct (%\d+)', listing)
        (record,) = re.findall(rf'{array} = OpTypeRuntimeArray (%\d+)', listing)
        (stride,) = re.findall(rf'OpDecorate {array} ArrayStride (\d+)', listing)
    names = dict(re.findall(rf'OpMemberName {record} (\d+) "(\w+)"', listing))
    offsets = dict(re.findall(rf'OpMemberDecorate {record} (\d+) Offset (\d+)', listing))
    return {names[place]: int(offset) for place, offset in offsets.items()} | {'': int(stride)}


@pytest.fixture(scope='module')
def cpp_layouts() -> dict[str, dict[str, int]]:
    """Offsets by field of each record, and its size under '', as the C++ compiler has them."""
    fields = [(name, field) for name, listed in kernels.structs().items() for _, field, _ in listed]
    offsets = ', '.join(f'offsetof(cotorra::{name}, {field})' for name, field in fields)
    sizes = ', '.join(f'sizeof(cotorra::{name})' for name in kernels.structs())
    code = ''.join(map(kernels.include, RECORDS))
    code += f'extern "C" const std::size_t offsets[] = {{{offsets}}};\n'
    code += f'extern "C" const std::size_t sizes[] = {{{sizes}}};\n'
    library = build('layouts', [cpp_source('layouts', code)], ('-O0', '-g0'))
    result: dict[str, dict[str, int]] = {name: {} for name in kernels.structs()}
    for (name, field), offset in zip(fields, (ctypes.c_size_t * len(fields)).in_dll(library, 'offsets'), strict=True):
        result[name][field] = offset
    for name, size in zip(result, (ctypes.c_size_t * len(result)).in_dll(library, 'sizes'), strict=True):
        result[name][''] = size
    return result


@pytest.mark.parametrize('header', RECORDS, ids=lambda path: path.stem)
def test_record_layouts(
    header: Path, spirv_layouts: dict[str, dict[str, int]], cpp_layouts: dict[str, dict[str, int]]
) -> None:
    for name in RECORDS[header]:
        in_spirv, layout = spirv_layouts[name], cpp_layouts[name]
        assert in_spirv == layout, f'GLSL (left) and C++ (right) disagree about {name}'
        dtype = kernels.dtype_of(name)
        assert {field: dtype.fields[field][1] for field in dtype.names} | {'': dtype.itemsize} == layout


def test_vectors_have_no_padding() -> None:
    assert kernels.dtype_of('vec3') == np.dtype(('<f4', (3,)))
    assert set(kernels.references()) >= {'FloatBuffer', 'LightBuffer'}, 'the parser lost the buffer references'


STATE = (kernels.KERNELS / 'state.inc').read_text()


@pytest.mark.parametrize('kind, record', [('PATH', 'PathState'), ('SHADOW', 'ShadowRay'), ('BSDF', 'Bsdf')])
def test_state_lists_every_member(kind: str, record: str) -> None:
    """What the list left out a later stage would read from nowhere. A Bsdf's normal is the surface's."""
    members = {field for _, field, _ in kernels.structs()[record]} - {'unused', 'unused2'}
    listed = re.findall(rf'^{kind}_STATE\(\w+, \w+, (\w+),', STATE, re.MULTILINE)
    assert sorted(listed) == sorted(members - ({'n'} if kind == 'BSDF' else set()))


def test_lobes_take_the_place_of_a_bsdf() -> None:
    """Each member has a place of its type for itself, beside what a Bsdf tells of a lobe as well."""
    places = dict(re.findall(r'^LOBE_STATE\((\w+), (\w+)\)', STATE, re.MULTILINE))
    lobe, bsdf = ({field: kind for kind, field, _ in kernels.structs()[name]} for name in ('Lobe', 'Bsdf'))
    assert places.keys() == lobe.keys() - {'kind', 'mode'}
    assert {member: bsdf[place] for member, place in places.items()} == {name: lobe[name] for name in places}
    assert len(set(places.values())) == len(places) and not {'n', 'n_smooth', 'lobes'} & set(places.values())
