# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the package `cotorra` importable where it is not installed (it is the folder addon/), and registers the engine.

Test data are not made here, but in tests/scenes.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ADDON = Path(__file__).resolve().parent.parent / 'addon'


def _import_addon_folder() -> None:
    spec = importlib.util.spec_from_file_location(
        'cotorra', ADDON / '__init__.py', submodule_search_locations=[str(ADDON)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules['cotorra'] = module
    spec.loader.exec_module(module)


if importlib.util.find_spec('cotorra') is None:
    _import_addon_folder()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line('markers', 'every(n): of many cases of one kind only each n-th, unless COTORRA_LONG is set')
    config.addinivalue_line('markers', 'long: not at all, unless COTORRA_LONG is set')
    config.addinivalue_line(
        'markers', 'early: of a file that takes minutes, which no processor shall wait for at the end'
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Comparisons with Cycles and of devices are many. A short run takes some of each kind; COTORRA_LONG=1 takes all.

    Cases that are asked for by name, or by an expression, all run. Files that take minutes come first.
    """
    items.sort(key=lambda item: item.get_closest_marker('early') is None)
    named = any('::' in argument for argument in config.args) or config.option.keyword
    if os.environ.get('COTORRA_LONG') or named:
        return
    kept, left_out, seen = [], [], defaultdict(int)
    for item in items:
        mark = item.get_closest_marker('every')
        kind = item.nodeid.partition('[')[0]
        # A strict known fault always runs: its mending must show.
        known_fault = item.get_closest_marker('xfail') is not None
        seen[kind] += 1
        runs = mark is None or known_fault or seen[kind] % mark.args[0] == 1 % mark.args[0]
        runs &= item.get_closest_marker('long') is None
        (kept if runs else left_out).append(item)
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = kept


@pytest.fixture(scope='session')
def engine() -> Iterator[None]:
    """Cotorra is registered in this process's Blender."""
    import cotorra

    cotorra.register()
    yield
    cotorra.unregister()


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    """The native module is replaced by the one that renders nothing."""
    from cotorra import native

    import fake_native

    fake_native.reset()
    monkeypatch.setattr(native, 'load', lambda: fake_native)
    monkeypatch.setattr(native, 'embree_library', lambda: 'libembree4.so')


@pytest.fixture(scope='session')
def lavapipe() -> Any:
    """The device that runs single shaders (vulkan.Runner); the test is skipped where there is none."""
    import vulkan

    runner = vulkan.open_lavapipe()
    if isinstance(runner, str):
        pytest.skip(runner)  # the text says why there is none, and what to install
    return runner


@pytest.fixture(scope='module')
def module() -> Iterator[ModuleType]:
    """The native module, whose Vulkan is lavapipe under validation; the test is skipped where there is none."""
    import vulkan_jobs

    yield from vulkan_jobs.opened()


@pytest.fixture(params=['SOFTWARE', 'HARDWARE'])
def tracing(request: pytest.FixtureRequest, module: ModuleType) -> str:
    """RenderSettings.ray_tracing, for tests that run with both builds of the stages that trace."""
    import vulkan_jobs

    vulkan_jobs.require(module, request.param)
    return request.param


@pytest.fixture(params=['CPU', 'VULKAN'])
def device(request: pytest.FixtureRequest) -> str:
    """RenderSettings.device, for tests that hold on both; skipped where there is no lavapipe."""
    if request.param == 'VULKAN':
        request.getfixturevalue('module')
    return request.param
