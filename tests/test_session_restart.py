# SPDX-License-Identifier: GPL-3.0-or-later
"""A session that is restarted gives the bits of a new one, on both devices. No Blender here."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cotorra import native
from cotorra.export import buffers as b

from devices import on_both
from texture_scenes import F32, camera, lights, materials, plane, scene

BASE = b.RenderSettings(samples=4, integrator='PATH')
VIEWS = {
    'nearer': (camera(0.6, 24, 2.0), BASE),
    'larger': (camera(1.0, 40, 2.0), BASE),
    'small': (camera(1.0, 3, 2.0), BASE),
    'more samples': (camera(1.0, 24, 2.0), replace(BASE, samples=9)),
    'other noise': (camera(1.0, 24, 2.0), replace(BASE, seed=5)),
    'adaptive': (camera(1.0, 24, 2.0), replace(BASE, adaptive=True, samples=64)),
    'other integrator': (camera(1.0, 24, 2.0), replace(BASE, integrator='DIRECT')),
    'other pass': (camera(1.0, 24, 2.0), replace(BASE, passes=('combined', 'normal'))),
}


def made(device: str) -> Any:
    colors = materials(2, base_color=[[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]])
    walls = plane(-0.8, 0.3, 0.1), plane(-0.3, 0.9, -0.2)
    buffers = scene(walls, colors, lights=lights(((0.0, 0.0, -1.0), 3.0)), world=b.World((0.2, 0.2, 0.3)))
    module = native.load()
    if device == 'CPU':
        return module.Scene(buffers, embree=native.embree_library())
    return module.Scene(buffers, bvh=False)


def picture(session: Any, view: b.Camera) -> np.ndarray:
    session.start()
    assert session.wait(120.0)
    out = np.zeros((view.region[3], view.region[2], 4), F32)
    session.read('combined', out)
    return out


@on_both('name', [(name,) for name in VIEWS], [(name,) for name in ('nearer', 'larger', 'adaptive', 'other pass')])
def test_the_bits_are_those_of_a_new_session(device: str, name: str) -> None:
    built, module = made(device), native.load()
    first = camera(1.0, 24, 2.0)
    session = module.Session(built, first, replace(BASE, device=device), restarts=True)
    before = picture(session, first)
    assert before[..., :3].std() > 0.02
    view, settings = VIEWS[name]
    settings = replace(settings, device=device)
    session.restart(view, settings)
    assert session.progress() == 0.0 and session.samples_done() == 0
    expected = picture(module.Session(built, view, settings), view)
    assert (picture(session, view) == expected).all()
    session.restart(first, replace(BASE, device=device))
    assert (picture(session, first) == before).all()


@pytest.mark.parametrize('restarts', [False, True])
def test_a_session_at_work_is_stopped_by_it(restarts: bool) -> None:
    built, module = made('CPU'), native.load()
    view = camera(1.0, 64, 2.0)
    session = module.Session(built, view, replace(BASE, samples=1 << 20), restarts=restarts)
    for _ in range(5):
        session.start()
        session.restart(view, replace(BASE, samples=1 << 20))
    session.restart(view, BASE)
    assert (picture(session, view) == picture(module.Session(built, view, BASE), view)).all()


@on_both('adaptive', [(False,), (True,)], [(False,)])
def test_a_cancelled_session_goes_on_to_the_same_bits(device: str, adaptive: bool) -> None:
    built, module = made(device), native.load()
    view = replace(camera(1.0, 64, 2.0), filter_width=1.5)
    settings = replace(BASE, samples=64, device=device, adaptive=adaptive, sharing=True)
    expected = picture(module.Session(built, view, settings), view)
    session = module.Session(built, view, settings, restarts=True)
    session.start()
    stops = 0
    while not session.wait(0.005) and stops < 20:
        session.cancel()
        stops += session.progress() < 1.0
        session.resume()
    assert stops, 'it was stopped while it worked'
    assert session.wait(120.0) and session.progress() == 1.0
    out = np.zeros_like(expected)
    session.read('combined', out)
    assert (out == expected).all()


def test_what_is_wrong_is_named() -> None:
    session = native.load().Session(made('CPU'), camera(1.0, 8), BASE, restarts=True)
    with pytest.raises(ValueError, match='settings.samples = 0'):
        session.restart(camera(1.0, 8), replace(BASE, samples=0))
    with pytest.raises(ValueError, match='settings.integrator'):
        session.restart(camera(1.0, 8), replace(BASE, integrator='NONE'))
    session.restart(camera(1.0, 8), BASE)
    picture(session, camera(1.0, 8))
