# SPDX-License-Identifier: GPL-3.0-or-later
"""Stages whose constants were set before the driver sees them: valid SPIR-V, smaller, and of the same results.

That pictures are the CPU's is test_vulkan_device.py's.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kernel_source as kernels
import vulkan
from native_build import BUILD
from spirv_calls import specialized

STAGES = ('trace', 'shade', 'light', 'shadow', 'bounce')

# Branches, loops and switches that the constants decide, alone and with what only the run knows; what is stored once in
# a variable, and returns and breaks from inside.
CONSTRUCTS = """
layout(constant_id = 1) const uint SECOND = 7u;
layout(buffer_reference, scalar) buffer Numbers { uint v[]; };
layout(push_constant, scalar) uniform Push { Numbers numbers; uint count; };
bool has(uint bit) { return (KERNEL_FEATURES & bit) != 0u; }
uint twice(uint x) { return 2u * x + 1u; }
uint thrice(uint x) { for (uint k = 0u; k < 3u; ++k) { if ((SECOND & 1u) != 0u) break; x += k; } return 3u * x; }
uint returns(uint x) {
  if ((KERNEL_FEATURES & 1u) != 0u) {
    if ((SECOND & 2u) != 0u) return thrice(x);
    return 11u;
  } else {
    if (x % 3u == 1u) return 5u;
  }
  return x;
}
uint loops(uint x) {
  uint sum = 0u;
  for (uint k = 0u; k < x % 5u; ++k) {
    if ((KERNEL_FEATURES & 2u) != 0u && k == 3u) continue;
    if ((SECOND & 1u) != 0u || x % 7u == 2u) { sum += twice(k); break; }
    do { sum += k; } while ((SECOND & 4u) != 0u && sum % 4u != 0u);
    while (true) { if ((KERNEL_FEATURES & 4u) != 0u) break; sum += 3u; if (sum > 20u) return sum; }
  }
  return sum;
}
uint choices(uint x) {
  const bool once = (KERNEL_FEATURES & 8u) != 0u;
  const bool both = once && (SECOND & 2u) != 0u;
  uint y = once ? x : x + 1u;
  if (both && x % 2u == 0u) y = twice(y);
  if (!once || x == 3u) y += 100u;
  switch (x % 4u) {
    case 0u: if (once) return y; y += 7u; break;
    case 1u: y += 13u;
    case 2u: if (both) { y += 17u; break; } y += 19u; break;
    default: y = (SECOND & 1u) != 0u ? thrice(y) : y;
  }
  return y;
}
void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uint y = returns(i);
  if (has(16u)) y += 1000u;
  numbers.v[i] = y * 65536u + loops(i) * 256u + choices(i);
}
"""


def stage(name: str) -> np.ndarray:
    """The SPIR-V of a stage, as the build has it."""
    spirv = BUILD / 'spirv' / f'stage_{name}.spv'
    spirv.parent.mkdir(parents=True, exist_ok=True)
    source = kernels.STAGES / f'{name}.comp'
    options = ('-V', '-g0', '--target-env', 'vulkan1.2', f'-I{kernels.KERNELS}')
    kernels.run_tool('glslang', *options, '-o', str(spirv), str(source))
    return np.fromfile(spirv, np.uint32)


def validate(code: np.ndarray, target: Path) -> None:
    """The module must be valid, and have no specialization constants."""
    code.tofile(target)
    kernels.run_tool('spirv-val', '--target-env', 'vulkan1.2', '--scalar-block-layout', str(target))
    place, ops = 5, set()
    while place < len(code):
        ops.add(int(code[place]) & 0xFFFF)
        place += int(code[place]) >> 16
    assert not ops & set(range(48, 53)), 'OpSpecConstant and its like'


@pytest.mark.parametrize('name', STAGES)
def test_stages_stay_valid(name: str, tmp_path: Path) -> None:
    code, known = stage(name), kernels.constants()
    random = np.random.default_rng(len(name))
    features, groups = (
        [value for key, value in known.items() if key.startswith(prefix)] for prefix in ('FEATURE_', 'GROUP_')
    )
    everything = (sum(set(features)), 0xFFFFFFFF, 0xFFFFFFFF)
    some = [sum(value for value in values if random.random() < 0.5) for values in (features, groups)]
    sizes = {}
    for choice in ((0, 0, 0), everything, (*some, 0xFF)):
        made = specialized(code, *choice)
        validate(made, tmp_path / 'made.spv')
        sizes[choice] = len(made)
    if name in ('trace', 'shade', 'shadow'):  # most of these is programs and lobes
        assert sizes[0, 0, 0] < 0.3 * sizes[everything]


def test_results_are_those_of_the_driver(lavapipe: vulkan.Runner, tmp_path: Path) -> None:
    spirv = kernels.compile_glsl('specialize_constructs', CONSTRUCTS)
    count = 64
    for first, second in [(0, 0), (31, 7), *np.random.default_rng(1).integers(0, (32, 8), (30, 2)).tolist()]:
        pictures = []
        code = np.fromfile(spirv, np.uint32)
        made = specialized(code, first, second)
        validate(made, tmp_path / 'made.spv')
        for module, constants in ((code, {0: first, 1: second}), (made, None)):
            numbers = lavapipe.upload(np.zeros(count, np.uint32))
            lavapipe.run('constructs', module, [numbers.address], count, constants)
            pictures.append(numbers.data.view(np.uint32).copy())
        assert (pictures[0] == pictures[1]).all(), f'constants {first} and {second}'


def test_what_is_no_module_is_named() -> None:
    code = stage('bounce')
    with pytest.raises(RuntimeError, match=r'no SPIR-V'):
        specialized(np.arange(9, dtype=np.uint32), 0, 0, 0)
    with pytest.raises(RuntimeError, match='ends too soon'):
        specialized(code[:8], 0, 0, 0)
    with pytest.raises(RuntimeError, match='no value for constant'):
        specialized(code)
