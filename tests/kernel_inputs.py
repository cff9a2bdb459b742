# SPDX-License-Identifier: GPL-3.0-or-later
"""Random inputs for kernel functions, and a small scene with one of each thing that a kernel meets.

Values stay within what the exporter may hand over; what it must refuse is tested with the exporter.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from cotorra.shader.ies import read

from ies_files import STREET
from kernel_inputs_programs import add_programs
from kernel_inputs_textures import add_textures
from kernel_parity import Draw, Scene
from kernel_source import constants, dtype_of

# ---- Domains: each returns a function that draws n values


def integers(high: int = 1 << 32) -> Draw:
    """Whole numbers below `high`; 0 and the largest come first."""

    def draw(rng: np.random.Generator, n: int) -> np.ndarray:
        values = rng.integers(0, high, n, dtype=np.uint64).astype(np.uint32)
        values[:2] = 0, high - 1
        return values

    return draw


def uniform(low: float = 0.0, high: float = 1.0) -> Draw:
    """Numbers of [low, high), the ends (the upper one just below) first."""

    def draw(rng: np.random.Generator, n: int) -> np.ndarray:
        values = rng.uniform(low, high, n).astype(np.float32)
        values[:2] = low, np.nextafter(np.float32(high), np.float32(low))
        return np.clip(values, values[0], values[1])

    return draw


def magnitudes(low: float, high: float) -> Draw:
    """Positive numbers of all magnitudes from low to high."""
    return lambda rng, n: np.exp(rng.uniform(np.log(low), np.log(high), n)).astype(np.float32)


def choices(*values: float) -> Draw:
    return lambda rng, n: rng.choice(np.array(values), n)


def vectors(draw: Draw, size: int = 3) -> Draw:
    """Vectors of independent components."""
    return lambda rng, n: np.stack([draw(rng, n) for _ in range(size)], axis=-1)


def directions(upper: bool = False) -> Draw:
    """Unit vectors, the axes first; with `upper`, those with z above 0."""

    def draw(rng: np.random.Generator, n: int) -> np.ndarray:
        values = rng.normal(size=(n, 3))
        values[:6] = np.concatenate([np.eye(3), -np.eye(3)])[:n]
        if upper:
            values[:, 2] = np.abs(values[:, 2]) + 1e-3
        return (values / np.linalg.norm(values, axis=1, keepdims=True)).astype(np.float32)

    return draw


def points(scale: float = 3.0) -> Draw:
    return lambda rng, n: rng.normal(scale=scale, size=(n, 3)).astype(np.float32)


def colors(high: float = 1.0) -> Draw:
    return vectors(uniform(0.0, high))


def records(kind: str, /, **members: Draw) -> Draw:
    """Records of a kernel type; members that are not named are 0."""

    def draw(rng: np.random.Generator, n: int) -> np.ndarray:
        values = np.zeros(n, dtype_of(kind))
        for name, member in members.items():
            values[name] = member(rng, n)
        return values

    return draw


def materials(rng: np.random.Generator, n: int) -> np.ndarray:
    """Materials over all sockets, with the ends of each range among them."""
    return records(
        'Material',
        base_color=colors(),
        metallic=choices(0.0, 0.0, 0.3, 1.0),
        specular_tint=colors(),
        roughness=uniform(),
        emission=colors(5.0),
        ior=choices(1.0, 1.33, 1.45, 1.5, 2.4, 0.8),
        specular_level=choices(0.5, 0.5, 0.0, 1.0, 0.2),
        alpha=uniform(),
        flags=integers(256),
        pass_index=integers(100),
    )(rng, n)


def material_models(rng: np.random.Generator, n: int) -> np.ndarray:
    """Reflection models of all kinds, each with all of its parameters."""
    return records(
        'MaterialModel',
        model=integers(7),
        distribution=integers(3),
        masking=integers(4),
        fresnel=integers(4),
        f0_mode=integers(3),
        split=integers(2),
        normalized=integers(2),
        oren_nayar_form=integers(2),
        toon_steps=integers(6),
        kd=uniform(0.0, 0.3),
        ks=uniform(),
        shininess=magnitudes(0.5, 200.0),
        oren_nayar_sigma=uniform(0.0, 1.5),
        specular_color=colors(),
        f0=colors(),
        conductor_n=colors(3.0),
        conductor_k=colors(4.0),
        f82_tint=colors(),
        toon_lit=colors(),
        toon_shade=colors(),
    )(rng, n)


def lights(rng: np.random.Generator, n: int) -> np.ndarray:
    """Lamps of each type, with and without a size; rotations are orthonormal frames as the exporter writes them."""
    known = constants()
    values = records(
        'Light',
        position=points(),
        axis=directions(),
        radiance=colors(20.0),
        type=choices(known['LIGHT_POINT'], known['LIGHT_SUN'], known['LIGHT_SPOT']),
        flags=integers(32),
        visibility=integers(64),
        group=integers(3),
        max_bounces=integers(4),
        name_index=integers(9),
        spot_versine=uniform(0.05, 1.0),
        spot_scale=magnitudes(1.0, 1e3),
    )(rng, n)
    sun = values['type'] == known['LIGHT_SUN']
    sized = rng.random(n) < 0.7
    # A sun's `radius` is 1 - cos(angle / 2).
    values['radius'] = sized * np.where(sun, rng.uniform(1e-5, 0.1, n), rng.uniform(0.01, 1.0, n))
    values['cos_sun'] = np.where(sun, 1.0 - values['radius'], 0.0)
    local_z = -values['axis']
    helper = np.where(np.abs(local_z[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    local_x = np.cross(helper, local_z)
    local_x /= np.linalg.norm(local_x, axis=1, keepdims=True)
    values['local_x'], values['local_y'], values['local_z'] = local_x, np.cross(local_z, local_x), local_z
    return values


def area_lights(rng: np.random.Generator, n: int) -> np.ndarray:
    """Rectangles and ellipses, wide and long, near and far, with any spread; some are beams."""
    known = constants()
    values = lights(rng, n)
    values['type'] = known['LIGHT_AREA']
    values['flags'] = rng.choice(np.array((0, known['LIGHT_ELLIPSE'])), n) | known['LIGHT_VISIBLE']
    values['local_z'] = -values['axis']
    values['half_u'], values['half_v'] = np.exp(rng.uniform(np.log(0.02), np.log(5.0), (2, n)))
    values['radius'] = np.hypot(values['half_u'], values['half_v'])
    h = rng.choice(np.array((0.0, 0.1, 0.6, 1.2)), n)
    open_wide = rng.random(n) < 0.5
    scale = np.where(h > 0.0, 1.0 / np.maximum(np.tan(h) - h, 1e-9), 0.0)
    values['tan_spread'] = np.where(open_wide, 1e18, np.tan(h))
    values['spread_scale'] = np.where(open_wide, 1e-18, scale)
    return values


def light_programs(rng: np.random.Generator, n: int, programs: np.ndarray) -> np.ndarray:
    """Lamps with the programs of materials, in frames that scale."""
    values = np.zeros(n, dtype_of('LightProgram'))
    frames = _frames(rng, n)
    inverse = np.linalg.inv(frames)
    for column, axis in enumerate('xyz'):
        values[f'{axis}_axis'] = frames[:, :, column]
        values['space'][axis][:, :3] = inverse[:, column, :]
        values['space'][axis][:, 3] = rng.normal(size=n)
    values['space']['origin'] = rng.normal(size=(n, 3))
    chosen = rng.integers(len(programs), size=n)
    values['emission'], values['constants'] = programs['emission'][chosen], programs['constants'][chosen]
    values['mean'], values['uv_scale'] = rng.uniform(0.1, 2.0, n), rng.uniform(0.3, 2.0, n)
    return values


def light_shapes(rng: np.random.Generator, n: int) -> np.ndarray:
    """Falloffs and edges as native/scene_lights.cpp writes them; some ranges and polynomials are 0."""
    edges = rng.integers(0, 3, n)
    outer = rng.uniform(0.1, np.pi / 2, n)
    inner = outer * rng.uniform(0.0, 0.99, n)
    linear = edges == constants()['SPOT_EDGE_LINEAR']
    inner, outer = (np.where(linear, angle, 1.0 - np.cos(angle)) for angle in (inner, outer))
    values = records(
        'LightShape',
        falloff=integers(3),
        inverse_range=choices(1e30, 1.0, 0.2, 0.05),
        c0=choices(0.0, 0.0, 1.0),
        c1=choices(0.0, 0.0, 0.7),
        c2=choices(0.0, 1.0, 0.3),
    )(rng, n)
    values['edge'], values['edge_end'], values['edge_scale'] = edges, outer, 1.0 / (outer - inner)
    return values


# ---- The scene

MESHES, TRIANGLES, INSTANCES, EMITTERS, LIGHTS, MATERIALS = 4, 12, 5, 7, 6, 5
WORLD = (13, 7)  # cells of the world's table: odd, so that no axis lies between two


def _frames(rng: np.random.Generator, n: int) -> np.ndarray:
    """Invertible 3x3 matrices, some of them mirroring."""
    return np.linalg.qr(rng.normal(size=(n, 3, 3)))[0] * rng.uniform(0.5, 2.0, (n, 1, 3))


def _mesh_arrays(rng: np.random.Generator) -> dict[str, np.ndarray]:
    vertices = TRIANGLES + 2
    normals = directions()(rng, 3 * TRIANGLES)
    return {
        'positions': points(1.0)(rng, vertices),
        'triangles': np.stack([rng.permutation(vertices)[:3] for _ in range(TRIANGLES)]).astype(np.uint32),
        'corners': np.arange(3 * TRIANGLES, dtype=np.uint32).reshape(-1, 3),
        'normals': normals,
        'uv': rng.random((2 * 3 * TRIANGLES, 2), np.float32),  # two layers
        'slots': rng.integers(0, 4, TRIANGLES).astype(np.uint32),
    }


@cache
def scene() -> Scene:
    """A scene of a few meshes, objects, materials, lamps and emitters; its geometry is noise, not a picture."""
    known = constants()
    rng = np.random.default_rng(1)
    meshes = np.zeros(MESHES, dtype_of('Mesh'))
    smooth = (0, known['MESH_SMOOTH_VERTEX'], known['MESH_SMOOTH_CORNER'], known['MESH_SMOOTH_CORNER'])
    meshes['flags'] = np.array(smooth) | np.array((0, known['MESH_HAS_UV'], known['MESH_HAS_SLOTS'], 0))
    meshes['flags'][3] |= known['MESH_HAS_UV'] | known['MESH_HAS_SLOTS']
    meshes['triangle_count'] = TRIANGLES
    nested = [(mesh, name, array) for mesh in range(MESHES) for name, array in _mesh_arrays(rng).items()]

    instances = np.zeros(INSTANCES, dtype_of('Instance'))
    frames = _frames(rng, INSTANCES)
    frames[0] = np.eye(3)
    inverse = np.linalg.inv(frames)
    for column, axis in enumerate('xyz'):
        instances[f'{axis}_axis'] = frames[:, :, column]
        instances[f'normal_{axis}'] = inverse[:, column, :]
    instances['origin'][1:] = points()(rng, INSTANCES - 1)
    instances['mesh'] = np.arange(INSTANCES) % MESHES
    instances['material_base'] = np.arange(INSTANCES)
    instances['material_count'] = 3
    instances['visibility'] = known['VISIBLE_ALL']
    instances['flags'][:3] = known['INSTANCE_IDENTITY'], known['INSTANCE_MIRRORED'], 0
    instances['flags'][1:] |= known['INSTANCE_COPLANAR']
    instances['flags'] |= (rng.integers(0, 1 << 16, INSTANCES) << known['INSTANCE_TERMINATOR_SHIFT']).astype(np.uint32)

    emitters = np.zeros(EMITTERS, dtype_of('Emitter'))
    for name in ('v0', 'edge1', 'edge2'):
        emitters[name] = points(1.0)(rng, EMITTERS)
    emitters['instance'] = rng.integers(0, INSTANCES, EMITTERS)
    emitters['triangle'] = rng.integers(0, TRIANGLES, EMITTERS)
    emitters['material'] = rng.integers(0, MATERIALS, EMITTERS)
    dark = (0, known['EMITTER_DARK_ALONG'], known['EMITTER_DARK_AGAINST'])
    emitters['material'] |= np.array(dark, np.uint32)[np.arange(EMITTERS) % 3]

    data = np.zeros(1, dtype_of('SceneData'))
    data['light_count'], data['emitter_count'] = LIGHTS, EMITTERS
    data['instance_count'], data['material_count'] = INSTANCES, MATERIALS
    data['starts_at_point'] = 1
    data['world'], data['world_visibility'] = (0.2, 0.4, 0.7), known['VISIBLE_ALL']
    data['world_width'], data['world_height'], data['world_sampled'] = *WORLD, known['VISIBLE_ALL']
    data['world_sun'], data['world_sun_cap'], data['world_sun_share'] = (0.48, 0.6, 0.64), 0.05, 0.25
    data['tree_picks'], data['light_linking'] = 3, 1
    made = Scene(
        data=data,
        arrays={
            'lights': lights(rng, LIGHTS),
            'light_shapes': light_shapes(np.random.default_rng(2), LIGHTS),
            'materials': materials(rng, MATERIALS),
            'models': material_models(np.random.default_rng(2), MATERIALS),
            'material_slots': rng.integers(0, MATERIALS, INSTANCES + 4).astype(np.uint32),
            'meshes': meshes,
            'instances': instances,
            'emitters': emitters,
            **light_tree(np.random.default_rng(5)),
            'classic': np.zeros(MATERIALS, dtype_of('ClassicMaterial')),
            'albedo': rng.uniform(0.4, 1.0, known['TABLE_SIZE']).astype(np.float32),
            'world_table': world_table(np.random.default_rng(4)),
            'tables': np.append(np.random.default_rng(3).uniform(0.0, 1.0, 4 * 257), read(STREET).table).astype(
                np.float32
            ),
            'filter_table': filter_table(rng, known['FILTER_TABLE_SIZE']),
        },
        nested={'meshes': nested},
    )
    add_textures(made, rng, 3 * TRIANGLES, TRIANGLES + 2)
    assert add_programs(made) == MATERIALS, 'rows name materials with programs by this number'
    own = made.arrays['programs'][MATERIALS:]
    made.arrays['light_programs'] = light_programs(np.random.default_rng(4), LIGHTS, own)
    return made


def light_tree(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The light tree's arrays: the lamps, one of them distant, and a node of all emitters but one."""
    known = constants()
    fanout = known['LIGHT_FANOUT']
    rows = np.zeros((2, known['LIGHT_ROWS'], fanout), np.float32)
    rows[:, :3] = points()(rng, 2 * fanout).reshape(2, fanout, 3).swapaxes(1, 2)
    rows[:, known['LIGHT_ROW_RADIUS']] = rng.choice((0.0, 0.3, 2.0), (2, fanout))
    axes = slice(known['LIGHT_ROW_AXIS'], known['LIGHT_ROW_AXIS'] + 3)
    rows[:, axes] = directions()(rng, 2 * fanout).reshape(2, fanout, 3).swapaxes(1, 2)
    angles = rng.choice((0.0, 0.4, np.pi), (2, fanout))
    rows[:, known['LIGHT_ROW_COS']], rows[:, known['LIGHT_ROW_SIN']] = np.cos(angles), np.sin(angles)
    rows[:, known['LIGHT_ROW_COS_SENT']] = rng.choice((1.0, 0.5, 0.0), (2, fanout))
    rows[:, known['LIGHT_ROW_ENERGY']] = rng.uniform(0.1, 1.0, (2, fanout))
    leaf, lamp = known['LIGHT_CHILD_LEAF'], known['LIGHT_CHILD_LEAF'] | known['LIGHT_CHILD_LAMPS']
    lamps = lamp | np.arange(LIGHTS, dtype=np.uint32)
    lamps[1] |= known['LIGHT_CHILD_DISTANT']
    first = [*lamps, leaf, known['LIGHT_CHILD_TWO_SIDED'] | 1]
    second = [leaf | known['LIGHT_CHILD_TWO_SIDED'] | (i + 1) for i in range(EMITTERS - 1)]
    rows[1, known['LIGHT_ROW_ENERGY'], EMITTERS - 1 :] = 0.0
    children = np.array([first, second + [0] * (fanout - len(second))], np.uint32)
    rows[:, known['LIGHT_ROW_CHILD']] = children.view(np.float32)
    of_triangles = rng.choice((known['INVALID_ID'], LIGHTS, fanout, fanout + 3), INSTANCES * TRIANGLES)
    firsts = LIGHTS + INSTANCES + TRIANGLES * np.arange(INSTANCES)
    links = records('LightLink', sets=vectors(integers(), 2), shadows=integers(1 << 31), set=integers(64))
    return {
        'light_links': links(rng, LIGHTS + INSTANCES),
        'light_node_sets': rng.integers(0, 1 << 32, (2 * fanout, 2), np.uint32)
        | rng.integers(0, 1 << 32, (2 * fanout, 2), np.uint32),
        'light_nodes': rows.ravel(),
        'light_parents': np.array((known['INVALID_ID'], fanout - 1), np.uint32),
        'light_places': np.concatenate((np.arange(LIGHTS), firsts, of_triangles)).astype(np.uint32),
    }


