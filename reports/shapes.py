"""Shapes as people read them: whole while they are short, and else with their long lists of numbers put aside."""

from __future__ import annotations

import hashlib
import json
import re

import numpy as np

from oracles.scene import readable
from refimpl.shapes import Composite, Polyhedron, Proxy
from reports import text

WHOLE = 1000
"""Longest constructor call that is shown as it is, in characters."""

FEW = 12
"""A list of up to so many numbers is short."""

LONGEST = 2000
"""Longest text of a shape, in characters."""

LIST = re.compile(r"(?<==)\[[-+0-9.e, \[\]]*\]")
"""A field's numbers in a constructor call."""


def in_words(shape: Proxy) -> str:
    """Constructor call in full precision, with lists of many numbers named by their size and digest.

    The digest, the first of the SHA-256 of the numbers as little-endian doubles, tells equal geometry from other.
    """
    call = _call(shape)
    return text.visible(call if len(call) <= WHOLE else LIST.sub(lambda found: _list(found[0]), call), LONGEST)


def is_whole(shape: Proxy) -> bool:
    """Whether `in_words` gives every number."""
    return in_words(shape) == _call(shape)


def _call(shape: Proxy) -> str:
    """Constructor call with every number."""
    if isinstance(shape, Composite):
        return f"Composite([{', '.join(map(_call, shape.parts))}])"
    if isinstance(shape, Polyhedron):
        names = ("vertices", "triangles", "position", "rotation")
        return f"Polyhedron({', '.join(f'{name}={getattr(shape, name).tolist()!r}' for name in names)})"
    return readable(shape)


def _list(numbers: str) -> str:
    values = np.array(json.loads(numbers), dtype="<f8")
    if values.size <= FEW:
        return numbers
    digest = hashlib.sha256(values.tobytes()).hexdigest()[:12]
    size = text.count(len(values)) + (f" × {values.shape[1]}" if values.ndim > 1 else "")
    return f"<{size} numbers, sha256 {digest}>"
