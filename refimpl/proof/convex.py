"""Claims about two bounded convex proxies: proposals from several searches, of which the best proven are taken."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from refimpl.proof.bodies import Body, Corners, Mix, Vertices, numbered
from refimpl.proof.bounds import bounds_of
from refimpl.proof.claims import Bound, Claim, Common, Core, Escape, Near, Place, Separated
from refimpl.proof.exact import Difference, Features, pyramid
from refimpl.proof.exact import nearest as exactly_nearest
from refimpl.proof.inscribed import ball_around_point, inscribed
from refimpl.proof.points import Vector, along, cross, dot, doubles, exact, minus, opposite, root
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.search import MANY, VERTICES, Grid, Meeting, deepest, nearest
from refimpl.proof.solids import body
from refimpl.proof.unions import Union, parts_of
from refimpl.shapes import HalfSpace, Proxy, UnsupportedOperation

ENOUGH = Fraction(1, 1 << 47)  # of the scene; proposals stop when the interval is as narrow as this
FAIR = Fraction(1, 1 << 34)  # as narrow as is worth a large polytope
TURN = 0.02  # sine of the angle up to which the normal of a flat part competes with the direction found


class Search:
    """Two proxies, and the best claims about them so far."""

    def __init__(self, a: Proxy, b: Proxy) -> None:
        self.shapes = a, b
        self.solids = Union(parts_of(a)), Union(parts_of(b))
        self.bodies = Body() if isinstance(a, HalfSpace) else body(a), body(b)
        self.radius = self.bodies[0].radius + self.bodies[1].radius
        self.lower: tuple[Bound, Claim | None] = (-math.inf, None)
        self.upper: tuple[Bound, Claim | None] = (math.inf, None)
        self.size = Fraction(max(a.magnitude.tolist(), b.magnitude.tolist()))

    def claims(self) -> tuple[Claim, ...]:
        """Search in turn, until the bounds are near to each other."""
        half = isinstance(self.shapes[0], HalfSpace)
        for step in (self._plane,) if half else (self._features, self._supports, self._reference):
            step()
            if self._done():
                break
        return tuple(claim for _, claim in (self.lower, self.upper) if claim is not None)

    # ------------------------------------------------------------------------------------- proposals

    def _plane(self) -> None:
        """A half-space and a body: only its own normal has a supporting plane."""
        half, other = self.shapes[0], self.bodies[1]
        assert isinstance(half, HalfSpace)
        n: Vector = tuple(half.normal.tolist())
        self.across([n])
        lowest, mix = other.lowest(n)
        found = pyramid(half, lowest)
        if not found.triangles:
            self.touch((found.pairs[0], ((), mix)))
            return
        place = self._place(1, lowest, mix)
        for plain, point in ((True, place), (False, place), (False, lowest)):  # depths below rounding need all of it
            pairs = tuple((doubles(p) if plain else p, point) for p, _ in found.pairs)
            if self.propose_upper(Core(pairs, tuple(found.triangles))) and self._done():
                break

    def _done(self) -> bool:
        return self.upper[0] - self.lower[0] <= ENOUGH * self.size

    def _features(self) -> None:
        """Two polytopes: exact corners tell whether they meet, and which features are nearest."""
        a, b = self.bodies
        if not isinstance(a, Corners) or not isinstance(b, Corners):
            return
        self.found, mixes = exact_nearest(a, b)
        self.touch((self.found.pairs[0], mixes))
        if any(self.found.normal):
            self.across([self.found.normal])

    def _supports(self) -> None:
        """Any two bodies, by support points in floats."""
        grid = Grid(*self.bodies)
        found = nearest(grid)
        for (p, mix_p), (q, mix_q) in found.pairs:
            self.touch(((p, q), (mix_p, mix_q)))
        if found.normals:
            self.across([*found.normals, *self._flat(found.normals)])
        if self.lower[0] < -self.radius:
            self._depth(grid)

    def _depth(self, grid: Grid) -> None:
        """Bodies that meet: a polytope; for circles of directions an ellipsoid, or else a larger polytope."""
        for claim in ball_around_point(self.bodies):
            self.propose_upper(claim)
            self._reference()
            if self._done():
                return
        for vertices in (VERTICES, MANY):
            deep = deepest(grid, vertices)
            self.across([*deep.normals, *self._flat(deep.normals)])
            self.inside(deep)
            if deep.closed:
                return
            enough = float(-self.lower[0] - self.radius - ENOUGH * self.size)
            for claim in inscribed(self.shapes, self.bodies, plain(deep.normals[0]), enough):
                self.propose_upper(claim)
            self._reference()
            if self.upper[0] - self.lower[0] <= FAIR * self.size:
                return

    def _reference(self) -> None:
        """What the pair table answers: as good a proposal as any."""
        found = reference(*self.shapes)
        if found is None:
            return
        n: Vector = tuple(found.normal.tolist())
        self.across([n, *self._flat([n])])
        on_a, on_b = tuple(found.on_a.tolist()), tuple(found.on_b.tolist())
        if not any(isinstance(part, Vertices) for part in self.bodies):
            self.propose_upper(Near(on_a, on_b))

    def _flat(self, ways: Iterable[Vector]) -> Iterator[Vector]:
        """Normals of flat parts near to some directions."""
        flat = [*self.bodies[0].normals(), *(opposite(n) for n in self.bodies[1].normals())]
        for way in [doubles(way) for way in ways]:
            for n in flat:
                m = doubles(n)
                c = cross(way, m)
                if dot(way, m) > 0 and dot(c, c) <= TURN**2 * dot(way, way) * dot(m, m):
                    yield n

    # ---------------------------------------------------------------------------------------- claims

    def across(self, normals: Iterable[Vector]) -> None:
        """Claim what supporting planes across some directions prove, in doubles and as they are."""
        for n in normals:
            for way in dict.fromkeys((plain(n), n)):
                if not any(way):
                    continue
                of_a, of_b = self.bodies[0].faces(exact(way)), self.bodies[1].faces(opposite(exact(way)))
                faces = numbered(0, of_a), numbered(0, of_b)
                if not self._propose_lower(Separated(way, None, faces)):
                    self._propose_lower(Escape(way, faces))

    def _propose_lower(self, claim: Claim) -> bool:
        try:
            bound = bounds_of(claim, self.solids)[0]
        except InvalidCertificate:
            return False
        if bound > self.lower[0]:
            self.lower = bound, claim
        return True

    def propose_upper(self, claim: Claim) -> bool:
        """Take a claim if it proves more than those before."""
        try:
            bound = bounds_of(claim, self.solids)[1]
        except InvalidCertificate:
            return False
        if bound < self.upper[0]:
            self.upper = bound, claim
        return True

    def _place(self, side: int, point: Vector, mix: Mix) -> Place:
        return self.bodies[side].place(point, mix)

    def touch(self, found: tuple[tuple[Vector, Vector], tuple[Mix, Mix]]) -> None:
        """Claim what two near points of the cores prove."""
        (p, q), (mix_p, mix_q) = found
        across = minus(q, p)
        length = root(dot(across, across))[1]
        a, b = self.bodies
        if length <= self.radius:
            self.propose_upper(Core(((self._place(0, p, mix_p), self._place(1, q, mix_q)),)))
        on_a = along(p, a.radius / length, across) if length and a.radius else p
        on_b = along(q, -b.radius / length, across) if length and b.radius else q
        places = self._place(0, on_a, mix_p), self._place(1, on_b, mix_q)
        self.propose_upper(Near(*places))
        if self.upper[0] > ENOUGH * self.size or self.upper[0] <= 0:
            return
        for place in dict.fromkeys((places[0], places[1], on_a, on_b)):
            self.propose_upper(Common(place))

    def inside(self, deep: Meeting) -> None:
        """Claim the depth that a polytope of pairs proves."""
        if deep.triangles:
            pairs = tuple((self._place(0, p, m), self._place(1, q, k)) for (p, m), (q, k) in deep.pairs)
            self.propose_upper(Core(pairs, tuple(deep.triangles)))


def reference(a: Proxy, b: Proxy) -> Any:
    """What the pair table answers, where it does and the answer is finite."""
    from refimpl.queries import distance  # noqa: PLC0415  it imports this package

    try:
        found = distance(a, b)
    except UnsupportedOperation:
        return None
    return found if math.isfinite(found.distance) else None


def plain(n: Vector) -> Vector:
    """Doubles along n."""
    if all(isinstance(c, float) for c in n):
        return n
    largest = max(abs(Fraction(c)) for c in n)
    return doubles((Fraction(n[0]) / largest, Fraction(n[1]) / largest, Fraction(n[2]) / largest))


def exact_nearest(a: Corners, b: Corners) -> tuple[Features, tuple[Mix, Mix]]:
    """Nearest points of two hulls, exactly, on the few corners that matter."""
    chosen: tuple[list[int], list[int]] = ([0], [0])
    while True:
        of_a, of_b = [a.corner(i) for i in chosen[0]], [b.corner(j) for j in chosen[1]]
        difference = Difference(of_a, of_b)
        found = exactly_nearest(difference)
        if not any(found.normal):
            break
        i, j = a.farthest(found.normal), b.farthest(opposite(found.normal))
        level = max(dot(found.normal, p) for p in of_a) - min(dot(found.normal, q) for q in of_b)
        if dot(found.normal, minus(a.corner(i), b.corner(j))) <= level:
            break
        chosen = [*chosen[0], *({i} - set(chosen[0]))], [*chosen[1], *({j} - set(chosen[1]))]
    mixes: list[dict[int, int]] = [{}, {}]
    for vertex, weight in zip(found.carriers, found.weights, strict=True):
        for side, number in enumerate((difference.a.index(vertex.a), difference.b.index(vertex.b))):
            i = chosen[side][number]
            mixes[side][i] = mixes[side].get(i, 0) + weight
    return found, (list(mixes[0].items()), list(mixes[1].items()))


def convex_claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    """Claims about two bounded convex proxies."""
    return Search(a, b).claims()
