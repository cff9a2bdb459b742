# SPDX-License-Identifier: GPL-3.0-or-later
"""Aluminium: Rakić, "Algorithm for the determination of intrinsic optical constants", Appl. Opt. 34, 4755 (1995).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(1.473, 0.986, 0.598), k=(7.636, 6.556, 5.347), roughness=0.3)
