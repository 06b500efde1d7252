"""Check what a certificate claims about two proxies, in exact arithmetic.

This file is all of the project that has to be believed. It needs nothing but the standard library, takes
every number as the exact rational that it is, and returns only bounds that it has computed itself.

Each proxy is a *core* widened by a ball: a sphere is its centre, a capsule its segment, a box itself with
radius 0. Two facts about each kind of core are trusted, and all else follows from them: its support function
h(n), the largest n·x over the core (`support`), and how far a point is from it (`square_distance`).

With A ⊖ B = {a − b}, the signed distance σ(A, B) is the distance of 0 from A ⊖ B, or, when 0 lies inside,
minus its distance from the boundary. The support function of A ⊖ B is h_A(n) + h_B(−n), and widening the
cores by balls lowers σ by the sum of the radii: σ(A, B) = σ(core A, core B) − r_A − r_B. For a `Ray` the
bounds are on the time when it first hits, ∞ for a miss; a ray up to time t is a segment.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

Number: TypeAlias = float | Fraction | int
Vector: TypeAlias = tuple[Number, Number, Number]
Bound: TypeAlias = Fraction | float  # a float only for ±∞
Whole: TypeAlias = Sequence[int]
Exact: TypeAlias = Sequence[Fraction]

MAX_BITS = 1 << 17  # of a number in a certificate: what doubles of all exponents lead to stays below
MAX_ITEMS = 1 << 13  # claims, vertices or triangles
ROOT_BITS = 160  # irrational square roots are enclosed to about this many leading bits


class InvalidCertificate(ValueError):
    """The certificate, or a shape given with it, is malformed, or does not prove what it claims."""


@dataclass(frozen=True)
class Separated:
    """σ ≥ L > 0: planes across `n`, from A to B, leave a gap. For a ray: up to the time `until`, or ever."""

    n: Vector
    until: Number | None = None


@dataclass(frozen=True)
class Escape:
    """σ ≥ −D: moving B along `n`, a direction from A to B, by a length D ≥ 0 separates the interiors."""

    n: Vector


@dataclass(frozen=True)
class Near:
    """σ ≤ ‖a − b‖, as `a` lies in A and `b` in B."""

    a: Vector
    b: Vector


@dataclass(frozen=True)
class Common:
    """σ ≤ 0, as the point `p` lies in both. For a ray, in place of `p`: the ray is inside at `time`."""

    p: Vector | None
    time: Number | None = None


@dataclass(frozen=True)
class Core:
    """σ ≤ −r − r_A − r_B: a closed polytope of points a_j − b_j of the cores holds a ball of radius r at 0.

    `pairs` are the (a_j, b_j), `triangles` their indices, counter-clockwise seen from outside. One pair and
    no triangle: σ ≤ ‖a − b‖ − r_A − r_B ≤ 0. With `directions`, the pairs are recession directions (u_j, v_j)
    of A and B, and a closed polytope around 0 proves that A ⊖ B is the whole space: σ = −∞.
    """

    pairs: tuple[tuple[Vector, Vector], ...]
    triangles: tuple[tuple[int, int, int], ...] = ()
    directions: bool = False


Claim: TypeAlias = Separated | Escape | Near | Common | Core


@dataclass(frozen=True)
class Certificate:
    """Claims about one pair of proxies, and the bounds that whoever made it believes them to prove."""

    claims: tuple[Claim, ...]
    lower: Bound = -math.inf
    upper: Bound = math.inf


def _number(value: Any, what: str) -> Fraction:
    if type(value) not in (int, float, Fraction):  # no subclass: it may compare as it likes
        raise InvalidCertificate(f"{what}: not a number but {type(value).__name__}")
    if isinstance(value, float) and not math.isfinite(value):
        raise InvalidCertificate(f"{what}: must be finite, got {value!r}")
    number = Fraction(value)
    if max(number.numerator.bit_length(), number.denominator.bit_length()) > MAX_BITS:
        raise InvalidCertificate(f"{what}: a number of more than {MAX_BITS} bits")
    return number


def _items(value: Any, what: str, count: int | None = None) -> Sequence[Any]:
    if type(value) not in (tuple, list):  # no subclass: it may answer differently the second time
        raise InvalidCertificate(f"{what}: expected a tuple, got {type(value).__name__}")
    if len(value) > MAX_ITEMS or (count is not None and len(value) != count):
        raise InvalidCertificate(f"{what}: {len(value)} items, expected {count or 'fewer'}")
    return tuple(value)


def _vector(value: Any, what: str, count: int = 3) -> Exact:
    return [_number(v, what) for v in _items(value, what, count)]


def _whole(vectors: Sequence[Exact]) -> tuple[list[Whole], int]:
    """Put vectors on one common denominator: integers, and that denominator."""
    unit = 1
    for denominator in {x.denominator for v in vectors for x in v}:
        unit = math.lcm(unit, denominator)
        if unit.bit_length() > 4 * MAX_BITS:
            raise InvalidCertificate("the numbers have no common denominator of reasonable size")
    return [[x.numerator * (unit // x.denominator) for x in v] for v in vectors], unit


def _direction(value: Any) -> Whole:
    """Take integers along a direction: its length means nothing."""
    n = _whole([_vector(value, "n")])[0][0]
    if not any(n):
        raise InvalidCertificate("n: a direction must not be zero")
    return n


def _dot(u: Sequence[Any], v: Sequence[Any]) -> Any:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _minus(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]


def _cross(u: Whole, v: Whole) -> Whole:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def _root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose the square root of `square` ≥ 0; both ends are equal when it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, ROOT_BITS - product.bit_length() // 2)
    root, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(root, scale), Fraction(root + (root * root != product << 2 * shift), scale)


class _Round(NamedTuple):
    """{(corner + Σ tᵢ edgeᵢ) / unit : 0 ≤ tᵢ ≤ 1} ⊕ ball(radius), the edges at right angles to each other."""

    corner: Whole
    edges: Sequence[Whole]
    unit: int
    radius: Fraction

    def support(self, n: Whole) -> Fraction:
        return Fraction(_dot(n, self.corner) + sum(max(0, _dot(n, edge)) for edge in self.edges), self.unit)

    def square_distance(self, point: Exact) -> Fraction:
        """‖x − corner‖², less the parts along the edges as far as these reach."""
        (whole,), scale = _whole([point])
        offset = [self.unit * x - scale * c for x, c in zip(whole, self.corner, strict=True)]
        numerator, denominator = _dot(offset, offset), 1
        for edge in self.edges:
            square, along = _dot(edge, edge), _dot(offset, edge)
            beyond = max(-along, 0, along - scale * square)
            numerator = numerator * square - (along * along - beyond * beyond) * denominator
            denominator *= square
        return Fraction(numerator, denominator * (scale * self.unit) ** 2)


class _Half(NamedTuple):
    """normal·x + k ≤ 0, in integers; its own core."""

    normal: Whole
    k: int
    radius: Fraction = Fraction(0)

    def support(self, n: Whole) -> Fraction:
        along = _dot(n, self.normal)
        if any(_cross(n, self.normal)) or along <= 0:
            raise InvalidCertificate("n: the half-space is unbounded in this direction")
        return Fraction(-self.k * along, _dot(self.normal, self.normal))

    def square_distance(self, point: Exact) -> Fraction:
        beyond = max(Fraction(0), _dot(self.normal, point) + self.k)
        return Fraction(beyond * beyond, _dot(self.normal, self.normal))


class _Ray(NamedTuple):
    origin: Exact
    direction: Exact

    def support(self, n: Whole) -> Fraction:
        if _dot(n, self.direction) > 0:
            raise InvalidCertificate("n: the ray is unbounded in this direction")
        return Fraction(_dot(n, self.origin))

    def at(self, time: Fraction) -> Exact:
        return [o + time * d for o, d in zip(self.origin, self.direction, strict=True)]


_Solid: TypeAlias = _Round | _Half


def _round(corner: Exact, edges: Sequence[Exact], radius: Fraction = Fraction(0)) -> _Round:
    (start, *rest), unit = _whole([corner, *edges])
    return _Round(start, [edge for edge in rest if any(edge)], unit, radius)


def _box(centre: Exact, half: Exact, rotation: Exact) -> _Round:
    """Edges along the columns of the rotation matrix of a quaternion (x, y, z, w) of any non-zero length."""
    x, y, z, w = rotation
    square = x * x + y * y + z * z + w * w
    columns = (
        (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y),
    )
    edges = [[2 * h * c / square for c in column] for h, column in zip(half, columns, strict=True)]
    return _round([c - sum(along) / 2 for c, *along in zip(centre, *edges, strict=True)], edges)


def _read(shape: Any) -> _Solid | _Ray:
    """Take a proxy by the name of its type and the numbers of its fields: this says what they mean."""
    kind = type(shape).__name__

    def field(name: str, count: int = 3, nonzero: bool = False, size: bool = False) -> Exact:
        try:
            values = getattr(shape, name).tolist()
        except AttributeError:
            raise InvalidCertificate(f"{kind}: no array {name!r}, not a proxy of this project") from None
        numbers = _vector(values if count > 1 else [values], f"{kind}.{name}", count)
        if (nonzero and not any(numbers)) or (size and min(numbers) < 0):
            raise InvalidCertificate(f"{kind}.{name}: {values!r} means no set")
        return numbers

    match kind:
        case "Point":
            body: _Solid | _Ray = _round(field("position"), [])
        case "Ray":
            body = _Ray(field("origin"), field("direction", nonzero=True))
        case "Sphere":
            body = _round(field("center"), [], *field("radius", 1, size=True))
        case "Capsule":
            start = field("p")
            body = _round(start, [_minus(field("q"), start)], *field("radius", 1, size=True))
        case "AABB":
            low = field("lower")
            size = _minus(field("upper"), low)
            if min(size) < 0:
                raise InvalidCertificate("AABB.upper: below AABB.lower")
            body = _round(low, [[size[i] * (i == j) for j in range(3)] for i in range(3)])
        case "Box":
            body = _box(field("center"), field("half_extents", size=True), field("rotation", 4, True))
        case "HalfSpace":
            (plane,), _ = _whole([[*field("normal", nonzero=True), *field("k", 1)]])
            body = _Half(plane[:3], plane[3])
        case _:
            raise InvalidCertificate(f"{kind} is not a proxy that can be checked")
    return body


def _gap(n: Whole, a: _Solid | _Ray, b: _Solid | _Ray, radius: Fraction) -> tuple[Fraction, int]:
    """‖n‖ times the gap between the supporting planes of the cores, and the sign of gap/‖n‖ − radius."""
    rise = a.support(n) + b.support([-c for c in n])
    beyond = rise * rise - radius * radius * _dot(n, n) if rise <= 0 else Fraction(-1)
    return -rise, (beyond > 0) - (beyond < 0)


def _outside(shape: _Solid, point: Exact, radius: Fraction = Fraction(0)) -> Fraction:
    """At most so far lies `point` outside the core widened by `radius`; 0 exactly when it is inside."""
    square = shape.square_distance(point)
    return Fraction(0) if square <= radius * radius else _root(square)[1] - radius


def _polytope(points: Sequence[Exact], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of `points`, proven by a closed surface.

    Every directed edge must occur as often as its reverse, and every triangle must turn its inner side to 0.
    Then the surface, seen from 0, covers every direction: it is a cycle, so it covers all directions equally
    often, counting each triangle by its orientation, and all of them, at least one, count as +1. So no ray
    from 0 leaves the hull before it meets some triangle, hence not within the distance of the nearest plane.
    """
    edges: Counter[tuple[int, int]] = Counter()
    whole, unit = _whole(points)
    squares = []
    for triangle in _items(triangles, "triangles"):
        if any(type(i) is not int or not 0 <= i < len(points) for i in _items(triangle, "triangles", 3)):
            raise InvalidCertificate("triangles: not the index of a pair")
        i, j, k = triangle
        edges.update([(i, j), (j, k), (k, i)])
        normal = _cross(_minus(whole[j], whole[i]), _minus(whole[k], whole[i]))
        offset = _dot(normal, whole[i])
        if offset <= 0:
            raise InvalidCertificate(f"triangles: {triangle!r} does not turn its inner side to 0")
        squares.append(Fraction(offset * offset, _dot(normal, normal)))
    if not squares or any(edges[i, j] != edges[j, i] for i, j in list(edges)):
        raise InvalidCertificate("triangles: the surface is not closed")
    return min(squares) / (unit * unit)


