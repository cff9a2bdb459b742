# SPDX-License-Identifier: GPL-3.0-or-later
"""The device's specializer of SPIR-V (native/spirv_specialize.h) as a NumPy function.

That what it makes is right is test_spirv_specialize.py's.
"""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np

from native_build import build


@cache
def _library() -> ctypes.CDLL:
    made = build('spirv_specialize', ['tests/native/spirv_specialize_calls.cpp', 'native/spirv_specialize.cpp'])
    made.specialize.restype = ctypes.c_size_t
    made.specialize_error.restype = ctypes.c_char_p
    return made


def specialized(code: np.ndarray, *constants: int) -> np.ndarray:
    """The module with its constants set, words each. Raises RuntimeError with what native code says."""
    values, out = np.array(constants, np.uint32), np.zeros(max(len(code), 1), np.uint32)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (code, values, out)]
    size = ctypes.c_size_t
    length = _library().specialize(pointers[0], size(len(code)), pointers[1], size(len(values)), pointers[2])
    if length == 0:
        raise RuntimeError(_library().specialize_error().decode())
    return out[:length]
