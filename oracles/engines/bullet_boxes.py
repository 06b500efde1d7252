"""Bullet's broad phase: `getOverlappingObjects` around each body's `getAABB`.

Measured on PyBullet 3.2.7: the tree's boxes are those of the shapes, to the last bits, until a body is moved; then they
are larger by the contact breaking threshold of 0.02, while `getAABB` still gives those of the shapes. Bodies of a size
of 1e-6 are then all pairs of each other.
"""

from __future__ import annotations

from typing import ClassVar

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.crowds.engine import BroadPhaseEngine
from oracles.engines.bullet_shapes import BOX, SPHERE, UPRIGHT, Placed
from oracles.engines.bullet_world import World

SCRIPT = """import pybullet


def pairs(bodies):
    pybullet.connect(pybullet.DIRECT)
    made = []
    for ball, _, half, before in bodies:
        sizes = {"radius": half[0]} if ball else {"halfExtents": half}
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE if ball else pybullet.GEOM_BOX, **sizes)
        made.append(pybullet.createMultiBody(1.0, shape, -1, before))
    if any(center != before for _, center, _, before in bodies):
        for one, body in zip(made, bodies):
            pybullet.resetBasePositionAndOrientation(one, body[1], [0.0, 0.0, 0.0, 1.0])
        pybullet.performCollisionDetection()
    found = []
    for one in made:
        for other, _ in pybullet.getOverlappingObjects(*pybullet.getAABB(one)) or ():
            if other != one:
                found.append((made.index(one), made.index(other)))
    return found
"""


class BulletCrowds(BroadPhaseEngine):
    """One world for each crowd."""

    calls: ClassVar[str] = "getOverlappingObjects(*getAABB(body)) for every body"
    script: ClassVar[str] = SCRIPT
    margin: ClassVar[float] = 0.02
    margin_why: ClassVar[str] = "the contact breaking threshold, by which a box is larger once its body has been moved"

    def __init__(self) -> None:
        self._world: World | None = None

    def pairs(self, crowd: BoxCrowd) -> list[Pair]:
        """Pairs of which one is found around the other."""
        self._world = self._world or World()
        self._world.scenes_left = 0  # a crowd is a world of its own
        places = crowd.before.tolist()
        shapes = [
            Placed(SPHERE, {"radius": half[0]}, place, UPRIGHT)
            if ball
            else Placed(BOX, {"halfExtents": half}, place, UPRIGHT)
            for ball, half, place in zip(crowd.balls.tolist(), crowd.half.tolist(), places, strict=True)
        ]
        return self._world.overlapping(shapes, crowd.center.tolist() if crowd.moved else None)
