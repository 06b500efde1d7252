"""Asking PyBullet: a world that answers one scene at a time, fast.

`getClosestPoints` takes collision shapes without bodies, so distances and overlaps need none: two shapes and a
query cost 8 µs. Contacts and rays need bodies: 90 µs each, and three times that without a shared visual shape,
for then PyBullet tessellates the collision shape. What is removed stays in memory; a reset frees it, and with it the
hulls and meshes, which are otherwise kept.
"""

from __future__ import annotations

import math
from operator import itemgetter
from typing import Any

from oracles.engine import AnswerRow, EngineUnavailable, NoAnswer, Row, UnsupportedCell, answer_row
from oracles.engines import geometry
from oracles.engines.bullet_shapes import (
    BOX,
    CAPSULE,
    COMPOUND,
    CYLINDER,
    HULL,
    MESH,
    PLANE,
    SPHERE,
    Placed,
    compound_arguments,
    ray_at,
    ray_end,
)
from oracles.engines.geometry import Kept, Key

FAR = 1e30
"""Beyond any distance, and its square is finite."""
RESET_EVERY = 500
"""Scenes between resets; keeps what was removed below 4 MB."""

ON_A, ON_B, NORMAL_ON_B, DISTANCE_FIELD = 5, 6, 7, 8
"""Places in a contact or closest point of PyBullet; its normal points from B to A."""
SURFACES = (PLANE, MESH)
"""What never moves, and has no algorithm against its like."""


def without_extra(point: Any, extra_a: float, extra_b: float) -> dict[str, Any]:
    """Answer of a contact or closest point, with what was added to the radii taken off."""
    normal = [-u for u in point[NORMAL_ON_B]]
    on_a, on_b = point[ON_A], point[ON_B]
    if extra_a:
        on_a = [u - extra_a * n for u, n in zip(on_a, normal, strict=True)]
    if extra_b:
        on_b = [u + extra_b * n for u, n in zip(on_b, normal, strict=True)]
    return {"distance": point[DISTANCE_FIELD] + (extra_a + extra_b), "on_a": on_a, "on_b": on_b, "normal": normal}


def pairs_of(a: list[Placed], b: list[Placed]) -> list[tuple[Placed, Placed]]:
    """Every part against every part; raises `UnsupportedCell` for two surfaces."""
    if any(x.geometry in SURFACES for x in a) and any(y.geometry in SURFACES for y in b):
        raise UnsupportedCell("Bullet has no algorithm for two planes or meshes")
    return [(x, y) for x in a for y in b]


RANK = {COMPOUND: 0, HULL: 0, MESH: 2, PLANE: 2}


def comes_second(a: Placed, b: Placed) -> bool:
    """Whether the closest points of two shapes without bodies come back as those of `b` and `a`.

    Whatever the order of the call, compounds come back first, a hull being one of a single part for PyBullet, and
    meshes and planes last.
    """
    return RANK.get(a.geometry, 1) > RANK.get(b.geometry, 1)


