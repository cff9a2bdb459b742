# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the machine's memory runs out, the error says how much was needed and what for; nothing crashes or hangs.

Each case runs in a process of its own, whose address space is limited once the native module has rendered something.
Memory of graphics cards is test_vulkan_device.py's.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
# RLIMIT_AS makes an allocation fail on Linux; macOS takes the limit and ignores it, and Windows has none.
pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='limits of the address space are Linux here')

# Arguments: MiB that may be added, vertices along a side of the mesh, pixels along a side of the picture, emission.
PROGRAM = """
import resource, sys
sys.path.insert(0, sys.argv[1])
import conftest
import numpy as np
from cotorra.export import buffers as b
import texture_scenes as made
room, side, size, emission = (int(value) for value in sys.argv[2:])
x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, side, dtype=np.float32)] * 2)
positions = np.zeros((side * side + 1, 3), np.float32)
positions[:-1] = np.stack([x.ravel(), y.ravel(), np.sin(9.0 * x.ravel())], axis=-1)
i = np.arange(side * side, dtype=np.uint32).reshape(side, side)
halves = [i[:-1, :-1], i[1:, :-1], i[1:, 1:]], [i[:-1, :-1], i[1:, 1:], i[:-1, 1:]]
triangles = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in halves])
grid = b.Mesh('grid', positions[:-1], triangles)
frame = np.eye(3, 4, dtype=np.float32)[None].copy()
frame[0, 0, 3] = 0.5
sun = made.lights(((0.0, 0.0, -1.0), 3.0))
materials = made.materials(emission=[[float(emission)] * 3])
scene = made.scene((grid,), materials, instances=made.instances(1, frame), lights=sun)
made.render(made.scene((made.plane(),), made.materials(), lights=sun))
used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (room << 20),) * 2)
try:
    made.render(scene, made.camera(size=size))
except MemoryError as error:
    print(error)
else:
    print('rendered')
"""


def out_of_memory(room: int, side: int, size: int, emission: int) -> str:
    """What is said where only so many MiB are left: the last line, for Blender may speak of its own settings first."""
    arguments = [str(value) for value in (TESTS, room, side, size, emission)]
    done = subprocess.run(
        [sys.executable, '-c', PROGRAM, *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    'room, side, size, emission, purpose, least',
    [
        (8, 700, 64, 0, 'the BVH', 50),  # of 977,000 triangles of 55 bytes; Embree cannot even begin
        (132, 700, 64, 0, 'the BVH', 50),  # it runs out on the way
        (16, 1500, 64, 1, 'the triangles that emit', 20),
        (300, 50, 5000, 0, 'a picture of 5000 x 5000 pixels', 380),  # 16 bytes each
    ],
)
def test_what_was_needed_is_said(room: int, side: int, size: int, emission: int, purpose: str, least: int) -> None:
    said = out_of_memory(room, side, size, emission)
    found = re.match(r'out of memory: (\d+) MiB for (.*)', said)
    assert found is not None, said
    assert found[2].startswith(purpose) and int(found[1]) >= least, said


def test_enough_memory_is_enough() -> None:
    assert out_of_memory(2000, 300, 64, 1) == 'rendered'