def _core(claim: Core, a: _Solid, b: _Solid) -> Bound:
    """Upper bound of σ from points of the cores."""
    ends = [[_vector(x, "pairs") for x in _items(pair, "pairs", 2)] for pair in _items(claim.pairs, "pairs")]
    points = [_minus(p, q) for p, q in ends]
    if claim.directions is True:
        ways = [(shape, way) for end in ends for shape, way in zip((a, b), end, strict=True)]
        if any(_dot(shape.normal, way) > 0 if isinstance(shape, _Half) else any(way) for shape, way in ways):
            raise InvalidCertificate("pairs: not directions in which the shape is unbounded")
        _polytope(points, claim.triangles)
        return -math.inf
    # moving its vertices by `outside` at most, into the cores, brings no facet of the hull nearer by more than that
    outside = max((_outside(a, p) + _outside(b, q) for p, q in ends), default=Fraction(0))
    if len(points) == 1 and not _items(claim.triangles, "triangles"):
        bound = _root(_dot(points[0], points[0]))[1] + outside - a.radius - b.radius
    else:
        bound = outside - _root(_polytope(points, claim.triangles))[0] - a.radius - b.radius
    if bound > 0:
        raise InvalidCertificate("pairs: they do not prove that the shapes meet")
    return bound


def _times(claim: Claim, a: _Solid | _Ray, b: _Solid | _Ray) -> tuple[Bound, Bound]:
    """Bounds on the time when a ray first hits, from one claim."""
    ray, solid, sign = (a, b, 1) if isinstance(a, _Ray) else (b, a, -1)
    if not isinstance(ray, _Ray) or isinstance(solid, _Ray):
        raise InvalidCertificate("two rays have no signed distance")
    match claim:
        case Separated(direction, until):
            n, rises = _direction(direction), False
            time: Bound = math.inf
            part: _Round | _Ray = ray
            if until is not None:
                time = _number(until, "until")
                part = _round(ray.origin, [_minus(ray.at(time), ray.origin)])
                rises = sign * _dot(n, ray.direction) > 0  # then only the end of the segment may touch its plane
            _, side = _gap(n, part, solid, solid.radius) if sign > 0 else _gap(n, solid, part, solid.radius)
            if time < 0 or side < (0 if rises else 1):
                raise InvalidCertificate("n: the supporting planes do not leave a gap")
            return time, math.inf
        case Common(None, instant):
            moment = _number(instant, "time")
            if moment < 0 or solid.square_distance(ray.at(moment)) > solid.radius * solid.radius:
                raise InvalidCertificate("time: the ray is not inside then")
            return Fraction(0), moment
    raise InvalidCertificate(f"{type(claim).__name__}: not a claim about a ray")


