# SPDX-License-Identifier: GPL-3.0-or-later
"""Gold: Johnson and Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 4370 (1972).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(0.064, 0.496, 1.46), k=(3.6, 2.33, 1.818), roughness=0.2)
