"""The Flexible Collision Library, by way of python-fcl. Facts below were measured on python-fcl 0.7.0.11.

Signed distances come from GJK and EPA (libccd) for every pair of solids, also where FCL has a closed form for the
unsigned distance: that one says −1 for every overlap. `collide` has closed forms for pairs of spheres, boxes and
half-spaces with anything but a capsule and a box, and for spheres with capsules and cylinders; libccd answers the
other pairs by portal refinement (MPR). There is no ray query.

A Point is a Sphere of radius 0, which FCL takes: its answers are as good as those for any small sphere, but that
GJK may end at a corner where a radius up to 1e-6 and a box line up, as it does for two boxes.

Polytopes are `Convex` hulls of their vertices. A mesh is a `BVHModel`, a surface: a shape wholly inside has a
distance from it, and no contact; an overlap has no depth (without the signed distance, which FCL does not have for
meshes, it says −1, for two meshes 0), and each contact is that of one triangle. FCL has no unions: a composite
is asked part by part, and the nearest, or deepest, answer counts.

Sweeps are in `fcl_sweeps`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import Any, ClassVar

import numpy as np

from oracles.engine import (
    NATIVE,
    AnswerRow,
    Array,
    Convention,
    Effective,
    Engine,
    EngineUnavailable,
    Kind,
    NoAnswer,
    Row,
    Solver,
    Support,
    Tolerance,
    UnsupportedCell,
    answer_row,
    emulated,
    unsupported,
)
from oracles.engines import fcl_sweeps as sweeps
from oracles.engines import geometry
from oracles.engines.fcl_crowd import FclCrowds
from oracles.engines.fcl_shapes import Maker, Placed, frame_text, place, shape_text
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, SWEEP
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    Cylinder,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)

MOST_CONTACTS, MOST_OF_A_MESH = 20, 100_000
"""Contacts that are asked for; of a mesh each triangle has its own, and the deepest is not the first."""
OVERLAP = -float("inf")
"""What is said of an overlap whose depth the engine does not say."""

SAYS = {
    DISTANCE: frozenset({"distance", "on_a", "on_b"}),
    CONTACTS: frozenset({"hit", "distance", "normal", "point"}),
    BOOLEAN: frozenset({"hit"}),
    SWEEP: frozenset({"hit", "t"}),
}

EMULATED = {
    Point: "a Point is a Sphere of radius 0",
    AABB: "an AABB is a Box without rotation",
    KDOP: "a KDOP is the Convex hull of its corners",
    Composite: "a Composite is asked part by part; the nearest or deepest answer counts",
}

# Defaults of FCL's distance_tolerance (distance) and gjk_tolerance (collide), neither of which the binding can set:
# absolute thresholds on what the last step gains, read as relative for scenes larger than 1.
ITERATIVE = Tolerance.uniform(1e-6, 1e-6, "FCL's solver stops when a step gains less than 1e-6")
# A dozen roundings of coordinates at 1.1e-16 each, with room for the sums inside.
CLOSED = Tolerance.uniform(0.0, 1e-12, "closed form in double precision")
# The parts of a composite in a frame of their own, the normal of the plane, and the position each round once more.
CLOSED_BY_PARTS = Tolerance.uniform(0.0, 3e-12, "closed form in double precision for each part")

BALLS = (Point, Sphere)
BOXES = (AABB, Box)
NO_PLANES = "fcl.distance ends the process (segmentation fault) on any pair with a Halfspace"


class FclEngine(Engine):
    """FCL: signed distance with nearest points, contacts of `collide`, overlap."""

    name: ClassVar[str] = "fcl"
    thresholds: ClassVar[Mapping[str, float]] = {"tolerance of GJK and libccd": 1e-6}

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains the library."""
        return {"python-fcl": metadata.version("python-fcl")}

    def warm(self) -> None:
        """Import fcl."""
        _import()

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        if query == RAYCAST:
            return unsupported("FCL has no ray query")
        if HalfSpace in (A, B) and query == DISTANCE:
            return unsupported(NO_PLANES)
        if A is B is HalfSpace and query == CONTACTS:
            return unsupported("fcl.collide gives no contact for any two half-spaces")
        notes = [text for kind, text in EMULATED.items() if kind in (A, B)]
        return emulated("; ".join(notes)) if notes else NATIVE

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        lacking = sweeps.lacking(A, B)
        return unsupported(lacking) if lacking else self._support(SWEEP, A, B)

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer: a contact has one position, not two witnesses."""
        del A, B
        return SAYS.get(query, frozenset())

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give the solver's thresholds for GJK, EPA and MPR, and rounding for closed forms."""
        if query == SWEEP:
            return sweeps.TOLERANCE
        if query == DISTANCE or _by_portal(A, B):
            return ITERATIVE
        return CLOSED_BY_PARTS if Composite in (A, B) else CLOSED

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        """Take meshes for the surfaces that they are."""
        del query
        return _effective(A, rows_a), _effective(B, rows_b)

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Contacts whose depth is that of their own normal, and what a surface has instead of a depth."""
        found: dict[Convention, str] = {}
        if query == DISTANCE and Polyhedron in (A, B):
            text = "a BVHModel is a surface: signed distances do not exist, and an unsigned one of −1 is an overlap"
            found[Convention.NO_DEPTH] = text
        if query == CONTACTS and Polyhedron in (A, B) and HalfSpace not in (A, B):
            found[Convention.OF_ONE_TRIANGLE] = "a contact with a BVHModel is one with a triangle of it"
        if query == CONTACTS and _by_portal(A, B):
            text = "portal refinement (MPR) gives a direction that separates, with its depth, not the least"
            found[Convention.DEPTH_OF_ITS_NORMAL] = text
        if query == CONTACTS and A in BOXES and B in BOXES:
            text = "edge-edge axes count only when they beat the face axes by 5 %"
            found[Convention.DEPTH_OF_ITS_NORMAL] = text
        return found

    def broad_phase(self) -> FclCrowds:
        """Give the engine's broad phase."""
        return FclCrowds()

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 4 to 15 µs, where it has no parts and no new hull or mesh."""
        self.require(query, A, B)
        fcl = _import()
        if query == SWEEP:
            return sweeps.solver(fcl, A, B)
        make, ask, nearer = Maker(fcl), ASK[query](fcl), NEARER[query]

        def solve(row_a: Row, row_b: Row) -> AnswerRow:
            placed_a, placed_b = _placed(query, A, row_a), _placed(query, B, row_b)
            with_mesh = _is_mesh(placed_a) or _is_mesh(placed_b)
            if len(placed_a) == len(placed_b) == 1:
                return ask(make(placed_a[0]), make(placed_b[0]), with_mesh)
            objects_b = [make(b) for b in placed_b]
            answers = [ask(a, b, with_mesh) for a in map(make, placed_a) for b in objects_b]
            return min(answers, key=nearer)

        return solve

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs fcl and numpy."""
        self.require(query, A, B)
        if query == SWEEP:
            return sweeps.script(A, row_a, B, row_b)
        placed_a, placed_b = _placed(query, A, row_a), _placed(query, B, row_b)
        signed = not (_is_mesh(placed_a) or _is_mesh(placed_b))
        most = MOST_CONTACTS if signed else MOST_OF_A_MESH
        ask = SCRIPTS[query].replace("SIGNED", repr(signed)).replace("MOST", repr(most))
        if query == DISTANCE:
            ask += TELL_SIGNED if signed else TELL_UNSIGNED
        return SCRIPT.format(
            query=query, A=A.__name__, B=B.__name__, a=_objects("a", placed_a), b=_objects("b", placed_b), ask=ask
        )