def filter_table(rng: np.random.Generator, size: int) -> np.ndarray:
    """Where samples lie by random number, and what falls off from the middle."""
    return np.append(np.sort(rng.uniform(-1.0, 1.0, size)), np.linspace(1.0, 1e-2, size) ** 2).astype(np.float32)


def world_table(rng: np.random.Generator) -> np.ndarray:
    """Cumulated cells of each row, some of them black, and cumulated rows, one of them black."""
    width, height = WORLD
    cells = rng.random((height, width)) * (rng.random((height, width)) > 0.3)
    cells[2] = 0.0
    rows = cells.sum(axis=1)
    shares = np.cumsum(cells, axis=1) / np.where(rows > 0.0, rows, 1.0)[:, None]
    return np.concatenate((shares.ravel(), np.cumsum(rows) / rows.sum())).astype(np.float32)


def principled_inputs(rng: np.random.Generator, n: int) -> np.ndarray:
    """Principled surfaces with any of its layers."""
    unit = ('metallic', 'roughness', 'coat', 'coat_roughness', 'sheen', 'sheen_roughness', 'diffuse_roughness')
    unit += ('subsurface', 'subsurface_anisotropy', 'anisotropic', 'rotation', 'transmission', 'specular_level')
    fields = {name: uniform(0.2) for name in unit}
    fields |= {name: colors() for name in ('base_color', 'specular_tint', 'coat_tint', 'sheen_tint', 'emission')}
    fields |= {name: uniform(1.1, 2.0) for name in ('ior', 'coat_ior', 'film_ior')}
    fields |= {name: directions() for name in ('tangent', 'n', 'coat_n')}
    fields |= {name: integers(2) for name in ('thin_wall', 'multiscatter', 'inside')}
    fields['no_caustics'] = choices(0, 0, 1, 2, 3)
    return records('PrincipledInputs', film=choices(0.0, 0.0, 300.0), **fields)(rng, n)


