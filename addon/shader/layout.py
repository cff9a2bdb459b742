# SPDX-License-Identifier: GPL-3.0-or-later
"""What all nodes of one type have in common: its names, and the identifiers of its inputs. Each type is asked once.

Blender makes a Python object of each socket and each text that is asked for, which took more time than what is done
with them. It knows no tree and no value.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy


@dataclass(frozen=True, slots=True)
class Layout:
    """kind: a node's `bl_idname`; type: its `type`; identifiers: of its inputs, in order."""

    kind: str
    type: str
    identifiers: tuple[str, ...]


_LAYOUTS: dict[type, Layout] = {}
_SOCKET_TYPES: dict[type, str] = {}


def layout(node: bpy.types.Node) -> Layout:
    """What this node's type is. Nodes of a class are alike, but for those whose inputs the user makes (zones)."""
    found = _LAYOUTS.get(type(node))
    return _asked(node) if found is None else found


def inputs(node: bpy.types.Node) -> dict[str, bpy.types.NodeSocket]:
    """The inputs of a node by identifier."""
    sockets = node.inputs.values()
    identifiers = layout(node).identifiers
    if len(identifiers) != len(sockets):
        identifiers = tuple(socket.identifier for socket in sockets)
    return dict(zip(identifiers, sockets, strict=True))


def socket_type(socket: bpy.types.NodeSocket) -> str:
    """`socket.type`, which is the same for all sockets of a class."""
    found = _SOCKET_TYPES.get(type(socket))
    if found is None:
        found = socket.type
        if type(socket).__name__ == socket.bl_idname:
            _SOCKET_TYPES[type(socket)] = found
    return found


def _asked(node: bpy.types.Node) -> Layout:
    kind = node.bl_idname
    identifiers = tuple(socket.identifier for socket in node.inputs)
    found = Layout(kind, node.type, identifiers)
    if kind == type(node).__name__ and kind.startswith('ShaderNode') and kind != 'ShaderNodeGroup':
        _LAYOUTS[type(node)] = found
    return found
