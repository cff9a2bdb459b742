# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that a command at a terminal is about: Blender is loaded, the engine registered, and the file opened or the
demo built; what its picture is put together from; and the render of it, with Blender's own words where it fails.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from . import choices, outputs, watch
from .terminal import WRONG_ARGUMENTS, CommandError

if TYPE_CHECKING:
    import bpy

BLENDER_BYTES = 1300 * 2**20  # of addresses, before a file is opened (measured, 5.2); given less, Blender crashes


def is_blend(path: Path) -> bool:
    """Whether it is a .blend file, by its name (backups end in .blend1) or by its first bytes, compressed or not."""
    if path.suffix.lower().startswith('.blend'):
        return True
    with path.open('rb') as file:
        return file.read(7).startswith((b'BLENDER', b'\x28\xb5\x2f\xfd', b'\x1f\x8b'))


def require_source(file: Path) -> None:
    """Fail where it cannot be read, or is none that can be opened. Blender is not needed to tell."""
    outputs.require_readable(file)
    if not is_blend(file) and file.suffix.lower() not in choices.IMPORTERS:
        raise CommandError(f'{file}: is none of .blend, {", ".join(choices.IMPORTERS)}', WRONG_ARGUMENTS)


def require_address_space() -> None:
    """Fail where a limit on the process's memory is too low for Blender to start."""
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < BLENDER_BYTES:
        needed = f'Blender needs {BLENDER_BYTES >> 20} MiB to start'
        raise CommandError(f'memory is limited to {limit >> 20} MiB (ulimit -v), and {needed}')


def open_scene(file: Path | None, demo: str | None) -> bpy.types.Scene:
    """Load Blender, register the engine, and open the file or build the demo. Raises CommandError."""
    require_address_space()
    try:
        import bpy
    except ImportError as error:
        raise CommandError(f'the Python package bpy, which holds Blender, cannot be loaded: {error}') from error
    from . import register

    register()
    if demo is not None:
        from . import demos

        return demos.build(demo)
    if not is_blend(file):
        from . import importers

        return importers.load(file)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(file.resolve()), load_ui=False)
    except RuntimeError as error:
        raise CommandError(f'{file}: {blender_words(error)}') from error
    if bpy.app.autoexec_fail:
        watch.message('WARNING', f'{file}: its Python scripts were not run ({bpy.app.autoexec_fail_message})')
    return bpy.context.scene


def has_layers(scene: bpy.types.Scene) -> bool:
    return any(layer.use for layer in scene.view_layers)


def shows_anything(scene: bpy.types.Scene) -> bool:
    """Whether there is a picture: Blender would write a black PNG, and crash where it writes EXR."""
    return has_layers(scene) or shows_sequence(scene) or shows_other_scenes(scene)


def shows_other_scenes(scene: bpy.types.Scene) -> bool:
    """Whether the picture is put together from other scenes' view layers, too."""
    from . import compat

    tree = compat.compositing_tree(scene) if scene.render.use_compositing else None
    trees = [tree] if tree is not None else []
    for tree in trees:  # grows by the groups that are met
        for node in tree.nodes:
            if node.type == 'R_LAYERS' and node.scene not in (None, scene) and has_layers(node.scene):
                return True
            inner = node.node_tree if node.type == 'GROUP' else None
            if inner is not None and inner not in trees:
                trees.append(inner)
    return False


def shows_sequence(scene: bpy.types.Scene) -> bool:
    """Whether the picture is the sequencer's; sound and what is muted show nothing."""
    editor = scene.sequence_editor
    strips = editor.strips if editor is not None and scene.render.use_sequencer else []
    return any(strip.type != 'SOUND' and not strip.mute for strip in strips)


def render_in_blender(scene: bpy.types.Scene) -> str:
    """Render into the scene's file path; the errors that Blender tells of, or ''."""
    import bpy

    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        return blender_words(error)
    return ''


def blender_words(error: RuntimeError) -> str:
    """Blender's own message out of the error that an operator raises."""
    lines = [re.sub(r'^Error: (Cotorra: )?', '', line) for line in str(error).splitlines()]
    return '; '.join(dict.fromkeys(line for line in lines if line))
