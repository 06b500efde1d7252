"""Bullet, by way of PyBullet. Facts below were measured on PyBullet 3.2.7, whose arithmetic is double precision.

Box and AABB have a margin of 0.001: the set that closest points, contacts and rays use is the box shrunk by the
margin and grown again by a ball of that radius, so its edges are round. In two cases the sharp box is used:
contacts of two boxes (separating axes), and everything against a plane. A half extent below the margin turns
the shrunk box inside out, and answers are off by about the margin. Spheres and capsules are exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import metadata
from typing import ClassVar

import numpy as np

from oracles.engine import (
    NATIVE,
    Array,
    Convention,
    Effective,
    Engine,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    emulated,
    unsupported,
)
from oracles.engines.bullet_world import FAR, MARGIN, PLACE, Placed, World, import_bullet, ray_at, ray_end
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST
from refimpl.shapes import AABB, Box, HalfSpace, Point

THINNEST = {DISTANCE: 1e-300, BOOLEAN: 1e-300, RAYCAST: 1e-300, CONTACTS: 1e-8}
"""Radius in place of 0, which PyBullet refuses, relative to coordinates above 1; it is taken off the answer again.
Bullet drops a contact whose two points slide apart by 2 % of the smaller shape's size: on a thinner point rounding
alone would do that. On a thicker one the contact is turned a little, which is not taken off."""

BOXES = (AABB, Box)
SAYS = {
    DISTANCE: frozenset({"distance", "on_a", "on_b", "normal"}),
    CONTACTS: frozenset({"hit", "distance", "on_a", "on_b", "normal"}),
    BOOLEAN: frozenset({"hit"}),
    RAYCAST: frozenset({"hit", "t", "normal", "point"}),
}

EXACT = Tolerance.uniform(1e-12, 1e-12, "Bullet's thresholds in double precision: GJK and EPA stop at 1e-12")
# btBoxBoxDetector adds 1e-5 to each |cosine| of an edge-edge axis, multiplies it by one of four half extents, and
# divides by the sine between the edges: 8e-5 of the size for edges that cross at 30 degrees or more.
EDGES = Tolerance.uniform(1e-12, 8e-5, "the separating-axis test adds 1e-5 to the cosines of edge-edge axes")
# btGjkConvexCast advances a ray until it is within 0.001 of the shape and calls that the hit.
CAST = Tolerance.uniform(MARGIN, 1e-12, "a ray hits a convex shape once it is within 0.001 of it")
PLANE_CAST = Tolerance.uniform(0.0, 1e-12, "closed form in double precision")


class BulletEngine(Engine):
    """Bullet: closest points, contacts after collision detection, overlap, ray tests."""

    name: ClassVar[str] = "bullet"

    def __init__(self) -> None:
        self._world: World | None = None

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains the library."""
        return {"pybullet": metadata.version("pybullet")}

    def warm(self) -> None:
        """Import pybullet."""
        import_bullet()

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        if A is B is HalfSpace:
            return unsupported("Bullet has no algorithm for two planes and never reports anything")
        notes = []
        if Point in (A, B):
            notes.append(f"a Point is a sphere of radius {THINNEST[query]:g}, which is taken off the answer")
        if AABB in (A, B):
            notes.append("an AABB is a box without rotation")
        return emulated("; ".join(notes)) if notes else NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer."""
        del A, B
        return SAYS[query]

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give rounding, except for rays on convex shapes and contacts of boxes."""
        if query == RAYCAST:
            return PLANE_CAST if B is HalfSpace else CAST
        return EDGES if _by_axes(query, A, B) else EXACT

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        """Round the edges of boxes where Bullet does."""
        sharp = HalfSpace in (A, B) or _by_axes(query, A, B)
        return _effective(A, rows_a, sharp), _effective(B, rows_b, sharp)

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Rays from inside, and the axes that contacts of boxes prefer."""
        if query == RAYCAST and B is HalfSpace:
            return {Convention.TWO_SIDED_PLANE: "for rays, Bullet's plane is a surface hit from both sides"}
        if query == RAYCAST:
            text = "from inside, a box is not hit, and a sphere or capsule only by a ray towards its core"
            return {Convention.NO_HIT_FROM_INSIDE: text}
        if _by_axes(query, A, B):
            text = "edge-edge axes count only when they beat the face axes by 5 %"
            return {Convention.DEPTH_OF_ITS_NORMAL: text}
        return {}

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 15 µs (closest points, overlap), 120 µs (rays) or 220 µs (contacts)."""
        self.require(query, A, B)
        self._world = self._world or World()
        world, thinnest, place_b = self._world, THINNEST[query], PLACE[B]
        if query == RAYCAST:
            return lambda ray, b: world.cast(ray, place_b(b, thinnest))
        place_a = PLACE[A]
        closest = world.closest_to_plane if A is HalfSpace else world.closest
        ask = {DISTANCE: closest, CONTACTS: world.contacts, BOOLEAN: world.overlap}[query]
        return lambda a, b: ask(place_a(a, thinnest), place_b(b, thinnest))

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs pybullet only."""
        self.require(query, A, B)
        thinnest = THINNEST[query]
        b = PLACE[B](row_b, thinnest)
        if query == RAYCAST:
            body = _cast_script(row_a, b)
        elif query == CONTACTS:
            body = _contacts_script(PLACE[A](row_a, thinnest), b)
        else:
            body = _closest_script(query, PLACE[A](row_a, thinnest), b)
        return SCRIPT.format(query=query, A=A.__name__, B=B.__name__, body=body)


def _by_axes(query: str, A: Kind, B: Kind) -> bool:
    """Whether the cell is answered by the separating axes of two boxes."""
    return query == CONTACTS and A in BOXES and B in BOXES


def _effective(kind: Kind, rows: Array, sharp: bool) -> Effective:
    """Shapes of one side: boxes shrunk by their margin and grown again, unless they are `sharp`."""
    if kind not in BOXES or sharp:
        return Effective.exactly(kind, rows)
    return Effective(kind, _shrunk(kind, rows), np.full(len(rows), MARGIN))


def _shrunk(kind: Kind, rows: Array) -> Array:
    """Boxes that are smaller by the margin on every side, down to nothing."""
    shrunk = rows.copy()
    if kind is Box:
        shrunk[:, 3:6] = np.maximum(rows[:, 3:6] - MARGIN, 0.0)
        return shrunk
    center = rows[:, :3] / 2 + rows[:, 3:] / 2
    shrunk[:, :3] = np.minimum(rows[:, :3] + MARGIN, center)
    shrunk[:, 3:] = np.maximum(rows[:, 3:] - MARGIN, center)
    return shrunk


SCRIPT = '''"""Bullet: {query} of {A} (a) and {B} (b)."""

from importlib.metadata import version

import pybullet

print("pybullet", version("pybullet"))
pybullet.connect(pybullet.DIRECT)
{body}'''


def _shape_script(name: str, placed: Placed) -> str:
    sizes = ", ".join(f"{key}={value!r}" for key, value in placed.sizes.items())
    return f"{name} = pybullet.createCollisionShape(pybullet.{placed.geometry}, {sizes})\n"


def _body_script(name: str, placed: Placed, mass: float = 1.0) -> str:
    mass = 0.0 if placed.geometry == "GEOM_PLANE" else mass
    frame = f"basePosition={placed.position!r}, baseOrientation={placed.orientation!r}"
    return _shape_script(name, placed) + f"{name} = pybullet.createMultiBody({mass}, {name}, {frame})\n"


def _best_script(a: Placed, b: Placed, swapped: bool) -> str:
    """Print the nearest of `points`; fields 5 to 8 are on A, on B, the normal from B to A, the distance."""
    on_a, on_b = ("best[6]", "best[5]") if swapped else ("best[5]", "best[6]")
    sign, distance = "" if swapped else "-", "best[8]"
    text = f"best = min(points, key=lambda point: point[8])\nnormal = [{sign}u for u in best[7]]  # from a to b\n"
    if a.extra or b.extra:
        text += f"extra_a, extra_b = {a.extra!r}, {b.extra!r}  # radii that stand in for 0, taken off again\n"
        distance = "best[8] + (extra_a + extra_b)"
    on_a = f"[u - extra_a * n for u, n in zip({on_a}, normal)]" if a.extra else f"list({on_a})"
    on_b = f"[u + extra_b * n for u, n in zip({on_b}, normal)]" if b.extra else f"list({on_b})"
    return (
        text
        + f"""print("distance =", repr({distance}))
