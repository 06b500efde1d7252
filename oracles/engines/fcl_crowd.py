"""FCL's broad phase: the self-collisions of a `DynamicAABBTreeCollisionManager`, as its callback is told of them.

The callback gets objects that are none of those registered, and python-fcl tells neither their identity nor their
geometry: bodies are told apart by their centres. Nothing of the narrow phase is called.
"""

from __future__ import annotations

from typing import Any, ClassVar

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.crowds.engine import BroadPhaseEngine
from oracles.engine import EngineUnavailable, NoAnswer

SCRIPT = """import fcl
import numpy as np


def pairs(bodies):
    objects = []
    for ball, _, half, before in bodies:
        shape = fcl.Sphere(half[0]) if ball else fcl.Box(*(2 * h for h in half))
        objects.append(fcl.CollisionObject(shape, fcl.Transform(np.array(before))))
    manager = fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(objects)
    manager.setup()
    if any(center != before for _, center, _, before in bodies):
        for one, body in zip(objects, bodies):
            one.setTranslation(np.array(body[1]))
        manager.update()
    number = {tuple(body[1]): n for n, body in enumerate(bodies)}  # the callback tells of copies
    found = []

    def note(a, b, _):
        found.append(tuple(number[tuple(one.getTranslation().tolist())] for one in (a, b)))
        return False  # go on

    manager.collide(None, note)
    return found
"""


class FclCrowds(BroadPhaseEngine):
    """Register all bodies, move those that move, update; then collide, or look for the nearest pair."""

    calls: ClassVar[str] = (
        "DynamicAABBTreeCollisionManager.registerObjects, setup, update, collide(callback), distance(callback)"
    )
    script: ClassVar[str] = SCRIPT
    closed: ClassVar[bool] = True
    finds_nearest: ClassVar[bool] = True

    def pairs(self, crowd: BoxCrowd) -> list[Pair]:
        """Pairs for which the callback is called."""
        told = _Told(crowd)
        found: list[Pair] = []

        def note(a: Any, b: Any, _: Any) -> bool:
            found.append(told.pair(a, b))
            return False  # to be told of all others too

        told.manager.collide(None, note)
        return found

    def nearest(self, crowd: BoxCrowd) -> Pair | None:
        """Nearest of the pairs for which the callback is called; it answers with the distance of their boxes."""
        told, gaps = _Told(crowd), crowd.gaps()
        best: list[Pair] = []

        def measure(a: Any, b: Any, _: Any) -> tuple[bool, float]:
            pair = told.pair(a, b)
            if not best or gaps[pair] < gaps[best[0]]:
                best[:] = [pair]
            return False, float(gaps[best[0]])

        told.manager.distance(None, measure)
        return best[0] if best else None


class _Told:
    """A manager with all bodies of a crowd, and who they are when its callback is told of them."""

    def __init__(self, crowd: BoxCrowd) -> None:
        fcl = _import_fcl()
        bodies = zip(crowd.balls.tolist(), crowd.half.tolist(), crowd.before.tolist(), strict=True)
        objects = [
            fcl.CollisionObject(fcl.Sphere(half[0]) if ball else fcl.Box(*(2 * h for h in half)), fcl.Transform(place))
            for ball, half, place in bodies
        ]
        self.manager = fcl.DynamicAABBTreeCollisionManager()
        self.manager.registerObjects(objects)
        self.manager.setup()
        if crowd.moved:
            for one, place in zip(objects, crowd.center, strict=True):
                one.setTranslation(place)
            self.manager.update()
        self._number = {tuple(place): n for n, place in enumerate(crowd.center.tolist())}
        if len(self._number) < len(crowd):
            raise NoAnswer("two bodies have one centre: python-fcl's callback does not tell them apart")

    def pair(self, a: Any, b: Any) -> Pair:
        """Numbers of two objects."""
        i, j = (self._number[tuple(one.getTranslation().tolist())] for one in (a, b))
        return i, j


def _import_fcl() -> Any:
    try:
        import fcl  # noqa: PLC0415  an optional package
    except ImportError as error:
        raise EngineUnavailable(f"fcl cannot be imported ({error}): pip install python-fcl") from None
    return fcl
