"""What the answer to a sweep claims.

Its time is a claim about the way to the first contact: how far the two move until then, a length. Nothing else is new:
where both are at that time, they touch; the point lies on both; planes across the normal, through the point, have them
on their sides. These are claims about signed distances of the moved shapes.

Where bodies graze each other, a tiny error of a distance is a large one of the time. So an early contact counts for no
more than the gap that is left at its time, and one that is late or missed for no more than the depth to which the two
have got into each other until then.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from oracles import claimed_shapes, claims
from oracles.answers import take
from oracles.claimed_shapes import ROUNDING, leverage
from oracles.claims import BOOL, LARGEST, VALUE, WITNESS, Claim, Proof, Questioned
from oracles.course import Course
from oracles.reference import signed
from oracles.scene import SWEEP, Scene, size_of
from oracles.sweep_reference import (
    FACTOR,
    STEPS,
    FirstContact,
    error_of_time,
    first_contacts,
    in_lengths,
    proven_sweep,
    stands,
)
from refimpl import Capsule, HalfSpace, Point, Proxy, Sphere
from refimpl.linear import Array, Bools, scale


@dataclass(frozen=True)
class WayClaim(Claim):
    """low ≤ how far the two move until they first touch ≤ high; in all of the time they move by `way`.

    The claim is about x and y on their `course`.
    """

    course: Course = field(kw_only=True)
    way: Array = field(kw_only=True)

    def violations(self) -> tuple[Array, Array, Array]:
        """By how much the first contact comes before `low` and after `high`, in lengths, and the possible error."""
        found = first_contacts(self.x, self.y, self.course)
        lower, upper = (
            np.where(found.hit, self.way * np.where(found.hit, t, 0.0), np.inf) for t in (found.lower, found.t)
        )
        with np.errstate(invalid="ignore"):
            below = np.where(self.made & (upper < self.low), self.low - upper, -np.inf)
            above = np.where(self.made & (lower > self.high), lower - self.high, -np.inf)
        error = error_of_time(self.course) * self.way + self.rounding
        return np.minimum(below, self.cap), np.minimum(above, self.cap), error

    def proof(self, scene: Scene) -> Proof:
        """The certificate of the first contact, and the way until then."""
        x, y, course = self.x[0], self.y[0], self.course[0]
        certificate, interval = proven_sweep(x, y, course)
        about = Scene(SWEEP, x, y, scene.regime, scene.source, course)
        time = float(first_contacts(self.x[:1], self.y[:1], self.course[:1]).t[0])
        fits = stands(time, interval, x, y, course)
        return Proof(certificate, in_lengths(interval, float(self.way[0])), interval, about, time, fits)


@dataclass(frozen=True)
class SweptRows(Questioned):
    """Rows of a sweep as the judge takes them: shapes at the start, their growth and course, the engine's answers."""

    course: Course = field(kw_only=True)

    def claims(self) -> Iterator[Claim]:
        """Every claim the answers make, the gravest first."""
        yield from self._way_claims()
        yield self._contact_claim(claims.UNTOUCHED, self.hit)
        yield from self._point_claims()
        yield self.unit_claim(self._normal_said)
        yield from self._normal_claims()

    def claims_at_rest(self) -> Iterator[Claim]:
        """The same without those about ways: in their place such about the moved shapes, by the same names."""
        miss = ~self.first.hit
        for symptom, rows in ((claims.SWEEP_FALSE, self.hit & miss), (claims.EARLY, self.hit & ~miss)):
            yield self._contact_claim(symptom, rows)
        for symptom, kind, rows in (
            (claims.SWEEP_MISSED, BOOL, self._missed),
            (claims.LATE, VALUE, self._late),
        ):
            a, b = self._deepest
            bounds = self._zero, np.full(len(rows), np.inf)
            margin, rounding = self.margin_a + self.margin_b, self._rounding(a, b)
            yield self.claim(a, b, bounds, (symptom, ""), kind, rows, margin, rounding=rounding)
        yield from (claim for claim in self.claims() if not isinstance(claim, WayClaim))

    def take(self, rows: Any) -> SweptRows:
        """Pick rows."""
        margins, pair = (self.margin_a[rows], self.margin_b[rows]), (self.a[rows], self.b[rows])
        return SweptRows(
            self.query,
            *pair,
            *margins,
            take(self.answers, rows),
            self.answered[rows],
            self.waived,
            self.ways_out,
            course=self.course[rows],
        )

    # -- what is known -----------------------------------------------------------------------------------------

    @cached_property
    def size(self) -> Array:
        """Size of each scene."""
        return size_of(self.a, self.b, self.course)

    @cached_property
    def unusable(self) -> Bools:
        """Rows in which the engine owes a number and gave none, or gave one that no scene can have."""
        answers, hit = self.answers, self.answers.hit == 1
        bad = self.neither | (hit & ~((answers.t >= 0) & (answers.t < LARGEST)))
        for vector in (answers.normal, answers.point):
            bad |= hit & (np.abs(vector) > LARGEST).any(axis=-1)
        return np.asarray(self.answered & bad)

    @cached_property
    def hit(self) -> Bools:
        """Rows in which the engine says that the two touch, and when."""
        return np.asarray((self.answers.hit == 1) & self.answered & ~self.unusable)

    @cached_property
    def time(self) -> Array:
        """Times of the hits, 0 elsewhere."""
        return np.where(self.hit, self.answers.t, 0.0)

    @cached_property
    def way(self) -> Array:
        """How far the two move against each other in the whole of the time, at most."""
        return self.course.way(self.a, self.b)

    @cached_property
    def grown(self) -> tuple[Proxy, Proxy]:
        """Both at the start, one of them grown by both margins."""
        return grown_by(self.a, self.b, self.margin_a + self.margin_b)

    @cached_property
    def first(self) -> FirstContact:
        """First contacts, by the reference."""
        return first_contacts(*self.grown, self.course)

    def hit_point(self) -> Proxy:
        """Where moving points are at the times of their hits, as seen from B."""
        assert isinstance(self.a, Point)
        way = self.world.vectors(self.course.a.linear - self.course.b.linear)
        return self.world.point(self.a.position + scale(self.time, way))

    @cached_property
    def _there(self) -> tuple[Proxy, Proxy]:
        """Both at the times of the hits."""
        return self.course.at(self.a, self.b, self.time)

    @property
    def _zero(self) -> Array:
        return np.zeros(len(self.a))

    @cached_property
    def _missed(self) -> Bools:
        return np.asarray((self.answers.hit == 0) & self.answered & self.first.hit)

    @cached_property
    def _late(self) -> Bools:
        return np.asarray(self.hit & (self.time > self.first.t))

    @cached_property
    def _gap(self) -> Array:
        """How far the two are apart at the times of the hits; 0 where they are not."""
        sigma = signed(*self._there, self.hit)[1] - self.margin_a - self.margin_b
        return np.where(self.hit, np.maximum(sigma, 0.0), 0.0)

    @cached_property
    def _deepest(self) -> tuple[Proxy, Proxy]:
        """Both where they are deepest in each other, of some times from the first contact to the answer."""
        return self.course.at(self.a, self.b, self._depths[0])

    @cached_property
    def _depths(self) -> tuple[Array, Array]:
        """Time of the greatest depth, and that depth."""
        rows = self._late | self._missed
        begin = np.where(rows, self.first.t, 0.0)
        span = np.where(rows, np.where(self._late, self.time, 1.0) - begin, 0.0)
        best, depth = begin, np.zeros(len(rows))
        for power in range(STEPS) if rows.any() else ():
            time = begin + np.maximum(span, 0.0) * FACTOR**-power
            sigma = signed(*self.course.at(self.a, self.b, time), rows)[1] - self.margin_a - self.margin_b
            deeper = rows & (-sigma > depth)
            best, depth = np.where(deeper, time, best), np.where(deeper, -sigma, depth)
        return best, depth

    def _rounding(self, a: Proxy, b: Proxy) -> Array:
        """What rounding moved shapes costs."""
        far = a.magnitude + b.magnitude + self.size
        return np.asarray(ROUNDING * far * np.maximum(leverage(a), leverage(b)))

    # -- claims ------------------------------------------------------------------------------------------------

    def _way_claims(self) -> Iterator[Claim]:
        """First whether there is a contact at all, then when."""
        n, until = len(self.a), self.way * self.time
        missed, false = (self.answers.hit == 0) & self.answered, self.hit & ~self.first.hit
        cap = np.where(self._late | missed, self._depths[1], self._gap)
        bounds = np.where(missed, self.way, -np.inf), np.full(n, np.inf)
        yield self._way_claim(bounds, (claims.SWEEP_MISSED, ""), BOOL, missed, cap, None)
        bounds = np.full(n, -np.inf), np.where(false, until, np.inf)
        yield self._way_claim(bounds, ("", claims.SWEEP_FALSE), VALUE, false, cap, None)
        timed = self.hit & self.first.hit
        bounds = np.where(timed, until, -np.inf), np.where(timed, until, np.full(n, np.inf))
        yield self._way_claim(bounds, (claims.LATE, claims.EARLY), VALUE, timed, cap, timed)

    def _way_claim(
        self,
        bounds: tuple[Array, Array],
        words: tuple[str, str],
        kind: str,
        made: Bools,
        cap: Array,
        measures: Bools | None,
    ) -> WayClaim:
        made, rounding = made & ~self.unusable, ROUNDING * self.size
        a, b = self.grown
        zero = self._zero
        return WayClaim(
            a, b, *bounds, *words, kind, made, zero, cap, rounding, measures=measures, course=self.course, way=self.way
        )

    def _contact_claim(self, symptom: str, rows: Bools) -> Claim:
        """Where both are at the time of a hit, they touch."""
        a, b = self._there
        free, margin = np.full(len(rows), -np.inf), self.margin_a + self.margin_b
        rounding = self._rounding(a, b)
        return self.claim(a, b, (free, self._zero), ("", symptom), VALUE, rows, margin, rounding=rounding)

    @property
    def _point_said(self) -> Bools:
        return np.asarray(self.hit & np.isfinite(self.answers.point).all(axis=-1))

    @property
    def _normal_said(self) -> Bools:
        return np.asarray(self.hit & (self.time > 0) & np.isfinite(self.answers.normal).all(axis=-1))

    def _point_claims(self) -> Iterator[Claim]:
        """The point lies on both, where they are then."""
        said, shapes = self._point_said, self._there
        point = self.world.point(np.where(said[:, None], self.answers.point, 0.0))
        bounds, rounding = (np.full(len(said), -np.inf), self._zero), self._rounding(*shapes)
        for shape, margin in zip(shapes, (self.margin_a, self.margin_b), strict=True):
            tested = claimed_shapes.tested(shape)
            yield self.claim(point, tested, bounds, ("", claims.SWEEP_POINT), WITNESS, said, margin, rounding=rounding)

    def _normal_claims(self) -> Iterator[Claim]:
        """Planes across the normal, through the point: A does not reach beyond them, nor B to this side of them.

        Of unions, other parts may.
        """
        said = self._normal_said & self._point_said & (np.abs(self.answers.normal).max(axis=-1) > 0)
        if self.of_union:
            return
        point = np.where(said[:, None], self.answers.point, 0.0)
        normal = np.where(said[:, None], self.answers.normal, self.world.up)
        bounds, rounding = (self._zero, np.full(len(said), np.inf)), self._rounding(*self._there)
        sides = zip(self._there, (self.margin_a, self.margin_b), (normal, -normal), strict=True)
        for shape, margin, outward in sides:
            # two half-spaces overlap without end at the least tilt
            beyond_of = claimed_shapes.cube_on if isinstance(shape, HalfSpace) else self.world.beyond
            beyond = beyond_of(point, outward, self.size)
            words = claims.SWEEP_TILTED, ""
            tested = claimed_shapes.tested(shape)
            yield self.claim(beyond, tested, bounds, words, WITNESS, said, margin, rounding=rounding)


def grown_by(a: Proxy, b: Proxy, margin: Array) -> tuple[Proxy, Proxy]:
    """Both, one of them grown by a ball: a sweep of grown shapes is one of a round shape and the other.

    Raises
    ------
    ValueError
        Where there is something to grow, and neither is round.
    """
    if not margin.any():
        return a, b
    for side, shape in enumerate((a, b)):
        if isinstance(shape, Point | Sphere | Capsule):
            larger = _larger(shape, margin)
            return (larger, b) if side == 0 else (a, larger)
    raise ValueError("a margin in a sweep needs a Point, a Sphere or a Capsule on one side")


def _larger(shape: Point | Sphere | Capsule, by: Array) -> Proxy:
    if isinstance(shape, Point):
        return Sphere(shape.position, by)
    if isinstance(shape, Sphere):
        return Sphere(shape.center, shape.radius + by)
    return Capsule(shape.p, shape.q, shape.radius + by)
