# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the command line out of this folder, by any Python with NumPy and OpenImageIO: Blender's own has no `cotorra`.

usage: python launch.py ARGUMENTS of `cotorra`
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

if __name__ == '__main__':
    folder = Path(__file__).resolve().parent.parent
    spec = importlib.util.spec_from_file_location(
        'cotorra', folder / '__init__.py', submodule_search_locations=[str(folder)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules['cotorra'] = module
    spec.loader.exec_module(module)
    sys.path = [entry for entry in sys.path if Path(entry or '.').resolve() != Path(__file__).resolve().parent]
    from cotorra.cli import main

    sys.exit(main())
