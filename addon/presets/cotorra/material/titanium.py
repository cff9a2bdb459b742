# SPDX-License-Identifier: GPL-3.0-or-later
"""Titanium: Johnson and Christy, "Optical constants of transition metals", Phys. Rev. B 9, 5056 (1974).

n and k are means over the spectrum under D65, weighted as linear Rec. 709 is (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_metal(n=(2.734, 2.509, 2.236), k=(3.823, 3.4, 3.01), roughness=0.35)