class World:
    """A physics client without display, and the ways to ask it."""

    def __init__(self) -> None:
        self.bullet = import_bullet()
        self.client = self.bullet.connect(self.bullet.DIRECT)
        if self.client < 0:
            raise EngineUnavailable("PyBullet does not open a DIRECT client")
        self.types = {name: getattr(self.bullet, name) for name in (SPHERE, CAPSULE, PLANE, BOX, CYLINDER)}
        self._kept = {HULL: Kept(self._hull), MESH: Kept(self._mesh)}
        self.scenes_left = 0
        self.skin = -1

    def _begin(self) -> None:
        if not self.scenes_left:
            self.bullet.resetSimulation(physicsClientId=self.client)
            cube = {"halfExtents": [1.0, 1.0, 1.0], "physicsClientId": self.client}
            self.skin = self.bullet.createVisualShape(self.bullet.GEOM_BOX, **cube)
            self.scenes_left = RESET_EVERY
            for kept in self._kept.values():
                kept.clear()
        self.scenes_left -= 1

    def _shape(self, placed: Placed) -> int:
        if placed.key:
            return self._kept[placed.geometry][placed.key]
        if placed.geometry == COMPOUND:
            types = [self.types[child.geometry] for child in placed.children]
            many = self.bullet.createCollisionShapeArray
            return int(many(shapeTypes=types, **compound_arguments(placed), physicsClientId=self.client))
        kind = self.types[placed.geometry]
        return int(self.bullet.createCollisionShape(kind, **placed.sizes, physicsClientId=self.client))

    def _hull(self, key: Key) -> int:
        points = geometry.vertices(key).tolist()
        make = self.bullet.createCollisionShape
        return int(make(self.bullet.GEOM_MESH, vertices=points, physicsClientId=self.client))

    def _mesh(self, key: Key) -> int:
        vertices, triangles = geometry.mesh(key)
        arguments = {"vertices": vertices.tolist(), "indices": triangles.ravel().tolist()}
        concave = self.bullet.GEOM_FORCE_CONCAVE_TRIMESH
        make = self.bullet.createCollisionShape
        return int(make(self.bullet.GEOM_MESH, **arguments, flags=concave, physicsClientId=self.client))

    def _body(self, placed: Placed, mass: float = 1.0) -> int:
        """Make a body: one of mass 0 cannot move, and a plane or mesh never does.

        Two bodies that cannot move have no contacts; nor have two that can, when the diagonals of their bounding
        boxes exceed 1e6. One of each kind always has.
        """
        mass = 0.0 if placed.geometry in SURFACES else mass
        shape, client = self._shape(placed), self.client
        made = self.bullet.createMultiBody(
            mass, shape, self.skin, placed.position, placed.orientation, physicsClientId=client
        )
        return int(made)

    def _points(self, a: Placed, b: Placed, threshold: float) -> Any:
        return self.bullet.getClosestPoints(
            bodyA=-1,
            bodyB=-1,
            distance=threshold,
            collisionShapeA=self._shape(a),
            collisionShapeB=self._shape(b),
            collisionShapePositionA=a.position,
            collisionShapePositionB=b.position,
            collisionShapeOrientationA=a.orientation,
            collisionShapeOrientationB=b.orientation,
            physicsClientId=self.client,
        )

    def closest(self, a: list[Placed], b: list[Placed]) -> AnswerRow:
        """Nearest of the closest points of any two parts."""
        self._begin()
        return min((self._closest(x, y) for x, y in pairs_of(a, b)), key=itemgetter(1))

    def _closest(self, a: Placed, b: Placed) -> AnswerRow:
        """Nearest of the closest points, asked for in the order in which they come back."""
        if not comes_second(a, b):
            return self._signed(self._points(a, b, FAR), a, b)
        answer = self._signed(self._points(b, a, FAR), b, a)
        _, distance, bx, by, bz, ax, ay, az, x, y, z = answer[:11]
        return answer_row(distance=distance, on_a=(ax, ay, az), on_b=(bx, by, bz), normal=(-x, -y, -z))

    @staticmethod
    def _signed(points: Any, a: Placed, b: Placed) -> AnswerRow:
        if not points:
            raise NoAnswer("PyBullet returned no closest point")
        best = min(points, key=itemgetter(DISTANCE_FIELD))
        return answer_row(**without_extra(best, a.extra, b.extra))

    def overlap(self, a: list[Placed], b: list[Placed]) -> AnswerRow:
        """Whether there is a closest point at a distance of at most 0."""
        self._begin()
        return answer_row(hit=float(any(len(self._points(x, y, 0.0)) > 0 for x, y in pairs_of(a, b))))

    def contacts(self, a: list[Placed], b: list[Placed]) -> AnswerRow:
        """Deepest contact of a collision detection; contacts across a gap are no hits."""
        self._begin()
        pairs_of(a, b)
        bullet, client = self.bullet, self.client
        mass_a = float(any(y.geometry in SURFACES for y in b))
        found: list[tuple[float, dict[str, Any]]] = []
        bodies: list[int] = []
        try:
            for x in a:
                bodies.append(self._body(x, mass_a))
            for y in b:
                bodies.append(self._body(y, 1.0 - mass_a))
            bullet.performCollisionDetection(physicsClientId=client)
            for x, i in zip(a, bodies, strict=False):
                for y, j in zip(b, bodies[len(a) :], strict=True):
                    points = bullet.getContactPoints(i, j, physicsClientId=client)
                    best = min(points, key=itemgetter(DISTANCE_FIELD), default=None)
                    if best is not None:
                        contact = without_extra(best, x.extra, y.extra)
                        found.append((contact["distance"], contact))
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)
        deepest = min(found, key=itemgetter(0), default=None)
        if deepest is None or deepest[0] > 0:
            return answer_row(hit=0.0)
        return answer_row(hit=1.0, **deepest[1])

    def cast(self, ray: Row, target: list[Placed]) -> AnswerRow:
        """First hit of a ray up to beyond its target."""
        self._begin()
        bullet, client = self.bullet, self.client
        end = max(ray_end(ray, part) for part in target)
        bodies: list[int] = []
        try:
            for part in target:
                bodies.append(self._body(part))
            found = bullet.rayTest(ray[:3], ray_at(ray, end), physicsClientId=client)
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)
        unique, _, fraction, point, normal = found[0]
        if unique < 0:
            return answer_row(hit=0.0, t=math.inf)
        return answer_row(hit=1.0, t=fraction * end, normal=normal, point=point)

    def overlapping(self, shapes: list[Placed], moved_to: list[list[float]] | None) -> list[tuple[int, int]]:
        """Pairs of shapes whose boxes overlap, as the broad phase has them; bodies may have to be moved before."""
        self._begin()
        bullet, client = self.bullet, self.client
        bodies = [self._body(shape) for shape in shapes]
        if moved_to is not None:
            for body, place in zip(bodies, moved_to, strict=True):
                bullet.resetBasePositionAndOrientation(body, place, [0.0, 0.0, 0.0, 1.0], physicsClientId=client)
            bullet.performCollisionDetection(physicsClientId=client)
        numbers = {body: number for number, body in enumerate(bodies)}
        found = []
        for body, number in numbers.items():
            lower, upper = bullet.getAABB(body, physicsClientId=client)
            others = bullet.getOverlappingObjects(lower, upper, physicsClientId=client) or ()
            found += [(number, numbers[other]) for other, _ in others if other != body]
        return found

    def sweep(self, ray: Row, along: list[float], target: list[Placed]) -> AnswerRow:
        """First hit of a ray from t = 0 to 1, where the target and all else moves `along`."""
        self._begin()
        bullet, client = self.bullet, self.client
        bodies: list[int] = []
        try:
            for part in target:
                bodies.append(self._body(part))
            unique, _, t, point, normal = bullet.rayTest(ray[:3], ray_at(ray, 1.0), physicsClientId=client)[0]
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)
        if unique < 0:
            return answer_row(hit=0.0, t=math.inf)
        place = [u + t * v for u, v in zip(point, along, strict=True)]
        return answer_row(hit=1.0, t=t, normal=[-u for u in normal], point=place)


def import_bullet() -> Any:
    """Import pybullet, which prints a line when imported."""
    try:
        import pybullet  # noqa: PLC0415  an optional package
    except ImportError as error:
        text = f"pybullet cannot be imported ({error}): pip install pybullet"
        raise EngineUnavailable(text) from None
    return pybullet
