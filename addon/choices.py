# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and limits that Blender's settings and the command line share.

It imports nothing, so that the command line can answer before Blender is loaded.
"""

from __future__ import annotations

ENGINE = 'COTORRA'

# identifier, name, description
INTEGRATORS = (
    ('DIRECT', 'Direct', 'Light that comes straight from lights and the world, with shadows; nothing reflects'),
    ('PATH', 'Path', 'Light that also bounces between surfaces, and light from emitting surfaces'),
    (
        'WHITTED',
        'Whitted',
        'Light of lamps, ambient light, and rays that smooth metal and glass mirror and refract (Whitted 1980). '
        'Rough surfaces are lit by lamps only; emitting surfaces and the world are seen but light nothing',
    ),
    ('AO', 'Ambient Occlusion', 'How much of the sky each point sees within a distance, without any light'),
    ('TOON', 'Toon', 'Flat tones by the number of lamps that light a point fully, with outlines'),
    (
        'AUTO',
        'Auto',
        'As Path, without what a small render beforehand shows to be needless: bounces and samples that change the '
        'picture by less than a tolerance',
    ),
)
# What AUTO may simplify, each with a switch of its own.
AUTO_ROWS = (
    ('integrator', 'Integrator', 'Direct instead of Path, where bounces bring next to nothing'),
    ('bounces', 'Total Bounces', 'Fewer bounces of all kinds together'),
    ('diffuse', 'Diffuse Bounces', 'Fewer diffuse bounces'),
    ('glossy', 'Glossy Bounces', 'Fewer glossy bounces'),
    ('transmission', 'Transmission Bounces', 'Fewer passages through glass'),
    ('transparent', 'Transparent Surfaces', 'Fewer transparent surfaces that a ray crosses'),
    (
        'models',
        'Materials',
        'Materials without coat, sheen, film, specular layer, anisotropy, roughness of diffuse reflection or bent '
        'normals, where nobody would see it',
    ),
    ('light', 'Shadow Rays', 'Rays to little light traced at random, where that saves more than it adds noise'),
    (
        'sampling',
        'Samples',
        'Fewer samples where these leave less noise than the tolerance; more where there is noise and fewer where '
        'there is little, if that leaves no more of it in the picture than the samples that are set',
    ),
)
# Whose settings hold where Cycles has one of the same meaning; see addon/cycles_settings.py.
SETTINGS_FROM = (
    ('AUTO', 'Automatic', "What was set for Cotorra, and the scene's settings for Cycles for all the rest"),
    ('CYCLES', "Cycles'", "The scene's settings for Cycles: a file made for it is rendered as it would"),
    ('COTORRA', "Cotorra's", 'Settings of its own, whatever those for Cycles are'),
)
# How pictures are denoised: identifiers as Cycles has them.
DENOISING_INPUTS = (
    ('RGB', 'None', 'The picture alone'),
    ('RGB_ALBEDO', 'Albedo', 'And the colors of surfaces'),
    ('RGB_ALBEDO_NORMAL', 'Albedo and Normal', 'And the colors and normals of surfaces'),
)
DENOISING_PREFILTERS = (
    ('NONE', 'None', 'Albedo and normal count as free of noise'),
    ('FAST', 'Fast', 'Albedo and normal may be noisy, and are denoised with the picture'),
    ('ACCURATE', 'Accurate', 'Albedo and normal are denoised first'),
)
DENOISING_QUALITIES = (
    ('HIGH', 'High', 'The best picture'),
    ('BALANCED', 'Balanced', 'Between the two'),
    ('FAST', 'Fast', 'The shortest time'),
)
# What the Rendered viewport can show: identifier, native pass ('': of what is chosen), name, description.
LIGHT_PASS, LIGHT_GROUP_PASS = 'LIGHT', 'LIGHT_GROUP'
VIEWPORT_PASSES = (
    ('COMBINED', 'combined', 'Combined', 'The picture'),
    ('NORMAL', 'normal', 'Normal', 'Which way surfaces face, in world space'),
    ('DIFFUSE_COLOR', 'diffuse_color', 'Diffuse Color', 'What color surfaces have, without light'),
    ('DENOISING_ALBEDO', 'denoising_albedo', 'Albedo', 'What color surfaces have, mirrors and glass seen through'),
    ('POSITION', 'position', 'Position', 'Where surfaces are, in world space'),
    ('DEPTH', 'depth', 'Depth', 'How far surfaces are along the view'),
    ('UV', 'uv', 'UV', 'Texture coordinates of the active UV map'),
    ('EMISSION', 'emission', 'Emission', 'Light that surfaces emit toward the viewer'),
    ('ENVIRONMENT', 'environment', 'Environment', 'The world where nothing stands before it'),
    (LIGHT_PASS, '', 'Light', 'What one light gives to surfaces that it lights'),
    (LIGHT_GROUP_PASS, '', 'Light Group', 'The light of one light group, bounces included'),
    ('SHADOW', 'shadow', 'Shadow', 'How much of the light of lamps arrives'),
    ('AO', 'ao', 'Ambient Occlusion', 'How much of the sky each point sees'),
    ('TERM_D', 'term_d', 'Distribution', 'The distribution term D of highlights, for each lamp, summed'),
    ('TERM_G', 'term_g', 'Masking', 'The masking term G of highlights, for each lamp, summed'),
    ('TERM_F', 'term_f', 'Fresnel', 'The Fresnel term F of highlights, for each lamp, summed'),
    (
        'HEALTH',
        'health',
        'Health',
        'Bad samples of each pixel: red where not finite, green where negative, blue where fireflies',
    ),
    ('SAMPLE_COUNT', 'sample_count', 'Sample Count', 'The part of the samples that each pixel took'),
)
HEALTHS = (
    ('OFF', 'Off', 'Bad samples are dropped, and not counted'),
    (
        'REPORT',
        'Report',
        'Count samples that are not finite, negative or fireflies, with where they come from (slower)',
    ),
    ('STRICT', 'Strict', 'As Report; where a sample or a number of a shader is not finite, the render fails'),
)
DEVICES = (
    ('CPU', 'CPU', "All processor cores that Blender's thread setting allows"),
    ('VULKAN', 'GPU (Vulkan)', 'A graphics card with Vulkan 1.2'),
)
RAY_TRACINGS = (
    ('AUTO', 'Automatic', 'In hardware, where the graphics card can'),
    ('SOFTWARE', 'Software', 'By compute kernels, on any graphics card'),
    ('HARDWARE', 'Hardware', "By the graphics card's own ray tracing units (Vulkan ray queries)"),
)
DEVICE_INDEX_MAX = 63

# What a material reflects by, in the order of kernels/scene_types.h (MODEL_*), as are the lists that follow.
MODELS = (
    ('PRINCIPLED', 'Principled', "What the material's own nodes say"),
    ('LAMBERT', 'Lambert', 'The same brightness from everywhere: base color / π'),
    ('OREN_NAYAR', 'Oren-Nayar', 'Rough diffuse surfaces, such as clay, plaster or the moon'),
    ('PHONG', 'Phong', 'Diffuse, and a highlight around the mirrored direction (Phong 1975)'),
    ('BLINN_PHONG', 'Blinn-Phong', 'Diffuse, and a highlight around the half vector (Blinn 1977)'),
    (
        'COOK_TORRANCE',
        'Cook-Torrance',
        'Diffuse, and microfacets with a D, G and F to choose (Cook and Torrance 1982)',
    ),
    ('TOON', 'Toon', 'A few flat tones by the angle of the light'),
)
DISTRIBUTIONS = (
    ('GGX', 'GGX', 'Highlights with a wide glow around them (Trowbridge and Reitz 1975, Walter et al. 2007)'),
    ('BECKMANN', 'Beckmann', 'Highlights without a glow, from Gaussian slopes (Beckmann and Spizzichino 1963)'),
    (
        'BLINN_PHONG',
        'Blinn-Phong',
        "Phong's cosine power as a distribution of microfacets (Blinn 1977). "
        'With G by Smith, rough surfaces reflect more light than arrives at grazing angles',
    ),
)
MASKINGS = (
    ('SMITH_CORRELATED', 'Smith, Correlated', 'Smith, where high facets are both seen and lit more (Heitz 2014)'),
    ('SMITH', 'Smith', 'Smith, with view and light independent of each other (Smith 1967)'),
    ('COOK_TORRANCE', 'Cook-Torrance', 'Facets in V-shaped grooves (Torrance and Sparrow 1967)'),
    ('SCHLICK_GGX', 'Schlick-GGX', "Schlick's cheaper fit, with k = a / 2 (Karis 2013)"),
)
FRESNELS = (
    ('SCHLICK', 'Schlick', 'From F0 to white at grazing angles (Schlick 1994)'),
    ('DIELECTRIC', 'Dielectric', "Fresnel's equations for glass and plastic, from the index of refraction"),
    ('CONDUCTOR', 'Conductor', "Fresnel's equations for metals, from n and k for red, green and blue"),
    (
        'F82',
        'F82 Tint',
        'Schlick with a tint near the edge (Kutz et al. 2021), as Principled has it for metals',
    ),
)
F0_MODES = (
    ('COLOR', 'Color', 'The color below'),
    ('METALLIC', 'Metallic', "0.04 to the base color, by the node's Metallic"),
    ('IOR', 'IOR', "((n - 1) / (n + 1))², by the node's index of refraction n"),
)
SPLITS = (
    (
        'ENERGY',
        'Energy',
        'Diffuse gets what Fresnel leaves: (1 - F) (1 - metallic). '
        'Bright surfaces reflect more light than arrives at grazing angles, as each half vector has its own F',
    ),
    ('MIX', 'Mix', 'Diffuse and specular are mixed by Metallic'),
)
OREN_NAYAR_FORMS = (
    (
        'QUALITATIVE',
        'Qualitative',
        'The short form of the paper, which loses energy, and makes 1 % where sigma is small (Oren and Nayar 1994)',
    ),
    ('ENERGY_PRESERVING', 'Energy Preserving', 'EON, which keeps the energy (Portsmouth et al. 2024)'),
)
FALLOFFS = (
    ('PHYSICAL', 'Physical', 'By the square of the distance'),
    ('RANGED', 'Ranged', 'By the square of the distance, and smoothly to nothing at the range'),
    ('POLYNOMIAL', 'Polynomial', '1 / (c0 + c1 d + c2 d²), d being the distance'),
)
SPOT_EDGES = (
    ('BLENDER', 'Blender', 'By Angle and Blend, as in Cycles'),
    ('LINEAR', 'Linear', 'Evenly with the angle, between the inner and the outer angle'),
    ('SQUARED', 'Squared Cosine', 'By the square of a ramp in the cosine, between the inner and the outer angle'),
)

DEMOS = {
    'three_lights': 'thirty twice-subdivided monkeys under a sun, a point and a spot light',
    'box_room': 'a cone, a cube and a sphere in a room under three lights',
    'material_grid': 'spheres over roughness and metallic under three lights',
    'whitted_classic': 'a glass and a mirror sphere over a checker floor, as in 1980',
    'model_room': 'a furnished room, textured, each piece with a reflection model of its own',
    'model_pair': 'a copper vase and a tiled block, textured, each with a reflection model of its own',
}

# Files of other programs, and the operators of Blender that read them.
IMPORTERS = {
    '.glb': 'import_scene.gltf',
    '.gltf': 'import_scene.gltf',
    '.usd': 'wm.usd_import',
    '.usda': 'wm.usd_import',
    '.usdc': 'wm.usd_import',
    '.usdz': 'wm.usd_import',
    '.obj': 'wm.obj_import',
    '.stl': 'wm.stl_import',
    '.ply': 'wm.ply_import',
    '.fbx': 'wm.fbx_import',
}

TOLERANCES = (0.01, 100.0)  # of integrator AUTO, percent of the picture's mean: least, most
SAMPLES_MAX = 2**24
REWEIGHTING_MAX = 100.0  # strength; the least is one over it
SEED_MAX = 2**31 - 1  # the largest integer of Blender's properties
BOUNCES_MAX = 1024
SHININESS_MAX = 1e6
TOON_STEPS_MAX = 64
WHITTED_DEPTH_MAX = 64
SECONDS_MAX = 1e6
THREADS_MAX = 1024
SIZE_MAX = 65536
FRAME_MAX = 1048574  # as in Blender
