# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders are not made of: nodes that are not read, and nodes that the nearest stands in for, each with why.

The README quotes it. Nodes that are read have a function in nodes_*.py, bump.py or closures.py.
"""

from __future__ import annotations

# Nodes that are no part of what is shown, or are resolved before reading.
STRUCTURE = frozenset(
    (
        'ShaderNodeAddShader',
        'ShaderNodeMixShader',
        'ShaderNodeGroup',
        'ShaderNodeOutputLight',
        'ShaderNodeOutputMaterial',
        'ShaderNodeOutputWorld',
    )
)

# What is not read, and why. Where Cycles does not render a node either, an input that it feeds keeps its own value,
# as in Cycles.
AS_CYCLES = 'Cycles does not render it either'
NOT_SUPPORTED = {
    'ShaderNodeCustomGroup': 'nodes that other add-ons define are not supported',
    'ShaderNodeEeveeSpecular': AS_CYCLES,
    'ShaderNodeOutputAOV': 'passes of shaders are not supported yet',
    'ShaderNodeOutputLineStyle': AS_CYCLES,
    'ShaderNodeScript': 'scripts (OSL) are not supported',
    'ShaderNodeShaderToRGB': AS_CYCLES,
    'ShaderNodeSqueeze': AS_CYCLES,
    'ShaderNodeTexPointDensity': 'point density is not supported',
    'ShaderNodeUVAlongStroke': AS_CYCLES,
    'ShaderNodeVolumeAbsorption': 'volumes are not supported yet',
    'ShaderNodeVolumeCoefficients': 'volumes are not supported yet',
    'ShaderNodeVolumePrincipled': 'volumes are not supported yet',
    'ShaderNodeVolumeScatter': 'volumes are not supported yet',
}

# What something else is shown for, which a message says.
NEAREST = {
    'ShaderNodeBsdfHair': 'hair shaders are not supported yet: it is diffuse',
    'ShaderNodeBsdfHairPrincipled': 'hair shaders are not supported yet: it is diffuse',
    'ShaderNodeBsdfRayPortal': 'ray portals are not supported yet: it is clear',
    'ShaderNodeSubsurfaceScattering': 'subsurface scattering is not supported yet: it is diffuse',
}
