# SPDX-License-Identifier: GPL-3.0-or-later
"""Hypothesis' strategies for scenes as plain data, which builder.py makes into Blender's.

Most numbers are ordinary, so that most of each scene can be rendered; some are as wild as single precision can hold.
What comes first in a choice is what a failing scene is shrunk to.
"""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

Setting = dict[str, Any]
Catalogue = dict[str, Any]  # as catalogue.py reads it
WILD = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-45, 1e-38, 1e-20, 1e-7, 1e7, 1e20, 3.4e38, -3.4e38]),
    st.sampled_from([float('nan'), float('inf'), float('-inf')]),
    st.floats(width=32),
)
WHOLE = st.sampled_from([0, 1, -1, 2, 7, 255, 65535, 2**24, 2**31 - 1, -(2**31)])
STEPS = st.integers(0, 64)
SEEDS = st.integers(0, 2**31 - 1)
PRIMITIVES = ('quad', 'cube', 'sphere', 'line', 'point', 'loose', 'empty', 'huge', 'tiny', 'far', 'many')
DATA = ('CURVE', 'FONT', 'META', 'SURFACE', 'VOLUME', 'POINTCLOUD', 'CURVES', 'LATTICE', 'EMPTY')


def seldom(strategy: st.SearchStrategy, rest: Any = None, one_in: int = 4) -> st.SearchStrategy:
    """The strategy's once in a while, else `rest`."""
    return st.one_of(*[st.just(rest)] * (one_in - 1), strategy)


def number(least: float, most: float) -> st.SearchStrategy[float]:
    """An ordinary number between the two, or, once in ten, any at all."""
    least, most = max(least, -10.0), min(most, 10.0)
    ordinary = STEPS.map(lambda step: least + (most - least) * step / 64.0)
    return st.integers(0, 9).flatmap(lambda dice: WILD if dice == 9 else ordinary)


def vector(least: float, most: float, length: int = 3) -> st.SearchStrategy[list[float]]:
    return st.lists(number(least, most), min_size=length, max_size=length)


def value(setting: Setting) -> st.SearchStrategy[Any]:
    """Anything that a property may be told to hold."""
    if setting['type'] == 'ENUM':
        return st.sampled_from(setting['items'])
    if setting['type'] == 'BOOLEAN':
        one = st.booleans()
    elif setting['type'] == 'INT':
        least, most = (int(min(max(limit, -(2**31)), 2**31 - 1)) for limit in setting['limits'])
        ordinary = st.integers(least, min(most, max(least, 0) + 64))
        one = ordinary if setting['held'] else st.one_of(ordinary, ordinary, WHOLE)
    else:
        one = number(*setting['limits'])
    length = setting.get('length', 0)
    return st.lists(one, min_size=length, max_size=length) if length else one


def settings(known: dict[str, Setting], most: int = 6) -> st.SearchStrategy[dict[str, Any]]:
    """Up to `most` of these properties, with values."""
    return st.lists(st.sampled_from(sorted(known)), max_size=most, unique=True).flatmap(
        lambda names: st.fixed_dictionaries({name: value(known[name]) for name in names})
    )


def trees(kinds: tuple[str, ...]) -> st.SearchStrategy[dict[str, Any]]:
    """A node tree by its seed; wild: its numbers are any."""
    return st.fixed_dictionaries({'kind': st.sampled_from(kinds), 'seed': SEEDS, 'wild': st.booleans()})


def transforms() -> st.SearchStrategy[dict[str, Any]]:
    scale = st.one_of(vector(-2.0, 2.0), st.sampled_from([[1.0] * 3, [-1.0, 1.0, 1.0], [0.0] * 3, [1.0, 1.0, 0.0]]))
    return st.fixed_dictionaries(
        {},
        optional={
            'location': vector(-2.0, 2.0),
            'rotation_euler': vector(-3.0, 3.0),
            'scale': scale,
            'matrix_parent_inverse': seldom(vector(-2.0, 2.0, 16), [1.0] * 16),
        },
    )


