# SPDX-License-Identifier: GPL-3.0-or-later
"""Copper: Johnson and Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 4370 (1972).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(0.18, 1.041, 1.29), k=(3.27, 2.604, 2.367), roughness=0.25)
