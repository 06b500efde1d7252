"""How hard a scene is to take in: one measure, by which the simplest witness is chosen everywhere."""

from __future__ import annotations

from oracles.scene import Scene
from refimpl import Composite, Proxy
from refimpl.shapes import Polyhedron

PLAIN = frozenset({0.0, 1.0, -1.0, 0.5, 2.0})
"""Numbers that a reader does not have to read."""

AT_A_GLANCE = 3
"""Other numbers that a reader takes in at a glance."""

Clumsiness = tuple[int, int]


def numbers_of(shape: Proxy) -> list[float]:
    """Every number that says what a proxy is: none of sizes, codes, or which vertices a face joins."""
    if isinstance(shape, Composite):
        return [x for part in shape.parts for x in numbers_of(part)]
    if isinstance(shape, Polyhedron):
        return [*shape.vertices.ravel().tolist(), *shape.position.tolist(), *shape.rotation.tolist()]
    return list(map(float, shape.pack()[shape.header :]))


def numbers_in(scene: Scene) -> list[float]:
    """Every number of both proxies, and of their motion."""
    moving = [] if scene.motion is None else scene.motion.pack().tolist()
    return [*numbers_of(scene.a), *numbers_of(scene.b), *moving]


def odd_numbers(scene: Scene) -> int:
    """How many numbers are none of 0, 1, −1, 0.5 and 2."""
    return sum(x not in PLAIN for x in numbers_in(scene))


def clumsiness(scene: Scene) -> Clumsiness:
    """Numbers that have to be read, and then what is written: digits, and anything that is not 0."""
    numbers = numbers_in(scene)
    written = sum(0 if x == 0 else 1 if x == 1 else 2 if x in PLAIN else 2 + len(f"{x:.17g}") for x in numbers)
    return sum(x not in PLAIN for x in numbers), written + len(numbers)
