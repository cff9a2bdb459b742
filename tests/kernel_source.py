# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernel headers as text: which functions and records they declare, how records lie in memory, and GLSL to SPIR-V.

What the functions compute is compared elsewhere (kernel_parity.py); here nothing runs.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np

from native_build import BUILD, ROOT, included

KERNELS = ROOT / 'kernels'
# Every header is both languages', except the one that is C++'s side of the bargain. Bodies of stages (stage/) work on
# what a device keeps of a lane: they are compiled with each device alone.
HEADERS = sorted(
    path
    for path in KERNELS.rglob('*.h')
    if path.name != 'language_cpp.h' and path.parent.name not in ('program', 'stage')
)
STAGES = KERNELS / 'entry' / 'vulkan'  # stages of a Vulkan device, by name
# Ops of shading programs: what reads none of them does not include them.
PROGRAM_HEADERS = sorted((KERNELS / 'program').glob('*.h'))
EVERY_HEADER = [*HEADERS, *PROGRAM_HEADERS]

PRELUDE = """#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint KERNEL_FEATURES = 0xffffffffu;
"""

_COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/', re.DOTALL)
_STRUCT = re.compile(r'^(?:struct |RECORD\()(\w+)\)? \{(.*?)^\};', re.DOTALL | re.MULTILINE)
_FIELD = re.compile(r'(\w+)(?:\(\w+\))?\s+(\w+)(?:\[(\w+)\])?\s*;')
_RECORD = re.compile(r'^RECORD\((\w+)\)', re.MULTILINE)
_FUNCTION = re.compile(r'^FN\s+\w+\s+(\w+)\s*\(', re.MULTILINE)
# From the name to the next function, or to the end.
_DEFINITION = re.compile(r'^FN\s+\w+\s+(\w+)\s*\((.*?)(?=^FN\b|\Z)', re.DOTALL | re.MULTILINE)
_MEMBERS = re.compile(r'^#define LANE_STATE.*?^#undef BSDF_STATE\n', re.DOTALL | re.MULTILINE)
_STATE = re.compile(r'^(\w+)_STATE\(\w+, (\w+), (\w+), ', re.MULTILINE)
_REFERENCE = re.compile(r'^BUFFER_(?:REF|RW)\((\w+),\s*(\w+)\)', re.MULTILINE)
_CONSTANT = re.compile(r'^const uint (\w+) =\s+(\w+?)u;', re.MULTILINE)

_SCALARS = {'float': np.dtype('<f4'), 'uint': np.dtype('<u4'), 'int': np.dtype('<i4')}
_VECTORS = {'vec': 'float', 'uvec': 'uint', 'ivec': 'int'}


def include(path: Path) -> str:
    """The line that includes a header."""
    return f'#include "{path.relative_to(KERNELS).as_posix()}"\n'


@cache
def text(path: Path) -> str:
    """A header without its comments, and with the members that state.inc lists where they are declared."""
    return _MEMBERS.sub(_members(), _COMMENT.sub('', path.read_text()))


def _members() -> str:
    """What state.inc declares."""
    prefixes = {'LANE': '', 'PATH': 'path_', 'SHADOW': 'shadow_', 'BSDF': 'bsdf_'}
    listed = _STATE.findall(_COMMENT.sub('', (KERNELS / 'state.inc').read_text()))
    return ''.join(f'  {buffer} {prefixes[kind]}{name};\n' for kind, buffer, name in listed)


def functions(path: Path) -> list[str]:
    """Names of the functions that a header defines."""
    return _FUNCTION.findall(text(path))


def bodies(path: Path) -> dict[str, str]:
    """Text of each function that a header defines, by its name; those of one name together."""
    found: dict[str, str] = {}
    for name, body in _DEFINITION.findall(text(path)):
        found[name] = found.get(name, '') + body
    return found


@cache
def structs_of(path: Path) -> dict[str, list[tuple[str, str, int]]]:
    """Every record that a header declares: its fields as (type, name, number of elements), in order.

    What only C++ knows has functions for fields, and is no record.
    """
    return {
        name: [(kind, field, _count(count)) for kind, field, count in _FIELD.findall(body)]
        for name, body in _STRUCT.findall(text(path))
        if _FIELD.search(body)
    }


