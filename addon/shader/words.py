# SPDX-License-Identifier: GPL-3.0-or-later
"""Words for what programs are made of: ops with their modes, and their arguments by name.

Which node becomes which op is told in nodes_*.py; lines and tables are put together in explain.py.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from ..export.buffers import INTERPOLATION_CLOSEST, INTERPOLATION_CUBIC
from .bump import DIRECTX
from .closures import DISTRIBUTIONS
from .nodes_input import FALLOFF, LIGHT_PATH, OBJECT_F
from .nodes_rays import INSIDE, ONLY_LOCAL, RAYCAST_ONLY_LOCAL, SAMPLES_SHIFT
from .nodes_texture import GABOR_OUTPUTS, NOISE_TYPES
from .reader import enum_numbers
from .tree import BENT_NORMAL, OWN_NORMAL, SHIFT_BIT

# The arguments of ops by name, in order; '' is never told.
ARGUMENTS = {
    'attribute': 'layer',
    'attribute_alpha': 'layer',
    'attribute_fac': 'layer',
    'uv_tangent': 'layer',
    'normal_map': 'color strength layer',
    'wireframe': 'size',
    'object_transform': 'vector',
    'bump': 'height height_x height_y strength distance normal',
    'ao': 'distance normal',
    'bevel': 'radius normal',
    'raycast': 'position direction length',
    'raycast_normal': 'position direction length',
    'fresnel': 'ior normal',
    'layer_weight': 'blend normal',
    'light_falloff': 'strength smooth',
    'layers': ('coat coat_roughness coat_ior coat_tint coat_normal sheen sheen_roughness sheen_tint normal'),
    'splat': 'number',
    'luminance': 'color',
    'average': 'vector',
    'component': 'vector',
    'combine': 'x y z',
    'math': 'a b c',
    'vector_math_v': 'a b c scale',
    'vector_math_f': 'a b c scale',
    'clamp_f': 'value min max',
    'map_range_f': 'value from_min from_max to_min to_max steps',
    'map_range_v': 'value from_min from_max to_min to_max steps',
    'mix_f': 'factor a b',
    'mix_v': 'factor a b',
    'mapping': 'vector location rotation scale',
    'vector_rotate': 'vector center axis angle rotation',
    'affine': 'vector x y z moved',
    'radial_tiling_v': 'vector sides roundness',
    'radial_tiling_f': 'vector sides roundness',
    'mix_color': 'factor a b',
    'combine_color': 'a b c',
    'separate_color': 'color',
    'hsv': 'hue saturation value factor color',
    'gamma': 'color gamma',
    'bright_contrast': 'color bright contrast',
    'invert': 'color factor',
    'blackbody': 'kelvin',
    'wavelength': 'nanometres',
    'noise_f': 'vector w scale detail roughness lacunarity offset gain distortion',
    'noise_v': 'vector w scale detail roughness lacunarity offset gain distortion',
    'voronoi_f': 'vector w scale detail roughness lacunarity smoothness exponent randomness',
    'voronoi_v': 'vector w scale detail roughness lacunarity smoothness exponent randomness',
    'white_noise_f': 'vector w',
    'white_noise_v': 'vector w',
    'wave_f': 'vector scale distortion detail detail_scale detail_roughness phase',
    'magic_v': 'vector scale distortion',
    'gradient_f': 'vector',
    'checker_f': 'vector scale',
    'brick_f': 'vector scale mortar_size mortar_smooth bias width height offset squash',
    'gabor_f': 'vector scale frequency anisotropy orientation direction',
    'ramp_v': 'factor table size',
    'ramp_alpha': 'factor table size',
    'curve_f': 'value table min max factor',
    'rgb_curve_v': 'color table min max factor',
    'vector_curve_v': 'vector table min max factor',
    'ies_f': 'direction table horizontal vertical',
    'image_v': 'vector image blend normal',
    'image_f': 'vector image blend normal',
    'environment_v': 'vector image',
}

CLOSURE_ARGUMENTS = {
    'emission': ('color',),
    'transparent': ('color',),
    'holdout': (),
    'diffuse': ('color', 'roughness', 'normal'),
    'translucent': ('color', 'normal'),
    'glossy': ('color', 'roughness', 'anisotropy', 'rotation', 'normal', 'tangent'),
    'metallic': (
        *('base', 'edge', 'ior', 'extinction', 'roughness', 'anisotropy', 'rotation', 'normal', 'tangent'),
        *('film_thickness', 'film_ior'),
    ),
    'glass': ('color', 'roughness', 'ior', 'normal', 'film_thickness', 'film_ior'),
    'refraction': ('color', 'roughness', 'ior', 'normal'),
    'sheen': ('color', 'roughness', 'normal'),
    'toon': ('color', 'size', 'smooth', 'normal'),
    'principled': (
        *('base', 'metallic', 'roughness', 'ior', 'normal', 'diffuse_roughness', 'subsurface', 'subsurface_radius'),
        *('subsurface_scale', 'subsurface_ior', 'subsurface_anisotropy', 'specular_level', 'specular_tint'),
        *('anisotropic', 'rotation', 'tangent', 'transmission', 'coat', 'coat_roughness', 'coat_ior', 'coat_tint'),
        *('coat_normal', 'sheen', 'sheen_roughness', 'sheen_tint', 'emission', 'film_thickness', 'film_ior'),
        *('thin_wall', 'alpha'),
    ),
}

# Arguments of closures that mean nothing where another is 0.
ONLY_WITH = {
    'rotation': ('anisotropy', 'anisotropic'),
    'tangent': ('anisotropy', 'anisotropic'),
    'film_ior': ('film_thickness',),
    **dict.fromkeys(('subsurface_radius', 'subsurface_scale', 'subsurface_ior'), ('subsurface',)),
    'subsurface_anisotropy': ('subsurface',),
    **dict.fromkeys(('coat_roughness', 'coat_ior', 'coat_tint', 'coat_normal'), ('coat',)),
    **dict.fromkeys(('sheen_roughness', 'sheen_tint'), ('sheen',)),
}
# Arguments that are off at 0, and what emits and lets through, which is told apart.
OFF_AT_0 = frozenset(
    (
        *('anisotropy', 'anisotropic', 'film_thickness', 'subsurface', 'coat', 'sheen', 'transmission'),
        *('diffuse_roughness', 'thin_wall'),
    )
)
TOLD_APART = {'principled': frozenset(('emission', 'alpha'))}

SIGNS = {'ADD': '+', 'SUBTRACT': '-', 'MULTIPLY': '×', 'DIVIDE': '/', 'SCALE': '×'}
ONE_OPERAND = frozenset(
    (
        *('SQRT', 'INVERSE_SQRT', 'ABSOLUTE', 'EXPONENT', 'SIGN', 'ROUND', 'FLOOR', 'CEIL', 'TRUNC', 'FRACT'),
        *('FRACTION', 'SINE', 'COSINE', 'TANGENT', 'ARCSINE', 'ARCCOSINE', 'ARCTANGENT', 'SINH', 'COSH', 'TANH'),
        *('RADIANS', 'DEGREES', 'NORMALIZE', 'LENGTH'),
    )
)
THREE_OPERANDS = frozenset(('MULTIPLY_ADD', 'COMPARE', 'SMOOTH_MIN', 'SMOOTH_MAX', 'WRAP', 'FACEFORWARD'))


@cache
def choice(kind: str, member: str, number: int) -> str:
    """The name of a choice of Blender's by its number."""
    names = {value: name for name, value in enum_numbers(f'ShaderNode{kind}', member).items()}
    return names.get(number, str(number))


