# SPDX-License-Identifier: GPL-3.0-or-later
"""Iron: Johnson and Christy, "Optical constants of transition metals", Phys. Rev. B 9, 5056 (1974).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(2.923, 2.918, 2.546), k=(3.074, 2.938, 2.75), roughness=0.4)
