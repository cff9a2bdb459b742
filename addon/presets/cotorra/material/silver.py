# SPDX-License-Identifier: GPL-3.0-or-later
"""Silver: Johnson and Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 4370 (1972).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(0.056, 0.055, 0.043), k=(4.353, 3.535, 2.568), roughness=0.15)
