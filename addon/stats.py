# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render cost: times, rays and memory of each view layer, kept until the next render of the same scene.

Engine instances do not outlive a frame, so the figures stand here, by scene name; writing a file is up to the reader.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .export.buffers import RenderSettings


@dataclass(slots=True)
class LayerStats:
    """One view layer of one frame, in seconds and bytes.

    samples was asked for, samples_done is what every pixel has, progress the part of the work that is done. noise is
    the mean error that adaptive sampling estimates to be left (kernels/film.h), 0 without it. reweighting is what
    holding fireflies back changed the picture's mean by, in percent.
    memory_peak_bytes is the process's so far, memory_above_bytes what this render added to memory_before_bytes at
    most. `scene` and `session` are the rest of what the native module counted. `auto` is what integrator AUTO chose and
    why (auto/choice.py), empty with all others; its pilot's seconds are no part of render_seconds. health: what was
    wrong with samples, in words (health.py).
    """

    layer: str
    frame: int
    width: int = 0
    height: int = 0
    integrator: str = ''
    device: str = ''
    threads: int = 0
    seed: int = 0
    samples: int = 0
    samples_done: int = 0
    noise: float = 0.0
    reweighting: float = 0.0
    progress: float = 0.0
    sync_seconds: float = 0.0
    build_seconds: float = 0.0
    pilot_seconds: float = 0.0
    render_seconds: float = 0.0
    denoise_seconds: float = 0.0
    total_seconds: float = 0.0
    rays: dict[str, int] = field(default_factory=dict)
    features: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    health: list[str] = field(default_factory=list)
    scene: dict[str, Any] = field(default_factory=dict)
    session: dict[str, Any] = field(default_factory=dict)
    auto: dict[str, Any] = field(default_factory=dict)
    memory_before_bytes: int = 0
    memory_peak_bytes: int = 0
    memory_above_bytes: int = 0
    interrupted: bool = False
    error: str = ''
    warnings: list[str] = field(default_factory=list)

    def describe(self, size: tuple[int, int], device: str, settings: RenderSettings) -> None:
        """What is about to be rendered."""
        self.width, self.height = size
        self.device = device
        self.integrator = settings.integrator
        self.threads = settings.threads
        self.seed = settings.seed
        self.samples = settings.samples

    def take(self, session: Any) -> None:
        """What the native session counted."""
        counted = dict(session.stats())
        self.samples_done = session.samples_done()
        self.progress = session.progress()
        self.render_seconds = counted.pop('render_seconds')
        self.rays = dict(counted.pop('rays'))
        self.features = list(counted.pop('features'))
        self.left_out = list(counted.pop('left_out'))
        self.session = counted

    def measure(self, memory: MemoryMeter) -> None:
        self.memory_before_bytes = memory.before
        self.memory_peak_bytes = max(memory_peak(), memory.peak())
        self.memory_above_bytes = memory.above()


_last: dict[str, list[LayerStats]] = {}


def record(scene_name: str, stats: LayerStats) -> None:
    """Keep the figures of a layer beside those of the frame's earlier layers."""
    _last.setdefault(scene_name, []).append(stats)


def last(scene_name: str) -> list[LayerStats]:
    """The view layers of the frame that was rendered last."""
    return list(_last.get(scene_name, []))


def everything() -> list[LayerStats]:
    """The view layers of all scenes that were rendered since `clear_everything`: strips and compositing mix scenes."""
    return [entry for entries in _last.values() for entry in entries]


def clear(scene_name: str) -> None:
    """A frame begins: forget the one before."""
    _last.pop(scene_name, None)


def clear_everything() -> None:
    _last.clear()


_of_viewports: dict[int, tuple[str, list[str]]] = {}


def note_viewport(viewport: int, scene_name: str, warnings: list[str]) -> None:
    """What a viewport (its `id`) has to say of what it shows now."""
    _of_viewports[viewport] = scene_name, warnings


def forget_viewport(viewport: int) -> None:
    _of_viewports.pop(viewport, None)


def of_viewports(scene_name: str) -> list[str]:
    """What the viewports of a scene say, each once."""
    found = [text for name, warnings in _of_viewports.values() if name == scene_name for text in warnings]
    return list(dict.fromkeys(found))


def memory_now() -> int:
    """Resident memory of this process in bytes; 0 where the system does not tell."""
    try:
        pages = int(Path('/proc/self/statm').read_text(encoding='ascii').split()[1])
    except (OSError, ValueError, IndexError):
        return 0
    import resource

    return pages * resource.getpagesize()


def memory_peak() -> int:
    """Largest resident memory of this process so far in bytes; 0 where the system does not tell."""
    if sys.platform == 'win32':
        return 0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == 'darwin' else peak * 1024  # bytes on macOS, KiB elsewhere


class MemoryMeter:
    """Memory of the process above what it held when the render began."""

    def __init__(self) -> None:
        self.before = memory_now()
        self._peak_before = memory_peak()
        self._sampled = self.before

    def sample(self) -> int:
        """Memory now; to be called at the end of each phase and while rendering."""
        now = memory_now()
        self._sampled = max(self._sampled, now)
        return now

    def peak(self) -> int:
        """Exact where this render raised the peak of the whole process, otherwise the largest sample."""
        peak = memory_peak()
        return peak if peak > self._peak_before else self._sampled

    def above(self) -> int:
        return max(0, self.peak() - self.before)