def hits(rng: np.random.Generator, n: int) -> np.ndarray:
    """Points on triangles of the scene."""
    u = rng.random((n, 2)).astype(np.float32)
    u[u.sum(axis=1) > 1.0] *= 0.5
    values = records('Hit', t=magnitudes(0.01, 100.0), triangle=integers(TRIANGLES), instance=integers(INSTANCES))(
        rng, n
    )
    values['u'], values['v'] = u[:, 0], u[:, 1]
    return values


def surfaces(rng: np.random.Generator, n: int) -> np.ndarray:
    """Shading points; the shading normal leans away from the geometric one by up to a third."""
    values = records(
        'Surface',
        p=points(),
        ng=directions(),
        epsilon=magnitudes(1e-7, 1e-5),
        side=choices(-1.0, 1.0),
        terminator=choices(0.0, 0.1, 0.3),
        material=integers(MATERIALS),
        instance=integers(INSTANCES),
        triangle=integers(TRIANGLES),
    )(rng, n)
    lean = values['ng'] + 0.3 * directions()(rng, n)
    values['n'] = lean / np.linalg.norm(lean, axis=1, keepdims=True)
    u = rng.random((n, 2)).astype(np.float32) * 0.5
    values['u'], values['v'] = u[:, 0], u[:, 1]
    return values


def paths(rng: np.random.Generator, n: int) -> np.ndarray:
    """States of paths that are under way."""
    known = constants()
    glossy = known['VISIBLE_GLOSSY'] | known['RAY_BOTH_SIDES'] | 37 << known['RAY_SET_SHIFT']
    kinds = (known['VISIBLE_CAMERA'] | known['RAY_SHOWN'], known['VISIBLE_DIFFUSE'], glossy)
    return records(
        'PathState',
        throughput=colors(2.0),
        pdf=choices(0.0, 0.1, 1.0, 30.0),
        normal=directions(),
        bounce=integers(5),
        diffuse_bounces=integers(3),
        glossy_bounces=integers(3),
        ray_kind=choices(*kinds),
        random=integers(),
        transparent_bounces=integers(4),
        transmission_bounces=integers(3),
        kind_pdf=choices(0.0, 0.1, 1.0, 30.0),
        kind_weight=colors(2.0),
        min_pdf=choices(0.01, 0.3, 20.0, 1e30),
        spread=choices(0.0, 0.25, 1.0),
    )(rng, n)