def _by_portal(A: Kind, B: Kind) -> bool:
    """Whether `collide` has no closed form for the pair."""
    if HalfSpace in (A, B):
        return False
    balls = [kind in BALLS for kind in (A, B)]
    if any(balls):
        other = B if balls[0] else A
        return not (all(balls) or other in (Sphere, Capsule, Cylinder, *BOXES))
    return not (A in BOXES and B in BOXES)


def _effective(kind: Kind, rows: Array) -> Effective:
    if kind is not Polyhedron:
        return Effective.exactly(kind, rows)
    return Effective.of(geometry.surface(rows), np.zeros(len(rows)))


def _placed(query: str, kind: Kind, row: Row) -> list[Placed]:
    found = place(kind, row)
    if query == DISTANCE and any(placed.geometry == "Halfspace" for placed in found):
        raise UnsupportedCell(NO_PLANES)
    if kind is Composite and _is_mesh(found):
        raise UnsupportedCell("a mesh that is part of a Composite would be asked as a surface, beside solids")
    return found


def _is_mesh(placed: list[Placed]) -> bool:
    return any(p.geometry == "BVHModel" for p in placed)


def _import() -> Any:
    try:
        import fcl  # noqa: PLC0415  an optional package
    except ImportError as error:
        raise EngineUnavailable(f"fcl cannot be imported ({error}): pip install python-fcl") from None
    return fcl


Ask = Callable[[Any, Any, bool], AnswerRow]


