# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for `cotorra_native` that renders nothing: it takes as long as it is told and fails where it is told.

For tests of what the engine does around a render; no test of an image may use it.
"""

from __future__ import annotations

import threading
import time

import cotorra_native
import numpy as np

# Lists, by which trees are read, and what the exporter asks of meshes.
shader_ops, shader_closures = cotorra_native.shader_ops, cotorra_native.shader_closures
corner_tangents, are_directions = cotorra_native.corner_tangents, cotorra_native.are_directions

# Knobs.
fail_in = ''  # 'scene', 'session', 'device', 'lost', 'render' or 'read'
bytes = 0  # of memory, that the scene holds, and a session beside it
build_seconds = 0.0
sample_seconds = 0.0
read_seconds = 0.0

# What happened.
reads: list[str] = []
sessions: list[Session] = []


class Cancelled(Exception):
    pass


class DeviceError(RuntimeError):
    pass


def configure(text: str) -> None:
    """Set knobs, such as 'fail_in=render build_seconds=5'."""
    for item in text.split():
        name, _, setting = item.partition('=')
        globals()[name] = type(globals()[name])(setting)


def reset() -> None:
    configure('fail_in= bytes=0 build_seconds=0 sample_seconds=0 read_seconds=0')
    reads.clear()
    sessions.clear()


class Scene:
    def __init__(self, buffers, threads=0, embree='', should_cancel=None, bvh=True, editable=False, previous=None):
        self.bvh = False
        if fail_in == 'scene':
            raise ValueError('positions[3] = nan')
        if bvh:
            self.build_bvh(threads, embree, should_cancel)

    def build_bvh(self, threads=0, embree='', should_cancel=None, previous=None):
        assert embree, 'the engine must name an Embree library'
        self.bvh = True
        end = time.perf_counter() + build_seconds
        while time.perf_counter() < end:
            time.sleep(0.01)
            if should_cancel is not None and should_cancel():
                raise Cancelled

    def stats(self):
        lights = {'lights': 0, 'emitters': 0, 'light_bytes': 0, 'light_tree_seconds': 0.0}
        return {'build_seconds': build_seconds, 'memory_bytes': bytes, 'triangles': 0, **lights}


class Session:
    def __init__(self, scene, camera, settings):
        if fail_in == 'session':
            raise RuntimeError('no session today')
        if fail_in == 'device' and settings.device != 'CPU':
            raise DeviceError('no card today')
        assert scene.bvh == (settings.device == 'CPU'), 'a BVH for the CPU, and for it alone'
        self.camera, self.settings = camera, settings
        sessions.append(self)
        self._scene = scene
        self._samples = 0
        self._prepare()

    def _prepare(self):
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def _work(self):
        while self._samples < self.settings.samples and not self._stop.is_set():
            self._stop.wait(sample_seconds)
            if not self._stop.is_set():
                self._samples += 1

    def start(self):
        self._thread.start()

    def wait(self, seconds):
        if fail_in == 'render':
            raise RuntimeError('a worker failed')
        if fail_in == 'lost' and self.settings.device != 'CPU' and not self._scene.bvh and self._samples > 1:
            self._stop.set()
            raise DeviceError('the card is gone')
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def continue_on_cpu(self):
        assert self._scene.bvh, 'the CPU needs a BVH'
        self._thread.join()
        self._prepare()

    def cancel(self):
        self._stop.set()

    def resume(self):
        self._thread.join()
        self._prepare()
        self.start()

    def progress(self):
        return self._samples / self.settings.samples

    def samples_done(self):
        return self._samples

    def read(self, name, out):
        if fail_in == 'read':
            raise RuntimeError(f'pass {name} cannot be read')
        assert out.dtype == np.float32 and out.flags.c_contiguous
        assert out.shape[:2] == self.camera.region[:1:-1], (out.shape, self.camera.region)
        reads.append(name)
        time.sleep(read_seconds)
        out[...] = self._samples if name == 'sample_count' else 0.5
        # The lower left pixel is darker, so that a picture upside down is seen.
        out[0, 0] = 0.0

    def stats(self):
        width, height = self.camera.region[2:]
        return {
            'render_seconds': 0.0,
            'rays': {'camera': self._samples * width * height, 'shadow': 0, 'bounce': 0},
            'samples': self._samples,
            'device': self.settings.device,
            'isa': 'imagination',
            'memory_bytes': bytes,
            'features': ['fake'],
            'left_out': ['real pixels: this is a fake'],
        }
