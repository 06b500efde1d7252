"""Bullet, by way of PyBullet. Facts below were measured on PyBullet 3.2.7, whose arithmetic is double precision.

Box, AABB and Cylinder have a margin of 0.001: the set that closest points, contacts and rays use is the shape shrunk
by the margin and grown again by a ball of that radius, so its edges are round. In two cases the sharp box is used:
contacts of two boxes (separating axes), and boxes against a plane. A half extent below the margin turns the shrunk
shape inside out, and answers are off by about the margin. Spheres and capsules are exact.

A hull is grown by the margin, and its vertices are moved: `btConvexHullComputer` keeps them on a grid of 10216 steps
along each side of their bounding box. What it makes of them is reproduced to the last bits in `bullet_shapes.on_grid`
and declared as the shape that Bullet effectively uses.

A concave mesh is a surface that cannot move: a shape wholly inside is at a distance from it. Its triangles are grown
by the margin, but not against spheres. There is no algorithm for two meshes, or a mesh and a plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib import metadata
from typing import ClassVar

import numpy as np

from oracles.engine import (
    NATIVE,
    VELOCITIES,
    Array,
    Bound,
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
from oracles.engines import bullet_impacts as impacts
from oracles.engines import geometry
from oracles.engines.bullet_boxes import BulletCrowds
from oracles.engines.bullet_scripts import script, sweep_script
from oracles.engines.bullet_shapes import MARGIN, NO_ELLIPSOID, on_grid, place, ray_of
from oracles.engines.bullet_world import World, import_bullet
from oracles.keeping import kept_by_rows, shape_of
from oracles.motion import Motion
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
)

THINNEST = {DISTANCE: 1e-300, BOOLEAN: 1e-300, RAYCAST: 1e-300, SWEEP: 1e-300, CONTACTS: 1e-8}
"""Radius in place of 0, which PyBullet refuses, relative to coordinates above 1; it is taken off the answer again.
Bullet drops a contact whose two points slide apart by 2 % of the smaller shape's size: on a thinner point rounding
alone would do that. On a thicker one the contact is turned a little, which is not taken off."""

BOXES = (AABB, Box)
SURFACES = (HalfSpace, Polyhedron)
SAYS = {
    DISTANCE: frozenset({"distance", "on_a", "on_b", "normal"}),
    CONTACTS: frozenset({"hit", "distance", "on_a", "on_b", "normal"}),
    BOOLEAN: frozenset({"hit"}),
    RAYCAST: frozenset({"hit", "t", "normal", "point"}),
    SWEEP: frozenset({"hit", "t", "normal", "point"}),
    IMPACT: frozenset(VELOCITIES),
}

EXACT = Tolerance.uniform(1e-12, 1e-12, "Bullet's thresholds in double precision: GJK and EPA stop at 1e-12")
# btBoxBoxDetector adds 1e-5 to each |cosine| of an edge-edge axis, multiplies it by one of four half extents, and
# divides by the sine between the edges: 8e-5 of the size for edges that cross at 30 degrees or more.
EDGES = Tolerance.uniform(1e-12, 8e-5, "the separating-axis test adds 1e-5 to the cosines of edge-edge axes")
# btGjkConvexCast advances a ray until it is within 0.001 of the shape and calls that the hit.
CAST = Tolerance.uniform(MARGIN, 1e-12, "a ray hits a convex shape once it is within 0.001 of it")
PLANE_CAST = Tolerance.uniform(0.0, 1e-12, "closed form in double precision")
# A plane's triangles are made as small as the way, down to 1e-10 of the coordinates, and have that many digits less.
PLANE_SWEEP = Tolerance(
    Bound(0.0, 1e-12), Bound(1e-4, 1e-4), Bound(0.0, 1e-12), "closed form, but for the normal of a triangle on the way"
)
# Both shapes may have the margin, and both the grid, whose step is 1e-4 of a hull's extent, twice its largest number.
PARTS = Tolerance.uniform(2.2e-3, 4e-4, "each part has its own margin of up to 0.001, and hulls a grid of 1/10216")

RAY_TESTS = (RAYCAST, SWEEP)
"""Queries that are answered by ray tests."""
AS_RAY = "a moving Point is a ray test along its way, as seen from the other"
STEPPED = "only Bullet's ray test, of a moving Point, says when there is a contact; its steps are another engine's"

EMULATED = {
    Point: "a Point is a sphere of radius {:g}, which is taken off the answer",
    AABB: "an AABB is a box without rotation",
    KDOP: "a KDOP is the hull of its corners",
    Composite: "a Composite is a compound of its boxes and round parts, with its hulls beside it; the nearest counts",
}


class BulletEngine(Engine):
    """Bullet: closest points, contacts after collision detection, overlap, ray tests, impacts."""

    name: ClassVar[str] = "bullet"
    thresholds: ClassVar[Mapping[str, float]] = {
        "margin": MARGIN,
        "contact breaking threshold": 0.02,
        "where GJK and EPA stop": 1e-12,
    }

    def __init__(self) -> None:
        self._world: World | None = None
        self._impacts: impacts.ImpactWorld | None = None

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains the library."""
        return {"pybullet": metadata.version("pybullet")}

    def warm(self) -> None:
        """Import pybullet."""
        import_bullet()

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        if A is B is HalfSpace:
            return unsupported("Bullet has no algorithm for two planes and never reports anything")
        if A in SURFACES and B in SURFACES:
            return unsupported("Bullet has no algorithm for two concave meshes, nor for one and a plane")
        if Ellipsoid in (A, B):
            return unsupported(NO_ELLIPSOID)
        notes = [text.format(THINNEST[query]) for kind, text in EMULATED.items() if kind in (A, B)]
        return emulated("; ".join(notes)) if notes else NATIVE

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        del A, B
        return NATIVE

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        if A is not Point:
            return unsupported(STEPPED)
        kept = self._support(SWEEP, Ray, B)
        return emulated(f"{AS_RAY}; {kept.reason}" if kept.reason else AS_RAY) if kept else kept

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer."""
        del A, B
        return SAYS[query]

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give rounding, except for rays on convex shapes, contacts of boxes, and composites."""
        if query == IMPACT:
            return impacts.TOLERANCE
        if Composite in (A, B):
            return PARTS
        if query in RAY_TESTS and B in SURFACES:
            return PLANE_CAST if query == RAYCAST else PLANE_SWEEP
        if query in RAY_TESTS:
            return CAST
        return EDGES if _by_axes(query, A, B) else EXACT

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        """Round the edges of boxes and cylinders, grow hulls and triangles, and take meshes for surfaces."""
        sharp = HalfSpace in (A, B) or _by_axes(query, A, B)
        bare = query in RAY_TESTS or A in (Point, Sphere) or B in (Point, Sphere)
        return _effective(A, rows_a, sharp, bare), _effective(B, rows_b, sharp, bare)

    def effective_motion(self, A: Kind, B: Kind, motion: Motion, rows: tuple[Array, Array]) -> Motion:
        """Leave bodies the moments about their own axes, as Bullet has no others, and have them spin for a step."""
        a, b = (impacts.as_held(*body) for body in zip((A, B), motion.bodies, rows, strict=True))
        return replace(motion, a=a, b=b)

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Rays from inside, the axes that contacts of boxes prefer, and the law of friction."""
        if query == IMPACT:
            text = "friction ends the sliding after the bounce; the reference's ends that of the compression"
            return {Convention.OTHER_FRICTION: text}
        if query in RAY_TESTS and B is HalfSpace:
            return {Convention.TWO_SIDED_PLANE: "for rays, Bullet's plane is a surface hit from both sides"}
        if query in RAY_TESTS and B is Polyhedron:
            return {Convention.TWO_SIDED_PLANE: "for rays, a mesh is a surface hit from both sides"}
        if query in RAY_TESTS:
            text = "from inside, a box or hull is not hit, and a round shape only by a ray towards its core"
            return {Convention.NO_HIT_FROM_INSIDE: text}
        if _by_axes(query, A, B):
            text = "edge-edge axes count only when they beat the face axes by 5 %"
            return {Convention.DEPTH_OF_ITS_NORMAL: text}
        return {}

    def broad_phase(self) -> BulletCrowds:
        """Give the engine's broad phase."""
        return BulletCrowds()

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 15 µs (closest points, overlap), 120 µs (rays), 220 µs (contacts) or 1 ms (impacts)."""
        self.require(query, A, B)
        if query == IMPACT:
            self._impacts = self._impacts or impacts.ImpactWorld(impacts.EXACTLY)
            return self._impacts.solver(A, B)
        self._world = self._world or World()
        world, thinnest = self._world, THINNEST[query]
        if query == RAYCAST:
            return lambda ray, b: world.cast(ray, place(B, b, thinnest))
        if query == SWEEP:
            return lambda a, b: world.sweep(*ray_of(a), place(B, b, thinnest))
        ask = {DISTANCE: world.closest, CONTACTS: world.contacts, BOOLEAN: world.overlap}[query]
        return lambda a, b: ask(place(A, a, thinnest), place(B, b, thinnest))

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs pybullet only."""
        self.require(query, A, B)
        if query == IMPACT:
            return impacts.script(A, row_a, B, row_b, impacts.EXACTLY)
        thinnest, names = THINNEST[query], (A.__name__, B.__name__)
        b = place(B, row_b, thinnest)
        if query == SWEEP:
            ray, along = ray_of(row_a)
            return sweep_script(names, ray, along, b)
        if query == RAYCAST:
            return script(query, names, row_a, [], b)
        return script(query, names, [], place(A, row_a, thinnest), b)


