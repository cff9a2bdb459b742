# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's side of the native module, run by test_native_sanitizers.py in a process of its own, without Blender.

usage: module_border.py MODULE EMBREE. It fails by an exception; the sanitizer fails by itself.
"""

from __future__ import annotations

import dataclasses
import gc
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np


def load(name: str, path: str | Path) -> ModuleType:
    """A module from this very file: an installed one of its name must not come first."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def package(name: str, folder: Path) -> None:
    """A package whose own code, which needs Blender, is not run."""
    made = ModuleType(name)
    made.__path__ = [str(folder)]
    sys.modules[name] = made


library, embree = sys.argv[1:]
cotorra_native = load('cotorra_native', library)
ADDON = Path(__file__).resolve().parent.parent / 'addon'
package('cotorra', ADDON)
package('cotorra.export', ADDON / 'export')
package('cotorra.shader', ADDON / 'shader')
buffers = importlib.import_module('cotorra.export.buffers')
shaders = importlib.import_module('shaders')

F32, U32, I32 = np.float32, np.uint32, np.int32
WIDTH, HEIGHT = 37, 21
SCALE = 10  # of Vector Math


def ones(kind: type, *names: str, count: int = 1) -> dict[str, np.ndarray]:
    return {name: np.ones(count, kind) for name in names}


def make_scene() -> object:
    """A quad under a lamp; its arrays own their memory and have no padding."""
    quad = buffers.Mesh(
        name='quad',
        positions=np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], F32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], U32),
        corners=np.arange(6, dtype=U32).reshape(2, 3),
        uv=np.zeros((6, 2), F32),
    )
    frame = np.eye(3, 4, dtype=F32)[None]
    return buffers.SceneBuffers(
        meshes=(quad,),
        instances=buffers.Instances(
            mesh=np.zeros(1, U32),
            transform=frame.copy(),
            material_base=np.zeros(1, U32),
            material_count=np.ones(1, U32),
            pass_index=np.zeros(1, I32),
            visibility=np.full(1, 63, U32),
            light_group=np.full(1, -1, I32),
            terminator=np.zeros(1, F32),
        ),
        materials=buffers.Materials(
            pass_index=np.zeros(1, I32), emission_sampling=np.ones(1, U32), shader=np.zeros(1, I32)
        ),
        shaders=(shaders.principled(),),
        material_slots=np.zeros(1, U32),
        lights=buffers.Lights(
            type=np.zeros(1, U32),
            strength=np.full((1, 3), 50.0, F32),
            transform=frame + np.array([0, 0, 0, 2], F32),
            size=np.full(1, 0.1, F32),
            light_group=np.full(1, -1, I32),
            visibility=np.full(1, 63, U32),
            **ones(F32, 'spot_size', 'spot_blend'),
            **ones(U32, 'soft_falloff', 'normalize', 'cast_shadow', 'use_mis', 'max_bounces'),
        ),
        world=buffers.World(color=(0.1, 0.1, 0.1)),
    )