def operation(name: str, mode: int) -> str:
    """The operation of math and vector math."""
    return choice('Math' if name == 'math' else 'VectorMath', 'operation', mode & 0xFFFF)


def op_words(name: str, mode: int) -> str:
    """An op and its mode, such as 'noise 3D FBM normalized'."""
    shift = mode >> SHIFT_BIT
    aside = ''
    if shift:
        width = float(np.array(mode & 0xFFFF, np.uint16).view(np.float16))
        aside, mode = f' {width:.3g} px {" xy"[shift]} aside', 0
    made = MODES.get(name)
    words = made(mode) if made is not None else (f'mode {mode}' if mode else '')
    return f'{NAMES.get(name, name.replace("_", " "))} {words}'.strip() + aside


NAMES = {
    'math': 'math',
    'vector_math_v': 'vector math',
    'vector_math_f': 'vector math',
    'attribute_fac': 'attribute number',
    'object_info_v': 'object',
    'object_info_f': 'object',
    'ao': 'ambient occlusion',
    'splat': 'three of a number',
    'combine': 'combine XYZ',
    'clamp_f': 'clamp',
    'map_range_f': 'map range',
    'map_range_v': 'map range',
    'mix_f': 'mix',
    'mix_v': 'mix vector',
    'radial_tiling_v': 'radial tiling',
    'radial_tiling_f': 'radial tiling',
    'hsv': 'hue saturation value',
    'noise_f': 'noise',
    'noise_v': 'noise color',
    'voronoi_f': 'voronoi',
    'voronoi_v': 'voronoi',
    'white_noise_f': 'white noise',
    'white_noise_v': 'white noise color',
    'wave_f': 'wave',
    'magic_v': 'magic',
    'gradient_f': 'gradient',
    'checker_f': 'checker',
    'brick_f': 'brick',
    'gabor_f': 'gabor',
    'ramp_v': 'color ramp',
    'ramp_alpha': 'color ramp alpha',
    'curve_f': 'float curve',
    'rgb_curve_v': 'RGB curves',
    'vector_curve_v': 'vector curves',
    'ies_f': 'IES',
    'image_v': 'image',
    'image_f': 'image alpha',
    'environment_v': 'environment',
    'layers': 'passes coat and sheen',
}


