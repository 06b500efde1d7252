#!/usr/bin/env python3
# bullet · raycast · Ray–Cylinder · ray misses a hit · huge · 1e-1
"""bullet, raycast of Ray (A) and Cylinder (B): ray misses a hit.

bullet answers no hit: ray misses a hit; the ray's signed distance from the shape is proven to be between
-447213.59549995797 and -447213.5954958963. It is wrong by at least 4.47e+05. On the shapes that bullet
effectively uses, still by 4.47e+05.

    python FILE                       asks bullet, and judges its answer
    python FILE "distance = 3.0" ...  judges this answer instead

The engine is asked in a process of its own, which may crash, and is ended after 10 seconds. What is true need not
be believed: this file holds a certificate, and checks it in exact arithmetic with nothing but the standard library.
Exit status: 1 while the answer is wrong, 0 once it is right, 2 if the engine is not installed or the certificate does
not hold.
"""

from __future__ import annotations

import base64
import json
import math
import signal
import subprocess
import sys
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from importlib.util import find_spec
from typing import Any

# ---- 1. The engine, called as its users call it ------------------------------------------------------------------

def ask():
    """Bullet: raycast of Ray (a) and Cylinder (b)."""

    from importlib.metadata import version

    import pybullet

    print("pybullet", version("pybullet"))
    pybullet.connect(pybullet.DIRECT)
    b = []  # shape, position, orientation, and the part of its radius that is taken off again
    shape = pybullet.createCollisionShape(pybullet.GEOM_CYLINDER, radius=1000000.0, height=1000000.0)
    b.append((shape, [0.0, 0.0, 500000.0], [-0.0, 0.0, 0.0, 1.0], 0.0))
    bodies_b = [pybullet.createMultiBody(1.0, shape, -1, at, turn) for shape, at, turn, _ in b]
    end = 5377708.765788517  # the ray is past b
    body, _, fraction, point, normal = pybullet.rayTest([2000000.0, 0.0, 0.0], [-3377708.765788517, 0.0, 2688854.3828942585])[0]
    print("hit =", float(body >= 0))
    print("t =", repr(fraction * end if body >= 0 else float("inf")))
    if body >= 0:
        print("normal =", list(normal))
        print("point =", list(point))


# ---- 3. The exact checker ----------------------------------------------------------------------------------------

Vector = Sequence[Any]

class Refused(Exception):
    """The certificate does not hold."""

def require(condition: object, text: str) -> None:
    """Refuse what does not meet a condition."""
    if not condition:
        raise Refused(text)

def number(value: Any) -> Fraction:
    """Take a double or an integer as the rational that it is, and a text such as '1/3'."""
    if isinstance(value, str):
        above, _, below = value.partition("/")
        return Fraction(int(above, 0), int(below or "1", 0))
    require(not isinstance(value, float) or math.isfinite(value), f"not a number: {value!r}")
    return Fraction(value)

def vector(values: Any) -> list[Fraction]:
    """Take three numbers."""
    require(len(values) == 3, f"not three numbers: {values!r}")
    return [number(value) for value in values]

def dot(u: Vector, v: Vector) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]

def cross(u: Vector, v: Vector) -> list[Any]:
    """Vector product."""
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]

def minus(u: Vector, v: Vector) -> list[Any]:
    """Difference u − v."""
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]

def along(u: Vector, t: Any, v: Vector) -> list[Any]:
    """Point u + t v."""
    return [u[0] + t * v[0], u[1] + t * v[1], u[2] + t * v[2]]

def times(t: Any, v: Vector) -> list[Any]:
    """Multiple t v."""
    return [t * v[0], t * v[1], t * v[2]]

def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose a square root, to 160 bits; both ends are equal where it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, 160 - product.bit_length() // 2)
    low, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(low, scale), Fraction(low + (low * low != product << 2 * shift), scale)

def length(v: Vector) -> tuple[Fraction, Fraction]:
    """Enclose the length of a vector."""
    return root(Fraction(dot(v, v)))

def whole(vectors: Sequence[Vector]) -> tuple[list[list[int]], int]:
    """Put vectors on one common denominator: integers, and that denominator."""
    unit = math.lcm(*{number(x).denominator for v in vectors for x in v})
    return [[int(number(x) * unit) for x in v] for v in vectors], unit

class Solid:
    """A convex core and the `radius` of a ball around each of its points."""

    radius = Fraction(0)
    centre: Vector = ()

    def member(self, place: Any, widened: bool = False) -> tuple[list[Fraction], Any]:
        """Read a point of the certificate, and find how far at most it lies outside the core, or the solid."""
        x = vector(place)
        square, radius = self.square(x), self.radius if widened else 0
        return x, 0 if square <= radius * radius else root(Fraction(square))[1] - radius