def _bounds(claim: Claim, a: _Solid | _Ray, b: _Solid | _Ray) -> tuple[Bound, Bound]:
    """Bounds on σ, or on the time of the first hit, from one claim."""
    if isinstance(a, _Ray) or isinstance(b, _Ray):
        return _times(claim, a, b)
    match claim:
        case Separated(direction, None) | Escape(direction):
            apart, n, radius = isinstance(claim, Separated), _direction(direction), a.radius + b.radius
            gap, side = _gap(n, a, b, radius)
            if (side > 0) != apart:
                raise InvalidCertificate(f"n: the supporting planes {'do not ' if apart else ''}leave a gap")
            low, high = _root(Fraction(_dot(n, n)))
            bound = gap / (high if gap > 0 else low) - radius
            return max(bound, Fraction(0)) if apart else bound, math.inf
        case Near(p, q):
            on_a, on_b = _vector(p, "a"), _vector(q, "b")
            outside = _outside(a, on_a, a.radius) + _outside(b, on_b, b.radius)
            return -math.inf, _root(_dot(_minus(on_a, on_b), _minus(on_a, on_b)))[1] + outside
        case Common(p, None) if p is not None:
            return _bounds(Near(p, p), a, b)
        case Core():
            return -math.inf, _core(claim, a, b)
    raise InvalidCertificate(f"{type(claim).__name__}: not a claim about two solids")


def check(certificate: Certificate, a: Any, b: Any) -> tuple[Bound, Bound]:
    """Prove bounds on the signed distance of two single proxies, or on the time when a ray first hits one.

    Returns lower ≤ σ(a, b) ≤ upper [length], ±math.inf where nothing is proven or σ is infinite; for a ray
    lower ≤ t ≤ upper in units of its direction's length, (∞, ∞) when it misses. The certificate's own bounds
    are ignored. Raises `InvalidCertificate` when anything is malformed or false.
    """
    if not isinstance(certificate, Certificate):
        raise InvalidCertificate(f"not a certificate but {type(certificate).__name__}")
    first, second = _read(a), _read(b)
    claims = _items(certificate.claims, "claims")
    bounds = [(-math.inf, math.inf), *(_bounds(claim, first, second) for claim in claims)]
    lower, upper = max(low for low, _ in bounds), min(high for _, high in bounds)
    if lower > upper:
        raise InvalidCertificate("the claims contradict each other")
    return lower, upper
