# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles the kernels of graphics cards for AMD's families without a card, and prints what each stage needs.

Mesa's RADV compiles for hardware that is not there. The exit status is 1 where a register was spilled to memory.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from typing import Any

FAMILIES = ('navi21', 'navi31', 'gfx1201')  # RDNA 2, 3 and 4
# A minus leaves out of all there is. Whitted and Toon have their own way through some stages, in the place of paths'.
SETS = {
    'direct': ('soft lights', 'specular lobe'),
    'path': ('bounces', 'soft lights', 'visible lights', 'specular lobe', 'world', 'light found by bounces'),
    # No scene uses it all.
    'everything': ('-Whitted', '-toon', '-programs', '-lobes'),
    'whitted': ('-toon', '-programs', '-lobes'),
    'toon': ('-Whitted', '-bounces', '-light found by bounces', '-programs', '-lobes'),
    'programs': ('-Whitted', '-toon'),
}
# What programs hold of most materials that are made of images.
OPS = ('component', 'combine', 'math', 'mix_f', 'mix_color', 'mapping', 'parametric', 'normal_map', 'image_v')
TRACINGS = ('SOFTWARE', 'HARDWARE')  # builds of the stages that trace; the others are the same
COLUMNS = {'VGPRs': 'VGPRs', 'SGPRs': 'SGPRs', 'spilled': 'Spilled VGPRs', 'waves': 'Subgroups per SIMD'}
COLUMNS |= {'instructions': 'Instructions', 'bytes': 'Code size', 'scratch': 'Scratch size'}

COMPILE = """
import json, sys
import cotorra_native
names = [name for name in sys.argv[3:] if not name.startswith('-')]
if not names:
    everything = max((names for _, names in cotorra_native.kernels()), key=len)
    names = [name for name in everything if '-' + name not in sys.argv]
ops = sys.argv[2].split(',') if 'programs' in names else []
print(json.dumps(cotorra_native.compile_kernels(names, ray_tracing=sys.argv[1], ops=ops)))
"""


def compile_for(family: str, features: tuple[str, ...], tracing: str = 'HARDWARE') -> list[dict[str, Any]]:
    """Each stage as cotorra_native.compile_kernels tells of it. Raises RuntimeError with the compiler's words."""
    driver = os.environ.get('COTORRA_RADV')
    if driver is None:
        raise RuntimeError('no RADV is at hand (scripts/mesa fetches it)')
    environment = os.environ | {'VK_DRIVER_FILES': driver, 'RADV_FORCE_FAMILY': family}
    environment['MESA_SHADER_CACHE_DISABLE'] = 'true'  # the seconds are those of a first start
    command = [sys.executable, '-c', COMPILE, tracing, ','.join(OPS), *features]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        raise RuntimeError(f'{family}: {done.stderr.strip() or f"the compiler ended with {done.returncode}"}')
    return json.loads(done.stdout)


def spilled(stages: list[dict[str, Any]]) -> list[str]:
    """The stages that keep registers in memory. Scalar ones beyond their file stand in lanes of vector registers."""
    kinds = ('Spilled VGPRs', 'Scratch size')
    return [stage['stage'] for stage in stages if any(stage['statistics'][kind] > 0 for kind in kinds)]


def table(title: str, stages: list[dict[str, Any]]) -> str:
    lines = [f'{title:24}' + ''.join(f'{name:>13}' for name in (*COLUMNS, 'seconds'))]
    for stage in stages:
        numbers = ''.join(f'{stage["statistics"][name]:13.0f}' for name in COLUMNS.values())
        lines.append(f'  {stage["stage"]:22}{numbers}{stage["seconds"]:13.2f}')
    return '\n'.join(lines)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog='registers', description=__doc__)
    parser.add_argument('--family', nargs='+', default=FAMILIES, help=f'default: {" ".join(FAMILIES)}')
    parser.add_argument('--features', choices=SETS, nargs='+', default=list(SETS), help='default: all of these sets')
    options = parser.parse_args(arguments)
    bad = []
    for family in options.family:
        for name in options.features:
            for tracing in TRACINGS:
                stages = compile_for(family, SETS[name], tracing)
                title = f'{family}, {name}, {tracing.lower()}'
                print(table(title, stages) + '\n', flush=True)
                bad += [f'{title}: {stage}' for stage in spilled(stages)]
    print('registers are spilled: ' + '; '.join(bad) if bad else 'no register is spilled')
    return int(bool(bad))


if __name__ == '__main__':
    sys.exit(main())
