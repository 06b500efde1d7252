"""FCL's broad phase: the self-collisions of a `DynamicAABBTreeCollisionManager`, as its callback is told of them.

The callback gets objects that are none of those registered, and python-fcl tells neither their identity nor their
geometry: bodies are told apart by their centres. Nothing of the narrow phase is called.
"""

from __future__ import annotations

from typing import Any, ClassVar

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.crowds.engine import BroadPhaseEngine
from oracles.engine import EngineUnavailable, NoAnswer


class FclCrowds(BroadPhaseEngine):
    """Register all bodies, move those that move, update, collide."""

    calls: ClassVar[str] = "DynamicAABBTreeCollisionManager.registerObjects, setup, update, collide(callback)"
    closed: ClassVar[bool] = True

    def pairs(self, crowd: BoxCrowd) -> list[Pair]:
        """Pairs for which the callback is called."""
        fcl = _import_fcl()
        objects = [
            fcl.CollisionObject(fcl.Sphere(half[0]) if ball else fcl.Box(*(2 * h for h in half)), fcl.Transform(place))
            for ball, half, place in zip(crowd.balls.tolist(), crowd.half.tolist(), crowd.before.tolist(), strict=True)
        ]
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects(objects)
        manager.setup()
        if crowd.moved:
            for one, place in zip(objects, crowd.center, strict=True):
                one.setTranslation(place)
            manager.update()
        number = {tuple(place): n for n, place in enumerate(crowd.center.tolist())}
        if len(number) < len(crowd):
            raise NoAnswer("two bodies have one centre: python-fcl's callback does not tell them apart")
        found: list[Pair] = []

        def note(a: Any, b: Any, _: Any) -> bool:
            found.append((number[tuple(a.getTranslation().tolist())], number[tuple(b.getTranslation().tolist())]))
            return False  # to be told of all others too

        manager.collide(None, note)
        return found


def _import_fcl() -> Any:
    try:
        import fcl  # noqa: PLC0415  an optional package
    except ImportError as error:
        raise EngineUnavailable(f"fcl cannot be imported ({error}): pip install python-fcl") from None
    return fcl
