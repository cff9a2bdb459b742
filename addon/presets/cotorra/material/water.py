# SPDX-License-Identifier: GPL-3.0-or-later
"""Water at 20 °C: Daimon and Masumura, Appl. Opt. 46, 3811 (2007).

The index of refraction is that of the helium d line, 587.6 nm (tests/optical_constants.py).
Absorption at 650, 550 and 450 nm: Pope and Fry, Appl. Opt. 36, 8710 (1997).
"""

import bpy

bpy.context.material.cotorra.set_dielectric(
    ior=1.3334, base_color=(1.0, 1.0, 1.0), roughness=0.0, transmission=1.0, absorption=(0.34, 0.0565, 0.00922)
)
