# SPDX-License-Identifier: GPL-3.0-or-later
"""The graphics cards of this machine, by name, for the choice in the render properties.

They are asked for once a session, and only when somebody wants to choose; what renders is the native module's affair.
"""

from __future__ import annotations

from . import native

AUTOMATIC = ('AUTO', 'Automatic', 'The best graphics card that can render', 0)

_cards: list[dict] | None = None
_problem = ''

# Blender keeps no reference to the words of an enumeration that a function makes.
_items: dict[int, list[tuple[str, str, str, int]]] = {}


def cards() -> list[dict]:
    """What the native module tells of each card, in the order by which they are chosen; none where it has none."""
    global _cards, _problem
    if _cards is None:
        try:
            _cards = native.load().devices()
        except Exception as error:  # no module, or no Vulkan: the choice stays empty, and the panel says why
            _cards, _problem = [], str(error)
        _items.clear()
    return _cards


def problem(index: int) -> str:
    """Why this card cannot render (-1: why none can), or nothing."""
    found = cards()
    if not found:
        return _problem or 'No graphics card with Vulkan was found'
    if index >= len(found):
        return 'This machine has no such graphics card'
    if index >= 0:
        return found[index]['problem'] and f'{found[index]["name"]}: {found[index]["problem"]}'
    usable = any(not card['problem'] for card in found)
    return '' if usable else '; '.join(f'{card["name"]}: {card["problem"]}' for card in found)


def items(chosen: int) -> list[tuple[str, str, str, int]]:
    """Choices of an enumeration whose numbers are the card's index and one; a card that is not there stays a choice."""
    found = cards()
    key = chosen if chosen >= len(found) else -1
    if key not in _items:
        _items[key] = [AUTOMATIC, *(_item(index, card) for index, card in enumerate(found))]
        if key >= 0:
            name = f'Card {key + 1}, which this machine has not'
            _items[key].append((str(key), name, 'The file was set up on another machine', key + 1))
    return _items[key]


def _item(index: int, card: dict) -> tuple[str, str, str, int]:
    memory = f'{card["memory_bytes"] / 2**30:.1f} GiB' if card['memory_bytes'] else ''
    words = [card['driver'], memory, 'ray tracing in hardware' if card['ray_query'] else '', card['problem']]
    return str(index), card['name'], ', '.join(word for word in words if word), index + 1