print("on_a =", {on_a})
print("on_b =", {on_b})
print("normal =", normal)
"""
    )


def _closest_script(query: str, a: Placed, b: Placed) -> str:
    swapped = a.geometry == "GEOM_PLANE" and query == DISTANCE
    text = _shape_script("a", a) + _shape_script("b", b)
    if swapped:
        text += "# The plane goes second: of shapes without bodies PyBullet returns a leading plane as B.\n"
    text += "points = pybullet.getClosestPoints(\n    bodyA=-1,\n    bodyB=-1,\n"
    text += f"    distance={FAR if query == DISTANCE else 0.0},\n"
    sides = (("A", "b", b), ("B", "a", a)) if swapped else (("A", "a", a), ("B", "b", b))
    for side, name, placed in sides:
        text += f"    collisionShape{side}={name},\n    collisionShapePosition{side}={placed.position!r},\n"
        text += f"    collisionShapeOrientation{side}={placed.orientation!r},\n"
    text += ")\n"
    if query == BOOLEAN:
        return text + 'print("hit =", float(len(points) > 0))\n'
    return text + _best_script(a, b, swapped)


def _contacts_script(a: Placed, b: Placed) -> str:
    text = _body_script("a", a, 1.0 if b.geometry == "GEOM_PLANE" else 0.0) + _body_script("b", b)
    text += "pybullet.performCollisionDetection()\n"
    reach = -(a.extra + b.extra)
    text += f"points = [point for point in pybullet.getContactPoints(a, b) if point[8] <= {reach!r}]\n"
    text += 'print("hit =", float(len(points) > 0))\nif points:\n'
    return text + "".join(f"    {line}\n" for line in _best_script(a, b, swapped=False).splitlines())


def _cast_script(ray: Row, b: Placed) -> str:
    end = ray_end(ray, b)
    return f"""{_body_script("b", b)}end = {end!r}  # the ray is past b
body, _, fraction, point, normal = pybullet.rayTest({ray[:3]!r}, {ray_at(ray, end)!r})[0]
print("hit =", float(body >= 0))
print("t =", repr(fraction * end if body >= 0 else float("inf")))
if body >= 0:
    print("normal =", list(normal))
    print("point =", list(point))
"""
