"""The Flexible Collision Library, by way of python-fcl. Facts below were measured on python-fcl 0.7.0.11.

Signed distances come from GJK and EPA (libccd) for every pair, also where FCL has a closed form for the
unsigned distance: that one says −1 for every overlap. `collide` has closed forms for all pairs here but
capsule–capsule and capsule–box, which libccd answers by portal refinement (MPR). There is no ray query.

A Point is a Sphere of radius 0, which FCL takes: its answers are as good as those for any small sphere, but that
GJK may end at a corner where a radius up to 1e-6 and a box line up, as it does for two boxes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import Any, ClassVar, NamedTuple

import numpy as np

from oracles.engine import (
    NATIVE,
    AnswerRow,
    Array,
    Convention,
    Engine,
    EngineUnavailable,
    Kind,
    NoAnswer,
    Row,
    Solver,
    Support,
    Tolerance,
    answer_row,
    emulated,
    unsupported,
)
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Sphere

MOST_CONTACTS = 20

SAYS = {
    DISTANCE: frozenset({"distance", "on_a", "on_b"}),
    CONTACTS: frozenset({"hit", "distance", "normal", "point"}),
    BOOLEAN: frozenset({"hit"}),
}

EMULATED = {Point: "a Point is a Sphere of radius 0", AABB: "an AABB is a Box without rotation"}

# Defaults of FCL's distance_tolerance (distance) and gjk_tolerance (collide), neither of which the binding can set:
# absolute thresholds on what the last step gains, read as relative for scenes larger than 1.
ITERATIVE = Tolerance.uniform(1e-6, 1e-6, "FCL's solver stops when a step gains less than 1e-6")
# A dozen roundings of coordinates at 1.1e-16 each, with room for the sums inside.
CLOSED = Tolerance.uniform(0.0, 1e-12, "closed form in double precision")

ROUND = (Point, Sphere)
BOXES = (AABB, Box)


class Placed(NamedTuple):
    """A proxy as FCL takes it: geometry in its own frame, and where that frame stands; None: not turned."""

    geometry: str
    sizes: tuple[float | Array, ...]
    rotation: list[list[float]] | None
    translation: list[float]


def _rotation_to(x: float, y: float, z: float) -> list[list[float]]:
    """Rotation that takes the z axis to the unit vector (x, y, z) (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return [[1.0 + sign * x * x * a, b, x], [sign * b, sign + y * y * a, y], [-sign * x, -y, z]]


def _rotation_of(x: float, y: float, z: float, w: float) -> list[list[float]]:
    """Rotation matrix of a quaternion of any length."""
    size = max(abs(x), abs(y), abs(z), abs(w))
    x, y, z, w = x / size, y / size, z / size, w / size
    s = 2.0 / ((x * x + y * y) + (z * z + w * w))
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]


def _point(r: Row) -> Placed:
    return Placed("Sphere", (0.0,), None, r)


def _sphere(r: Row) -> Placed:
    return Placed("Sphere", (r[3],), None, r[:3])


def _capsule(r: Row) -> Placed:
    """Stand a capsule, which lies along z and whose length excludes the caps, on its segment."""
    px, py, pz, qx, qy, qz, radius = r
    x, y, z = qx - px, qy - py, qz - pz
    length = math.hypot(x, y, z)
    rotation = _rotation_to(x / length, y / length, z / length) if length > 0 else None
    return Placed("Capsule", (radius, length), rotation, [px / 2 + qx / 2, py / 2 + qy / 2, pz / 2 + qz / 2])


def _halfspace(r: Row) -> Placed:
    """Turn normal·x + k ≤ 0 into FCL's n·x ≤ d with a unit n."""
    length = math.hypot(r[0], r[1], r[2])
    normal = np.array([r[0] / length, r[1] / length, r[2] / length])
    return Placed("Halfspace", (normal, -r[3] / length), None, [0.0, 0.0, 0.0])


def _aabb(r: Row) -> Placed:
    lower, upper = r[:3], r[3:]
    sides = tuple(u - v for u, v in zip(upper, lower, strict=True))
    return Placed("Box", sides, None, [u / 2 + v / 2 for u, v in zip(upper, lower, strict=True)])


def _box(r: Row) -> Placed:
    return Placed("Box", (2 * r[3], 2 * r[4], 2 * r[5]), _rotation_of(*r[6:]), r[:3])


PLACE: dict[Kind, Callable[[Row], Placed]] = {
    Point: _point,
    Sphere: _sphere,
    Capsule: _capsule,
    HalfSpace: _halfspace,
    AABB: _aabb,
    Box: _box,
}


