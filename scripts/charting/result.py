# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chart is made of: tables for text and CSV, and a figure. Nothing is computed here."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmark.report import table as aligned


@dataclass(frozen=True, slots=True)
class Table:
    """name: for the file. Cells are text or numbers; numbers are printed with four digits and saved with all."""

    name: str
    title: str
    head: tuple[str, ...]
    rows: list[tuple[Any, ...]]
    notes: tuple[str, ...] = ()

    def text(self) -> str:
        lines = [tuple(shown(cell) for cell in row) for row in self.rows]
        return '\n'.join((self.title, aligned(self.head, lines), *(f'  {note}' for note in self.notes)))

    def csv(self) -> str:
        out = io.StringIO()
        writer = csv.writer(out, lineterminator='\n')
        writer.writerow(self.head)
        writer.writerows(self.rows)
        return out.getvalue()


@dataclass(frozen=True, slots=True)
class Chart:
    name: str
    tables: list[Table]
    figure: Figure
    summary: str = ''  # Markdown, where a chart has one


def shown(cell: Any) -> str:
    return f'{cell:.4g}' if isinstance(cell, float) else str(cell)


def panels(title: str, rows: int, columns: int, width: float = 4.2, height: float = 3.2) -> tuple[Figure, list[Any]]:
    """A figure of rows × columns axes, listed row by row."""
    figure = Figure(figsize=(width * columns, height * rows + 0.6), layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(rows, columns, squeeze=False).flat)
