"""Asking PyBullet: proxies as it takes them, and a world that answers one scene at a time, fast.

`getClosestPoints` takes collision shapes without bodies, so distances and overlaps need none: two shapes and a
query cost 8 µs. Contacts and rays need bodies: 90 µs each, and three times that without a shared visual shape,
for then PyBullet tessellates the collision shape. What is removed stays in memory; a reset frees it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import itemgetter
from typing import Any, NamedTuple

from oracles.engine import AnswerRow, EngineUnavailable, Kind, NoAnswer, Row, answer_row
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Sphere

MARGIN = 0.001
"""Collision margin of boxes, and how near a ray must come to hit a convex shape."""
FAR = 1e30
"""Beyond any distance, and its square is finite."""
RESET_EVERY = 500
"""Scenes between resets; keeps what was removed below 4 MB."""

ON_A, ON_B, NORMAL_ON_B, DISTANCE_FIELD = 5, 6, 7, 8
"""Places in a contact or closest point of PyBullet; its normal points from B to A."""

UPRIGHT = [0.0, 0.0, 0.0, 1.0]


class Placed(NamedTuple):
    """A proxy as PyBullet takes it: arguments of createCollisionShape, and where the shape stands.

    `extra` is the part of its radius that the proxy does not have, to be taken off the answer again.
    """

    geometry: str
    sizes: dict[str, float | list[float]]
    position: list[float]
    orientation: list[float]
    extra: float = 0.0


def _point(r: Row, thinnest: float) -> Placed:
    extra = _instead_of_0(r, thinnest)
    return Placed("GEOM_SPHERE", {"radius": extra}, r, UPRIGHT, extra)


def _sphere(r: Row, _: float) -> Placed:
    return Placed("GEOM_SPHERE", {"radius": r[3]}, r[:3], UPRIGHT)


def _capsule(r: Row, thinnest: float) -> Placed:
    """Stand a capsule, which lies along z and whose height excludes the caps, on its segment."""
    px, py, pz, qx, qy, qz, radius = r
    x, y, z = qx - px, qy - py, qz - pz
    length = math.hypot(x, y, z)
    turn = _turn_to(x / length, y / length, z / length) if length > 0 else UPRIGHT
    middle = [px / 2 + qx / 2, py / 2 + qy / 2, pz / 2 + qz / 2]
    extra = 0.0 if radius else _instead_of_0(middle, thinnest)
    return Placed("GEOM_CAPSULE", {"radius": radius or extra, "height": length}, middle, turn, extra)


def _instead_of_0(position: list[float], thinnest: float) -> float:
    return thinnest * max(1.0, *map(abs, position))


def _turn_to(x: float, y: float, z: float) -> list[float]:
    """Quaternion that takes the z axis to a unit vector, or to its opposite: a capsule has no front."""
    return _unit(-y, x, 0.0, 1.0 + z) if z >= 0 else _unit(y, -x, 0.0, 1.0 - z)


def _unit(x: float, y: float, z: float, w: float) -> list[float]:
    size = max(abs(x), abs(y), abs(z), abs(w))
    x, y, z, w = x / size, y / size, z / size, w / size
    length = math.hypot(x, y, z, w)
    return [x / length, y / length, z / length, w / length]


def _halfspace(r: Row, _: float) -> Placed:
    """Stand a plane, which can only be given by its normal, on its point nearest to the origin."""
    length = math.hypot(r[0], r[1], r[2])
    normal = [r[0] / length, r[1] / length, r[2] / length]
    offset = -r[3] / length
    sizes: dict[str, float | list[float]] = {"planeNormal": normal}
    return Placed("GEOM_PLANE", sizes, [offset * u for u in normal], UPRIGHT)


def _aabb(r: Row, _: float) -> Placed:
    center = [u / 2 + v / 2 for u, v in zip(r[3:], r[:3], strict=True)]
    half = [u / 2 - v / 2 for u, v in zip(r[3:], r[:3], strict=True)]
    return Placed("GEOM_BOX", {"halfExtents": half}, center, UPRIGHT)


def _box(r: Row, _: float) -> Placed:
    return Placed("GEOM_BOX", {"halfExtents": r[3:6]}, r[:3], _unit(*r[6:]))


PLACE: dict[Kind, Callable[[Row, float], Placed]] = {
    Point: _point,
    Sphere: _sphere,
    Capsule: _capsule,
    HalfSpace: _halfspace,
    AABB: _aabb,
    Box: _box,
}


def ray_end(ray: Row, target: Placed) -> float:
    """Time at which a ray is past the whole target; a plane is past at twice the time of its crossing."""
    origin, direction = ray[:3], ray[3:]
    length = math.hypot(*direction)
    toward = [c - o for c, o in zip(target.position, origin, strict=True)]
    sizes = target.sizes
    if target.geometry == "GEOM_PLANE":
        normal: Any = sizes["planeNormal"]
        speed, gap = _dot(normal, direction), _dot(normal, toward)
        return 2 * gap / speed if gap * speed > 0 else 1.0
    reach = sum(math.hypot(*s) if isinstance(s, list) else s for s in sizes.values())
    along = _dot([u / length for u in toward], [d / length for d in direction])
    return max(along, 0.0) + 2 * (reach + MARGIN) / length


def _dot(u: list[float], v: list[float]) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def ray_at(ray: Row, t: float) -> list[float]:
    """Point of a ray."""
    return [o + t * d for o, d in zip(ray[:3], ray[3:], strict=True)]


def without_extra(point: Any, extra_a: float, extra_b: float) -> dict[str, Any]:
    """Answer of a contact or closest point, with what was added to the radii taken off."""
    normal = [-u for u in point[NORMAL_ON_B]]
    on_a, on_b = point[ON_A], point[ON_B]
    if extra_a:
        on_a = [u - extra_a * n for u, n in zip(on_a, normal, strict=True)]
    if extra_b:
        on_b = [u + extra_b * n for u, n in zip(on_b, normal, strict=True)]
    return {"distance": point[DISTANCE_FIELD] + (extra_a + extra_b), "on_a": on_a, "on_b": on_b, "normal": normal}


class World:
    """A physics client without display, and the four ways to ask it."""

    def __init__(self) -> None:
        self.bullet = import_bullet()
        self.client = self.bullet.connect(self.bullet.DIRECT)
        if self.client < 0:
            raise EngineUnavailable("PyBullet does not open a DIRECT client")
        self.geometry = {n: getattr(self.bullet, n) for n in ("GEOM_SPHERE", "GEOM_CAPSULE", "GEOM_PLANE", "GEOM_BOX")}
        self.scenes_left = 0
        self.skin = -1

    def _begin(self) -> None:
        if not self.scenes_left:
            self.bullet.resetSimulation(physicsClientId=self.client)
            cube = {"halfExtents": [1.0, 1.0, 1.0], "physicsClientId": self.client}
            self.skin = self.bullet.createVisualShape(self.bullet.GEOM_BOX, **cube)
            self.scenes_left = RESET_EVERY
        self.scenes_left -= 1

    def _shape(self, placed: Placed) -> int:
        kind = self.geometry[placed.geometry]
        return int(self.bullet.createCollisionShape(kind, **placed.sizes, physicsClientId=self.client))

    def _body(self, placed: Placed, mass: float = 1.0) -> int:
        """Make a body: one of mass 0 cannot move, and a plane never does.

        Two bodies that cannot move have no contacts; nor have two that can, when the diagonals of their bounding
        boxes exceed 1e6. One of each kind always has.
        """
        mass = 0.0 if placed.geometry == "GEOM_PLANE" else mass
        shape, client = self._shape(placed), self.client
        made = self.bullet.createMultiBody(
            mass, shape, self.skin, placed.position, placed.orientation, physicsClientId=client
        )
        return int(made)

    def _points(self, a: Placed, b: Placed, threshold: float) -> Any:
        self._begin()
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

    def closest(self, a: Placed, b: Placed) -> AnswerRow:
        """Nearest of the closest points."""
        return self._signed(self._points(a, b, FAR), a, b)

    def closest_to_plane(self, plane: Placed, b: Placed) -> AnswerRow:
        """Nearest of the closest points; for shapes without bodies PyBullet returns a leading plane as B."""
        answer = self._signed(self._points(b, plane, FAR), b, plane)
        _, distance, bx, by, bz, ax, ay, az, x, y, z = answer[:11]
        return answer_row(distance=distance, on_a=(ax, ay, az), on_b=(bx, by, bz), normal=(-x, -y, -z))

    @staticmethod
    def _signed(points: Any, a: Placed, b: Placed) -> AnswerRow:
        if not points:
            raise NoAnswer("PyBullet returned no closest point")
        best = min(points, key=itemgetter(DISTANCE_FIELD))
        return answer_row(**without_extra(best, a.extra, b.extra))

    def overlap(self, a: Placed, b: Placed) -> AnswerRow:
        """Whether there is a closest point at a distance of at most 0."""
        return answer_row(hit=float(len(self._points(a, b, 0.0)) > 0))

    def contacts(self, a: Placed, b: Placed) -> AnswerRow:
        """Deepest contact of a collision detection; contacts across a gap are no hits."""
        self._begin()
        bullet, client = self.bullet, self.client
        bodies: list[int] = []
        try:
            fixed = b.geometry != "GEOM_PLANE"
            bodies += [self._body(a, 0.0 if fixed else 1.0)]
            bodies += [self._body(b)]
            bullet.performCollisionDetection(physicsClientId=client)
            points = bullet.getContactPoints(*bodies, physicsClientId=client)
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)
        best = min(points, key=itemgetter(DISTANCE_FIELD), default=None)
        if best is None or best[DISTANCE_FIELD] + (a.extra + b.extra) > 0:
            return answer_row(hit=0.0)
        return answer_row(hit=1.0, **without_extra(best, a.extra, b.extra))

    def cast(self, ray: Row, target: Placed) -> AnswerRow:
        """First hit of a ray up to beyond its target."""
        self._begin()
        bullet, client = self.bullet, self.client
        end, body = ray_end(ray, target), self._body(target)
        try:
            found = bullet.rayTest(ray[:3], ray_at(ray, end), physicsClientId=client)
        finally:
            bullet.removeBody(body, physicsClientId=client)
        unique, _, fraction, point, normal = found[0]
        if unique < 0:
            return answer_row(hit=0.0, t=math.inf)
        return answer_row(hit=1.0, t=fraction * end, normal=normal, point=point)


def import_bullet() -> Any:
    """Import pybullet, which prints a line when imported."""
    try:
        import pybullet  # noqa: PLC0415  an optional package
    except ImportError as error:
        text = f"pybullet cannot be imported ({error}): pip install pybullet"
        raise EngineUnavailable(text) from None
    return pybullet