def make_textured_scene() -> object:
    """The quad with images at its inputs and holes in it; no image's bytes make whole words but the last's."""
    plain = make_scene()
    rng = np.random.default_rng(0)
    images = tuple(
        buffers.Image(f'image {channels}', (rng.random((3, 5, channels)) * 200).astype(kind))
        for channels, kind in ((1, np.uint8), (2, np.float16), (3, np.uint16), (4, F32))
    )
    sketch = shaders.Sketch()
    places = [sketch.op('attribute', 0.0), sketch.op('generated'), sketch.op('object_position'), sketch.op('position')]

    def read(use: int, name: str = 'image_v') -> object:
        at = sketch.op('affine', places[use % 4], (7.0, 0.0, 0.0), (0.0, -5.0, 0.0), 0.0, (-3.0, 2.0, 0.0))
        mode = use % 3 | use % 4 << 2
        value = sketch.op(name, at, use % 4, 0.0, 0.0, mode=mode)
        return value if name == 'image_f' else sketch.op('vector_math_v', value, 0.0, 0.0, 0.005, mode=SCALE)

    colors = ('base_color', 'specular_tint', 'emission')
    numbers = ('metallic', 'roughness', 'ior', 'specular_level')
    values = {name: read(use) for use, name in enumerate(colors)}
    values |= {name: sketch.op('component', read(use + 3)) for use, name in enumerate(numbers)}
    values['alpha'] = read(6, 'image_f')  # clipped: there are holes
    sketch.principled(**values, normal=sketch.op('normal_map', read(8), 1.0, 0.0))
    mesh = dataclasses.replace(
        plain.meshes[0],
        uv=rng.random((6, 2)).astype(F32),
        tangents=np.tile(np.array([1, 0, 0, 1], F32), (6, 1)),
        generated=rng.random((4, 3)).astype(F32),
    )
    return dataclasses.replace(
        plain,
        meshes=(mesh,),
        images=images,
        shaders=(sketch.shader(),),
        tangent_layers=(0,),
    )


def render_textured(settings: object) -> None:
    """Images outlive the arrays' names, and rays that pass surfaces stay within what they may note."""
    for limit in (0, 1, 8, 1000):
        scene = build(make_textured_scene())
        gc.collect()
        chosen = dataclasses.replace(settings, transparent_bounces=limit, transparent_film=True)
        session = cotorra_native.Session(scene, make_camera(), chosen)
        session.start()
        assert session.wait(60.0)
        image = np.zeros((HEIGHT, WIDTH, 4), F32)
        session.read('combined', image)
        assert np.isfinite(image).all() and 0.0 < image[..., 3].mean() < 1.0
        assert {'programs', 'transparency'} <= set(session.stats()['features'])


def render_wild(settings: object) -> None:
    """Every op, whatever its arguments are, constants and what is computed: no place beyond an array is read."""
    sketch = shaders.Sketch()
    far = sketch.op('math', sketch.op('component', sketch.op('position')), 1e38, 0.0, mode=2)
    wild = (far, np.nan, np.inf, -np.inf, -1.0, 3e9, 1e38, 70000.5)
    total, uses = sketch.op('splat', far), 0
    for name, (number, result, arguments) in cotorra_native.shader_ops().items():
        if name.startswith(('ramp', 'curve', 'rgb_curve', 'vector_curve', 'ies')):  # compiling demands their places
            continue
        for trial in range(3):
            values = []
            for kind in arguments:
                uses += 1
                value = far if name.startswith(('image', 'environment')) else wild[uses % len(wild)]
                values.append(sketch.op('splat', value) if kind == 'v' else value)
            place = 8 if name in ('ao', 'bevel') else 30  # of a number of rays, or of where the point is shifted to
            mode = (37 * uses & 63) | (trial << place if number < 48 else 0)
            value = sketch.op(name, *values, mode=mode)
            total = sketch.op('vector_math_v', total, value if result == 'v' else sketch.op('splat', value), 0.0, 1.0)
    sketch.principled(
        base_color=total, roughness=far, normal=total, emission=total, alpha=sketch.op('component', total)
    )
    scene = build(dataclasses.replace(make_textured_scene(), shaders=(sketch.shader('wild'),)))
    session = cotorra_native.Session(scene, make_camera(), dataclasses.replace(settings, samples=2))
    session.start()
    assert session.wait(120.0)
    image = np.zeros((HEIGHT, WIDTH, 4), F32)
    session.read('combined', image)
    assert np.isfinite(image).all()


def make_camera() -> object:
    transform = np.eye(3, 4, dtype=F32)
    transform[2, 3] = 3.0
    window = (-0.5, 0.5, -0.3, 0.3)
    return buffers.Camera('PERSP', transform, window, (0.1, 100.0), (WIDTH, HEIGHT), (0, 0, WIDTH, HEIGHT))


