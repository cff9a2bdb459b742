# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the package `cotorra` importable where it is not installed: it is the folder addon/.

Test data are not made here, but in tests/scenes.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

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
