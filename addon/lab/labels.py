# SPDX-License-Identifier: GPL-3.0-or-later
"""Places for labels in a plot, so that none covers another, a marker, or the edge.

Boxes are (left, bottom, right, top) in pixels; it knows no plotting library.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

Box = tuple[float, float, float, float]

DIRECTIONS = 16
DISTANCES = (5.0, 9.0, 15.0, 24.0, 36.0, 52.0, 72.0)


@dataclass(frozen=True, slots=True)
class Label:
    """anchor: the point that it names. needed: it is placed even where it must cover something; others are left out."""

    text: str
    anchor: tuple[float, float]
    size: tuple[float, float]
    needed: bool = True


def overlap(a: Box, b: Box) -> float:
    """Area that two boxes share."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    return width * height if width > 0.0 and height > 0.0 else 0.0


def candidates(label: Label) -> list[tuple[float, Box]]:
    """Boxes around the anchor with what speaks against each: its distance, and a side less liked."""
    (x, y), (width, height) = label.anchor, label.size
    found = []
    for distance in DISTANCES:
        for step in range(DIRECTIONS):
            angle = 2.0 * math.pi * step / DIRECTIONS
            dx, dy = math.cos(angle), math.sin(angle)
            # The box's nearest point lies at the distance: its centre is away by its half sides, too.
            left = x + dx * (distance + width / 2) - width / 2
            bottom = y + dy * (distance + height / 2) - height / 2
            found.append((distance * (1.0 + 0.15 * (1.0 - dx)), (left, bottom, left + width, bottom + height)))
    return sorted(found)


def place(labels: Sequence[Label], obstacles: Sequence[Box], frame: Box) -> list[Box | None]:
    """A box for each label, those that are needed first; None for one that found no free place and is not."""
    taken = list(obstacles)
    boxes: list[Box | None] = [None] * len(labels)
    for index in sorted(range(len(labels)), key=lambda index: not labels[index].needed):
        label = labels[index]
        best, least = None, math.inf
        for cost, box in candidates(label):
            if not label.needed and cost > 2.0 * DISTANCES[1]:
                break
            inside = overlap(box, frame) >= 0.999 * label.size[0] * label.size[1]
            covered = sum(overlap(box, other) for other in taken)
            total = cost + 50.0 * covered + (0.0 if inside else 1e6)
            if total < least:
                best, least = box, total
            if inside and covered == 0.0:
                break
        if label.needed or (least < 2.0 * DISTANCES[1]):
            boxes[index] = best
            taken.append(best)
    return boxes