class Segment(Solid):
    """All points within `radius` of the segment from p to q: a point or ball, where these are one."""

    def __init__(self, p: Vector, q: Vector, radius: Fraction) -> None:
        self.p, self.q, self.radius = p, q, radius
        self.centre = along(p, Fraction(1, 2), minus(q, p))

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x over the segment."""
        return max(dot(n, self.p), dot(n, self.q))

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point from the segment."""
        way = minus(self.q, self.p)
        t = min(max(dot(minus(x, self.p), way) / dot(way, way), 0), 1) if any(way) else 0
        rest = minus(x, along(self.p, t, way))
        return dot(rest, rest)

def capsule(shape: Any) -> Segment:
    """All points within `radius` of the segment pq."""
    return Segment(vector(shape["p"]), vector(shape["q"]), number(shape["radius"]))

class Drum(Solid):
    """centre + t·half + a disc of radius `across` at right angles to `half`, with |t| ≤ 1."""

    def __init__(self, centre: Vector, half: Vector, across: Fraction) -> None:
        self.centre, self.half, self.across = centre, half, across

    def _split(self, x: Vector) -> tuple[Any, list[Any]]:
        """Share of `half` in a vector, and its part across."""
        t = dot(x, self.half) / dot(self.half, self.half)
        return t, along(x, -t, self.half)

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x, on the edge of one end, or more by less than 2⁻¹⁵⁰ of it."""
        _, flat = self._split(n)
        edge = root(Fraction(self.across**2 * dot(flat, flat)))[1]
        return dot(n, self.centre) + abs(dot(n, self.half)) + edge

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point, or a little more."""
        t, flat = self._split(minus(x, self.centre))
        beyond = max(abs(t) - 1, 0) ** 2 * dot(self.half, self.half)
        ratio = dot(flat, flat) / self.across**2
        return beyond + (dot(flat, flat) * (1 - 1 / root(Fraction(ratio))[1]) ** 2 if ratio > 1 else 0)

def cylinder(shape: Any) -> Drum:
    """Distance to the line pq ≤ radius, between the planes through p and q."""
    p, q, radius = vector(shape["p"]), vector(shape["q"]), number(shape["radius"])
    half = times(Fraction(1, 2), minus(q, p))
    require(any(half) and radius > 0, "a cylinder has a height and a radius")
    return Drum(minus(q, half), half, radius)

def weights(pairs: Any, end: int) -> list[tuple[int, Fraction]]:
    """Read weights ≥ 0 of some of `end` things, not all 0."""
    found = [(int(i), number(weight)) for i, weight in pairs]
    require(found and all(0 <= i < end and weight >= 0 for i, weight in found), "weights must not be negative")
    require(len(dict(found)) == len(found), "a weight must not be given twice")
    require(any(weight for _, weight in found), "some weight must be positive")
    return found

class Points:
    """Points / unit in integers, which several hulls share."""

    def __init__(self, points: Sequence[Vector]) -> None:
        self.places, self.unit = whole(points)

    def highest(self, n: Vector, corners: Any) -> Fraction:
        """Largest n·x over some of them."""
        ((x, y, z),), scale = whole([n])
        places = self.places
        best = max(x * places[i][0] + y * places[i][1] + z * places[i][2] for i in corners)
        return Fraction(best, scale * self.unit)

class Hull(Solid):
    """The hull of some points, which a certificate names by weights."""

    def __init__(self, points: Points, corners: Sequence[int], radius: Fraction = Fraction(0)) -> None:
        self.points, self.corners, self.radius = points, corners, radius

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at a corner."""
        return self.points.highest(n, self.corners)

    def member(self, place: Any, _: bool = False) -> tuple[list[Fraction], Any]:
        """A weighted mean of corners cannot lie outside."""
        found, total = [Fraction(0)] * 3, Fraction(0)
        for i, weight in weights(place, len(self.corners)):
            found, total = along(found, weight, self.points.places[self.corners[i]]), total + weight
        return times(1 / (total * self.points.unit), found), 0

def shares_of(faces: Any, atom: int = 0) -> Any:
    """Shares of the planes of one atom of a side, where a claim gives any."""
    return {int(i): shares for i, shares in faces}.get(atom, ())

Interval = tuple[Any, Any]

def room_along(claim: Any, a: Solid, b: Solid) -> tuple[Vector, Any]:
    """The direction n of a claim, and the room that planes across it leave between two cores, times ‖n‖."""
    n, (of_a, of_b) = vector(claim["n"]), claim["faces"]
    require(any(n), "a direction must not be 0")
    return n, -(a.support(n, shares_of(of_a)) + b.support(times(-1, n), shares_of(of_b)))

def sign_of(room: Any, n: Vector, radius: Any) -> Any:
    """Sign of room/‖n‖ − radius, without a root."""
    return room * room - radius * radius * dot(n, n) if room >= 0 else -1

def width_of(room: Any, n: Vector, radius: Any) -> Any:
    """At most room/‖n‖ − radius, by less than 2⁻¹⁵⁰ of it."""
    low, high = length(n)
    return room / (high if room > 0 else low) - radius

def escape(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ −D: moving B by D along n separates the two."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) <= 0, "the planes across n leave a gap")
    return width_of(room, n, a.radius + b.radius), math.inf

def ball_inside(points: Sequence[Vector], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of some points.

    The triangles are a closed surface, all of which turn their inner side to 0: so it winds around 0, and no ray from
    0 leaves the hull before it meets the plane of one of them.
    """
    edges: Counter[tuple[int, int]] = Counter()
    squares = []
    for i, j, k in triangles:
        require(min(i, j, k) >= 0, "no such point")
        edges.update([(i, j), (j, k), (k, i)])
        normal = cross(minus(points[j], points[i]), minus(points[k], points[i]))
        height = dot(normal, points[i])
        require(height > 0, "a triangle does not turn its inner side to 0")
        squares.append(Fraction(height * height) / dot(normal, normal))
    require(squares and all(n == edges[j, i] for (i, j), n in list(edges.items())), "the surface is not closed")
    least: Fraction = min(squares)
    return least