def _by_axes(query: str, A: Kind, B: Kind) -> bool:
    """Whether the cell is answered by the separating axes of two boxes."""
    return query == CONTACTS and A in BOXES and B in BOXES


# -- effective shapes ----------------------------------------------------------------------------------------

LEAST = 1e-6
"""Part of itself that a cylinder keeps when the margin takes more: it has no size 0."""


def _effective(kind: Kind, rows: Array, sharp: bool, bare: bool) -> Effective:
    """Shapes of one side: boxes keep their edges where they are `sharp`, triangles have no margin where `bare`."""
    grown = np.full(len(rows), MARGIN)
    if kind in BOXES and not sharp:
        return Effective(kind, _shrunk_boxes(kind, rows), grown)
    if kind is Cylinder:
        return Effective(kind, _shrunk_cylinders(rows), grown)
    if kind in (KDOP, ConvexPolyhedron):
        return Effective.of(_hulls(rows, kind), grown)
    if kind is Polyhedron:
        return Effective.of(geometry.surface(rows), 0.0 * grown if bare else grown)
    return Effective.exactly(kind, rows)


def _shrunk_boxes(kind: Kind, rows: Array) -> Array:
    """Boxes that are smaller by the margin on every side, down to nothing."""
    shrunk = rows.copy()
    if kind is Box:
        shrunk[:, 3:6] = np.maximum(rows[:, 3:6] - MARGIN, 0.0)
        return shrunk
    center = rows[:, :3] / 2 + rows[:, 3:] / 2
    shrunk[:, :3] = np.minimum(rows[:, :3] + MARGIN, center)
    shrunk[:, 3:] = np.maximum(rows[:, 3:] - MARGIN, center)
    return shrunk


def _shrunk_cylinders(rows: Array) -> Array:
    """Cylinders that are smaller by the margin on every side, down to almost nothing."""
    p, q, radius = rows[:, :3], rows[:, 3:6], rows[:, 6]
    length = np.maximum(np.linalg.norm(q - p, axis=1), np.finfo(float).tiny)
    step = (q - p) * np.minimum(MARGIN / length, (1 - LEAST) / 2)[:, None]
    meet = (p + step == q - step).all(axis=1)  # far away, almost nothing is nothing
    step[meet] = (q - p)[meet] / 8
    return np.column_stack([p + step, q - step, np.maximum(radius - MARGIN, LEAST * radius)])


@kept_by_rows
def _hulls(rows: Array, kind: Kind) -> ConvexPolyhedron:
    """Hulls with their vertices on Bullet's grid; a row that has fewer than others repeats its last one."""
    given = shape_of(rows, kind)
    assert isinstance(given, KDOP | ConvexPolyhedron)
    frame = () if isinstance(given, KDOP) else (given.position, given.rotation)
    return ConvexPolyhedron.from_vertices(on_grid(geometry.different(given.vertices)), *frame)
