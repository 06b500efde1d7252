"""What transformations a proxy survives: which of them give a proxy of the same type again, and what the others say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from refimpl.proxy import Proxy, UnsupportedOperation

TURN = (0.1, 0.2, 0.3, 0.9)
STRETCH = (1.0, 2.0, 3.0)

TRANSFORMATIONS: Mapping[str, Callable[[Proxy], Proxy]] = MappingProxyType(
    {
        "translation": lambda proxy: proxy.translated((1.0, 2.0, 3.0)),
        "rotation": lambda proxy: proxy.rotated(TURN),
        "scaling": lambda proxy: proxy.scaled(2.0),
        "stretching": lambda proxy: proxy.stretched(STRETCH),
    }
)
"""By name: moved, turned about an axis that is none of the frame's, scaled evenly, and by a factor for each axis."""


def survives(proxy: Proxy) -> dict[str, str]:
    """What keeps a proxy from each transformation, by name; empty where it survives it.

    They are tried, as the types have them: a type that a transformation leads out of says which other has the result.
    What can be turned is stretched after a turn: a box along the axes would survive what no other box does.
    """
    found: dict[str, str] = {}
    for name, change in TRANSFORMATIONS.items():
        try:
            changed = change(
                TRANSFORMATIONS["rotation"](proxy) if name == "stretching" and not found["rotation"] else proxy
            )
            found[name] = "" if type(changed) is type(proxy) else "it becomes another type"
        except UnsupportedOperation as error:
            found[name] = str(error)
    return found