def _distance(fcl: Any) -> Ask:
    requests = [fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=signed) for signed in (0, 1)]

    def ask(a: Any, b: Any, with_mesh: bool) -> AnswerRow:
        result = fcl.DistanceResult()
        fcl.distance(a, b, requests[not with_mesh], result)
        if with_mesh and result.min_distance <= 0:
            return answer_row(distance=OVERLAP)
        on_a, on_b = result.nearest_points
        if on_a is None:
            raise NoAnswer("fcl.distance left its result empty")
        return answer_row(distance=result.min_distance, on_a=on_a.tolist(), on_b=on_b.tolist())

    return ask


def _contacts(fcl: Any) -> Ask:
    several = (MOST_CONTACTS, MOST_OF_A_MESH)
    requests = [fcl.CollisionRequest(num_max_contacts=most, enable_contact=True) for most in several]

    def ask(a: Any, b: Any, with_mesh: bool) -> AnswerRow:
        result = fcl.CollisionResult()
        fcl.collide(a, b, requests[with_mesh], result)
        if not result.contacts:
            return answer_row(hit=float(result.is_collision))
        deepest = max(result.contacts, key=lambda contact: contact.penetration_depth)
        return answer_row(
            hit=1.0,
            distance=-deepest.penetration_depth,
            normal=deepest.normal.tolist(),
            point=deepest.pos.tolist(),
        )

    return ask


def _boolean(fcl: Any) -> Ask:
    request = fcl.CollisionRequest()

    def ask(a: Any, b: Any, _: bool) -> AnswerRow:
        result = fcl.CollisionResult()
        fcl.collide(a, b, request, result)
        return answer_row(hit=float(result.is_collision))

    return ask


ASK: dict[str, Callable[[Any], Ask]] = {DISTANCE: _distance, CONTACTS: _contacts, BOOLEAN: _boolean}
NEARER: dict[str, Callable[[AnswerRow], tuple[float, ...]]] = {
    DISTANCE: lambda row: (row[1],),
    CONTACTS: lambda row: (-row[0], row[1]),
    BOOLEAN: lambda row: (-row[0],),
}
"""By what the answer of a composite is chosen among those of its parts: the least of these."""


def _objects(name: str, placed: list[Placed]) -> str:
    """Lines that make the list of collision objects of one side."""
    lines, objects = "", []
    for i, one in enumerate(placed):
        shape = name + "_shape" + (str(i) if len(placed) > 1 else "")
        lines += shape_text(shape, one)
        objects.append(f"fcl.CollisionObject({shape}, {frame_text(one)})")
    return lines + f"{name} = [\n" + "".join(f"    {text},\n" for text in objects) + "]"


SCRIPT = '''"""FCL: {query} of {A} (a) and {B} (b); of several objects the nearest or deepest counts."""

from importlib.metadata import version

import fcl
import numpy as np

print("python-fcl", version("python-fcl"))
{a}
{b}
{ask}'''

SCRIPTS = {
    DISTANCE: """

def distance(x, y):
    result = fcl.DistanceResult()
    fcl.distance(x, y, fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=SIGNED), result)
    return result


result = min((distance(x, y) for x in a for y in b), key=lambda found: found.min_distance)
""",
    CONTACTS: """
request = fcl.CollisionRequest(num_max_contacts=MOST, enable_contact=True)
results = [(x, y, fcl.CollisionResult()) for x in a for y in b]
for x, y, result in results:
    fcl.collide(x, y, request, result)
print("hit =", float(any(result.is_collision for *_, result in results)))
contacts = [contact for *_, result in results for contact in result.contacts]
if contacts:
    deepest = max(contacts, key=lambda contact: contact.penetration_depth)
    print("distance =", repr(-float(deepest.penetration_depth)))
    print("normal =", deepest.normal.tolist())  # from a to b
    print("point =", deepest.pos.tolist())
""",
    BOOLEAN: """
results = [(x, y, fcl.CollisionResult()) for x in a for y in b]
for x, y, result in results:
    fcl.collide(x, y, fcl.CollisionRequest(), result)
print("hit =", float(any(result.is_collision for *_, result in results)))
""",
}

TELL_SIGNED = """if result.nearest_points[0] is None:
    raise RuntimeError("fcl.distance left its result empty")
print("distance =", repr(float(result.min_distance)))
print("on_a =", result.nearest_points[0].tolist())
print("on_b =", result.nearest_points[1].tolist())
"""
TELL_UNSIGNED = f"""if result.min_distance <= 0:
    print("distance = -inf")  # an overlap, whose depth FCL does not say of meshes
else:
{textwrap.indent(TELL_SIGNED, "    ")}"""
