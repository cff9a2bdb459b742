# SPDX-License-Identifier: GPL-3.0-or-later
"""Format, lint and the marks that each file carries.

What the formatters decide is configured in pyproject.toml and .clang-format, not here.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CPP = sorted(
    path
    for folder in ('native', 'kernels', 'tests/native')
    for path in (ROOT / folder).rglob('*')
    if path.suffix in {'.h', '.cpp', '.comp', '.glsl'}
)
PYTHON = sorted(path for folder in ('addon', 'tests', 'scripts') for path in (ROOT / folder).rglob('*.py'))
SCRIPTS = sorted(
    path for path in (*(ROOT / 'scripts').iterdir(), ROOT / '.ci' / 'run') if path.is_file() and not path.suffix
)


def tool(name: str) -> str:
    """The tool beside the running Python: the pinned one, never another on PATH."""
    path = shutil.which(name, path=str(Path(sys.executable).parent))
    assert path, f'{name} is not in the environment: run ./scripts/test, or ./scripts/setup test'
    return path


@pytest.mark.parametrize('arguments', [('check',), ('format', '--diff')], ids=['lint', 'format'])
def test_python(arguments: tuple[str, ...]) -> None:
    result = subprocess.run(
        [tool('ruff'), *arguments, '--quiet', 'addon', 'tests', 'scripts'], cwd=ROOT, capture_output=True, text=True
    )
    assert result.returncode == 0, f'mend with `ruff {arguments[0]}`:\n{result.stdout}{result.stderr}'


def test_cpp_format() -> None:
    result = subprocess.run(
        [tool('clang-format'), '--dry-run', '-Werror', *map(str, CPP)], capture_output=True, text=True
    )
    assert result.returncode == 0, f'mend with `clang-format -i FILE`:\n{result.stderr}'


@pytest.mark.parametrize('path', [*CPP, *PYTHON, *SCRIPTS], ids=lambda path: str(path.relative_to(ROOT)))
def test_file(path: Path) -> None:
    lines = path.read_text().splitlines()
    assert any('SPDX-License-Identifier: GPL-3.0-or-later' in line for line in lines[:2]), (
        'the licence line comes first'
    )
    assert len(lines) <= 600, f'{len(lines)} lines: would two files be clearer?'
