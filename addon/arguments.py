# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of the arguments that commands take at a terminal: each reads a text, and tells what is wrong with it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import choices

RESOLUTION_MIN = 4  # Blender's


def add_source(line: argparse.ArgumentParser) -> None:
    """Adds what is rendered: a file or a demo; opening.py opens it."""
    source = line.add_mutually_exclusive_group(required=True)
    source.add_argument('file', nargs='?', type=Path, metavar='FILE', help='.blend, or a file that can be imported')
    source.add_argument('--demo', choices=choices.DEMOS, metavar='NAME', help=', '.join(choices.DEMOS))


def one_of(line: argparse.ArgumentParser, option: str, items: Sequence[tuple[str, str, str]], text: str) -> None:
    """Adds an option that takes the identifier of one of these, in any case; text: its help, {} where they stand."""
    names = [identifier for identifier, _, _ in items]
    told = text.format(', '.join(names).lower())
    line.add_argument(option, type=str.upper, choices=names, metavar='NAME', help=told)


def whole(lowest: int, highest: int) -> Any:
    """A type of argument: a whole number within limits."""

    def read(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'{text!r} is not a whole number') from None
        if not lowest <= number <= highest:
            raise argparse.ArgumentTypeError(f'{number} is not from {lowest} to {highest}')
        return number

    return read


def amount(text: str) -> float:
    """A number; -1 where it is none."""
    try:
        return float(text)
    except ValueError:
        return -1.0


def seconds(text: str) -> float:
    number = amount(text)
    if not 0.0 <= number <= choices.SECONDS_MAX:
        raise argparse.ArgumentTypeError(f'{text!r} is no time from 0 to {choices.SECONDS_MAX:g} s')
    return number


def strength(text: str) -> float:
    """A type of argument: how strictly fireflies are held back, 0 for not at all."""
    most = choices.REWEIGHTING_MAX
    number = amount(text)
    if not (number == 0.0 or 1.0 / most <= number <= most):
        raise argparse.ArgumentTypeError(f'{text!r} is neither 0 nor from {1.0 / most:g} to {most:g}')
    return number


def percent(text: str) -> float:
    least, most = choices.TOLERANCES
    number = amount(text)
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f'{text!r} is not from {least:g} to {most:g} %')
    return number


def device(text: str) -> tuple[str, int]:
    """A device, and which one where there are several: 'vulkan:1'; -1 lets the engine choose."""
    name, colon, index = text.partition(':')
    names = [identifier for identifier, _, _ in choices.DEVICES]
    if name.upper() not in names:
        raise argparse.ArgumentTypeError(f'{name.upper()!r} is none of {", ".join(names)}')
    return name.upper(), whole(0, choices.DEVICE_INDEX_MAX)(index) if colon else -1


def frames(text: str) -> range:
    match = re.fullmatch(r'(-?\d+)(?:\.\.(-?\d+))?', text)
    if match is None:
        raise argparse.ArgumentTypeError(f'{text!r} is neither a frame nor a range A..B')
    first = int(match[1])
    last = int(match[2] or match[1])
    if last < first:
        raise argparse.ArgumentTypeError(f'the range {text} is empty')
    if max(abs(first), abs(last)) > choices.FRAME_MAX:
        raise argparse.ArgumentTypeError(f'frames go to {choices.FRAME_MAX}')
    return range(first, last + 1)


def size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r'(\d+)x(\d+)', text)
    if match is None:
        raise argparse.ArgumentTypeError(f'{text!r} is not a size such as 1920x1080')
    number = whole(1, choices.SIZE_MAX)
    sides = number(match[1]), number(match[2])
    if max(sides) > choices.SIZE_MAX // reduction(sides):
        most = choices.SIZE_MAX // RESOLUTION_MIN
        raise argparse.ArgumentTypeError(f'{text}: beside a side under {RESOLUTION_MIN}, {most} is the most')
    return sides


def reduction(sides: tuple[int, int]) -> int:
    """Blender's resolutions begin at 4: a smaller picture is rendered as a quarter of one that is not."""
    return RESOLUTION_MIN if min(sides) < RESOLUTION_MIN else 1
