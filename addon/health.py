# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad samples in words: what they are, how many, and the material, lamp, bounce and lobe that they come from.

They are counted by the native module (native/health.h), where the scene asks for it; nothing is counted here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .shader.words import CLOSURE_ARGUMENTS

# By the numbers of kernels/health.h.
NOT_FINITE, NEGATIVE, FIREFLY, NUMBER = range(4)
LIT, SCATTER, EMISSION, LAMP, WORLD, SHADER, UNKNOWN = range(7)
KINDS = ('not finite', 'negative', 'fireflies', 'with a number that is infinite or none')
# What is wrong in any case: lamps may be negative, and fireflies are noise.
FAULTS = (NOT_FINITE, NUMBER)
# kernels/closure/lobe_types.h, and the two of bsdf.h.
LOBES = {
    1: 'diffuse', 2: 'translucent', 3: 'reflection', 4: 'dielectric', 5: 'refraction', 6: 'thin wall',
    7: 'Ashikhmin-Shirley', 8: 'sheen', 9: 'velvet', 10: 'toon diffuse', 11: 'toon glossy',
    64: 'diffuse', 65: 'specular',
}  # fmt: skip
CLOSURES = tuple(CLOSURE_ARGUMENTS)
LINES = 12  # of a report; the rest is a sum


@dataclass(frozen=True, slots=True)
class Names:
    """Of materials and lamps, as the native scene numbers them, and of ops of shading programs by their numbers."""

    materials: Sequence[str] = ()
    lights: Sequence[str] = ()
    ops: Mapping[int, str] = field(default_factory=dict)


def line(bad: dict[str, Any], names: Names) -> str:
    """As 'material "Glass.003", bounce 4, dielectric: 12 samples not finite'."""
    words = []
    if bad['material'] >= 0:
        words.append(f'material "{_name(names.materials, bad["material"])}"')
    if bad['place'] == WORLD:
        words.append('world')
    if bad['light'] >= 0:
        words.append(f'light "{_name(names.lights, bad["light"])}"')
    words.append(f'bounce {bad["bounce"]}')
    if bad['place'] == EMISSION:
        words.append('emission')
    elif bad['place'] == SHADER:
        words.append(_input(bad))
    elif bad['place'] in (LIT, SCATTER):
        words.append(LOBES.get(bad['lobe'], 'unknown lobe'))
    elif bad['place'] == UNKNOWN:
        words = ['light that is finite but for its sum']
    if bad.get('op', -1) in names.ops:
        words.append(f'from {names.ops[bad["op"]].removesuffix("_v").removesuffix("_f").replace("_", " ")}')
    count = bad['samples']
    return f'{", ".join(words)}: {count} sample{"s" if count != 1 else ""} {KINDS[bad["kind"]]}'


def _name(names: Sequence[str], index: int) -> str:
    return names[index] if index < len(names) else f'number {index}'


def _input(bad: dict[str, Any]) -> str:
    closure = CLOSURES[bad['lobe']]
    arguments = CLOSURE_ARGUMENTS[closure]
    if not 0 <= bad['argument'] < len(arguments):
        return f'weight of {closure}'
    return f'{arguments[bad["argument"]].replace("_", " ")} of {closure}'


def report(bad_samples: Sequence[dict[str, Any]], samples: int, rejected: int, names: Names) -> list[str]:
    """Lines for people, the worst first: what was dropped and its weight in the mean, then where samples went bad."""
    lines = []
    if rejected:
        lines.append(dropped(rejected, samples))
    order = sorted(bad_samples, key=lambda bad: (bad['kind'] not in FAULTS, -bad['samples']))
    lines += [line(bad, names) for bad in order[:LINES]]
    if len(order) > LINES:
        rest = sum(bad['samples'] for bad in order[LINES:])
        lines.append(f'{rest} more bad samples at {len(order) - LINES} more places')
    return lines


def dropped(rejected: int, samples: int) -> str:
    """What of the picture's mean is missing: a sample that is dropped counts as black."""
    share = rejected / max(samples, 1)
    return (
        f'{rejected} of {samples} samples were dropped as not finite, {100.0 * share:.2g} % of the weight in the mean'
    )


def faults(bad_samples: Sequence[dict[str, Any]]) -> int:
    """Samples that are wrong in any case."""
    return sum(bad['samples'] for bad in bad_samples if bad['kind'] in FAULTS)
