# SPDX-License-Identifier: GPL-3.0-or-later
"""What most pictures need."""

import bpy

own = bpy.context.scene.cotorra
own.settings_from = 'COTORRA'
own.samples = 256
own.use_adaptive_sampling = True
own.noise_threshold = 0.02
own.adaptive_min_samples = 0
own.use_denoising = True
own.denoising_quality = 'HIGH'
own.use_reweighting = True
own.use_sample_sharing = True