def _listed(*names: str) -> Callable[[int], str]:
    return lambda mode: names[mode].lower() if mode < len(names) else str(mode)


def _bits(*words: str) -> str:
    return ' '.join(word for word in words if word)


def _mapped_range(mode: int) -> str:
    return _bits(choice('MapRange', 'interpolation_type', mode & 0xFF), 'clamped' if mode & 0x100 else '')


def _mix_color(mode: int) -> str:
    return _bits(choice('Mix', 'blend_type', mode & 0xFF), 'clamped' if mode & 0x200 else '')


def _noise(mode: int) -> str:
    kind = NOISE_TYPES[(mode >> 2) & 7]
    return _bits(f'{(mode & 3) + 1}D', kind, 'normalized' if mode & 32 and kind == 'FBM' else '')


def _voronoi(outputs: tuple[str, ...]) -> Callable[[int], str]:
    def words(mode: int) -> str:
        feature = choice('TexVoronoi', 'feature', (mode >> 2) & 7)
        metric = choice('TexVoronoi', 'distance', (mode >> 5) & 7)
        if feature in ('DISTANCE_TO_EDGE', 'N_SPHERE_RADIUS') or mode & 3 == 0:
            metric = ''
        shown = outputs[(mode >> 8) & 7]
        return _bits(f'{(mode & 3) + 1}D', feature, metric, shown, 'normalized' if mode >> 11 & 1 else '')

    return words


def _wave(mode: int) -> str:
    kind = choice('TexWave', 'wave_type', mode & 1)
    shift, member = (1, 'bands_direction') if kind == 'BANDS' else (3, 'rings_direction')
    return _bits(kind, choice('TexWave', member, (mode >> shift) & 3), choice('TexWave', 'wave_profile', mode >> 5))


