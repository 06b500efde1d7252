"""What the numbers of each proxy mean, in exact arithmetic: part of what has to be believed.

Each convex proxy is a *core* widened by a ball: a sphere is its centre, a capsule its segment, the others are
themselves with radius 0. Three facts about each kind of core are trusted:

`support(n, shares)`
    its support function, the largest n·x over the core, or something above it by less than 2⁻¹⁵⁰ of it.
`member(point, widened)`
    the exact point that a certificate means, and how far at most it lies outside the core, or outside the
    widened core; 0 exactly when it lies inside.
`holds(centre, columns, share)`
    whether {centre + Σ uᵢ·columnᵢ : ‖u‖ ≤ 1} lies in the core; True only if it does.

All are in the coordinates of the world: a pose is applied when a proxy is read.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.rational import (
    Exact,
    InvalidCertificate,
    Whole,
    cross,
    dot,
    index,
    is_positive,
    items,
    minus,
    root,
    shares,
    vector,
    whole,
)

NONE = Fraction(0)


def _beyond(square: Fraction, radius: Fraction) -> Fraction:
    """At most so much is the root of `square` larger than `radius`; 0 exactly when it is not."""
    return NONE if square <= radius * radius else root(square)[1] - radius


def ball_in_ball(centre: Exact, columns: Sequence[Exact], square: Fraction, share: Fraction) -> bool:
    """Whether ‖centre + Σ uᵢ·columnᵢ‖² ≤ square for all ‖u‖ ≤ 1.

    It is when square − ‖centre + P u‖² − share·(1 − ‖u‖²) ≥ 0 for all u, for some share ≥ 0. As a quadratic form in
    (1, u), this is a matrix that is positive semidefinite; its last three diagonal entries imply that share ≥ 0.
    """
    sides = [-dot(centre, column) for column in columns]
    matrix = [[square - dot(centre, centre) - share, *sides]]
    for i, u in enumerate(columns):
        matrix.append([sides[i], *(share * (i == j) - dot(u, v) for j, v in enumerate(columns))])
    return is_positive(matrix)


class Round(NamedTuple):
    """{(corner + Σ tᵢ edgeᵢ) / unit : 0 ≤ tᵢ ≤ 1} ⊕ ball(radius), the edges at right angles to each other."""

    corner: Whole
    edges: Sequence[Whole]
    unit: int
    radius: Fraction

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return Fraction(dot(n, self.corner) + sum(max(0, dot(n, edge)) for edge in self.edges), self.unit)

    def square_distance(self, point: Exact) -> Fraction:
        """‖x − corner‖², less the parts along the edges as far as these reach."""
        (x,), scale = whole([point])
        offset = [self.unit * a - scale * c for a, c in zip(x, self.corner, strict=True)]
        numerator, denominator = dot(offset, offset), 1
        for edge in self.edges:
            square, along = dot(edge, edge), dot(offset, edge)
            beyond = max(-along, 0, along - scale * square)
            numerator = numerator * square - (along * along - beyond * beyond) * denominator
            denominator *= square
        return Fraction(numerator, denominator * (scale * self.unit) ** 2)

    def member(self, point: Any, widened: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        return x, _beyond(self.square_distance(x), self.radius if widened else NONE)

    def holds(self, centre: Exact, columns: Sequence[Exact], _: Fraction) -> bool:
        """Along each edge it stays between the ends; across all edges it does not extend."""
        start = [self.unit * x - c for x, c in zip(centre, self.corner, strict=True)]
        for way in (start, *columns):
            if dot(way, way) != sum(Fraction(dot(way, edge) ** 2) / dot(edge, edge) for edge in self.edges):
                return False
        for edge in self.edges:
            square, reach = dot(edge, edge), sum(dot(edge, column) ** 2 for column in columns)
            room = square - abs(2 * dot(edge, start) - square)
            if room < 0 or 4 * self.unit**2 * reach > room * room:
                return False
        return True


class Half(NamedTuple):
    """normal·x + k ≤ 0, in integers; its own core."""

    normal: Whole
    k: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        along = dot(n, self.normal)
        if any(cross(n, self.normal)) or along <= 0:
            raise InvalidCertificate("n: the half-space is unbounded in this direction")
        return Fraction(-self.k * along, dot(self.normal, self.normal))

    def square_distance(self, point: Exact) -> Fraction:
        """Square distance of a point."""
        beyond = max(NONE, dot(self.normal, point) + self.k)
        return Fraction(beyond * beyond, dot(self.normal, self.normal))

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        return x, _beyond(self.square_distance(x), NONE)

    def holds(self, centre: Exact, columns: Sequence[Exact], _: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        room = -(dot(self.normal, centre) + self.k)
        reach = sum((dot(self.normal, column) ** 2 for column in columns), NONE)
        return bool(room >= 0 and reach <= room * room)


class Planes(NamedTuple):
    """The points behind every plane: normal·x + k ≤ 0, in integers."""

    halves: Sequence[Half]
    radius: Fraction = NONE

    def support(self, n: Whole, faces: Any = ()) -> Fraction:
        """Above it: if n = Σ λᵢ nᵢ with λᵢ ≥ 0, then n·x ≤ −Σ λᵢ kᵢ. The λ are given, up to a common factor."""
        normal, k = [NONE] * 3, NONE
        for i, share in shares(faces, len(self.halves)).items():
            half = self.halves[i]
            normal, k = [c + share * m for c, m in zip(normal, half.normal, strict=True)], k + share * half.k
        along = dot(n, normal)
        if any(cross(n, normal)) or along <= 0:
            raise InvalidCertificate("shares: the sum of these normals does not point along n")
        return Fraction(-k * along / dot(normal, normal))

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        (ints,), scale = whole([x])
        if any(dot(half.normal, ints) + half.k * scale > 0 for half in self.halves):
            raise InvalidCertificate("point: outside a face of the polytope")
        return x, NONE

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        return all(half.holds(centre, columns, share) for half in self.halves)


class Hull(NamedTuple):
    """The hull of vertices / unit."""

    vertices: Sequence[Whole]
    unit: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return Fraction(max(dot(n, vertex) for vertex in self.vertices), self.unit)

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """A point is given by the weights of some vertices, up to a common factor: it cannot lie outside."""
        weights = shares(point, len(self.vertices))
        unit = self.unit * sum(weights.values())
        mean = [sum(w * self.vertices[i][axis] for i, w in weights.items()) / unit for axis in range(3)]
        return [Fraction(x) for x in mean], NONE

    def holds(self, _centre: Exact, columns: Sequence[Exact], _share: Fraction) -> bool:
        """Only a point, and `member` gave that."""
        return not any(any(column) for column in columns)


class Ellipsoid(NamedTuple):
    """{(centre + Σ tᵢ axisᵢ) / unit : ‖t‖ ≤ 1}, the three axes at right angles to each other."""

    centre: Whole
    axes: Sequence[Whole]
    unit: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        swell = root(Fraction(sum(dot(n, axis) ** 2 for axis in self.axes)))[1]
        return Fraction(dot(n, self.centre) + swell) / self.unit

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        (ints,), scale = whole([x])
        offset = [self.unit * a - scale * c for a, c in zip(ints, self.centre, strict=True)]
        squares = [dot(axis, axis) for axis in self.axes]
        size = squares[0] * squares[1] * squares[2]
        parts = [(dot(offset, axis) * (size // s)) ** 2 for axis, s in zip(self.axes, squares, strict=True)]
        whole_square = (scale * size) ** 2
        if sum(parts) <= whole_square:
            return x, NONE
        t = [Fraction(part, whole_square) for part in parts]  # tᵢ²; now by how much it has to move to come inside:
        unit = scale * self.unit
        moves = [root(Fraction(dot(offset, offset), unit * unit))[1] * (1 - 1 / root(sum(t, NONE))[1])]  # to the centre
        for i, s in enumerate(squares):  # or along one axis
            rest = 1 - (sum(t, NONE) - t[i])
            if rest >= 0:
                moves.append((root(t[i])[1] - root(rest)[0]) * root(Fraction(s, self.unit**2))[1])
        return x, min(moves)

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """In the coordinates t it is a ball in a ball."""
        start = [self.unit * x - c for x, c in zip(centre, self.centre, strict=True)]
        squares = [dot(axis, axis) for axis in self.axes]
        local = [[dot(way, axis) / s for axis, s in zip(self.axes, squares, strict=True)] for way in (start, *columns)]
        scaled = [[self.unit * c for c in column] for column in local[1:]]
        return ball_in_ball(local[0], scaled, Fraction(1), share)


class Cylinder(NamedTuple):
    """Within `breadth` of the line from `start` along `way`, between the planes across its ends."""

    start: Exact
    way: Exact
    breadth: Fraction
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        along = dot(n, self.way)
        across = dot(n, n) - along * along / dot(self.way, self.way)
        return Fraction(dot(n, self.start) + max(NONE, along) + self.breadth * root(across)[1])

    def _across(self, v: Exact) -> Exact:
        share = dot(v, self.way) / dot(self.way, self.way)
        return [x - share * w for x, w in zip(v, self.way, strict=True)]

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """Outside by the way to the nearest cap plane, and by the way to the side, at right angles to it."""
        x = vector(point, "point")
        offset, square = minus(x, self.start), dot(self.way, self.way)
        across = self._across(offset)
        aside = _beyond(dot(across, across), self.breadth)
        ends = max(NONE, -dot(offset, self.way), dot(offset, self.way) - square)
        return x, root(ends * ends / square + aside * aside)[1]

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        offset, square = minus(centre, self.start), dot(self.way, self.way)
        room = square - abs(2 * dot(offset, self.way) - square)
        if room < 0 or 4 * sum(dot(column, self.way) ** 2 for column in columns) > room * room:
            return False
        aside = [self._across(column) for column in columns]
        return ball_in_ball(self._across(offset), aside, self.breadth * self.breadth, share)


class Line(NamedTuple):
    """A ray from `origin`."""

    origin: Exact
    direction: Exact

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        if dot(n, self.direction) > 0:
            raise InvalidCertificate("n: the ray is unbounded in this direction")
        return Fraction(dot(n, self.origin))

    def at(self, time: Fraction) -> Exact:
        """Point at a time."""
        return [o + time * d for o, d in zip(self.origin, self.direction, strict=True)]


Solid: TypeAlias = Round | Half | Planes | Hull | Ellipsoid | Cylinder


def _round(corner: Exact, edges: Sequence[Exact], radius: Fraction = NONE) -> Round:
    (start, *rest), unit = whole([corner, *edges])
    return Round(start, [edge for edge in rest if any(edge)], unit, radius)


def _turned(rotation: Exact) -> Sequence[Exact]:
    """Columns of the rotation matrix of a quaternion (x, y, z, w) of any non-zero length."""
    x, y, z, w = rotation
    square = x * x + y * y + z * z + w * w
    columns = (
        (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y),
    )
    return [[c / square for c in column] for column in columns]


def _stretched(sizes: Exact, columns: Sequence[Exact]) -> Sequence[Exact]:
    return [[size * c for c in column] for size, column in zip(sizes, columns, strict=True)]


def _box(centre: Exact, half: Exact, rotation: Exact) -> Round:
    edges = _stretched([2 * h for h in half], _turned(rotation))
    return _round([c - sum(along) / 2 for c, *along in zip(centre, *edges, strict=True)], edges)


def _aligned(low: Exact, high: Exact) -> Round:
    size = minus(high, low)
    if min(size) < 0:
        raise InvalidCertificate("AABB.upper: below AABB.lower")
    return _round(low, [[size[i] * (i == j) for j in range(3)] for i in range(3)])


def _cylinder(start: Exact, end: Exact, radius: Fraction) -> Cylinder:
    if start == end:
        raise InvalidCertificate("Cylinder.q: equal to Cylinder.p")
    return Cylinder(start, minus(end, start), radius)


def _ellipsoid(centre: Exact, radii: Exact, rotation: Exact) -> Solid:
    if radii[0] == radii[1] == radii[2]:
        return _round(centre, [], radii[0])
    (middle, *axes), unit = whole([centre, *_stretched(radii, _turned(rotation))])
    return Ellipsoid(middle, axes, unit)


def _planes(planes: Sequence[Exact], position: Exact, columns: Sequence[Exact]) -> Planes:
    """Place planes n·y + k ≤ 0: x = position + R y lies behind (R n)·x + k − (R n)·position ≤ 0."""
    frame, size = whole(list(zip(*columns, strict=True)))  # the rows of R
    (place,), scale = whole([position])
    halves = []
    for *n, k in whole(planes)[0]:
        if not any(n):
            raise InvalidCertificate("a plane's normal must not be zero")
        normal = [dot(row, n) for row in frame]
        halves.append(Half([scale * c for c in normal], scale * size * k - dot(normal, place)))
    return Planes(halves)


def placed(vertices: Sequence[Exact], position: Exact, columns: Sequence[Exact]) -> Hull:
    """Place vertices: position + R y."""
    (place, *axes), unit = whole([position, *columns])
    points, scale = whole(vertices)
    frame = list(zip(*axes, strict=True))
    placed = [[scale * p + dot(row, point) for p, row in zip(place, frame, strict=True)] for point in points]
    return Hull(placed, unit * scale)


class Fields:
    """The numbers of a proxy's fields."""

    def __init__(self, shape: Any) -> None:
        self.shape, self.kind = shape, type(shape).__name__

    def _values(self, name: str) -> Any:
        try:
            return getattr(self.shape, name).tolist()
        except AttributeError:
            raise InvalidCertificate(f"{self.kind}: no array {name!r}, not a proxy of this project") from None

    def __call__(self, name: str, count: int = 3, nonzero: bool = False, least: int | None = None) -> Exact:
        """`count` numbers, not all zero if `nonzero`, none negative if `least` is 0, all positive if it is 1."""
        values = self._values(name)
        numbers = vector(values if count > 1 else [values], f"{self.kind}.{name}", count)
        self._refuse(name, nonzero and not any(numbers))
        self._refuse(name, least is not None and (min(numbers) < 0 or (least > 0 and min(numbers) == 0)))
        return numbers

    def rows(self, name: str, count: int) -> list[Exact]:
        """One or more rows of `count` numbers."""
        what = f"{self.kind}.{name}"
        rows = [vector(row if count > 1 else [row], what, count) for row in items(self._values(name), what)]
        self._refuse(name, not rows)
        return rows

    def indices(self, name: str, end: int) -> list[Sequence[int]]:
        """Rows of three numbers of other rows."""
        what = f"{self.kind}.{name}"
        return [[index(i, what, end) for i in items(row, what, 3)] for row in items(self._values(name), what)]

    def pose(self) -> tuple[Exact, Sequence[Exact]]:
        """Position, and columns of the rotation."""
        return self("position"), _turned(self("rotation", 4, nonzero=True))

    def _refuse(self, name: str, bad: bool) -> None:
        if bad:
            raise InvalidCertificate(f"{self.kind}.{name}: means no set")


