"""What the numbers of each convex proxy mean, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from refimpl.proof.rational import InvalidCertificate, items, number, rational, require, whole
from refimpl.proof.sets import Factor, Hull, Line, Planes, Points, Product, Solid
from refimpl.proof.vectors import NONE, Exact, Number, dot, minus, times

AXES = [[Fraction(i == j) for j in range(3)] for i in range(3)]
Rows = Sequence[Sequence[Number]]


class Fields:
    """The numbers of a proxy's fields."""

    def __init__(self, shape: Any) -> None:
        self.shape, self.kind = shape, type(shape).__name__

    def values(self, name: str) -> Any:
        """What a field's array has, as numbers or lists of them."""
        try:
            return getattr(self.shape, name).tolist()
        except AttributeError:
            raise InvalidCertificate(f"{self.kind}: no array {name!r}, not a proxy of this project") from None

    def refuse(self, name: str, bad: bool) -> None:
        """Refuse a field's values if they are bad."""
        require(not bad, f"{self.kind}.{name}: means no set")

    def __call__(self, name: str, count: int = 3, least: int | None = None) -> Exact:
        """`count` numbers, none negative if `least` is 0, all positive if it is 1."""
        values, what = self.values(name), f"{self.kind}.{name}"
        numbers = [rational(v, what) for v in items(values if count > 1 else [values], what, count)]
        self.refuse(name, least is not None and (min(numbers) < 0 or (least > 0 and min(numbers) == 0)))
        return numbers

    def rows(self, name: str, count: int) -> Rows:
        """One or more rows of `count` numbers."""
        what = f"{self.kind}.{name}"
        given = [row if count > 1 else [row] for row in items(self.values(name), what)]
        self.refuse(name, not given)
        return [[number(v, what) for v in items(row, what, count)] for row in given]

    def turn(self) -> Sequence[Exact]:
        """Columns of the rotation matrix of a quaternion (x, y, z, w) of any non-zero length."""
        x, y, z, w = self("rotation", 4)
        square = x * x + y * y + z * z + w * w
        self.refuse("rotation", square == 0)
        columns = (
            (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y),
        )
        return [times(1 / square, column) for column in columns]


def product(centre: Exact, factors: Sequence[Sequence[Exact]], radius: Fraction = NONE) -> Product:
    """Sum of segments, discs and ellipsoids, each by its vectors; those that are only a point are left out."""
    (middle, *vectors), unit = whole([centre, *(v for vectors in factors for v in vectors)])
    following, found = iter(vectors), []
    for given in factors:
        group = [v for v in [next(following) for _ in given] if any(v)]
        if group:
            values = [Fraction(sum(dot(u, v) ** 2 for u in group), dot(v, v)) for v in group]
            (parts,), one = whole([[1 / value for value in values]])
            found.append(Factor(group, parts, one))
    return Product(middle, found, unit, radius)


def segment(p: Exact, q: Exact, radius: Fraction = NONE) -> Product:
    """All within `radius` of the segment pq."""
    half = times(Fraction(1, 2), minus(q, p))
    return product(minus(q, half), [[half]], radius)


def _box(centre: Exact, half: Exact, columns: Sequence[Exact]) -> Product:
    return product(centre, [[times(h, column)] for h, column in zip(half, columns, strict=True)])


def _aligned(field: Fields) -> Product:
    low, high = field("lower"), field("upper")
    half = times(Fraction(1, 2), minus(high, low))
    field.refuse("upper", min(half) < 0)
    return _box(minus(high, half), half, AXES)


def _cylinder(field: Fields) -> Product:
    p, q, (radius,) = field("p"), field("q"), field("radius", 1, least=1)
    half = times(Fraction(1, 2), minus(q, p))
    field.refuse("q", not any(half))
    kept = [minus(axis, times(dot(axis, half) / dot(half, half), half)) for axis in AXES]
    return product(minus(q, half), [[half], [times(radius, axis) for axis in kept]])


def _ellipsoid(field: Fields) -> Product:
    centre, radii, columns = field("center"), field("radii", least=1), field.turn()
    if min(radii) == max(radii):
        return product(centre, [], radii[0])
    return product(centre, [[times(r, column) for r, column in zip(radii, columns, strict=True)]])


def behind(planes: Rows, position: Exact, columns: Sequence[Exact]) -> Planes:
    """Place planes n·y + k ≤ 0: x = position + R y lies behind (R n)·x + k − (R n)·position ≤ 0."""
    frame, size = whole(list(zip(*columns, strict=True)))  # the rows of R
    (place,), scale = whole([position])
    found = []
    for *n, k in whole(planes)[0]:
        require(any(n), "a plane's normal must not be zero")
        normal = [dot(row, n) for row in frame]
        found.append((times(scale, normal), scale * size * k - dot(normal, place)))
    return Planes(found)


def _kdop(field: Fields) -> Planes:
    ways, lower, upper = field.rows("directions", 3), field.rows("lower", 1), field.rows("upper", 1)
    require(len(ways) == len(lower) == len(upper), "KDOP: as many bounds as directions are needed")
    above = [[*way, -high] for way, (high,) in zip(ways, upper, strict=True)]
    below = [[*times(-1, way), low] for way, (low,) in zip(ways, lower, strict=True)]
    return behind([*above, *below], [NONE] * 3, AXES)


def placed(field: Fields, name: str) -> Points:
    """Points y in the place position + R y."""
    (place, *axes), unit = whole([field("position"), *field.turn()])
    points, scale = whole(field.rows(name, 3))
    frame = list(zip(*axes, strict=True))
    found = [[scale * p + dot(row, y) for p, row in zip(place, frame, strict=True)] for y in points]
    return Points(found, unit * scale)


def _polytope(field: Fields) -> Planes | Hull:
    match getattr(field.shape, "given", None):
        case "planes":
            return behind(field.rows("numbers", 4), field("position"), field.turn())
        case "vertices":
            points = placed(field, "numbers")
            return Hull(points, range(len(points.places)))
    raise InvalidCertificate("ConvexPolyhedron.given: must be 'planes' or 'vertices'")


def _ray(field: Fields) -> Line:
    field.refuse("direction", not any(field("direction")))
    return Line(field("origin"), field("direction"))


MEANING: dict[str, Callable[[Fields], Solid | Line]] = {
    "Point": lambda field: product(field("position"), []),
    "Ray": _ray,
    "Sphere": lambda field: product(field("center"), [], *field("radius", 1, least=0)),
    "Capsule": lambda field: segment(field("p"), field("q"), *field("radius", 1, least=0)),
    "AABB": _aligned,
    "Box": lambda field: _box(field("center"), field("half_extents", least=0), field.turn()),
    "HalfSpace": lambda field: behind([[*field("normal"), *field("k", 1)]], [NONE] * 3, AXES),
    "Ellipsoid": _ellipsoid,
    "Cylinder": _cylinder,
    "KDOP": _kdop,
    "ConvexPolyhedron": _polytope,
}


def read(shape: Any) -> Solid | Line:
    """Take a convex proxy by the name of its type and the numbers of its fields: this says what they mean."""
    field = Fields(shape)
    require(field.kind in MEANING, f"{field.kind} is not a convex proxy that can be checked")
    return MEANING[field.kind](field)
