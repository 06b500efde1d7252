"""Pairs of moving convex bodies: their gap along a direction, and how far it can bend off its chord.

Along a direction n, which may depend on the time, the gap is n·d − h_A(R_Aᵀn) − h_B(−R_Bᵀn), with d the way between the
pivots and h the support functions about them. Let n go from n0 at t0 straight to n1 at t1, at the rate n′. Then R_Aᵀn
is off the chord of its values at both ends by no more than (t − t0)(t1 − t)/2 times its greatest second derivative,
which is at right angles to w and at most ‖w‖‖w×n‖ + 2‖w×n′‖. With d linear in time, the second derivative of n·d is
2 n′·d′. Support functions are convex, and grow with their argument no faster than the body's core swings. So the gap
lies above the chord of its values g0 and g1 at the ends, less λ(1 − λ)(t1 − t0)²/2·bend, and it does not close between
them if √g0 + √g1 > (t1 − t0)·√(bend/2). A half-space has a gap along its own normal only, which turns with it: what
bends is then n·d, and what the other body sees of n.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from refimpl.linear import Array, Bools, cross, dot, norm, scale
from refimpl.pairs import ITERATIVE, TABLE
from refimpl.queries import distance
from refimpl.shapes import HalfSpace
from refimpl.supports import support_point
from refimpl.sweeps.rigid_bodies import Turning

ROUNDING = 2.0**-53
SEARCHED = 1e-12
"""Part of a scene's size by which the depth of a pair may be off that is answered by a search."""
UPWARDS = 1.0 + 1e-9


class State(NamedTuple):
    """A batch of pairs at some times.

    Attributes
    ----------
    distance : (n,)
        Signed distance.
    normal : (n, 3)
        From A to B.
    gap : (n,)
        What planes across the normal leave between the two for sure: positive only if they are apart.
    rate : (n,)
        Velocity of the witness points away from each other.
    point : (n, 3)
        Half way between the witness points.
    """

    distance: Array
    normal: Array
    gap: Array
    rate: Array
    point: Array


class Pairs(NamedTuple):
    """Pairs of bodies; half-spaces, which can be in the first place only, have a class of their own."""

    a: Turning
    b: Turning

    def at(self, index: Any) -> Pairs:
        """Pairs at `index`."""
        return type(self)(self.a[index], self.b[index])

    def between(self, t: Array) -> Array:
        """The way from A's pivot to B's."""
        start = self.b.motion.center - self.a.motion.center
        return np.asarray(start + scale(t, self.b.motion.linear - self.a.motion.linear))

    def farthest(self) -> Array:
        """Largest distance of the pivots."""
        n = len(self.a)
        return np.maximum(norm(self.between(np.zeros(n))), norm(self.between(np.ones(n))))

    def slack(self) -> Array:
        """More than rounding can add to a gap; a turn by many radians is off by their rounding."""
        turns = self.a.rate * self.a.reach + self.b.rate * self.b.reach
        return ROUNDING * (32.0 * (self.a.size + self.b.size + self.farthest()) + 8.0 * turns)

    def doubt(self) -> Array:
        """More than a signed distance may be off."""
        kinds = type(self.a.shape), type(self.b.shape)
        rule = TABLE[kinds if kinds in TABLE else kinds[::-1]]
        return self.slack() + (SEARCHED * (self.a.size + self.b.size) if rule.exactness == ITERATIVE else 0.0)

    def state(self, t: Array) -> State:
        """Distance and what goes with it at times t."""
        way = self.between(t)
        found = distance(self.a.placed(t), self.b.placed(t).translated(way))
        gap = self.gap(found.normal, t) - self.slack()
        return State(found.distance, found.normal, gap, *self._witnesses(t, found.normal, found.on_a, found.on_b))

    def _witnesses(self, t: Array, normal: Array, on_a: Array, on_b: Array) -> tuple[Array, Array]:
        """Rate of separation of two points of the bodies, and the place half way between them."""
        apart = self.b.velocity(on_b - self.between(t)) - self.a.velocity(on_a)
        return dot(normal, apart), self.a.pivot(t) + (on_a / 2 + on_b / 2)

    def gap(self, n: Array, t: Array) -> Array:
        """Gap between supporting planes across unit vectors n at times t, up to rounding."""
        return np.asarray(dot(n, self.between(t)) - self.a.height(n, t) - self.b.height(-n, t))

    def bend(self, n0: Array, n1: Array, t0: Array, t1: Array) -> Array:
        """Upper bound of how strongly the gap is bent, in lengths per square of time, as the direction goes to n1."""
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.where((n0 == n1).all(axis=-1)[..., None], 0.0, (n1 - n0) / (t1 - t0)[..., None])
        bends = 2.0 * np.abs(dot(change, self.b.motion.linear - self.a.motion.linear))
        for z in (self.a, self.b):
            w = z.motion.angular
            seen = z.rate * np.maximum(norm(cross(w, n0)), norm(cross(w, n1))) + 2.0 * norm(cross(w, change))
            bends = bends + seen * z.swing
        return np.asarray(bends * UPWARDS)

    def is_free(self, n0: Array, n1: Array, t0: Array, t1: Array, g0: Array, g1: Array) -> Bools:
        """Whether gaps g0 along n0 at t0 and g1 along n1 at t1 show that nothing touches in between."""
        reach = (t1 - t0) * np.sqrt(self.bend(n0, n1, t0, t1) / 2)
        roots = np.sqrt(np.maximum(g0, 0.0)) + np.sqrt(np.maximum(g1, 0.0))
        return (g0 > 0) & (g1 > 0) & (roots > reach * UPWARDS)


