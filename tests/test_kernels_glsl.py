# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kernel header is GLSL too, and its records lie in memory alike in both languages.

That both languages also compute the same is tests/test_kernels_lavapipe.py's.
"""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest

import kernel_source as kernels
from native_build import BUILD, build

STEM = pytest.mark.parametrize('header', kernels.EVERY_HEADER, ids=lambda path: path.stem)


@STEM
def test_header_compiles_as_glsl(header: Path) -> None:
    kernels.compile_glsl(f'header_{header.stem}', f'{kernels.include(header)}void main() {{}}\n')


def cpp_source(header: Path, purpose: str, code: str = '') -> Path:
    """Writes a C++ file that includes one header with every feature on."""
    source = BUILD / f'{purpose}_{header.stem}.cpp'
    source.parent.mkdir(parents=True, exist_ok=True)
    features = 'namespace cotorra { constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu; }'
    source.write_text(f'#include <cstddef>\n#include <cstdint>\n{features}\n{kernels.include(header)}{code}')
    return source


@STEM
def test_header_compiles_alone_as_cpp(header: Path) -> None:
    build(f'header_{header.stem}', [cpp_source(header, 'header')])


def spirv_layout(header: Path, name: str) -> dict[str, int]:
    """Offsets by field of a record in a scalar-layout buffer, and its size under '', from what glslang makes."""
    if name in kernels.records_by_address():
        # Its size is the step from one to the next.
        body = f'{kernels.include(header)}layout(set = 0, binding = 0, scalar) buffer Probe {{ {name} probe; }};\n'
        body += 'void main() { probe = probe + 1; }\n'
        listing = kernels.run_tool('spirv-dis', '--raw-id', str(kernels.compile_glsl(f'layout_{name}', body)))
        (record,) = re.findall(rf'OpName (%\d+) "{name}"', listing)
        (step,) = re.findall(r'OpIAdd %\d+ %\d+ (%\d+)', listing)
        (stride,) = re.findall(rf'{step} = OpConstant %\d+ (\d+)', listing)
    else:
        # In a runtime array the record's size stands in SPIR-V too, as the array's stride.
        body = f'{kernels.include(header)}layout(set = 0, binding = 0, scalar) buffer Probe {{ {name} probe[]; }};\n'
        body += f'void main() {{ {name} copy = probe[0]; probe[1] = copy; }}\n'
        listing = kernels.run_tool('spirv-dis', '--raw-id', str(kernels.compile_glsl(f'layout_{name}', body)))
        (variable,) = re.findall(r'OpMemberName (%\d+) 0 "probe"', listing)
        (array,) = re.findall(rf'{variable} = OpTypeStruct (%\d+)', listing)
        (record,) = re.findall(rf'{array} = OpTypeRuntimeArray (%\d+)', listing)
        (stride,) = re.findall(rf'OpDecorate {array} ArrayStride (\d+)', listing)
    names = dict(re.findall(rf'OpMemberName {record} (\d+) "(\w+)"', listing))
    offsets = dict(re.findall(rf'OpMemberDecorate {record} (\d+) Offset (\d+)', listing))
    return {names[index]: int(offset) for index, offset in offsets.items()} | {'': int(stride)}


def cpp_layouts(header: Path) -> dict[str, dict[str, int]]:
    """Offsets by field of a header's records, and their sizes under '', as the C++ compiler has them."""
    records = kernels.structs_of(header)
    entries = [(name, field) for name, fields in records.items() for _, field, _ in fields]
    source = cpp_source(
        header,
        'layout',
        f'extern "C" const std::size_t offsets[] = '
        f'{{{", ".join(f"offsetof(cotorra::{name}, {field})" for name, field in entries)}}};\n'
        f'extern "C" const std::size_t sizes[] = {{{", ".join(f"sizeof(cotorra::{name})" for name in records)}}};\n',
    )
    library = build(source.stem, [source])
    result: dict[str, dict[str, int]] = {name: {} for name in records}
    for (name, field), offset in zip(entries, (ctypes.c_size_t * len(entries)).in_dll(library, 'offsets'), strict=True):
        result[name][field] = offset
    for name, size in zip(result, (ctypes.c_size_t * len(result)).in_dll(library, 'sizes'), strict=True):
        result[name][''] = size
    return result


@pytest.mark.parametrize(
    'header', [path for path in kernels.EVERY_HEADER if kernels.structs_of(path)], ids=lambda path: path.stem
)
def test_record_layouts(header: Path) -> None:
    for name, layout in cpp_layouts(header).items():
        assert spirv_layout(header, name) == layout, f'GLSL (left) and C++ (right) disagree about {name}'
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
