# SPDX-License-Identifier: GPL-3.0-or-later
"""Plastic: acrylic glass (PMMA), Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116, 585 (2009).

The index of refraction is that of the helium d line, 587.6 nm (tests/optical_constants.py).
The color is no one's measurement.
"""

import bpy

bpy.context.material.cotorra.set_dielectric(ior=1.4906, base_color=(0.5, 0.05, 0.05), roughness=0.3)