def meshes() -> st.SearchStrategy[dict[str, Any]]:
    corners = st.lists(vector(-2.0, 2.0), min_size=3, max_size=8)
    faces = st.lists(st.lists(st.integers(0, 7), min_size=3, max_size=6, unique=True), min_size=1, max_size=6)
    own = st.fixed_dictionaries({'kind': st.just('own'), 'vertices': corners, 'faces': faces})
    attributes = {
        'smooth': st.booleans(),
        'uv': seldom(vector(-2.0, 2.0, 2)),
        'paint': seldom(vector(0.0, 1.0, 4)),
        'normals': seldom(vector(-1.0, 1.0)),
        'slots': seldom(WHOLE),
    }
    made = st.fixed_dictionaries({'kind': st.sampled_from(PRIMITIVES)})
    return st.tuples(st.one_of(made, own), st.fixed_dictionaries({}, optional=attributes)).map(lambda p: p[0] | p[1])


def materials(known: Catalogue) -> st.SearchStrategy[dict[str, Any]]:
    principled = st.fixed_dictionaries(
        {
            'kind': st.just('principled'),
            'inputs': settings(known['principled'], 8),
            'model': seldom(settings(known['material_settings'], 8)),
            'bump': seldom(vector(-1.0, 1.0)),
            'image': seldom(st.sampled_from(['lost', 'empty', 'wild', 'spots'])),
        }
    )
    return st.one_of(
        principled,
        trees(('surface', 'surface', 'emission', 'forest')),
        st.fixed_dictionaries({'kind': st.just('none')}),
    )


def modified(known: Catalogue) -> st.SearchStrategy[list[dict[str, Any]]]:
    one = st.sampled_from(sorted(known['modifiers'])).flatmap(
        lambda kind: st.fixed_dictionaries({'kind': st.just(kind), 'settings': settings(known['modifiers'][kind], 4)})
    )
    return st.lists(one, max_size=2)


def objects(known: Catalogue) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries(
        {
            'mesh': st.one_of(meshes(), meshes(), meshes(), st.fixed_dictionaries({'kind': st.sampled_from(DATA)})),
            'place': transforms(),
            'materials': st.lists(materials(known), max_size=3),
        },
        optional={
            'modifiers': modified(known),
            'instances': st.fixed_dictionaries(
                {
                    'kind': st.sampled_from(['collection', 'vertices', 'faces']),
                    'points': st.lists(vector(-2.0, 2.0), min_size=1, max_size=4),
                    'place': transforms(),
                }
            ),
            'settings': settings(known['object'], 3),
        },
    )


def lights(known: Catalogue) -> st.SearchStrategy[dict[str, Any]]:
    return st.sampled_from(sorted(known['lights'])).flatmap(
        lambda kind: st.fixed_dictionaries(
            {'kind': st.just(kind), 'settings': settings(known['lights'][kind], 8), 'place': transforms()},
            optional={
                'own': settings(known['light_settings']),
                'tree': trees(('emission',)),
                'ies': st.integers(0, 5),
            },
        )
    )


def worlds() -> st.SearchStrategy[dict[str, Any] | None]:
    plain = st.fixed_dictionaries({'kind': st.just('plain'), 'color': vector(0.0, 1.0), 'strength': number(0.0, 2.0)})
    sky = st.fixed_dictionaries({'kind': st.just('sky'), 'seed': SEEDS, 'wild': st.booleans()})
    image = st.fixed_dictionaries({'kind': st.just('image'), 'image': st.sampled_from(['lost', 'wild', 'spots'])})
    return st.one_of(plain, plain, st.none(), trees(('emission', 'background')), sky, image)


def render(known: Catalogue) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries(
        {
            'integrator': st.sampled_from(['PATH', 'PATH', 'PATH', 'DIRECT', 'WHITTED', 'AO', 'TOON']),
            'samples': st.integers(1, 2),
            'settings': settings(known['scene_settings'], 6),
            'override': seldom(settings(known['material_settings'], 6), one_in=8),
            'cycles': seldom(settings(known['cycles'], 6)),
            'layer': settings(known['layer'], 8),
            'layer_settings': settings(known['layer_settings'], 4),
            'transparent': st.booleans(),
            'border': seldom(vector(0.0, 1.0, 4), one_in=8),
        }
    )


def scenes(known: Catalogue) -> st.SearchStrategy[dict[str, Any]]:
    """The whole."""
    camera = st.fixed_dictionaries({'settings': settings(known['camera'], 4), 'place': transforms()})
    return st.fixed_dictionaries(
        {
            'objects': st.lists(objects(known), min_size=1, max_size=4),
            'lights': st.lists(lights(known), max_size=3),
            'world': worlds(),
            'camera': seldom(camera, one_in=6),
            'render': render(known),
        }
    )
