"""What an engine's answer claims, as statements about signed distances.

An answer is never compared with ours. It is taken apart into claims of one form, low ≤ σ(X, Y) ≤ high, each of
which a certificate can prove or refute: the distance it names; that a witness lies on its shape; that moving B
along the normal by the depth makes the two touch; that a ray is free up to its hit, and has arrived there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from oracles.answers import take
from oracles.claimed_shapes import ROUNDING, cube_on, is_fragile, leverage, moved_by, past, rounding_of, tested
from oracles.engine import Answers, Convention
from oracles.reference import UNIONS, allows, error_of, kept, proven, signed
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, Scene
from oracles.world import PLANE, World, world_of
from refimpl import HalfSpace, Proxy, Ray, distance
from refimpl.linear import Array, Bools, norm, scale
from refimpl.proof import Certificate, SweepCertificate
from refimpl.proof.claims import Bound

NOT_A_NUMBER = "not a number"
NEITHER = "fits neither the shapes nor those effectively used"
MISSED, FALSE = "missed contact", "false contact"
SHORT, LONG = "distance too small", "distance too large"
STUCK, OVERSHOT = "normal and depth do not separate", "normal and depth move too far"
BRIEF, LENGTHY = "normal shorter than 1", "normal longer than 1"
OFF_SHAPE = "witness off its shape"
OUTSIDE = "contact point farther from a shape than the depth"
APART, TOGETHER = "witnesses farther apart than the distance", "witnesses nearer than the distance"
RAY_MISSED, RAY_OFF, RAY_LATE = (
    "ray misses a hit",
    "ray hit off the shape",
    "ray hit behind the surface",
)
RAY_POINT = "ray's hit point is not where its time is"
RAY_FALSE = "ray hits a shape that it misses"
TILTED = "ray normal does not point outward"

SWEEP_MISSED, SWEEP_FALSE = "sweep misses a contact", "sweep hits a shape that it misses"
EARLY, LATE = "sweep's contact too early", "sweep's contact too late"
UNTOUCHED = "shapes do not touch at the sweep's time"
SWEEP_POINT = "sweep's point off a shape"
SWEEP_TILTED = "sweep's normal does not separate"

WRONG_BOOLEANS = (MISSED, FALSE, RAY_MISSED, RAY_FALSE, SWEEP_MISSED, SWEEP_FALSE)
VALUE, WITNESS, BOOL, LENGTH = "value", "witness", "boolean", "length"
OTHER_DEPTHS = {Convention.DEPTH_OF_ITS_NORMAL, Convention.OF_ONE_TRIANGLE}
"""Conventions by which the depth of a contact need not be that of the pair."""


@dataclass(frozen=True)
class Proof:
    """What is proven of the number that a claim is about, for one row.

    Attributes
    ----------
    interval
        Of that number; `proves` is what the certificate itself proves of `scene`.
    value, fits
        What the reference says in floats of what the certificate proves, and whether that is near enough.
    """

    certificate: Certificate | SweepCertificate
    interval: tuple[Bound, Bound]
    proves: tuple[Bound, Bound]
    scene: Scene
    value: float
    fits: bool


@dataclass(frozen=True)
class Claim:
    """For every row where it is `made`: low ≤ σ(x, y) − margin ≤ high, up to the engine's tolerance.

    Attributes
    ----------
    below, above
        Symptom when the signed distance is below `low`, or above `high`.
    margin
        By how much the shapes are grown beyond x and y: σ of the grown shapes is σ(x, y) − margin.
    kind
        Which of the engine's tolerances applies: "value", "witness" or "boolean"; or "length", of a normal, for which
        there is one that all engines share.
    cap
        No violation counts for more than this: a ray cannot be later than the way it has gone.
    rounding
        How far x or y may lie from what the engine said, because a moved proxy or a point of a ray is rounded.
    """

    x: Proxy
    y: Proxy
    low: Array
    high: Array
    below: str
    above: str
    kind: str
    made: Bools
    margin: Array
    cap: Array
    rounding: Array
    by_convention: bool = False
    """Whether the engine declares that it does not make this claim: breaking it is a convention."""
    measures: Bools | None = None
    """Where its violation is the error of a finite value that was answered."""
    kept: bool = False
    """Whether others will ask about x and y too, so that what is known of them is kept."""

    def violations(self) -> tuple[Array, Array, Array]:
        """By how much σ lies below `low` and above `high`, by the reference in floats; and its possible error.

        Where σ is only known to lie between two numbers, as for unions that overlap, the kinder one counts.
        """
        if not self.made.any():
            nothing = np.full(len(self.made), -np.inf)
            return nothing, nothing, np.zeros(len(self.made))
        magnitude = np.maximum(self.x.magnitude, self.y.magnitude)
        if self.kept:
            least, most = kept(self.x, self.y, self.made, enough=self.margin + self.high)
        else:
            bounded = self.low > -np.inf
            told = ~bounded & (self.margin + self.high > CLEAR * magnitude + 2.0 * self.rounding)
            any_depth = told if self.measures is None else None
            least, most = signed(self.x, self.y, self.made, above=bool(bounded[self.made].any()), any_depth=any_depth)
        size = np.maximum(magnitude, np.where(np.isfinite(most), np.abs(most), 0.0))
        with np.errstate(invalid="ignore"):
            least, most = least - self.margin, most - self.margin
            below = np.where(self.made & (most != self.low), self.low - most, -np.inf)
            above = np.where(self.made & (least != self.high), least - self.high, -np.inf)
        error = error_of(self.x, self.y) * size + self.rounding
        return np.minimum(below, self.cap), np.minimum(above, self.cap), error

    def proof(self, scene: Scene) -> Proof:
        """What is proven of the first row, which is of `scene`, and what the reference says of it.

        Raises
        ------
        InvalidCertificate
            When the checker refuses the reference's own certificate.
        """
        x, y = self.x[0], self.y[0]
        certificate, interval = proven(x, y)
        query = scene.query if scene.course is None else DISTANCE
        about, sigma = Scene(query, x, y, scene.regime, scene.source), float(distance(x, y).distance)
        fits = allows(*interval, sigma, error_of(x, y) * max(about.size, abs(sigma)))
        return Proof(certificate, interval, interval, about, sigma, fits)

    def measured(self, worst: Array, doubt: Array) -> Array:
        """Error of the value at least, given the larger violation and what it may err by; NaN where it has none.

        An infinite distance that is right, or that tells of an overlap without its depth, is no length.
        """
        valued = (worst > 0) if self.measures is None else self.measures | (worst > 0)
        return np.where(self.made & valued, np.maximum(worst - doubt, 0.0), np.nan)


UNIT_ERROR = 1e-6
"""How far from 1 a normal's length may be, whatever the scene's size: engines that keep normals in single precision are
not wrong."""

PIECE = 1.01
"""An overlap said to be deeper than its deepest pair of pieces by no more than this factor, and than the engine's
tolerance, may be meant to be that."""

CLEAR = 1e-6
"""Part of a scene's size that no rounding comes near: where shapes that only must not be apart have so much room, any
overlap is enough, however deep."""

LARGEST = 1e150
"""No scene has such numbers; an engine that answers one, the largest double for instance, has not set it."""


@dataclass(frozen=True)
class Questioned:
    """Rows of one cell as the judge takes them: shapes, their growth, the engine's answers."""

    query: str
    a: Proxy
    b: Proxy
    margin_a: Array
    margin_b: Array
    answers: Answers
    answered: Bools
    waived: frozenset[Convention] = frozenset()
    """Conventions of the engine's that take back a claim."""
    ways_out: bool = False
    """Whether any overlap of unions is answered by a way out, as the reference does, and never by that of a piece."""
    allowed: Array | None = None
    """By how much a depth may be off, where the engine does not promise it to rounding."""

    def claims(self) -> Iterator[Claim]:
        """Every claim the answers make, the gravest first."""
        if self.query == RAYCAST:
            yield from self._ray_claims()
            return
        yield from self._boolean_claim()
        if self.query != BOOLEAN:
            yield from self._value_claims()

    def is_as(self, other: Questioned) -> bool:
        """Whether these are the very shapes, grown by as much: then the claims are the same."""
        grown = (self.margin_a, other.margin_a), (self.margin_b, other.margin_b)
        return self.a is other.a and self.b is other.b and all(np.array_equal(x, y) for x, y in grown)

    @cached_property
    def size(self) -> Array:
        """Largest coordinate or extent of each scene."""
        return np.maximum(self.a.magnitude, self.b.magnitude)

    def take(self, rows: Any) -> Questioned:
        """Pick rows."""
        margins = self.margin_a[rows], self.margin_b[rows]
        answers = take(self.answers, rows)
        pair = self.a[rows], self.b[rows]
        allowed = None if self.allowed is None else self.allowed[rows]
        return Questioned(
            self.query, *pair, *margins, answers, self.answered[rows], self.waived, self.ways_out, allowed
        )

    def only(self, rows: Any) -> Questioned:
        """The same batch, in which only these rows count as answered."""
        answered = np.zeros_like(self.answered)
        answered[rows] = self.answered[rows]
        return replace(self, answered=answered)

    @cached_property
    def unusable(self) -> Bools:
        """Rows in which the engine owes a number and gave none, or gave one that no scene can have."""
        answers, hit = self.answers, self.answers.hit == 1
        empty, endless = self.neither, answers.distance == -np.inf
        unmeasured = hit & ~endless & (np.isnan(answers.distance) | np.isnan(answers.normal).any(axis=-1))
        owed: dict[str, Bools] = {
            BOOLEAN: empty,
            RAYCAST: empty | (hit & ~((answers.t >= 0) & (answers.t < np.inf))),
            CONTACTS: empty | unmeasured,
            DISTANCE: np.isnan(answers.distance),
        }
        beyond = (np.abs(answers.distance) > LARGEST) & np.isfinite(answers.distance)
        beyond |= hit & (np.abs(answers.t) > LARGEST)
        for vector in (answers.on_a, answers.on_b, answers.normal, answers.point):
            beyond |= (np.abs(vector) > LARGEST).any(axis=-1) & ~endless
        return self.answered & (owed[self.query] | beyond)

    @cached_property
    def neither(self) -> Bools:
        """Rows in which the engine says neither that the shapes meet nor that they do not."""
        return np.asarray((self.answers.hit != 0) & (self.answers.hit != 1))

    @property
    def world(self) -> World:
        """Where the shapes are."""
        return world_of(self.b)

    def hit_point(self) -> Proxy:
        """Points of the rays at the times of their hits, or where they start."""
        assert isinstance(self.a, Ray)
        named = (self.answers.hit == 1) & (np.abs(self.answers.t) < LARGEST)
        point = self.a.at(np.where(named, np.maximum(self.answers.t, 0.0), 0.0))
        return self.world.point(np.where((np.abs(point).max(axis=-1) < LARGEST)[:, None], point, self.a.origin))

    def claim(
        self,
        x: Proxy,
        y: Proxy,
        bounds: tuple[Array, Array],
        words: tuple[str, str],
        kind: str,
        made: Bools,
        margin: Array,
        cap: float | Array = np.inf,
        rounding: float | Array = 0.0,
        by_convention: bool = False,
        measures: Bools | None = None,
        kept: bool = False,
    ) -> Claim:
        """Make a claim for the rows that have an answer."""
        most, slack = (np.broadcast_to(np.asarray(v, dtype=np.float64), made.shape) for v in (cap, rounding))
        made = made & self.answered & ~self.unusable
        return Claim(x, y, *bounds, *words, kind, made, margin, most, slack, by_convention, measures, kept)

    @property
    def of_union(self) -> bool:
        """Whether one of the shapes is a union of convex pieces."""
        return isinstance(self.a, UNIONS) or isinstance(self.b, UNIONS)

    @property
    def _nothing(self) -> Array:
        return np.zeros(len(self.a))

    def _boolean_claim(self) -> Iterator[Claim]:
        hit = self.answers.hit
        if self.query in (BOOLEAN, CONTACTS):
            bounds = np.where(hit == 0, 0.0, -np.inf), np.where(hit == 1, 0.0, np.inf)
            margin, words = self.margin_a + self.margin_b, (MISSED, FALSE)
            yield self.claim(self.a, self.b, bounds, words, BOOL, ~np.isnan(hit), margin, kept=True)

    def _value_claims(self) -> Iterator[Claim]:
        answers, margin = self.answers, self.margin_a + self.margin_b
        value = answers.distance
        said = ~np.isnan(value)
        if self.query == CONTACTS:
            said &= answers.hit == 1
        waived = self.query == CONTACTS and bool(self.waived & OTHER_DEPTHS)
        some_depth = (value == -np.inf) & (Convention.NO_DEPTH in self.waived)
        bounds, words = (value, np.where(some_depth, 0.0, value)), (LONG, SHORT)
        finite = said & np.isfinite(value)
        yield self.claim(
            self.a, self.b, bounds, words, VALUE, said, margin, by_convention=waived, measures=finite, kept=True
        )
        directed = finite & np.isfinite(answers.normal).all(axis=-1)
        yield self.unit_claim(directed)  # moving along a normal that is too short also stops short
        yield from self._normal_claim(directed, margin)
        yield from self._witness_claims(finite)
        if self.query == CONTACTS:
            yield from self._contact_point_claims(finite)

    def _normal_claim(self, made: Bools, margin: Array) -> Iterator[Claim]:
        """Moving B back along the normal by the signed distance, or A forth, makes the two touch.

        Where unions overlap, the answer may be that of one pair of pieces, and others may overlap still.
        """
        normal = np.where(made[:, None], self.answers.normal, 0.0)
        move = -scale(np.where(made, self.answers.distance, 0.0), normal)
        made = made & (np.abs(move).max(axis=-1) < 1e150)
        zero, move = self._nothing, np.where(made[:, None], move, 0.0)
        low = np.where(self._of_a_piece(made, margin), -np.inf, zero)
        first_moves = is_fragile(self.b) and not is_fragile(self.a)
        before, way = (self.a, -move) if first_moves else (self.b, move)
        after, can_move = moved_by(before, way)
        x, y = (after, self.b) if first_moves else (self.a, after)
        made = made & can_move
        rounding = ROUNDING * (np.maximum(after.magnitude, before.magnitude) + np.abs(move).max(axis=-1))
        rounding = np.where(made, rounding * leverage(after), 0.0)
        waived = self.query == CONTACTS and Convention.OF_ONE_TRIANGLE in self.waived
        words = STUCK, OVERSHOT
        yield self.claim(x, y, (low, zero), words, VALUE, made, margin, rounding=rounding, by_convention=waived)

    def _of_a_piece(self, made: Bools, margin: Array) -> Bools:
        """Overlaps of unions whose depth may be meant for one pair of pieces.

        It is hardly more than the deepest pair has, or the engine does not promise it to be the least of the pair.
        """
        overlapping = made & self.answered & (self.answers.distance < 0)
        if self.ways_out or not self.of_union or not overlapping.any():
            return np.zeros(len(made), dtype=bool)
        if self.query == CONTACTS and self.waived & OTHER_DEPTHS:
            return overlapping
        _, most = kept(self.a, self.b, overlapping, enough=np.inf)
        deepest = margin - np.minimum(most, 0.0)
        slack = self._nothing if self.allowed is None else self.allowed
        return np.asarray(overlapping & (-self.answers.distance <= PIECE * deepest + slack))

    def unit_claim(self, made: Bools) -> Claim:
        """A normal has unit length, to single precision."""
        zero, origin, world = self._nothing, np.zeros_like(self.answers.normal), self.world
        tip = world.point(np.where(made[:, None], self.answers.normal, 0.0))
        unit_ball = world.rounded(origin, origin, zero + 1.0)
        return self.claim(tip, unit_ball, (zero, zero), (BRIEF, LENGTHY), LENGTH, made, zero)

    def _contact_point_claims(self, finite: Bools) -> Iterator[Claim]:
        """A single contact point is no farther from either shape than the depth, as both witnesses are."""
        depth = np.maximum(-self.answers.distance, 0.0)
        said = finite & np.isfinite(self.answers.point).all(axis=-1)
        point = self.world.point(np.where(said[:, None], self.answers.point, 0.0))
        bounds = np.full(len(said), -np.inf), np.where(said, depth, 0.0)
        for shape, margin in ((self.a, self.margin_a), (self.b, self.margin_b)):
            yield self.claim(point, tested(shape), bounds, ("", OUTSIDE), WITNESS, said, margin)

    def _witness_claims(self, finite: Bools) -> Iterator[Claim]:
        zero, answers = self._nothing, self.answers
        on_a, on_b = answers.on_a, answers.on_b
        said_a, said_b = (finite & np.isfinite(w).all(axis=-1) for w in (on_a, on_b))
        free = np.full(len(zero), -np.inf)
        for said, witness, shape, margin in (
            (said_a, on_a, self.a, self.margin_a),
            (said_b, on_b, self.b, self.margin_b),
        ):
            point = self.world.point(np.where(said[:, None], witness, 0.0))
            yield self.claim(point, tested(shape), (free, zero), ("", OFF_SHAPE), WITNESS, said, margin)
        both = said_a & said_b
        ball = np.where(both[:, None], on_b, 0.0)
        reach = np.where(both, np.abs(answers.distance), 0.0)
        yield self.claim(
            self.world.point(np.where(both[:, None], on_a, 0.0)),
            self.world.rounded(ball, ball, reach),
            (zero, zero),
            (TOGETHER, APART),
            WITNESS,
            both,
            zero,
        )

    def _ray_claims(self) -> Iterator[Claim]:
        ray, answers, zero, world = self.a, self.answers, self._nothing, self.world
        assert isinstance(ray, Ray)
        free = np.full(len(zero), -np.inf)
        hit, missed = answers.hit == 1, answers.hit == 0
        margin = self.margin_b
        reach = past(ray, self.b)
        usable = ~self.unusable
        reach = np.where(hit & usable & np.isfinite(answers.t), np.maximum(reach, answers.t), reach)
        end = ray.at(reach)
        whole, rounding = world.rounded(ray.origin, end, zero), rounding_of(ray.origin, end)
        yield self.claim(whole, self.b, (zero, -free), (RAY_MISSED, ""), BOOL, missed, margin, rounding=rounding)
        yield self.claim(whole, self.b, (free, zero), ("", RAY_FALSE), BOOL, hit, margin, rounding=rounding)
        point = self.hit_point().reference_point
        hit = hit & usable
        rounding = rounding_of(ray.origin, point)
        until = world.rounded(ray.origin, point, zero)
        way = norm(point - ray.origin)
        late, off = (RAY_LATE, ""), ("", RAY_OFF)
        yield self.claim(
            until, self.b, (zero, -free), late, VALUE, hit & (way > 0), margin, way, rounding, measures=hit
        )
        yield self.claim(
            world.point(point), self.b, (free, zero), off, VALUE, hit, margin, rounding=rounding, measures=hit
        )
        placed = hit & np.isfinite(answers.point).all(axis=-1)
        named_point = world.point(np.where((placed & usable)[:, None], answers.point, point))
        ball = world.rounded(point, point, zero)
        yield self.claim(named_point, ball, (free, zero), ("", RAY_POINT), WITNESS, placed, zero, rounding=rounding)
        normal = answers.normal
        named = hit & (answers.t > 0) & np.isfinite(normal).all(axis=-1) & (np.abs(normal).max(axis=-1) > 0)
        if self.of_union:  # in front of a face there may be another part of the solid
            named = np.zeros_like(named)
        outward = np.where(named[:, None], normal, world.up)
        size = np.maximum(ray.magnitude, self.b.magnitude)
        # two half-spaces overlap without end at the least tilt
        beyond = cube_on(point, outward, size) if isinstance(self.b, HalfSpace) else world.beyond(point, outward, size)
        if world is PLANE:  # its corners are rounded
            rounding = rounding + 4.0 * ROUNDING * size
        yield self.claim(beyond, self.b, (zero, -free), (TILTED, ""), WITNESS, named, margin, rounding=rounding)
        yield self.unit_claim(hit & (answers.t > 0) & np.isfinite(normal).all(axis=-1))
