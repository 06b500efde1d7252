"""When moving triangles first touch: what excludes a contact at a time, and the check of a certificate of it.

Part of what has to be believed. Four points move on straight lines, each at its own constant velocity, over the time
[0, 1]: a vertex p and the corners a, b, c of a face, or the ends a, b and c, d of two edges. The sets are closed, and
may be degenerate: an edge may be a point, a face a segment or a point, for a time or for ever.

**At a time t there is a contact exactly when none of a few exclusions holds.** An exclusion is a tuple of polynomials
in t, and holds when all are > 0 or all are < 0:

- the volume of the tetrahedron, a cubic: it holds when the four points are not coplanar;
- for each of the three axes, the differences of the two sets' points along it, linear: it holds when a plane across the
  axis separates them;
- for each axis, its component of pairs of normals, quadratics. For a face, with u, v, w the corners as seen from p, the
  normals v × w, w × u, u × v are to each other as the barycentric coordinates of p; two that are opposite exclude a
  contact. For two edges, the normals of the triangles that one edge makes with each end of the other; two of equal
  direction mean that both ends are on one side.

Why nothing else can keep the sets apart: when the volume is 0, all normals are parallel. If one of them is not 0, it
has a component that is not 0, and there the signs are those of barycentric coordinates that sum to 1, or tell on which
side of one edge the ends of the other are. If all are 0, the four points lie on a line, and two closed sets on a line
are apart exactly when they are so along any axis that the line is not across.

Exclusions are open conditions. So where no contact is, finitely many intervals of time cover the time, each with an
exclusion of one sign there. And a contact is proven by a polynomial g with a root in [low, high]: at that root every
exclusion fails, for one of its polynomials is a multiple of g, or two differ in sign on all of [low, high].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from refimpl.proof.claims import Bound
from refimpl.proof.polynomials import MAX_DEGREE, Polynomial, remainder, sign_on, trimmed, value
from refimpl.proof.rational import effort, items, number, rational, require, spend, whole
from refimpl.proof.vectors import Whole

Exclusion: TypeAlias = tuple[Polynomial, ...]
Path: TypeAlias = Sequence[Polynomial]
"""Three linear polynomials: a point, or a difference of points, over time."""
VOLUME = 0
AXES = (1, 2, 3)
EFFORT = 1 << 20
"""How much checking a certificate may ask for, about half a second of work."""


@dataclass(frozen=True)
class TouchCertificate:
    """Where four moving points come to the first contact of the two sets that they make, or that they never do.

    Attributes
    ----------
    cover : pairs (until, exclusion)
        There is no contact before the last `until`: from the end of the pair before, at first 0, to `until`, both
        included, the exclusion of that number holds.
    root : polynomial or None
        Whole coefficients, constant first; it has a root between the end of the cover and `high` at which there is a
        contact. None: there is none in [0, 1].
    high : the contact is not later; None if there is none
    """

    cover: tuple[tuple[Fraction, int], ...]
    root: Polynomial | None = None
    high: Fraction | None = None


class Exclusions:
    """What can exclude a contact of two sets, by number; each is made when it is first asked for.

    Parameters
    ----------
    start, end : four points as integers, on one common denominator
        At time 0 and at time 1: vertex and corners, or the ends of one edge and of the other.
    """

    count: int

    def __init__(self, start: Sequence[Whole], end: Sequence[Whole]) -> None:
        self._made: dict[int, Exclusion] = {}
        self.points: list[Path] = [
            [(x, z - x) for x, z in zip(p, q, strict=True)] for p, q in zip(start, end, strict=True)
        ]

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, number: int) -> Exclusion:
        if number not in self._made:
            self._made[number] = self._make(number)
        return self._made[number]

    def _make(self, number: int) -> Exclusion:
        raise NotImplementedError


class VertexFace(Exclusions):
    """A vertex p and a face abc."""

    count = 13

    def __init__(self, start: Sequence[Whole], end: Sequence[Whole]) -> None:
        super().__init__(start, end)
        p, *corners = self.points
        self.u, self.v, self.w = (_difference(corner, p) for corner in corners)

    def _make(self, number: int) -> Exclusion:
        u, v, w = self.u, self.v, self.w
        if number == VOLUME:
            return (_volume(u, v, w),)
        if number in AXES:
            return u[number - 1], v[number - 1], w[number - 1]
        which, axis = divmod(number - 4, 3)
        one, two, three = ((u, v, w), (v, w, u), (w, u, v))[which]
        return _normal(one, two, axis), _normal(three, two, axis)  # of u × v and of −(v × w)


class EdgeEdge(Exclusions):
    """An edge ab and an edge cd."""

    count = 10

    def __init__(self, start: Sequence[Whole], end: Sequence[Whole]) -> None:
        super().__init__(start, end)
        a, b, c, d = self.points
        self.ab, self.cd = _difference(b, a), _difference(d, c)
        self.ac, self.ad, self.bc, self.bd = (_difference(y, x) for x in (a, b) for y in (c, d))

    def _make(self, number: int) -> Exclusion:
        if number == VOLUME:
            return (_volume(self.ab, self.ac, self.ad),)
        if number in AXES:
            return tuple(path[number - 1] for path in (self.ac, self.ad, self.bc, self.bd))
        which, axis = divmod(number - 4, 3)
        edge, one, two = ((self.ab, self.ac, self.ad), (self.cd, self.ac, self.bc))[which]
        return _normal(edge, one, axis), _normal(edge, two, axis)


def _difference(p: Path, q: Path) -> Path:
    """Give p − q."""
    return [(a - c, b - d) for (a, b), (c, d) in zip(p, q, strict=True)]


def _normal(u: Path, v: Path, axis: int) -> Polynomial:
    """Component of u × v along an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    (a, b), (c, d), (e, f), (g, h) = u[i], u[j], v[i], v[j]
    return a * g - c * e, a * h + b * g - c * f - d * e, b * h - d * f


