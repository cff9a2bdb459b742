# SPDX-License-Identifier: GPL-3.0-or-later
"""Ceramic: alumina; Malitson and Dodge, J. Opt. Soc. Am. 62, 1405 (1972), for sapphire, the ordinary ray.

The index of refraction is that of the helium d line, 587.6 nm (tests/optical_constants.py).
The color is no one's measurement.
"""

import bpy

bpy.context.material.cotorra.set_dielectric(ior=1.7682, base_color=(0.8, 0.78, 0.72), roughness=0.25)
