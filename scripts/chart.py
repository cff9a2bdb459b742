# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts of the reflection models and integrators: prints their tables, and writes each as PNG and CSV.

The command line; what is measured and drawn is told in charting/.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from pathlib import Path

from benchmark.report import machine
from charting.result import Chart

ROOT = Path(__file__).resolve().parent.parent
CHARTS = {
    'furnace': 'how much light each model reflects in all, over roughness and angle; energy above 1 is named',
    'models': 'ms a frame and error of each model, D, G, F and integrator on box_room, beside Cycles (5 minutes)',
    'failures': 'where methods fail, and what the kernels do about it',
    'stability': 'relative error of each method over its parameters, and where 1e-3 is promised',
    'misprints': 'what the misprints in the founding texts do, each beside the right formula',
}


def parse(arguments: list[str] | None) -> argparse.Namespace:
    told = '\n'.join(f'  {name:<10} {text}' for name, text in CHARTS.items())
    parser = argparse.ArgumentParser(
        prog='chart', description=f'{__doc__}\n{told}', formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('names', metavar='NAME', nargs='+', choices=CHARTS, help=', '.join(CHARTS))
    parser.add_argument('-o', '--output', type=Path, default=ROOT / 'build' / 'charts', help='folder (build/charts)')
    parser.add_argument('--quick', action='store_true', help='coarse and small: to see that a chart can be made')
    return parser.parse_args(arguments)


def write(chart: Chart, folder: Path) -> None:
    """NAME.png, and NAME.csv or NAME-TABLE.csv for each table."""
    folder.mkdir(parents=True, exist_ok=True)
    chart.figure.savefig(folder / f'{chart.name}.png', dpi=110)
    for table in chart.tables:
        part = '' if len(chart.tables) == 1 else f'-{table.name}'
        (folder / f'{chart.name}{part}.csv').write_text(table.csv())
    if chart.summary:
        (folder / f'{chart.name}.md').write_text(chart.summary)


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    here = machine()
    print(f'{here["cpu"]}, {here["cores"]} cores, load {here["load"]}, Blender {here["bpy"]}\n', flush=True)
    for name in dict.fromkeys(options.names):
        began = time.perf_counter()
        chart = importlib.import_module(f'charting.{name}').make(options.quick)
        for table in chart.tables[: 1 if chart.summary else None]:  # maps are for files
            print(table.text() + '\n')
        write(chart, options.output)
        print(f'{options.output / name}.png, {time.perf_counter() - began:.0f} s\n', flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