def _image(mode: int) -> str:
    filtered = {INTERPOLATION_CLOSEST: 'Closest', INTERPOLATION_CUBIC: 'Cubic'}.get(mode & 3, 'Linear')
    projection = choice('TexImage', 'projection', (mode >> 4) & 3)
    return _bits(filtered, choice('TexImage', 'extension', (mode >> 2) & 3), '' if projection == 'FLAT' else projection)


def _environment(mode: int) -> str:
    return choice('TexEnvironment', 'projection', (mode >> 4) & 3)


def _transform(mode: int) -> str:
    start, end = (choice('VectorTransform', 'convert_from', mode >> shift & 3) for shift in (2, 4))
    return _bits(choice('VectorTransform', 'vector_type', mode & 3), start, 'to', end)


def _normal_map(mode: int) -> str:
    return _bits(choice('NormalMap', 'space', mode & 7), 'DirectX' if mode & DIRECTX else '')


def _rays(mode: int) -> str:
    return f'{mode >> SAMPLES_SHIFT} rays'


def _occlusion(mode: int) -> str:
    return _bits(_rays(mode), 'inside' if mode & INSIDE else '', 'only local' if mode & ONLY_LOCAL else '')


def _raycast(mode: int) -> str:
    return 'only local' if mode & RAYCAST_ONLY_LOCAL else ''


MODES: dict[str, Callable[[int], str]] = {
    'object_info_v': _listed('Location', 'Color'),
    'object_info_f': _listed(*OBJECT_F),
    'light_path': lambda mode: LIGHT_PATH[mode] if mode < len(LIGHT_PATH) else str(mode),
    'tangent': lambda mode: f'radial {"XYZ"[mode]}',
    'normal_map': _normal_map,
    'wireframe': _listed('', 'pixels'),
    'object_transform': _transform,
    'bump': _listed('', 'inverted'),
    'ao': _occlusion,
    'bevel': _rays,
    'raycast': _raycast,
    'raycast_normal': _raycast,
    'layer_weight': _listed('Fresnel', 'Facing'),
    'light_falloff': _listed(*FALLOFF),
    'component': _listed('x', 'y', 'z'),
    'math': lambda mode: _bits(operation('math', mode), 'clamped' if mode >> 16 else ''),
    'vector_math_v': lambda mode: operation('vector_math_v', mode),
    'vector_math_f': lambda mode: operation('vector_math_f', mode),
    'clamp_f': lambda mode: choice('Clamp', 'clamp_type', mode),
    'map_range_f': _mapped_range,
    'map_range_v': _mapped_range,
    'mix_f': _listed('', 'clamped'),
    'mix_v': _listed('', 'clamped'),
    'mapping': lambda mode: choice('Mapping', 'vector_type', mode),
    'vector_rotate': lambda mode: _bits(
        choice('VectorRotate', 'rotation_type', mode & 0xFF), 'inverted' if mode >> 8 else ''
    ),
    'radial_tiling_v': _listed('', 'normalized'),
    'radial_tiling_f': lambda mode: _bits(('id', 'width', 'rotation')[mode >> 1 & 3], 'normalized' if mode & 1 else ''),
    'mix_color': _mix_color,
    'combine_color': lambda mode: choice('CombineColor', 'mode', mode),
    'separate_color': lambda mode: choice('SeparateColor', 'mode', mode),
    'noise_f': _noise,
    'noise_v': _noise,
    'voronoi_f': _voronoi(('', 'w', 'radius')),
    'voronoi_v': _voronoi(('color', 'position')),
    'white_noise_f': lambda mode: f'{mode + 1}D',
    'white_noise_v': lambda mode: f'{mode + 1}D',
    'wave_f': _wave,
    'magic_v': lambda mode: f'depth {mode}',
    'gradient_f': lambda mode: choice('TexGradient', 'gradient_type', mode),
    'brick_f': lambda mode: f'offset every {mode & 0xFF}, squash every {mode >> 8}',
    'gabor_f': lambda mode: _bits(('2D', '3D')[mode & 1], GABOR_OUTPUTS[mode >> 1].lower()),
    'ramp_v': _listed('', 'constant'),
    'ramp_alpha': _listed('', 'constant'),
    'curve_f': _listed('', 'extrapolated'),
    'rgb_curve_v': _listed('', 'extrapolated'),
    'vector_curve_v': _listed('', 'extrapolated'),
    'image_v': _image,
    'image_f': _image,
    'environment_v': _environment,
}


