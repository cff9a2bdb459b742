# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass: N-BK7, by the data sheet of SCHOTT.

The index of refraction is that of the helium d line, 587.6 nm (tests/optical_constants.py).
"""

import bpy

bpy.context.material.cotorra.set_dielectric(ior=1.5168, base_color=(1.0, 1.0, 1.0), roughness=0.0, transmission=1.0)
