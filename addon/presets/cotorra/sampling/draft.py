# SPDX-License-Identifier: GPL-3.0-or-later
"""A look at light and composition, within seconds."""

import bpy

own = bpy.context.scene.cotorra
own.settings_from = 'COTORRA'
own.samples = 32
own.use_adaptive_sampling = True
own.noise_threshold = 0.1
own.adaptive_min_samples = 0
own.use_denoising = True
own.denoising_quality = 'FAST'
own.use_reweighting = True
own.use_sample_sharing = True