def _volume(u: Path, v: Path, w: Path) -> Polynomial:
    """Give u · (v × w)."""
    c = d = e = f = 0
    for axis, (a, b) in enumerate(u):
        p, q, r = _normal(v, w, axis)
        c, d, e, f = c + a * p, d + a * q + b * p, e + a * r + b * q, f + b * r
    return c, d, e, f


# ------------------------------------------------------------------------------------------ the check


def check_vertex_face(certificate: TouchCertificate, start: Any, end: Any) -> tuple[Bound, Bound]:
    """Prove when a moving vertex first touches a moving face.

    Parameters
    ----------
    certificate : of `refimpl.sweeps.vertex_face`, or of anyone
    start, end : four points at time 0 and at time 1, each of three finite floats, ints or Fractions
        The vertex, and the corners of the face; [length].

    Returns low and high: the first contact is in [low, high] ⊂ [0, 1]; (∞, ∞) if there is none in [0, 1]. Raises
    `InvalidCertificate` when anything is malformed or false.
    """
    return _check(certificate, VertexFace, start, end)


def check_edge_edge(certificate: TouchCertificate, start: Any, end: Any) -> tuple[Bound, Bound]:
    """Prove when two moving edges ab and cd first touch: like `check_vertex_face`, of the points a, b, c, d."""
    return _check(certificate, EdgeEdge, start, end)


def _check(certificate: TouchCertificate, sets: type[Exclusions], start: Any, end: Any) -> tuple[Bound, Bound]:
    require(type(certificate) is TouchCertificate, f"not a certificate but {type(certificate).__name__}")
    with effort(EFFORT):
        exclusions = sets(*moving_points(start, end))
        low = _covered(certificate.cover, exclusions)
        if certificate.root is None:
            require(low == 1, f"root: none is given, and the cover ends at {float(low)}")
            require(certificate.high is None, "high: given without a root")
            return math.inf, math.inf
        high = rational(certificate.high, "high")
        require(low <= high <= 1, "high: must be from the end of the cover to 1")
        root = _root(certificate.root, low, high)
        for i in range(len(exclusions)):
            spend(64)
            require(fails(exclusions[i], root, low, high), f"root: exclusion {i} may hold there")
        return low, high


def moving_points(start: Any, end: Any) -> tuple[list[Whole], list[Whole]]:
    """Read four points at time 0 and at time 1, as integers on one common denominator."""
    points = [
        [number(x, what) for x in items(point, what, 3)]
        for what, at in (("start", start), ("end", end))
        for point in items(at, what, 4)
    ]
    grid, unit = whole(points)
    spend(1 << 9, unit.bit_length() + max(abs(x) for point in grid for x in point).bit_length())
    return grid[:4], grid[4:]


def _covered(cover: Any, exclusions: Exclusions) -> Fraction:
    """End of the time from 0 on at all of which exclusions hold."""
    now = Fraction(0)
    for pair in items(cover, "cover"):
        until, which = items(pair, "cover", 2)
        until = rational(until, "cover")
        require(now < until <= 1, "cover: its ends must increase, up to 1")
        require(type(which) is int and 0 <= which < len(exclusions), "cover: no exclusion has that number")
        spend(16, until.denominator.bit_length())
        require(holds(exclusions[which], now, until), f"cover: exclusion {which} may not hold up to {float(until)}")
        now = until
    return now


def _root(given: Any, low: Fraction, high: Fraction) -> Polynomial:
    """Read a polynomial with a root in [low, high]."""
    root = items(given, "root")
    require(2 <= len(root) <= MAX_DEGREE + 1, "root: must have a degree of 1 to 3")
    for c in root:
        require(type(c) is int, "root: whole coefficients")
        number(c, "root")
    read = trimmed(root)
    require(len(read) > 1, "root: a constant")
    require(value(read, low) * value(read, high) <= 0, "root: does not change its sign up to `high`")
    return read


def holds(exclusion: Exclusion, low: Fraction, high: Fraction) -> bool:
    """Whether an exclusion is seen to hold at all times of [low, high]."""
    return {sign_on(p, low, high) for p in exclusion} in ({1}, {-1})


def fails(exclusion: Exclusion, root: Polynomial, low: Fraction, high: Fraction) -> bool:
    """Whether an exclusion is seen not to hold at any root of `root` in [low, high]."""
    signs = {sign_on(p, low, high) for p in exclusion}
    return {1, -1} <= signs or any(not remainder(p, root) for p in exclusion)