def read(shape: Any) -> Solid | Line:
    """Take a convex proxy by the name of its type and the numbers of its fields: this says what they mean."""
    field = Fields(shape)
    match field.kind:
        case "Point":
            found: Solid | Line = _round(field("position"), [])
        case "Ray":
            found = Line(field("origin"), field("direction", nonzero=True))
        case "Sphere":
            found = _round(field("center"), [], *field("radius", 1, least=0))
        case "Capsule":
            start = field("p")
            found = _round(start, [minus(field("q"), start)], *field("radius", 1, least=0))
        case "AABB":
            found = _aligned(field("lower"), field("upper"))
        case "Box":
            found = _box(field("center"), field("half_extents", least=0), field("rotation", 4, nonzero=True))
        case "HalfSpace":
            (plane,), _ = whole([[*field("normal", nonzero=True), *field("k", 1)]])
            found = Half(plane[:3], plane[3])
        case "KDOP" | "ConvexPolyhedron":
            found = _polytope(field)
        case "Ellipsoid":
            found = _ellipsoid(field("center"), field("radii", least=1), field("rotation", 4, nonzero=True))
        case "Cylinder":
            found = _cylinder(field("p"), field("q"), *field("radius", 1, least=1))
        case _:
            raise InvalidCertificate(f"{field.kind} is not a convex proxy that can be checked")
    return found


def _polytope(field: Fields) -> Planes | Hull:
    if field.kind == "KDOP":
        ways, lower, upper = field.rows("directions", 3), field.rows("lower", 1), field.rows("upper", 1)
        if not len(ways) == len(lower) == len(upper):
            raise InvalidCertificate("KDOP: as many bounds as directions are needed")
        planes = [[*way, -high] for way, (high,) in zip(ways, upper, strict=True)]
        planes += [[-way[0], -way[1], -way[2], low] for way, (low,) in zip(ways, lower, strict=True)]
        return _planes(planes, [NONE] * 3, _turned([NONE, NONE, NONE, Fraction(1)]))
    match getattr(field.shape, "given", None):
        case "planes":
            return _planes(field.rows("numbers", 4), *field.pose())
        case "vertices":
            return placed(field.rows("numbers", 3), *field.pose())
    raise InvalidCertificate("ConvexPolyhedron.given: must be 'planes' or 'vertices'")
