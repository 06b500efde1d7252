"""First contacts of moving triangles' features, to 50 digits: by the times at which they can begin, and distances then.

Sets that move and are apart come together first when four points are coplanar; or, if they are so all the time, when
a vertex comes to an edge's line; or, if they are so all the time, when two vertices meet. The polynomials of
these events come from interpolation, their roots from closed forms, and then the distances are computed as numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from mpmath import mp, mpf  # type: ignore[import-untyped]

from tests.truth.rationals import cross, dot, real

DIGITS = 140
ZERO = mpf(10) ** -40  # of sizes about 1; roots that are almost double are known to half the digits
Points = Sequence[Sequence[Any]]
Function = Callable[[Fraction], Fraction]


def first_contact(kind: str, start: Points, end: Points) -> mpf | None:
    """First time in [0, 1] of a contact, or None; `kind` is "vertex-face" or "edge-edge"."""
    with mp.workdps(DIGITS):
        for time in sorted(set(_candidates(kind, start, end))):
            if distance(kind, [placed(p, q, time) for p, q in zip(start, end, strict=True)]) < ZERO:
                return time
    return None


def placed(p: Sequence[Any], q: Sequence[Any], time: Any) -> list[Any]:
    """A moving point at a time: exactly, at a rational one."""
    if isinstance(time, Fraction):
        return [Fraction(x) + time * (Fraction(y) - Fraction(x)) for x, y in zip(p, q, strict=True)]
    return [real(Fraction(x)) + time * real(Fraction(y) - Fraction(x)) for x, y in zip(p, q, strict=True)]


def _minus(p: Sequence[Any], q: Sequence[Any]) -> Any:
    return [x - y for x, y in zip(p, q, strict=True)]


def _candidates(kind: str, start: Points, end: Points) -> Iterator[mpf]:
    """Times at which a contact can begin."""

    @cache
    def points(t: Fraction) -> list[list[Fraction]]:
        return [placed(p, q, t) for p, q in zip(start, end, strict=True)]

    def volume(t: Fraction) -> Fraction:
        a, b, c, d = points(t)
        return Fraction(dot(_minus(b, a), cross(_minus(c, a), _minus(d, a))))

    yield mpf(0)
    coplanar = _roots(volume)
    if coplanar is not None:
        yield from coplanar
        return
    faces = [(0, 1, 2), (0, 2, 3), (0, 1, 3)]
    for i, j, k in faces if kind == "vertex-face" else [(0, 2, 3), (1, 2, 3), (2, 0, 1), (3, 0, 1)]:
        for axis in range(3):

            def off_the_line(t: Fraction, i: int = i, j: int = j, k: int = k, axis: int = axis) -> Fraction:
                p = points(t)
                return Fraction(cross(_minus(p[j], p[i]), _minus(p[k], p[i]))[axis])

            yield from _roots(off_the_line) or ()
    for i in range(4):
        for j in range(i):
            for axis in range(3):
                yield from _roots(lambda t, i=i, j=j, axis=axis: points(t)[i][axis] - points(t)[j][axis]) or ()  # type: ignore[misc]


def _roots(f: Function) -> list[mpf] | None:
    """Real roots in [0, 1] of a polynomial of degree 3 at most; None if it is 0 all the time."""
    nodes = [Fraction(n) for n in range(4)]
    values = [f(t) for t in nodes]
    coefficients = [Fraction(0)] * 4
    for i, (t, y) in enumerate(zip(nodes, values, strict=True)):  # Lagrange
        basis = [y]
        for u in nodes[:i] + nodes[i + 1 :]:
            basis = [(a - u * b) / (t - u) for a, b in zip([Fraction(0), *basis], [*basis, Fraction(0)], strict=True)]
        coefficients = [a + b for a, b in zip(coefficients, basis, strict=True)]
    while coefficients and not coefficients[-1]:
        coefficients.pop()
    if not coefficients:
        return None
    if len(coefficients) == 1:
        return []
    return [t for t in map(real, _closed_form(coefficients)) if -ZERO < t < 1 + ZERO]


def _closed_form(coefficients: list[Fraction]) -> list[Any]:
    """Real roots of a polynomial of degree 1 to 3, constant first: which there are is decided by exact signs."""
    *rest, lead = coefficients
    match [c / lead for c in rest]:
        case [c]:
            return [-c]
        case [c, b]:
            square = b * b / 4 - c
            return [] if square < 0 else [real(-b / 2) + s * mp.sqrt(real(square)) for s in (-1, 1)]
        case [d, c, b]:  # Cardano's and Viète's formulas for x³ + p x + q
            p, q, shift = c - b * b / 3, 2 * b**3 / 27 - b * c / 3 + d, b / 3
            discriminant = -4 * p**3 - 27 * q * q
            if discriminant == 0:
                return [3 * q / p - shift, -3 * q / (2 * p) - shift] if p else [-shift]
            if discriminant < 0:
                root = mp.sqrt(real(-discriminant / 108))
                cube = real(-q / 2) + (root if q < 0 else -root)
                u = mp.sign(cube) * mp.cbrt(abs(cube))
                return [u - real(p) / (3 * u) - real(shift)]
            angle = mp.acos(real(3 * q / p) / 2 * mp.sqrt(real(-3 / p))) / 3
            size = 2 * mp.sqrt(real(-p / 3))
            return [size * mp.cos(angle - 2 * mp.pi * k / 3) - real(shift) for k in range(3)]
    raise AssertionError("a degree of 1 to 3")


# ------------------------------------------------------------------------------------------ distances


def distance(kind: str, points: Points) -> mpf:
    """Distance of a vertex and a face, or of two edges, as they stand; degenerate ones too."""
    a, b, c, d = points
    if kind == "edge-edge":
        ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)]
        return min([_to_segment(*e) for e in ends] + _across(a, b, c, d))
    return min([_to_segment(a, *edge) for edge in ((b, c), (c, d), (d, b))] + _above(a, b, c, d))


def _length(v: Sequence[Any]) -> mpf:
    return mp.sqrt(real(dot(v, v)))  # type: ignore[arg-type]


def _to_segment(p: Any, a: Any, b: Any) -> mpf:
    edge, square = _minus(b, a), dot(_minus(b, a), _minus(b, a))  # type: ignore[arg-type]
    share = min(max(dot(_minus(p, a), edge) / square, 0), 1) if square else 0
    return _length([x - y - share * e for x, y, e in zip(p, a, edge, strict=True)])


def _above(p: Any, a: Any, b: Any, c: Any) -> list[mpf]:
    """Distance from the plane of a face, if the vertex is over it."""
    n = cross(_minus(b, a), _minus(c, a))
    if dot(n, n) < ZERO:
        return []
    sides = [dot(n, cross(_minus(y, x), _minus(p, x))) for x, y in ((a, b), (b, c), (c, a))]
    return [abs(real(dot(n, _minus(p, a)))) / _length(n)] if min(sides) >= 0 else []


def _across(a: Any, b: Any, c: Any, d: Any) -> list[mpf]:
    """Distance of two lines, if their nearest points are within the edges."""
    u, v, w = _minus(b, a), _minus(d, c), _minus(c, a)
    n = cross(u, v)
    square = dot(n, n)
    if square < ZERO:
        return []
    s, r = dot(cross(w, v), n) / square, dot(cross(w, u), n) / square
    return [abs(real(dot(n, w))) / _length(n)] if 0 <= s <= 1 and 0 <= r <= 1 else []