def build(scene: object) -> object:
    return cotorra_native.Scene(scene, threads=2, embree=embree)


def refused(function: object, *arguments: object) -> bool:
    try:
        function(*arguments)
    except (ValueError, TypeError):
        return True
    return False


def with_mesh(scene: object, **arrays: object) -> object:
    return dataclasses.replace(scene, meshes=(dataclasses.replace(scene.meshes[0], **arrays),))


def main() -> None:
    settings = buffers.RenderSettings(integrator='PATH', samples=4, threads=2, passes=('combined', 'uv', 'depth'))
    scene = build(make_scene())
    gc.collect()  # the exporter's arrays are nobody's but the scene's now
    session = cotorra_native.Session(scene, make_camera(), settings)
    del scene
    gc.collect()
    session.start()
    assert session.wait(60.0)
    image = np.zeros((HEIGHT, WIDTH, 4), F32)
    session.read('combined', image)
    assert np.isfinite(image).all() and image[..., 3].max() == 1.0
    session.stats()

    render_textured(settings)
    render_wild(settings)

    # Arrays that do not fit are refused, and nothing is written through them.
    for out in (image[:, :, :3], image[:-1], image.astype(np.float64), image[:, ::2], np.zeros(3, F32)):
        assert refused(session.read, 'combined', out), out.shape
    assert refused(session.read, 'no such pass', image)

    good = make_scene()
    mesh = good.meshes[0]
    textured = make_textured_scene()
    (program,) = textured.shaders
    for wrong in (
        with_mesh(good, positions=mesh.positions.astype(np.float64)),
        with_mesh(good, positions=mesh.positions[:, :2]),
        with_mesh(good, positions=np.asfortranarray(mesh.positions)),
        with_mesh(good, positions=[[0.0, 0.0, 0.0]]),
        with_mesh(good, triangles=mesh.triangles.astype(np.int64)),
        with_mesh(good, triangles=mesh.triangles + 9),
        with_mesh(good, uv=mesh.uv[:3]),
        dataclasses.replace(good, material_slots=np.zeros(1, np.uint8)),
        dataclasses.replace(good, lights=dataclasses.replace(good.lights, strength=np.zeros(1, F32))),
        dataclasses.replace(good, instances=dataclasses.replace(good.instances, transform=np.zeros((1, 3), F32))),
        dataclasses.replace(good, materials=dataclasses.replace(good.materials, shader=np.ones(1, I32))),
        dataclasses.replace(good, world=buffers.World(shader=1)),
        dataclasses.replace(textured, images=textured.images[:3]),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, args=program.args[:-1]),)),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, args=program.args + 1),)),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, modes=program.modes[1:]),)),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, ops=program.ops + U32(400)),)),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, constants=program.constants[:1]),)),
        dataclasses.replace(textured, shaders=(dataclasses.replace(program, closure_args=program.closure_args[1:]),)),
    ):
        assert refused(build, wrong), wrong

    # A session that is dropped, and one that is read, while their threads run.
    long = dataclasses.replace(settings, samples=1 << 20)
    dropped = cotorra_native.Session(build(make_scene()), make_camera(), long)
    dropped.start()
    running = cotorra_native.Session(build(make_scene()), make_camera(), long)
    running.start()
    del dropped
    gc.collect()
    for _ in range(3):
        running.read('combined', image)
        assert not running.wait(0.02)
    running.cancel()
    assert running.wait(60.0)

    stopped = False
    try:
        cotorra_native.Scene(make_scene(), threads=1, embree=embree, should_cancel=lambda: 1 / 0)
    except ZeroDivisionError:
        stopped = True
    except cotorra_native.Cancelled:
        raise AssertionError('the error of should_cancel was lost') from None
    print('the border holds', 'with' if stopped else 'without', 'an interrupted build')


main()
