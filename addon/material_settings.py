# SPDX-License-Identifier: GPL-3.0-or-later
"""`material.cotorra`: by which model a material reflects, and what the Principled node has no input for.

Base color, roughness, metallic, IOR, normal and textures are the node's, whatever the model. See export/models.py.
Presets are files in presets/cotorra/material, which call `set_metal` and `set_dielectric`.
"""

from __future__ import annotations

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty

from . import compat, optics
from .choices import (
    DISTRIBUTIONS,
    F0_MODES,
    FRESNELS,
    MASKINGS,
    MODELS,
    OREN_NAYAR_FORMS,
    SHININESS_MAX,
    SPLITS,
    TOON_STEPS_MAX,
)


def tag_owner(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Blender does not see changes of an add-on's properties: with persistent data it would render the old ones."""
    settings.id_data.update_tag()


def color(name: str, description: str, default: tuple[float, float, float]) -> FloatVectorProperty:
    return FloatVectorProperty(
        name=name,
        description=description,
        subtype='COLOR',
        size=3,
        default=default,
        min=0.0,
        soft_max=1.0,
        update=tag_owner,
    )


def three(name: str, description: str, default: tuple[float, float, float], highest: float) -> FloatVectorProperty:
    """Three numbers for red, green and blue that are no color."""
    return FloatVectorProperty(
        name=name,
        description=description,
        size=3,
        default=default,
        min=0.0,
        soft_max=highest,
        precision=4,
        update=tag_owner,
    )


def number(name: str, description: str, default: float, highest: float = 1.0) -> FloatProperty:
    return FloatProperty(
        name=name, description=description, default=default, min=0.0, soft_max=highest, precision=3, update=tag_owner
    )


def choice(name: str, description: str, items: tuple[tuple[str, str, str], ...], default: str) -> EnumProperty:
    return EnumProperty(name=name, description=description, items=items, default=default, update=tag_owner)


class CotorraMaterialSettings(bpy.types.PropertyGroup):
    model: choice('Model', 'The formula by which the surface reflects light', MODELS, 'PRINCIPLED')
    use_auto: BoolProperty(
        name='Simplify',
        description='Integrator Auto may leave out parts of the material that hardly change the picture',
        default=True,
        update=tag_owner,
    )

    # Phong and Blinn-Phong
    normalized: BoolProperty(
        name='Normalized',
        description='Scale the highlight by its shininess, so that it keeps its energy. '
        'Without it, the classic form reflects more light than arrives where ks or the angle is large',
        default=False,
        update=tag_owner,
    )
    kd: number('Diffuse', 'kd, factor on the base color. 1/π makes the diffuse part that of Lambert', 1.0 / math.pi)
    ks: number('Specular', 'ks, factor on the specular color', 0.5)
    specular_color: color('Specular Color', 'Color of the highlight', (1.0, 1.0, 1.0))
    shininess: FloatProperty(
        name='Shininess',
        description='Exponent of the highlight: larger is smaller and sharper. '
        'Blinn-Phong needs about four times that of Phong to look like it',
        default=32.0,
        min=0.0,
        max=SHININESS_MAX,
        soft_max=1000.0,
        update=tag_owner,
    )

    # Oren-Nayar
    oren_nayar_form: choice('Form', 'Which formula of Oren-Nayar', OREN_NAYAR_FORMS, 'QUALITATIVE')
    oren_nayar_sigma: FloatProperty(
        name='Sigma',
        description='Standard deviation of the slope angles of the facets. 0 is Lambert',
        subtype='ANGLE',
        default=0.5,
        min=0.0,
        max=math.pi / 2,
        update=tag_owner,
    )

    # Cook-Torrance
    distribution: choice('Distribution', 'D, how many microfacets face which way', DISTRIBUTIONS, 'GGX')
    masking: choice('Masking', 'G, how many microfacets are both seen and lit', MASKINGS, 'SMITH_CORRELATED')
    fresnel: choice('Fresnel', 'F, how much each microfacet reflects', FRESNELS, 'SCHLICK')
    f0_mode: choice('F0 from', 'What F0, the reflection of perpendicular light, is read from', F0_MODES, 'METALLIC')
    split: choice('Split', 'How the light is divided between diffuse and specular', SPLITS, 'ENERGY')
    f0: color('F0 Color', 'Reflection of perpendicular light', (0.04, 0.04, 0.04))
    f82_tint: color('F82 Tint', 'Factor on the reflection at 82°, near the edge', (1.0, 1.0, 1.0))
    # Gold, as presets/cotorra/material/gold.py has it and tells where from.
    conductor_n: three(
        'Refraction', 'n, index of refraction of a metal for red, green and blue', (0.064, 0.496, 1.46), 5.0
    )
    conductor_k: three(
        'Extinction', 'k, extinction coefficient of a metal for red, green and blue', (3.6, 2.33, 1.818), 10.0
    )

    # Toon
    toon_lit: color('Lit', 'Color of what is fully lit', (0.8, 0.8, 0.8))
    toon_shade: color('Shade', 'Color of what is not lit', (0.2, 0.2, 0.2))
    toon_steps: IntProperty(
        name='Steps',
        description='Tones, from shade to lit',
        default=2,
        min=2,
        max=TOON_STEPS_MAX,
        soft_max=8,
        update=tag_owner,
    )

    # Whitted
    ka: number('Ambient', 'ka, factor on the ambient light, for the Whitted integrator', 1.0)
    kr: number('Reflection', 'kr, part of the mirrored ray, for the Whitted integrator', 0.0)
    kt: number('Transmission', 'kt, part of the refracted ray, for the Whitted integrator', 0.0)
    absorption: three(
        'Absorption', 'How much red, green and blue is lost inside, for each metre (Whitted)', (0.0, 0.0, 0.0), 10.0
    )

    def set_metal(self, n: tuple[float, ...], k: tuple[float, ...], roughness: float) -> None:
        """Make the material a metal with these n and k, for every model that can show one; the model stays.

        Lambert, Oren-Nayar and Toon have no highlight: they show a matt surface of the metal's color.
        """
        f0 = tuple(optics.perpendicular(*pair) for pair in zip(n, k, strict=True))
        tint = tuple(optics.edge_tint(*pair) for pair in zip(n, k, strict=True))
        self.fresnel, self.conductor_n, self.conductor_k = 'CONDUCTOR', n, k
        self._set_reflection(f0, roughness)
        self.f82_tint = tint
        self.kd, self.kr, self.kt, self.absorption = 0.0, optics.mean(f0), 0.0, (0.0, 0.0, 0.0)
        self._set_node(f0, roughness, {'Metallic': 1.0, 'Specular Tint': (*tint, 1.0), 'Transmission Weight': 0.0})

    def set_dielectric(
        self,
        ior: float,
        base_color: tuple[float, float, float],
        roughness: float,
        transmission: float = 0.0,
        absorption: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Make the material glass, plastic or the like, for every model; the model stays.

        Only Principled and Whitted let light through: the other models show the surface alone.
        """
        f0 = optics.perpendicular(ior)
        self.fresnel = 'DIELECTRIC'
        self._set_reflection((f0, f0, f0), roughness)
        self.f82_tint = (1.0, 1.0, 1.0)
        self.kd = (1.0 - transmission) * (1.0 - f0) / math.pi
        self.kr, self.kt, self.absorption = f0, transmission * (1.0 - f0), absorption
        inputs = {'Metallic': 0.0, 'IOR': ior, 'Specular IOR Level': 0.5, 'Transmission Weight': transmission}
        self._set_node(base_color, roughness, inputs | {'Specular Tint': (1.0, 1.0, 1.0, 1.0)})

    def _set_reflection(self, f0: tuple[float, ...], roughness: float) -> None:
        self.f0_mode, self.f0 = 'COLOR', f0
        # Normalised, a highlight reflects its color, whatever its width.
        self.normalized, self.ks, self.specular_color = True, 1.0, f0
        self.shininess = min(optics.shininess(roughness, half_vector=self.model != 'PHONG'), SHININESS_MAX)

    def _set_node(self, base_color: tuple[float, ...], roughness: float, inputs: dict[str, object]) -> None:
        """Set the Principled node, where there is one: inputs that textures feed keep them."""
        self.toon_lit, self.toon_shade = base_color, tuple(part / 4.0 for part in base_color)
        owner = self.id_data
        tree = compat.node_tree(owner) if isinstance(owner, bpy.types.Material) else None
        node = next((node for node in tree.nodes if node.type == 'BSDF_PRINCIPLED'), None) if tree else None
        if node is None:
            return
        for name, value in {'Base Color': (*base_color, 1.0), 'Roughness': roughness, **inputs}.items():
            node.inputs[name].default_value = value
