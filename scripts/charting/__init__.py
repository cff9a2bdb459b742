# SPDX-License-Identifier: GPL-3.0-or-later
"""What `scripts/chart` draws: a module for each chart, whose `make(quick)` gives its tables and its figure.

Printing and writing files is chart.py's.
"""
