"""What the numbers of each convex proxy mean, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from refimpl.proof.rational import Exact, InvalidCertificate, dot, index, items, minus, vector, whole
from refimpl.proof.sets import NONE, Cylinder, Ellipsoid, Half, Hull, Line, Planes, Round, Solid


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