def core(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ −r: a polytope of points p − q, with p in A and q in B, holds a ball of radius r around 0."""
    found = [(a.member(p), b.member(q)) for p, q in claim["pairs"]]
    points = [minus(p, q) for (p, _), (q, _) in found]
    outside = max(beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found)
    if len(points) == 1 and not claim["triangles"]:
        upper = length(points[0])[1] + outside - a.radius - b.radius
    else:
        upper = outside - root(ball_inside(points, claim["triangles"]))[0] - a.radius - b.radius
    require(upper <= 0, "the points do not prove that the shapes meet")
    return -math.inf, upper

class Mesh:
    """The solid that a closed surface of triangles winds around."""

    def __init__(self, points: Points, triangles: Sequence[Sequence[int]]) -> None:
        self.points, self.triangles = points, triangles
        edges = Counter((t[i - 1], t[i]) for t in triangles for i in range(3))
        require(all(n == edges[j, i] for (i, j), n in list(edges.items())), "the surface of a mesh is not closed")

    def contains(self, point: Vector) -> bool:
        """Whether the surface winds around a point: the triangles above it, counted by their orientation.

        The point is moved by (ε, ε², ε³), so that no corner, edge or face is exactly above it.
        """
        ((x, y, z),), scale = whole([point])
        unit, turns = self.points.unit, 0
        for triangle in self.triangles:
            corners = [self.points.places[i] for i in triangle]
            aside = [scale * corner[0] > unit * x for corner in corners]
            if all(aside) or not any(scale * corner[0] >= unit * x for corner in corners):
                continue
            a, b, c = ([scale * u - unit * w for u, w in zip(corner, (x, y, z), strict=True)] for corner in corners)
            side = side_of(a, b)
            if side == side_of(b, c) == side_of(c, a):
                n = cross(minus(b, a), minus(c, a))
                turns += side * (first_sign(dot(n, a), -n[0], -n[1], -n[2]) == first_sign(n[2]))
        return turns != 0

def first_sign(*values: Any) -> int:
    """Sign of the first number that is not 0."""
    return next((1 if value > 0 else -1 for value in values if value), 0)

def side_of(a: Vector, b: Vector) -> int:
    """On which side of the edge ab, seen from above, the origin lies."""
    return first_sign(a[0] * b[1] - a[1] * b[0], a[1] - b[1], b[0] - a[0])

class Union:
    """Parts, convex ones and meshes; its atoms are the convex parts and the triangles of the meshes, in order."""

    def __init__(self, parts: Sequence[Any]) -> None:
        self.convex = [part for part in parts if not isinstance(part, Mesh)]
        self.meshes = {i: part for i, part in enumerate(parts) if isinstance(part, Mesh)}
        self.atoms: list[Any] = []
        for part in parts:
            self.atoms += [Hull(part.points, t) for t in part.triangles] if isinstance(part, Mesh) else [part]

    def height(self, n: Vector, chosen: Sequence[int], faces: Any) -> tuple[Any, Any]:
        """Find (h, r): n·x ≤ h + r ‖n‖ for all x of some atoms."""
        radius = max(self.atoms[i].radius for i in chosen)
        levels, corners = [], dict[Points, set[int]]()
        for i in chosen:
            atom = self.atoms[i]
            if isinstance(atom, Hull) and atom.radius == radius:
                corners.setdefault(atom.points, set()).update(atom.corners)
            else:
                lack = radius - atom.radius
                levels.append(atom.support(n, shares_of(faces, i)) - (lack * length(n)[0] if lack else 0))
        return max([*levels, *(points.highest(n, some) for points, some in corners.items())]), radius

    def contains(self, point: Vector) -> bool:
        """Whether a mesh contains a point."""
        return any(mesh.contains(point) for mesh in self.meshes.values())

def gaps(tree: Any, a: Union, b: Union, shift: Vector = (0, 0, 0)) -> Iterator[tuple[Vector, Any, Any]]:
    """For each leaf of a tree of directions: n, the room that planes across it leave, times ‖n‖, and all radii.

    Each node parts the atoms of one side; so every atom of A meets every one of B in one leaf. B is moved by `shift`.
    """
    waiting = [(tree, list(range(len(a.atoms))), list(range(len(b.atoms))))]
    while waiting:
        node, of_a, of_b = waiting.pop()
        if node["kind"] == "split":
            first = set(node["first"])
            group = of_b if node["side"] else of_a
            halves = [i for i in group if i in first], [i for i in group if i not in first]
            for branch, half in zip(node["branches"], halves, strict=True):
                waiting.append((branch, of_a, half) if node["side"] else (branch, half, of_b))
        elif of_a and of_b:
            n, (faces_a, faces_b) = vector(node["n"]), node["faces"]
            require(any(n), "a direction must not be 0")
            (high_a, radius_a), (high_b, radius_b) = a.height(n, of_a, faces_a), b.height(times(-1, n), of_b, faces_b)
            yield n, dot(n, shift) - high_a - high_b, radius_a + radius_b

def chosen(side: Union, choice: Any) -> Any:
    """An atom, the only part, or a convex piece inside a mesh."""
    if choice is None:
        require(len(side.atoms) == 1, "more than one part")
        return side.atoms[0]
    if isinstance(choice, int):
        require(0 <= choice < len(side.atoms), "no such part")
        return side.atoms[choice]
    mesh, piece = choice
    return piece_of(side.meshes[mesh], piece)

def piece_of(mesh: Mesh, piece: Any) -> Solid:
    """The hull of some points, widened by a ball: no triangle enters it, and its middle lies in the solid."""
    points, radius = Points([vector(v) for v in piece["vertices"]]), number(piece["radius"])
    hull = Hull(points, range(len(points.places)), radius)
    edges = [minus(place, points.places[0]) for place in points.places]
    normal = next((n for n in map(cross, edges[1:], edges[2:]) if any(n)), (0, 0, 0))
    require(radius >= 0 and (radius or any(dot(normal, edge) for edge in edges)), "a flat piece")
    for n, room, radii in gaps(piece["tree"], Union([hull]), Union([mesh])):
        if sign_of(room, n, radii) < 0:
            raise Refused("a triangle may enter a piece")
    middle = [Fraction(sum(column), points.unit * len(edges)) for column in zip(*points.places, strict=True)]
    require(mesh.contains(middle), "a piece does not lie inside the solid")
    return hull

class Line(Solid):
    """{origin + t·direction : t ≥ 0}."""

    def __init__(self, origin: Vector, direction: Vector) -> None:
        self.origin, self.direction = origin, direction

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at the origin, where the ray goes the other way."""
        require(dot(n, self.direction) <= 0, "the ray has no end in a direction")
        return dot(n, self.origin)

    def at(self, time: Any) -> list[Any]:
        """Point at a time."""
        return along(self.origin, time, self.direction)

def ray(shape: Any) -> Line:
    """{origin + t·direction : t ≥ 0}, t in units of the direction's length."""
    direction = vector(shape["direction"])
    require(any(direction), "a ray needs a direction")
    return Line(vector(shape["origin"]), direction)

def free(claim: Any, a: Union, b: Union) -> Interval:
    """Prove t ≥ `until`, or no hit at all: planes part the ray up to then from every atom of B."""
    (line,) = a.atoms
    until = claim["until"]
    time = math.inf if until is None else number(until)
    require(time >= 0, "a time before the start")
    path = line if until is None else Segment(line.origin, line.at(time), line.radius)
    for n, room, radius in gaps(claim["tree"], Union([path]), b):
        ends_there = until is not None and dot(n, line.direction) > 0  # then the end of the way may touch the plane
        gap = sign_of(room, n, radius)
        require(gap > 0 or (gap == 0 and ends_there), "the planes across n leave no gap")
    require(not b.contains(line.origin), "the ray starts inside")
    return time, math.inf

def hit(claim: Any, a: Union, b: Union) -> Interval:
    """Prove t ≤ `time`: the ray is inside then."""
    (line,), time = a.atoms, number(claim["time"])
    place = line.at(time)
    point, outside = chosen(b, claim["of_b"]).member(place if claim["p"] is None else claim["p"], True)
    require(time >= 0 and outside == 0 and list(point) == place, "the ray is not inside then")
    return -math.inf, time

MEANING: dict[str, Any] = {
    "Capsule": capsule,
    "Cylinder": cylinder,
    "Ray": ray,
}

CHECKS: dict[str, Any] = {
    "escape": escape,
    "core": core,
    "free": free,
    "hit": hit,
}

def read(shape: Any) -> Any:
    """Take one shape by the name of its type: what its numbers mean, exactly."""
    return MEANING[shape["type"]](shape)

def parts_of(shape: Any) -> list[Any]:
    """The parts of a composite, those of composites in it too; any other shape is its own only part."""
    if shape["type"] == "Composite":
        return [found for part_of_it in shape["parts"] for found in parts_of(part_of_it)]
    return [read(shape)]

def interval_of(claims: Any, a: Any, b: Any, least: Any = -math.inf) -> Interval:
    """Interval in which the signed distance of two shapes lies, or the time of a hit, by all claims together."""
    bounds = [CHECKS[claim["kind"]](claim, a, b) for claim in claims]
    lower, upper = max([least, *(low for low, _ in bounds)]), min([math.inf, *(high for _, high in bounds)])
    require(lower <= upper, "its claims contradict each other")
    return lower, upper

def of_solids(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the signed distance of two convex shapes."""
    return interval_of(claims, read(x), read(y))

def of_rays(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the time when a ray first hits a shape; both ends are infinite where it never does."""
    return interval_of(claims, Union([read(x)]), Union(parts_of(y)), 0)

KINDS: dict[str, Any] = {
    "solids": of_solids,
    "rays": of_rays,
}

def proven(proof: Any) -> Interval:
    """Check a certificate, which must prove the interval that is stated with it."""
    lower, upper = KINDS[proof["kind"]](proof["claims"], proof["x"], proof["y"])
    low, high = proof["interval"]
    known = math.nextafter(low, -math.inf) <= lower and upper <= math.nextafter(high, math.inf)
    require(known, "it proves less than is stated with it")
    return lower, upper


# ---- 4. The verdict ----------------------------------------------------------------------------------------------

Error = tuple[str, Any, float]
"""What is wrong, by how much at least, and how much the engine is allowed."""

def distance_of(value: float) -> Any:
    """A distance as it is answered, exactly."""
    return number(value) if math.isfinite(value) else value

def of_time(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of a ray's hit, in lengths, by what is proven of the time when it first hits."""
    if side["truth"] is None:
        return
    lower, upper = side["truth"]["exact"]
    hit, t, speed = answer.get("hit"), answer.get("t", math.inf), held["speed"]
    if hit is None or (hit and not 0 <= t < math.inf):
        yield "not a number", math.inf, 0.0
    elif hit:
        yield "ray hits a shape that it misses", math.inf if lower == math.inf else 0, held["t"]
        yield "ray hit off the shape", (lower - number(t)) * number(speed) if lower < math.inf else 0, held["t"]
        yield "ray hit behind the surface", (number(t) - upper) * number(speed), held["t"]
    else:
        yield "ray misses a hit", math.inf if upper < math.inf else 0, held["t"]

def of_claim(_: Any, side: Any, __: Any) -> Iterator[Error]:
    """Error of a claim low ≤ σ(x, y) − margin ≤ high, which the recorded answer makes."""
    proof = side["claim"]
    lower, upper = proof["exact"]
    low, high = proof["low"], proof["high"]
    under = number(low) - (upper - number(proof["margin"])) if math.isfinite(low) else -math.inf
    over = lower - number(proof["margin"]) - number(high) if math.isfinite(high) else -math.inf
    excess = min(max(under, over), distance_of(proof["cap"]))
    yield proof["symptom"], excess - number(proof["rounding"]), proof["allowed"]

def of_numbers(answer: Any, _: Any, held: Any) -> Iterator[Error]:
    """Errors of what is no number, or one that no scene can have, or is not there though there is a hit."""
    if answer.get("distance") == -math.inf:  # has neither witnesses nor a normal
        return
    owed = held["owed"] if answer.get("hit") != 0 else ["hit"]
    for name, value in {**dict.fromkeys(owed, math.nan), **answer}.items():
        endless = name in ("t", "distance") and math.isinf(value)
        inside = name == "normal" and answer.get("t") == 0
        numbers = value if isinstance(value, list) else [value]
        if not endless and not inside and not all(abs(x) < 1e150 for x in numbers):
            yield "not a number", math.inf, 0.0

TRIALS: dict[str, Any] = {
    "numbers": of_numbers,
    "claim": of_claim,
    "time": of_time,
}

Answer = dict[str, float | list[float]]

def told(lines: Sequence[str], names: Sequence[str]) -> Answer:
    """Read an answer from lines such as ``distance = 3.0``; what is nan is not said."""
    found: Answer = {}
    for line in lines:
        name, equals, text = line.partition(" = ")
        if equals and name.strip() in names:
            try:
                values = [float(value) for value in text.strip().strip("[]()").split(",")]
            except ValueError:
                continue
            if not all(math.isnan(value) for value in values):
                found[name.strip()] = values if len(values) > 1 else values[0]
    return found

def asked(file: str, question: str, limit: float, names: Sequence[str]) -> tuple[Answer, str]:
    """Run the part of this file that asks the engine; gives its answer, or says why there is none."""
    isolated = ["-I"] if sys.flags.isolated else []
    command = [sys.executable, *isolated, file, question]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return {}, f"no answer within {limit:g} seconds: its process was ended"
    lines = ran.stdout.splitlines()
    answer = told(lines, names)
    for line in lines:
        if line.partition(" = ")[0].strip() not in answer:
            print(" ", line)
    if ran.returncode < 0:
        return {}, f"its process ended with signal {-ran.returncode} ({signal.strsignal(-ran.returncode)})"
    if ran.returncode:
        errors = ran.stderr.strip().splitlines() or [f"exit status {ran.returncode}"]
        return {}, f"it raised an error: {errors[-1]}"
    return answer, "" if answer else "it answered nothing"

def missing(modules: Sequence[tuple[str, str]]) -> str:
    """Say which module is not installed, and how to get it; empty when all are there."""
    lacking = [f"{module} ({how})" for module, how in modules if find_spec(module) is None]
    return f"not installed: {', '.join(lacking)}" if lacking else ""

def proofs_of(sides: Any) -> list[Any]:
    """Check every certificate; the exact intervals join those that are stated."""
    found = []
    for side in sides:
        proofs = {name: side[name] for name in ("truth", "claim") if side[name] is not None}
        found.append(side | {name: proof | {"exact": proven(proof)} for name, proof in proofs.items()})
    return found

def print_answer(engine: str, answer: Answer, words: str, recorded: Any) -> None:
    """Show what the engine said."""
    print(f"{engine} answers{'' if answer else f' nothing: {words}'}")
    for name, value in answer.items():
        print(f"  {name} = {value!r}")
    if answer != recorded:
        print("  (not what it answered when this file was written)")

def print_proofs(sides: Any) -> None:
    """Show what the certificates prove."""
    print("proven, by the certificates in this file:")
    for proof in [side[name] for side in sides for name in ("truth", "claim") if side[name] is not None]:
        low, high = proof["interval"]
        print(" ", proof["about"].format(repr(low) if low == high else f"from {low!r} to {high!r}"))

def errors_of(answer: Answer, recorded: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of an answer on one pair of shapes.

    What was recorded is tried by the claim that it breaks. Any other answer is tried by what is proven of the shapes
    themselves, and by what else can be told exactly.
    """
    same = answer == recorded and side["claim"] is not None
    for name, trial in TRIALS.items():
        if name in ("numbers", "seconds") or (name == "claim") == same:
            yield from trial(answer, side, held)

def wrong_by(answer: Answer, recorded: Any, sides: Any, held: Any) -> tuple[str, Any] | None:
    """What is wrong with an answer on every pair of shapes, and the least amount; None if it is right on one."""
    worst: list[tuple[str, Any]] = []
    for side in sides:
        found = [(name, by) for name, by, allowed in errors_of(answer, recorded, side, held) if by > allowed]
        if not found and (side["truth"] is not None or answer == recorded):
            return None
        worst += sorted(found, key=lambda error: error[0] != side["symptom"])[:1]
    return (worst[0][0], min(by for _, by in worst)) if worst else None

def verdict(answer: Answer, wrong: tuple[str, Any] | None, allowed: str) -> int:
    """Say whether the answer is right; gives the exit status."""
    if not answer:
        print("verdict: WRONG: there is no answer")
        return 1
    if wrong is None:
        print(f"verdict: right, as far as this file can tell ({allowed})")
        return 0
    symptom, amount = wrong
    size = f", by at least {float(amount)!r}" if amount < math.inf else ""
    print(f"verdict: WRONG: {symptom}{size} ({allowed})")
    return 1

def main(arguments):
    if arguments == ["--ask"]:
        ask()
        return 0
    lacking = "" if arguments else missing(NEEDED)
    if lacking:
        print(lacking)
        return 2
    try:
        sides = proofs_of(SIDES)
    except (Refused, ArithmeticError, LookupError, TypeError, ValueError) as why:
        print(f"the certificate does not hold: {why}")
        return 2
    answer, words = (told(arguments, NAMES), "") if arguments else asked(__file__, "--ask", 10, NAMES)
    print_answer("bullet", answer, words, ANSWER)
    print_proofs(sides)
    return verdict(answer, wrong_by(answer, ANSWER, sides, HELD), ALLOWED)


# ---- 5. Long lists of numbers ------------------------------------------------------------------------------------

def unpacked(text):
    """Plain data that is too long to be read."""
    return json.loads(zlib.decompress(base64.b85decode(text)))


NUMBERS = [  # JSON, compressed
    unpacked(
        'c-pO3%WfPu5d4*e&btKr-OR5nbPyCJFcLV1om=34Pc=DofItqg;|P#6GfUR8s;eJ!|Lf_u4<CPi`swoY_T}~E)7#Va^7Ik6_ginO'
        '!6Y_J#~2nF*Gq5xdcj9IR5@sLd@{)58QXq&d42m*Tkp8LKR<uHUj9LU{p0h*{`B(U^ICN0K7R^v|EZ0)F@M_FKX!c1O*o~yikqYl'
        'm$w`B=h}0>8B@n`TbEGF9(-&P@5bV-QwEPNUdzAt4gY?g3;a6={eMv2-D0Ou-c#<sMEeewkTXXM_fDP?S;(5WY&^1CHxhmHfYF1x'
        'w@9LN(~8eKj~>IsMpkZ=Mq%b1hq_rRP#dSZOSt;OQDw;(&4dl`=>iWW7kL#J$vUk6Fs6|!HFh@Zod}pWfk%m&bq-Nxp@%`?@-#5*'
        '+J$+H>xG8((GhV*<ZyV-$3Y{JEh6v?@`w?W8yN~fG;-&`3i^+uLV(m3><-eSG{xx&n054FPV_ka;V4X~QI2r2l-F+&Ba!Muh5%mt'
        '@!*61u%_k=m!rO2FFLwM^FZ`NQSj&lXn6`zfeGNt;T8SSnUP{6JYnAMb^_H$wxmjGMqxv)tCh<*4R)aN><Q59Fn<+*P|Zqxn2M}X'
        'Cj`pGIPy%PWP~3zSOzK5hky_7BeBwgA?+DRLv4c_(V$`;bc7}9Jjy*+#;TqHO=^e-QpbCTq>ldA62(N(<q)$tg^6R0;7l}1`240-'
        'U=VUgKO!MI1qz#T*&L1803hX3WKtkW6V~TbQ9_z`go6SZSqX(}xIsI5D~18lIHhUXltqzHGkeHHTIGK_;|ZiW*?Ac?KVWp5Hbr4+'
        '5zu46_z3@5)aZtTAy_~~55#Un3Ei((2Asr96gon#OP$n_VVPzFEk<MteQxjoNr$7tszsqcRh13JoaS=&paU7+6$Nw_sjh9HWKoZr'
        '9bksDsEKw|#c%c~YB(g47O0F`t*1dTn|S$Z_9$*>{Mw^qY{6;c^fU*%E9R2QAEbUr^%V6%=Ze%^4Oc2$Rc$}Ku~>8wlM>)OC@e&s'
        'tCuP=Ur<cC)Wn|WAqQp=Bc0<(HWVg&g?dz#9_K-WIMCwJpOE&RS|b#Ov;2`D!BI7t&hZ4b)N(LjF_@yp*bfZyFneazD1yH*mLdKq'
        'SMb&QqSkBApPxUxeEjwI<JAYKU@8TR|G3jRp5xK=V#iZGF7b$uOPy=yCC{~fETH2O|G}%?v+g#x#jzHL&ARltHjlNX>>Ru2+HtIf'
        'r)f>jbMd;a$*TxYCFb&VT^GfM=c2{yxTz)hT`Xzsk-evWC+T_h?WUGg?VmS`Ic>gFBf+AnYtQCf#gQgeTC{2No}FaTUDRoFuYO9C'
        'GA;VF`BzEjMS3Z~TY;MNc+#e&0dEbs-aIF5UK;S$fTyMBCrbm~8dO&Eq|HkM-WqT*U$mD7yft7j=SiEF2D~-kV!miE4R~w7HS|r|'
        'yfomgK@BRrXfF+TYfyuMOxnCOkgY*=H(9io2C_Af^6#WAhrhQ5_1Yq`-Wu1QtwEJbnY3kTAX@{eSE`i&O9T1ld#xAt`N`5iwgyr?'
        '?px^hwJbf>&GG%Yv3%di(grurU!VU5O{a(e'
    ),
    unpacked(
        'c-pO3+ioK_4E+@&&$b|vqDb~v3_k>ES_Cc9MRwnc{r4V9qbyLYAFS4Z6U|sU!*h6@>)%g*yuJVW^vmh#_3O*?m)EEB>FFJp*Gny}'
        '8Ix#eiwLzipK7V+6Mpe%jg6w>haim`PW|@$^7=JTUU7B3-M*hsKfqu9`WVn(p5H#^rYqO+NyPOh4_;z?N`%jq{`kGpJi}fE-_Tp0'
        'xL%a0!q$Sj73R=!LV8t}UMlt4)Kqi#J@|j$w~2kn%Kr!Dr$=-P<&JE36uW~Y)S0bVSC1;KTjDnFE``IYxO#ioJgY{v7jw7>VN(I{'
        'lUt8rIuSQ6<OoAHL?aA^Z9pyTg3}?D9`-4VTND*iw^lpiU7VAA6AEYCdKglvH!9qzlb9sHMJlq2idGho=irAyy_##`Jk6~&Kc6VH'
        'MlHhRNCmOS4Rv#5ioi&&T?9s5NRjwfsCTH%(c9yw;P0&%Yd5Pzh$k3Nz-(Yo+N8$gm>mTPwMpHDH2`oi3rCuVAOy7Q<1vbD7FwEW'
        'vPb-%Pc3S<(hYUaMe7dv45*TNHe^m#rHe#mMt+4s(2CI7LG9ti2_RiFbGT`S7<&ugMWYS&@CpLI6C3<gGn)`mq=hPOv4`@GrVs$m'
        'uN4`|lsSqpGDJSI$^?N6eRe>Vi?}yb_eSacFm=>;WrV(>4eV$dPKDrW<U3{QM7nChL*P0f+ZK6;RnghuD@Kl9T2`0ZwF4FfB?Z}N'
        'I!OE&mE6<$l0h0sF9if60&EM^3i449Q^-kJ%1sas4b1}$0fP1|KV_JrKq*;em_;g5GX0UHjJm%G8iiG>1)(x$oFcLcf);wP!vD2z'
        'qFP0xgR@Zitalu)&?C4b&)O!W6M`qKr=%ST=BNU}TC3XbyusSK8kuBoLSxDTYlK3AxZTB6nAAct?9rTBL0fUmQ%w}TbQjbsdLDpA'
        'bE0A>%z>oOhQ)mw)KHrlrDJp_E@=3z8tSOE*apo3q+uL^rAV%P1bok}>oy>KjhQC3yI3zQirA_s{e(GU8x$>{DtCluL&l@f=WK@n'
        'MFrTWo`qPcWw%GGLW9nSIGP^PY9G|lG&C(`Bs{7eW|M%eQrkYJlZ*KnOHf2HpEAN0lZn!QFcgK9JWD3#v2X;ZII0vTzdI9YzUF-U'
        'czb^T{m<i72dH?yBy7HQz&T?g$F1{8kGt(y;uasvHujDskG=iaK*tjQb572sj$?N0g|9uAeeCsPZ`PABYmdEg?9JSp<MP-%*C|&L'
        '9!iYubDfK1!(-FrbzI~Yd?!nqXJnnp?;t%^pBK3$YyP;H%xUqZ90exLHqR{1IlIuHN|QD%-jswV-ASDm_nazeP^L+r7JmY7o}{M&'
        'ycEc}fd_4x8t~G9!JG$eo*MAdATxp|?WqAT4LHApHct(BX^;aBPuf!hUK%i%^PtUB16~?%GM}`k2D~)L!pVa+PYrl!ko}b>?WqAT'
        '4RZ33L7S%rvNYg)znQeB2C_7ejNd_9j`&_0Wc?DEuZr``(jea$WYCtWfh-Lqd(}*UseydPeam<B@ypaemIjie&8O?vTBaWJ;&{F<'
        'tiCQ}YJ-d0_uD`Gl!I^'
    ),
]


# ---- 2. The scene, what was answered, and what proves it wrong ---------------------------------------------------

A = {"type": "Ray", "origin": [2000000.0, 0.0, 0.0], "direction": [-1.0, 0.0, 0.5]}
B = {"type": "Cylinder", "p": [0.0, 0.0, 0.0], "q": [0.0, 0.0, 1000000.0], "radius": 1000000.0}
B_USED = {"type": "Cylinder", "p": [0.0, 0.0, 0.001], "q": [0.0, 0.0, 999999.999], "radius": 999999.999}
ANSWER = {"hit": 0.0, "t": math.inf}
HELD = {"t": 0.001002, "speed": 1.118033988749895, "hit": 0.001002, "owed": ["hit", "normal", "point", "t"]}
SIDES = [
    {
        "symptom": "ray misses a hit",
        "margins": [0.0, 0.0],
        "truth": {
            "about": "the time of the hit is {}",
            "kind": "rays",
            "x": A,
            "y": B,
            "margin": 0.0,
            "interval": [1000000.0, 1000000.0],
            "claims": [
                {
                    "kind": "free",
                    "tree": {"kind": "separated", "n": [-1.0, 0.0, 0.0], "faces": [[], []]},
                    "until": 1000000.0,
                },
                {"kind": "hit", "time": 1000000.0, "p": None, "of_b": None},
            ],
        },
        "claim": {
            "about": "the ray's signed distance from the shape is {}",
            "kind": "solids",
            "x": {
                "type": "Capsule",
                "p": [2000000.0, 0.0, 0.0],
                "q": [-5210472.037458072, 0.0, 3605236.018729036],
                "radius": 0.0,
            },
            "y": B,
            "margin": 0.0,
            "interval": [-447213.59549995797, -447213.5954958963],
            "claims": NUMBERS[0],
            "low": 0.0,
            "high": math.inf,
            "cap": math.inf,
            "rounding": 6.404185659521453e-09,
            "symptom": "ray misses a hit",
            "allowed": 0.001002,
        },
    },
    {
        "symptom": "ray misses a hit",
        "margins": [0.0, 0.001],
        "truth": None,
        "claim": {
            "about": "the ray's signed distance from the shape is {}, of the shapes that bullet effectively uses",
            "kind": "solids",
            "x": {
                "type": "Capsule",
                "p": [2000000.0, 0.0, 0.0],
                "q": [-5210472.03209151, 0.0, 3605236.016045755],
                "radius": 0.0,
            },
            "y": B_USED,
            "margin": 0.001,
            "interval": [-447213.59415831714, -447213.59415425546],
            "claims": NUMBERS[1],
            "low": 0.0,
            "high": math.inf,
            "cap": math.inf,
            "rounding": 6.404185654754988e-09,
            "symptom": "ray misses a hit",
            "allowed": 0.001002,
        },
    },
]
ALLOWED = "bullet is allowed an error of hit 0.001002, t 0.001002"
NEEDED = [["pybullet", "pip install pybullet"]]
NAMES = ["hit", "distance", "on_a", "on_b", "normal", "t", "point"]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
