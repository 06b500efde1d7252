"""Where a rigid motion takes a proxy, in exact arithmetic: part of what has to be believed.

Sine and cosine are irrational, so a pose at a rational time is a rational rotation, computed here, and an upper bound
on how far it is from the true one. Half the angle is halved until it is small; the quaternion of that rotation comes
from the power series of sine and cosine, and is squared as often as the angle was halved. Its axis stays exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from refimpl.proof.rational import InvalidCertificate, require, spend, whole
from refimpl.proof.reading import AXES, Fields, product
from refimpl.proof.sets import Hull, Planes, Points, Product, Solid
from refimpl.proof.unions import Mesh, Union
from refimpl.proof.vectors import NONE, Exact, cross, dot, minus, times

BITS = 160  # of the quaternion's parts
HALVINGS = 48


class Course(NamedTuple):
    """A rigid motion: x(t) = center + t·linear + R(t·angular)(x − center)."""

    linear: Exact
    angular: Exact
    center: Exact


def course(motion: Any) -> Course:
    """Read a motion by the name of its type and its numbers; None is rest."""
    rest = [NONE] * 3
    if motion is None:
        return Course(rest, rest, rest)
    field = Fields(motion)
    if field.kind == "Translation":
        return Course(field("vector"), rest, rest)
    require(field.kind == "RigidMotion", f"not a motion but {field.kind}")
    return Course(field("linear"), field("angular"), field("center"))


class Pose(NamedTuple):
    """x ↦ place + Q (x − center), with a rational rotation Q by its columns; ‖Q − R‖ ≤ error for the true rotation."""

    columns: Sequence[Exact]
    center: Exact
    place: Exact
    error: Fraction

    def turned(self, v: Exact) -> Exact:
        """Q v."""
        return [dot(row, v) for row in zip(*self.columns, strict=True)]

    def carried(self, x: Exact) -> Exact:
        """Where the point x goes."""
        return minus(self.place, times(-1, self.turned(minus(x, self.center))))


def pose_at(motion: Course, time: Fraction) -> Pose:
    """Pose at a time."""
    columns, error = rotation(times(time, motion.angular))
    return Pose(columns, motion.center, minus(motion.center, times(-time, motion.linear)), error)


def rotation(turn: Exact) -> tuple[Sequence[Exact], Fraction]:
    """Columns of a rational rotation about `turn` by about ‖turn‖ radians, and how far at most it is off.

    A rotation by 2φ has the quaternion (sin φ, cos φ), and ‖Q − R‖ is twice the sine of the angle between the
    quaternions, hence at most twice their distance.
    """
    half = times(Fraction(1, 2), turn)
    if not any(half):
        return AXES, NONE
    halvings = 0
    while dot(half, half) > Fraction(4**halvings, 4):
        halvings += 1
        require(halvings <= HALVINGS, "angular: turns too often")
    axis = times(Fraction(1, 2**halvings), half)
    square = Fraction(dot(axis, axis))
    spend(256, square.numerator.bit_length())
    sine, cosine, error = _quaternion(square)
    for _ in range(halvings):
        p, q = square.numerator, square.denominator
        sine, cosine = 2 * sine * cosine >> BITS, (cosine * cosine * q - sine * sine * p) // (q << BITS)
        error = 2 * error + 3  # (2 + e)·e for the square of a quaternion that is off by e, and 2 for the rounding
    scaled = sine * sine * square
    size = cosine * cosine + scaled
    columns = []
    for i, unit in enumerate(AXES):  # (c² − s²) e + 2 s² (u·e) u + 2 c s u × e
        image = minus(times(cosine * cosine - scaled, unit), times(-2 * sine * sine * axis[i], axis))
        image = minus(image, times(-2 * cosine * sine, cross(axis, unit)))
        columns.append(times(1 / size, image))
    return columns, Fraction(2 * error, 1 << BITS)


def _quaternion(square: Fraction) -> tuple[int, int, int]:
    """Find sin φ / φ and cos φ for φ² ≤ 1/4, times 2^BITS, and how far off (u sin φ / φ, cos φ) with ‖u‖ = φ may be.

    Each term of a series is off by less than 2: by 1 for its own rounding, 1/2 for that of φ², and an eighth of the
    term before. There are no more than 22 until they vanish, and the rest is smaller than the last.
    """
    one = 1 << BITS
    x = square.numerator * one // square.denominator
    found = []
    for first in (2, 1):
        total, term, k, sign = one, one, first, -1
        while term := term * x // (one * k * (k + 1)):
            total += sign * term
            sign, k = -sign, k + 2
        found.append(total)
    return found[0], found[1], 64


def moved(parts: Sequence[Solid | Mesh], pose: Pose) -> Union:
    """A union where a pose takes it."""
    known: dict[int, Points] = {}
    return Union([_moved(part, pose, known) for part in parts])


def _moved(part: Any, pose: Pose, known: dict[int, Points]) -> Solid | Mesh:
    match part:
        case Mesh(points, triangles):
            return Mesh(_points(points, pose, known), triangles)
        case Hull(points, corners, radius):
            return Hull(_points(points, pose, known), corners, radius)
        case Product(centre, factors, unit, radius):
            one = Fraction(1, unit)
            vectors = [[pose.turned(times(one, v)) for v in factor.vectors] for factor in factors]
            return product(pose.carried(times(one, centre)), vectors, radius)
        case Planes(planes, radius):
            rows = []
            for n, k in planes:
                normal = pose.turned(n)  # type: ignore[arg-type]
                rows.append([*normal, k + dot(n, pose.center) - dot(normal, pose.place)])
            return Planes([(n, k) for *n, k in whole(rows)[0]], radius)  # on one scale: shares are of these normals
    raise InvalidCertificate("a ray does not move")


def _points(points: Points, pose: Pose, known: dict[int, Points]) -> Points:
    if id(points) not in known:
        one = Fraction(1, points.unit)
        known[id(points)] = Points(*whole([pose.carried(times(one, place)) for place in points.places]))
    return known[id(points)]
