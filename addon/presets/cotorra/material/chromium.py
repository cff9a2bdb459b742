# SPDX-License-Identifier: GPL-3.0-or-later
"""Chromium: Johnson and Christy, "Optical constants of transition metals", Phys. Rev. B 9, 5056 (1974).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(3.249, 3.109, 2.279), k=(3.287, 3.338, 3.125), roughness=0.1)
