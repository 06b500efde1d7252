"""Numbers that Hypothesis takes from source code: those of the engine's adapter, and of no other module.

Hypothesis mixes constants of the modules that happen to be loaded into what it draws, so that the same seed would
bring other scenes in a process that has loaded others. An adapter's own constants are worth trying, in any process.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from hypothesis.internal.conjecture import providers

from oracles.engine import Engine

OWN = {"builtins", "abc", Engine.__module__}


@contextmanager
def constants_of(engine: Engine) -> Iterator[None]:
    """Within the block, have Hypothesis know the constants of the engine's classes alone."""
    try:
        from hypothesis.internal.constants_ast import Constants, constants_from_module  # noqa: PLC0415
    except ImportError:  # a version that takes none from source code
        yield
        return
    found = Constants()
    for name in sorted({kind.__module__ for kind in type(engine).__mro__} - OWN):
        found |= constants_from_module(sys.modules[name])
    before = getattr(providers, FUNCTION, None)
    _know(lambda: found)
    try:
        yield
    finally:
        _know(before)


FUNCTION = "_get_local_constants"
"""It has no public name."""


def _know(constants: object) -> None:
    setattr(providers, FUNCTION, constants)
    providers.CONSTANTS_CACHE.cache.clear()