def _count(text: str) -> int:
    """Elements of an array, by number or by the name of a constant."""
    return constants()[text] if text and not text.isdecimal() else int(text or 1)


@cache
def structs() -> dict[str, list[tuple[str, str, int]]]:
    """Every record of the kernels."""
    return {name: fields for path in EVERY_HEADER for name, fields in structs_of(path).items()}


@cache
def references() -> dict[str, str]:
    """Buffer reference types by name, with the type of their elements."""
    return {name: element for path in EVERY_HEADER for element, name in _REFERENCE.findall(text(path))}


@cache
def records_by_address() -> set[str]:
    """Records that others hold, and functions hand on, by their address."""
    return {name for path in EVERY_HEADER for name in _RECORD.findall(text(path))}


@cache
def constants() -> dict[str, int]:
    """Integer constants of the headers, such as LIGHT_SPOT."""
    return {name: int(value, 0) for path in EVERY_HEADER for name, value in _CONSTANT.findall(text(path))}


def _layout(kind: str) -> tuple[np.dtype, int]:
    """The NumPy type of a kernel type, and its alignment: in scalar layout that of its largest component."""
    if kind in _SCALARS:
        return _SCALARS[kind], 4
    if kind[:-1] in _VECTORS:
        return np.dtype((_SCALARS[_VECTORS[kind[:-1]]], (int(kind[-1]),))), 4
    if kind in references() or kind == 'RECORD_REF':
        return np.dtype('<u8'), 8
    return record_dtype(tuple(structs()[kind]))


@cache
def record_dtype(fields: tuple[tuple[str, str, int], ...]) -> tuple[np.dtype, int]:
    """The NumPy type and alignment of a record with the given fields, by C's rules, which scalar layout shares."""
    names, formats, offsets, end, largest = [], [], [], 0, 1
    for kind, name, count in fields:
        dtype, alignment = _layout(kind)
        end = -(-end // alignment) * alignment
        names.append(name)
        formats.append(dtype if count == 1 else (dtype, (count,)))
        offsets.append(end)
        end += dtype.itemsize * count
        largest = max(largest, alignment)
    size = -(-end // largest) * largest
    return np.dtype({'names': names, 'formats': formats, 'offsets': offsets, 'itemsize': size}), largest


def dtype_of(kind: str) -> np.dtype:
    """The NumPy type of a kernel type: `dtype_of('Light')`, `dtype_of('vec3')`."""
    return _layout(kind)[0]


def tool(name: str) -> str:
    """A program of the environment's wheels (glslang, spirv-val, spirv-dis)."""
    path = shutil.which(name, path=str(Path(sys.executable).parent))
    assert path, f'{name} is not in the environment: run ./scripts/setup test'
    return path


def run_tool(*command: str) -> str:
    """Runs a tool and returns what it printed; its complaints are the failure's message."""
    result = subprocess.run([tool(command[0]), *command[1:]], capture_output=True, text=True)
    assert result.returncode == 0, f'{" ".join(command)}\n{result.stdout}{result.stderr}'
    return result.stdout


def compile_glsl(name: str, body: str) -> Path:
    """Compiles PRELUDE + body (which includes kernel headers and has a `main`) to valid SPIR-V 1.5; kept by content."""
    folder = BUILD / 'spirv'
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / f'{name}.comp'
    source.write_text(PRELUDE + body)
    digest = hashlib.sha256()
    for path, content in sorted(included(source).items()):
        digest.update(str(path).encode() + b'\0' + content)
    target = folder / f'{name}-{digest.hexdigest()[:16]}.spv'
    if not target.exists():
        for stale in folder.glob(f'{name}-{"[0-9a-f]" * 16}.spv'):
            stale.unlink(missing_ok=True)
        partial = target.with_suffix('.partial')
        run_tool('glslang', '-V', '--target-env', 'vulkan1.2', f'-I{KERNELS}', '-o', str(partial), str(source))
        run_tool('spirv-val', '--target-env', 'vulkan1.2', '--scalar-block-layout', str(partial))
        partial.replace(target)
    return target
