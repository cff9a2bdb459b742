# SPDX-License-Identifier: GPL-3.0-or-later
"""Integrator AUTO: no more is modelled than a scene needs for its picture to stay within a tolerance.

`measure.py` and `plan.py` decide, on figures alone; `facts.py` and `models.py` read the exported scene; `pilot.py`
renders the small pictures that the figures come from; `choice.py` puts them in order; `spread.py` tells, when the
render has begun, where more samples are taken. No Blender here.
"""

from .choice import Choice, Materials, choose
from .facts import Facts, facts
from .models import Part, parts_of
from .pilot import Pilot
from .spread import asked_samples, shared_reach, spread_samples

__all__ = [
    'Choice',
    'Facts',
    'Materials',
    'Part',
    'Pilot',
    'asked_samples',
    'choose',
    'facts',
    'parts_of',
    'shared_reach',
    'spread_samples',
]
