# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of `./scripts/bench`: what is rendered, how two engines are made comparable, and what is told about it.

The measures are not here but in `addon/metrics.py`, as are those of everything else.
"""