class Halves(Pairs):
    """Pairs whose first body is a half-space: all gaps are along its normal."""

    __slots__ = ()

    def slack(self) -> Array:
        """More than rounding can add to a gap: the direction itself is a rounded one."""
        return super().slack() + ROUNDING * 8.0 * self.a.rate * (self.b.reach + self.farthest())

    def state(self, t: Array) -> State:
        """Distance and what goes with it at times t."""
        n = self.a.outward(t)
        gap = self.gap(n, t)
        on_b = self.between(t) + self._lowest(n, t)
        on_a = on_b - scale(gap, n)
        return State(gap, n, gap - self.slack(), *self._witnesses(t, n, on_a, on_b))

    def _lowest(self, n: Array, t: Array) -> Array:
        return support_point(self.b.placed(t), -n)

    def gap(self, n: Array, t: Array) -> Array:
        """Gap along the half-space's normal."""
        n = self.a.outward(t)
        return np.asarray(dot(n, self.between(t)) - self.a.level - self._reach(n, t))

    def _reach(self, n: Array, t: Array) -> Array:
        return self.b.height(-n, t)

    def bend(self, n0: Array, n1: Array, t0: Array, t1: Array) -> Array:  # noqa: ARG002
        """Upper bound of the second derivative of n·d, and of the way of the direction that the other body sees."""
        spin, other, rate = self.a.motion.angular, self.b.motion.angular, self.b.rate
        n = self.a.outward(t0)
        turn = norm(cross(spin, n))
        still = rate * norm(cross(other, n)) * self.b.swing
        seen = ((self.a.rate + 2.0 * rate) * turn + rate * rate) * self.b.reach
        together = np.all(spin == other, axis=-1)
        return self._swaying(t0, t1) + UPWARDS * np.where(together, 0.0, np.where(turn == 0, still, seen))

    def _swaying(self, t0: Array, t1: Array) -> Array:
        """Upper bound of the second derivative of n·d."""
        spin = self.a.motion.angular
        turn = norm(cross(spin, self.a.outward(t0)))
        across = np.maximum(*(norm(cross(spin, self.between(t))) for t in (t0, t1)))
        return np.asarray(UPWARDS * turn * (across + 2.0 * norm(self.b.motion.linear - self.a.motion.linear)))


class Facing(Halves):
    """Pairs of half-spaces that face each other as long as they move."""

    __slots__ = ()

    def _lowest(self, n: Array, t: Array) -> Array:  # noqa: ARG002
        return scale(-self.b.level, n)

    def _reach(self, n: Array, t: Array) -> Array:  # noqa: ARG002
        return self.b.level

    def bend(self, n0: Array, n1: Array, t0: Array, t1: Array) -> Array:  # noqa: ARG002
        """Upper bound of the second derivative of n·d."""
        return self._swaying(t0, t1)


def paired(a: Turning, b: Turning) -> Pairs:
    """Pairs of the class that they need."""
    if isinstance(a.shape, HalfSpace):
        return (Facing if isinstance(b.shape, HalfSpace) else Halves)(a, b)
    return Pairs(a, b)