def unused(name: str, mode: int) -> frozenset[str]:
    """The arguments that an op of this mode does not read."""
    match name:
        case 'math' | 'vector_math_v' | 'vector_math_f':
            what = operation(name, mode)
            if what == 'SCALE':
                return frozenset('bc')
            last = 'scale' if what != 'REFRACT' else ''
            operands = frozenset('bc') if what in ONE_OPERAND else frozenset('c')
            return (frozenset() if what in THREE_OPERANDS else operands) | {last}
        case 'noise_f' | 'noise_v':
            kind = NOISE_TYPES[(mode >> 2) & 7]
            hidden = set() if kind in ('HYBRID_MULTIFRACTAL', 'RIDGED_MULTIFRACTAL') else {'gain'}
            hidden |= {'offset'} if kind in ('FBM', 'MULTIFRACTAL') else set()
            return _dimensions(mode) | hidden
        case 'voronoi_f' | 'voronoi_v':
            hidden = set() if choice('TexVoronoi', 'feature', (mode >> 2) & 7) == 'SMOOTH_F1' else {'smoothness'}
            hidden |= set() if choice('TexVoronoi', 'distance', (mode >> 5) & 7) == 'MINKOWSKI' else {'exponent'}
            return _dimensions(mode) | hidden
        case 'white_noise_f' | 'white_noise_v':
            return _dimensions(mode)
        case 'map_range_f' | 'map_range_v':
            return (
                frozenset()
                if choice('MapRange', 'interpolation_type', mode & 0xFF) == 'STEPPED'
                else frozenset(('steps',))
            )
        case 'vector_rotate':
            kind = choice('VectorRotate', 'rotation_type', mode & 0xFF)
            if kind == 'EULER_XYZ':
                return frozenset(('axis', 'angle'))
            return frozenset(('rotation',)) if kind == 'AXIS_ANGLE' else frozenset(('rotation', 'axis'))
        case 'gabor_f':
            return frozenset(('orientation',) if mode & 1 else ('direction',))
        case 'image_v' | 'image_f':
            is_box = choice('TexImage', 'projection', (mode >> 4) & 3) == 'BOX'
            return frozenset() if is_box else frozenset(('blend', 'normal'))
        case 'normal_map':
            return frozenset() if choice('NormalMap', 'space', mode & 7) == 'TANGENT' else frozenset(('layer',))
    return frozenset(('table', 'size'))


def _dimensions(mode: int) -> frozenset[str]:
    return (frozenset(('vector',)), frozenset('w'), frozenset('w'), frozenset())[mode & 3]


def closure_words(name: str, mode: int) -> str:
    """A closure and its mode, such as 'glossy MULTI_GGX'."""
    mode &= ~(OWN_NORMAL | BENT_NORMAL)
    match name:
        case 'glossy' | 'glass' | 'refraction':
            return f'{name} {DISTRIBUTIONS[mode]}'
        case 'metallic':
            kind = 'PHYSICAL_CONDUCTOR' if mode & 256 else 'F82'
            return f'{name} {kind} {DISTRIBUTIONS[mode & 255]}'
        case 'sheen':
            return f'{name} {("ASHIKHMIN", "MICROFIBER")[mode & 1]}'
        case 'toon':
            return f'{name} {("DIFFUSE", "GLOSSY")[mode & 1]}'
        case 'principled':
            return f'{name} {"MULTI_GGX" if mode & 1 else "GGX"}'
    return name
