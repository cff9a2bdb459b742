# SPDX-License-Identifier: GPL-3.0-or-later
"""What other pictures are compared with: no denoiser touches it, no weights of fireflies, and each
pixel has its own samples."""

import bpy

own = bpy.context.scene.cotorra
own.settings_from = 'COTORRA'
own.samples = 4096
own.use_adaptive_sampling = True
own.noise_threshold = 0.002
own.adaptive_min_samples = 0
own.use_denoising = False
own.denoising_quality = 'HIGH'
own.use_reweighting = False
own.use_sample_sharing = False
