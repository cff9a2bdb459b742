# SPDX-License-Identifier: GPL-3.0-or-later
"""Integrator AUTO: no more is modelled than a scene needs for its picture to stay within a tolerance.

`measure.py` and `plan.py` decide, on figures alone; `facts.py` reads the exported scene; `pilot.py` renders the small
pictures that the figures come from; `choice.py` puts them in order. No Blender here.
"""

from .choice import Choice, choose
from .facts import Facts, facts
from .pilot import Pilot

__all__ = ['Choice', 'Facts', 'Pilot', 'choose', 'facts']
