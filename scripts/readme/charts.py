# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the charts of README.md: `cotorra chart` of two demos, each figure in few colors, under 200 KB.

usage: .venv/bin/python scripts/readme/charts.py [FOLDER], with the packages of the group `bench` (scripts/setup bench)
FOLDER (build/readme) keeps the charts, so that a run that was stopped goes on. It takes 15 minutes on two cores.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from PIL import Image

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# A machine that does other work, too, tells processor seconds better than those of the clock on the wall.
DEMOS = {
    'box_room': ('--clock', 'cpu'),
    'three_lights': ('--clock', 'cpu', '--samples', '1,4,16', '--points', '15'),
}
COLORS = 64
BYTES_MAX = 200_000


def main(folder: Path) -> None:
    for name, options in DEMOS.items():
        chart = folder / name
        subprocess.run(
            [str(ROOT / 'scripts' / 'cotorra'), 'chart', '--demo', name, '-o', str(chart), *options], check=True
        )
        small = HERE / f'chart_{name}.png'
        picture = Image.open(chart / 'chart.png').convert('RGB')
        picture.quantize(COLORS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(small, optimize=True)
        size = small.stat().st_size
        print(f'{small}: {size / 1000:.0f} kB')
        if size > BYTES_MAX:
            sys.exit(f'{small} has more than {BYTES_MAX // 1000} kB')


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / 'build' / 'readme')