class FclEngine(Engine):
    """FCL: signed distance with nearest points, contacts of `collide`, overlap."""

    name: ClassVar[str] = "fcl"

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
            return unsupported("fcl.distance ends the process (segmentation fault) on any pair with a Halfspace")
        if A is B is HalfSpace and query == CONTACTS:
            return unsupported("fcl.collide gives no contact for any two half-spaces")
        notes = [text for kind, text in EMULATED.items() if kind in (A, B)]
        return emulated("; ".join(notes)) if notes else NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer: a contact has one position, not two witnesses."""
        del A, B
        return SAYS.get(query, frozenset())

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give the solver's thresholds for GJK, EPA and MPR, and rounding for closed forms."""
        return ITERATIVE if query == DISTANCE or _by_portal(A, B) else CLOSED

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Contacts whose depth is that of their own normal."""
        if query == CONTACTS and _by_portal(A, B):
            text = "portal refinement (MPR) gives a direction that separates, with its depth, not the least"
            return {Convention.DEPTH_OF_ITS_NORMAL: text}
        if query == CONTACTS and A in BOXES and B in BOXES:
            text = "edge-edge axes count only when they beat the face axes by 5 %"
            return {Convention.DEPTH_OF_ITS_NORMAL: text}
        return {}

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 4 to 15 µs."""
        self.require(query, A, B)
        fcl = _import()
        place_a, place_b, ask = PLACE[A], PLACE[B], ASK[query](fcl)

        def solve(row_a: Row, row_b: Row) -> AnswerRow:
            return ask(_object(fcl, place_a(row_a)), _object(fcl, place_b(row_b)))

        return solve

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs fcl and numpy."""
        self.require(query, A, B)
        a, b = _constructor(PLACE[A](row_a)), _constructor(PLACE[B](row_b))
        return SCRIPT.format(query=query, A=A.__name__, B=B.__name__, a=a, b=b, ask=SCRIPTS[query])


def _by_portal(A: Kind, B: Kind) -> bool:
    """Whether `collide` has no closed form for the pair."""
    others = (Capsule, *BOXES)
    return Capsule in (A, B) and A in others and B in others


def _import() -> Any:
    try:
        import fcl  # noqa: PLC0415  an optional package
    except ImportError as error:
        raise EngineUnavailable(f"fcl cannot be imported ({error}): pip install python-fcl") from None
    return fcl


def _object(fcl: Any, placed: Placed) -> Any:
    """Make the collision object; 2 to 4 µs."""
    geometry, sizes, rotation, translation = placed
    shape = getattr(fcl, geometry)(*sizes)
    frame = fcl.Transform(translation) if rotation is None else fcl.Transform(rotation, translation)
    return fcl.CollisionObject(shape, frame)


def _distance(fcl: Any) -> Callable[[Any, Any], AnswerRow]:
    request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)

    def ask(a: Any, b: Any) -> AnswerRow:
        result = fcl.DistanceResult()
        fcl.distance(a, b, request, result)
        on_a, on_b = result.nearest_points
        if on_a is None:
            raise NoAnswer("fcl.distance left its result empty")
        return answer_row(distance=result.min_distance, on_a=on_a.tolist(), on_b=on_b.tolist())

    return ask


def _contacts(fcl: Any) -> Callable[[Any, Any], AnswerRow]:
    request = fcl.CollisionRequest(num_max_contacts=MOST_CONTACTS, enable_contact=True)

    def ask(a: Any, b: Any) -> AnswerRow:
        result = fcl.CollisionResult()
        fcl.collide(a, b, request, result)
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


def _boolean(fcl: Any) -> Callable[[Any, Any], AnswerRow]:
    request = fcl.CollisionRequest()

    def ask(a: Any, b: Any) -> AnswerRow:
        result = fcl.CollisionResult()
        fcl.collide(a, b, request, result)
        return answer_row(hit=float(result.is_collision))

    return ask


ASK: dict[str, Callable[[Any], Callable[[Any, Any], AnswerRow]]] = {
    DISTANCE: _distance,
    CONTACTS: _contacts,
    BOOLEAN: _boolean,
}


def _constructor(placed: Placed) -> str:
    """Python text that makes the collision object."""
    geometry, sizes, rotation, translation = placed
    texts = [f"np.array({s.tolist()!r})" if isinstance(s, np.ndarray) else repr(s) for s in sizes]
    turned = "" if rotation is None else f"np.array({rotation!r}), "
    frame = f"fcl.Transform({turned}np.array({translation!r}))"
    return f"fcl.CollisionObject(\n    fcl.{geometry}({', '.join(texts)}),\n    {frame},\n)"


SCRIPT = '''"""FCL: {query} of {A} (a) and {B} (b)."""

from importlib.metadata import version

import fcl
import numpy as np

print("python-fcl", version("python-fcl"))
a = {a}
b = {b}
{ask}'''

SCRIPTS = {
    DISTANCE: """request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)
result = fcl.DistanceResult()
fcl.distance(a, b, request, result)
print("distance =", repr(float(result.min_distance)))
print("on_a =", result.nearest_points[0].tolist())
print("on_b =", result.nearest_points[1].tolist())
""",
    CONTACTS: f"""request = fcl.CollisionRequest(num_max_contacts={MOST_CONTACTS}, enable_contact=True)
result = fcl.CollisionResult()
fcl.collide(a, b, request, result)
print("hit =", float(result.is_collision))
if result.contacts:
    deepest = max(result.contacts, key=lambda contact: contact.penetration_depth)
    print("distance =", repr(-float(deepest.penetration_depth)))
    print("normal =", deepest.normal.tolist())  # from a to b
    print("point =", deepest.pos.tolist())
""",
    BOOLEAN: """result = fcl.CollisionResult()
fcl.collide(a, b, fcl.CollisionRequest(), result)
print("hit =", float(result.is_collision))
""",
}
