"""Sweeps by FCL's continuous collision. Facts below were measured on python-fcl 0.7.0.11.

Of the four solvers two exist. The naive one looks at `num_max_iterations` times and tunnels by design; conservative
advancement goes on by steps that are proven to be free, and stops when one is shorter than 1e-4 of the time, whatever
`toc_err` says. It is asked here, with FCL's own GJK (`GST_INDEP`): with libccd, the default, it comes too late on boxes
and misses capsules.

Of the motions `CCDM_TRANS`, the default, drops rotations. `CCDM_LINEAR` is meant to turn at a constant rate about the
origin of the object's frame, but never sets the point that it reads as its reference: the same scene is answered
otherwise in another process, from the right time to no hit at all. `CCDM_SCREW` is right for bodies that turn about an
axis along which they move, or rest, by half a turn at most; of one that does not turn it squares the length of the way.
So a sweep without rotation is asked as the first, and one with rotation as the third, where that is the same motion.

On pairs with a Halfspace, or with a BVHModel as the second, the process ends; a BVHModel as the first never hits, and
nor does anything with an Ellipsoid. Nothing but the time is answered.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from oracles.course import WIDTH, Course
from oracles.engine import AnswerRow, Bound, Kind, Row, Solver, Tolerance, UnsupportedCell, answer_row
from oracles.engines.fcl_shapes import Maker, Placed, frame_text, place, shape_text
from refimpl.linear import rotation_matrix
from refimpl.motions import RigidMotion
from refimpl.shapes import Ellipsoid, HalfSpace, Polyhedron

LACKING = {
    HalfSpace: "fcl.continuousCollide ends the process (segmentation fault) on any pair with a Halfspace",
    Polyhedron: "fcl.continuousCollide ends the process (segmentation fault) on a BVHModel, or never hits it",
    Ellipsoid: "FCL's conservative advancement has no test for an Ellipsoid: it warns, and never hits",
}
SHORTEST = 1e-4
"""`toc_err`: part of the time below which a step ends the search. It is the default, and whatever is given counts."""
TOLERANCE = Tolerance(
    Bound(1e-6, 16 * SHORTEST),
    Bound(1e-6, 16 * SHORTEST),
    Bound(1e-6, 1e-6),
    "a step of 1e-4 of the time ends the search, in which bodies that turn may move by 16 sizes; GJK is good to 1e-6",
)
ROUNDED = 1e-12
"""By how much a frame's origin may be off the centre of the turning, relative to the coordinates."""
NO_TURNING = "FCL turns an object about the origin of its frame, which is elsewhere"
NO_SCREW = "FCL's motions with rotation are screws: about an axis along which the body moves"
TOO_FAR = "FCL turns the shorter way: by half a turn at most"


class Going(NamedTuple):
    """An object as FCL sweeps it: where it is, and where it will be."""

    start: Placed
    end: Placed


def lacking(A: Kind, B: Kind) -> str:
    """Why there are no sweeps of two types; empty where there are."""
    return next((why for kind, why in LACKING.items() if kind in (A, B)), "")


def solver(fcl: Any, A: Kind, B: Kind) -> Solver:
    """Answer one scene in 20 to 50 µs."""
    make = Maker(fcl)
    types = fcl.CCDMotionType.CCDM_TRANS, fcl.CCDMotionType.CCDM_SCREW
    requests = [
        fcl.ContinuousCollisionRequest(
            toc_err=SHORTEST,
            ccd_motion_type=kind,
            gjk_solver_type=fcl.GJKSolverType.GST_INDEP,
            ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
        )
        for kind in types
    ]

    def frame(placed: Placed) -> Any:
        if placed.rotation is None:
            return fcl.Transform(placed.translation)
        return fcl.Transform(placed.rotation, placed.translation)

    def solve(row_a: Row, row_b: Row) -> AnswerRow:
        a, b, turning = going(A, row_a, B, row_b)
        best = math.inf
        for x in a:
            for y in b:
                result = fcl.ContinuousCollisionResult()
                ends = frame(x.end), frame(y.end)
                fcl.continuousCollide(make(x.start), ends[0], make(y.start), ends[1], requests[turning], result)
                best = min(best, result.time_of_contact if result.is_collide else math.inf)
        return answer_row(hit=float(best < math.inf), t=best)

    return solve


def going(A: Kind, row_a: Row, B: Kind, row_b: Row) -> tuple[list[Going], list[Going], bool]:
    """The objects of both sides, and whether any of them turns."""
    course = Course.unpack(np.array(row_a[-WIDTH:]))
    sides = ((A, row_a[:-WIDTH], course.a), (B, row_b, course.b))
    a, b = ([_going(placed, motion) for placed in place(kind, row)] for kind, row, motion in sides)
    return a, b, bool(course.turns)


def _going(start: Placed, motion: RigidMotion) -> Going:
    linear = motion.linear.tolist()
    if not motion.angular.any():
        at = [u + v for u, v in zip(start.translation, linear, strict=True)]
        return Going(start, start._replace(translation=at))
    off = max(abs(u - v) for u, v in zip(start.translation, motion.center.tolist(), strict=True))
    if off > ROUNDED * max(map(abs, start.translation)):
        raise UnsupportedCell(NO_TURNING)
    if math.hypot(*motion.angular.tolist()) >= math.pi:
        raise UnsupportedCell(TOO_FAR)
    across = np.linalg.norm(np.cross(motion.angular, motion.linear))
    if across > ROUNDED * np.linalg.norm(motion.angular) * np.linalg.norm(motion.linear):
        raise UnsupportedCell(NO_SCREW)
    turn = rotation_matrix(motion.rotation(1.0))
    before = np.eye(3) if start.rotation is None else np.array(start.rotation)
    at = [u + v for u, v in zip(start.translation, linear, strict=True)]
    return Going(start, start._replace(rotation=(turn @ before).tolist(), translation=at))


SCRIPT = '''"""FCL: sweep of {A} (a) and {B} (b); of several objects the first to meet counts."""

from importlib.metadata import version

import fcl
import numpy as np

print("python-fcl", version("python-fcl"))
{a}
{b}
request = fcl.ContinuousCollisionRequest(
    toc_err={shortest!r},
    ccd_motion_type=fcl.CCDMotionType.{motion},
    gjk_solver_type=fcl.GJKSolverType.GST_INDEP,
    ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
)
times = []
for x, x_end in a:
    for y, y_end in b:
        result = fcl.ContinuousCollisionResult()
        fcl.continuousCollide(x, x_end, y, y_end, request, result)
        if result.is_collide:
            times.append(result.time_of_contact)
print("hit =", float(len(times) > 0))
print("t =", repr(min(times, default=float("inf"))))
'''


def script(A: Kind, row_a: Row, B: Kind, row_b: Row) -> str:
    """Write the script of one scene; needs fcl and numpy."""
    a, b, turning = going(A, row_a, B, row_b)
    sides = _side("a", a), _side("b", b)
    motion = "CCDM_SCREW" if turning else "CCDM_TRANS"
    return SCRIPT.format(A=A.__name__, B=B.__name__, a=sides[0], b=sides[1], shortest=SHORTEST, motion=motion)


def _side(name: str, objects: list[Going]) -> str:
    """Lines that make the list of one side: each object, and where it will be."""
    lines = ""
    for i, one in enumerate(objects):
        lines += shape_text(f"{name}_shape{i}", one.start)
    pairs = [
        f"    (fcl.CollisionObject({name}_shape{i}, {frame_text(one.start)}), {frame_text(one.end)}),\n"
        for i, one in enumerate(objects)
    ]
    return f"{lines}{name} = [\n{''.join(pairs)}]"
