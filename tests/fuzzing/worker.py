# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that renders fuzzed scenes: reads a description a line, as JSON, and answers with a verdict a line.

It is run by runner.py, which sees to it that it may crash. `--build` only builds scenes and evaluates them, which tells
what Blender itself does not survive.
"""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import conftest  # noqa: F401 -- makes cotorra importable

# isort: split
import bpy
import cotorra
import numpy as np
from cotorra import stats

from fuzzing.builder import Builder
from fuzzing.catalogue import catalogue
from render_calls import read_exr, render_to

# An exception that nobody wrote a message for.
UNFORESEEN = re.compile(r'^\w*(Error|Exception|Exit|Interrupt): ')


# Faults on purpose, by which test_fuzz.py sees that faults are found.
SABOTAGE: dict[str, Callable[[], Any]] = {'crash': os.abort, 'hang': lambda: time.sleep(3600.0)}


def judged(scene: bpy.types.Scene, folder: Path, spoil: bool) -> dict[str, Any]:
    """Renders; fault: what is wrong with the outcome, '' where nothing is."""
    try:
        path = render_to(scene, folder / 'fuzzed.exr', multilayer=True)
    except RuntimeError as error:  # what engine.report({'ERROR'}) becomes
        told = str(error).strip()
        text = told.removeprefix('Error: ').removeprefix('Cotorra: ')
        return {'fault': told if UNFORESEEN.match(text) or not text else '', 'error': told}
    layers = stats.last(scene.name)
    warnings = [text for layer in layers for text in layer.warnings]
    for layer, channels in read_exr(path).items():
        for name, pixels in channels.items():
            if spoil:
                pixels[0, 0] = np.nan
            bad = int((~np.isfinite(pixels)).sum())
            if bad:
                return {'fault': f'{bad} pixels of {layer}.{name} are not finite', 'warnings': warnings}
    return {'fault': '', 'warnings': warnings}


def main() -> None:
    # Blender and scripts write to stdout, too.
    answers = os.fdopen(os.dup(1), 'w')
    os.dup2(2, 1)
    cotorra.register()
    known = catalogue()
    print(json.dumps(known), file=answers, flush=True)
    builder = Builder(tuple(known['nodes']))
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.stdin:
            began = time.process_time()
            try:
                description = json.loads(line)
                scene = builder.scene(description)
                bpy.context.view_layer.update()
            except Exception:
                verdict = {'fault': f'not built: {traceback.format_exc()}'}
            else:
                fault = description.get('sabotage')
                SABOTAGE.get(fault, int)()
                verdict = {'fault': ''} if '--build' in sys.argv else judged(scene, Path(folder), fault == 'nan')
            verdict['seconds'] = time.process_time() - began
            print(json.dumps(verdict), file=answers, flush=True)


if __name__ == '__main__':
    main()
