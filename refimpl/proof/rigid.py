"""Check when two proxies in rigid motion first meet, in exact arithmetic: part of what has to be believed.

On a span of time planes across n0 keep an atom of A and one of B apart at its start, planes across n1 at its end, and
in between those across what goes straight from n0 to n1. Seen from the body, such a direction is off the straight way
between its ends by no more than λ(1 − λ)·S²/2·(‖w‖‖w×n‖ + 2‖w×n′‖), at right angles to the axis w, where S is how long
the span is and n′ = (n1 − n0)/S. The support function about the pivot is convex and grows no faster than the body's
core swings about the axis; the way between the pivots is linear in time. So the gap between the planes stays above
(1 − λ)·g0 + λ·g1 − λ(1 − λ)·bend, and does not close if √g0 + √g1 ≥ √bend.

A half-space has planes across its own normal only, which turns with it. The way d between the pivots along it then has
a second derivative of ‖u×n‖(‖u×d‖ + 2‖d′‖) at most, if u is the half-space's angular velocity; and the other body sees
the normal turn with (‖u‖ + 2‖w‖)‖u×n‖ + ‖w‖², or ‖w‖‖w×n‖ if it does not turn, or not at all if both turn alike.

Poses at a time are rational, and off by a known angle at most: gaps are less by that times the bodies' reach.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from refimpl.proof.bounds import bounds_of
from refimpl.proof.claims import Bound, Claim, Part, Place, Tree
from refimpl.proof.gaps import Gap, Numbers, Sides, leaves, require_outside
from refimpl.proof.rational import effort, items, rational, require, spend
from refimpl.proof.rigid_poses import Course, Pose, course, moved, pose_at
from refimpl.proof.rigid_reach import Reach, SixShares, reaches
from refimpl.proof.sets import Line, Planes
from refimpl.proof.sweeps import SweepCertificate
from refimpl.proof.unions import Union, parts_of
from refimpl.proof.vectors import NONE, Exact, cross, dot, minus, root, times

EFFORT, EFFORT_PER_ITEM = 1 << 25, 1 << 12
"""How much a certificate may ask for, some ten seconds of work; and more for every number of large shapes."""


@dataclass(frozen=True)
class Span:
    """No contact until a time, from where the span before ended; with None, until 1 and then.

    `before` are planes between all atoms of A and B at the start of the span, as in a `Cover`, and `after` at its end:
    trees of the same form, whose directions may differ.
    """

    before: Tree
    after: Tree
    until: Fraction | float | None = None


@dataclass(frozen=True)
class Spans:
    """No contact until the end of the last span. `places` are as in a `Cover`, for the start."""

    spans: tuple[Span, ...]
    places: tuple[tuple[Place, ...], tuple[Place, ...]] = ((), ())


@dataclass(frozen=True)
class Boxes:
    """Shares of the planes of bounded atoms that are given by planes, across x, y, z, −x, −y, −z: so far they reach."""

    of_a: tuple[tuple[int, SixShares], ...] = ()
    of_b: tuple[tuple[int, SixShares], ...] = ()


@dataclass(frozen=True)
class Touch:
    """Contact at a time, as `claim` proves that the proxies are then deeper in each other than their poses are off."""

    time: Fraction | float
    claim: Claim


class Moment(NamedTuple):
    """Both sides at a time, their poses, and the way between their pivots."""

    sides: Sides
    poses: tuple[Pose, Pose]
    way: Exact


def check_rigid(
    certificate: SweepCertificate, a: Any, b: Any, motion_a: Any = None, motion_b: Any = None
) -> tuple[Bound, Bound]:
    """Prove bounds on the time from 0 to 1 when two single proxies in rigid motion first meet; see `check_sweep`."""
    with effort(1 << 62) as spent:
        scene = Scene((a, b), (motion_a, motion_b))
        size = spent()
    with effort(EFFORT + EFFORT_PER_ITEM * size):
        lower: Bound = NONE
        upper: Bound = math.inf
        for claim in items(certificate.claims, "claims"):
            spend(128)
            if isinstance(claim, Boxes):
                scene.boxes(claim)
            elif isinstance(claim, Spans):
                lower = max(lower, scene.free(claim))
            else:
                upper = min(upper, scene.touch(claim if isinstance(claim, Touch) else Touch(0.0, claim)))
    require(lower <= upper, "the claims contradict each other")
    return lower, upper


def _long(v: Exact) -> Fraction:
    """At least the length of a vector."""
    return root(Fraction(dot(v, v)))[1]


def is_space(atom: Any) -> bool:
    """Whether an atom is a half-space."""
    return isinstance(atom, Planes) and len(atom.planes) == 1


class Scene:
    """Two proxies in motion."""

    def __init__(self, shapes: tuple[Any, Any], motions: tuple[Any, Any]) -> None:
        self.parts = parts_of(shapes[0]), parts_of(shapes[1])
        require(not any(isinstance(part, Line) for parts in self.parts for part in parts), "a ray does not move")
        self.courses: tuple[Course, Course] = course(motions[0]), course(motions[1])
        self.rates = tuple(_long(motion.angular) for motion in self.courses)
        self.way = minus(self.courses[1].linear, self.courses[0].linear)  # per unit of time
        self.boxes(Boxes())

    def boxes(self, claim: Boxes) -> None:
        """Learn how far all bounded atoms reach from their pivots, and how fast they swing."""
        self.reach: list[list[Reach | None]] = [
            reaches(Union(parts), motion, given)
            for parts, motion, given in zip(self.parts, self.courses, (claim.of_a, claim.of_b), strict=True)
        ]

    def at(self, time: Fraction) -> Moment:
        """Both sides at a time."""
        one, other = (pose_at(motion, time) for motion in self.courses)
        sides = moved(self.parts[0], one), moved(self.parts[1], other)  # type: ignore[arg-type]
        return Moment(sides, (one, other), minus(other.place, one.place))

    def free(self, claim: Spans) -> Bound:
        """End of the last span, ∞ where it leaves no time to meet."""
        time, moment, last = NONE, self.at(NONE), False
        require_outside(moment.sides, claim.places)
        for span in items(claim.spans, "spans"):
            require(isinstance(span, Span) and not last, "spans: not one, or one after the last")
            last = span.until is None
            end = Fraction(1) if last else rational(span.until, "until")
            require(time < end <= 1, "until: before the start, or after the end")
            following = self.at(end)
            self.stays_apart(span, (moment, following), end - time)
            time, moment = end, following
        return math.inf if last else time

    def stays_apart(self, span: Span, ends: tuple[Moment, Moment], length: Fraction) -> None:
        """Refuse planes that do not keep all atoms apart on a span."""
        both = [list(leaves(tree, moment.sides)) for tree, moment in zip((span.before, span.after), ends, strict=True)]
        require(len(both[0]) == len(both[1]), "before, after: not of the same form")
        for (one, groups), (other, same) in zip(*both, strict=True):
            require([list(g) for g in groups] == [list(g) for g in same], "before, after: not of the same form")
            spend(256)
            gaps = Gap(one, ends[0].sides, groups), Gap(other, ends[1].sides, groups)
            spaces = [any(is_space(ends[0].sides[k].atoms[i]) for i in group) for k, group in enumerate(groups)]
            if any(spaces):
                alone = all(len(group) == 1 for group, space in zip(groups, spaces, strict=True) if space)
                require(alone, "n: a half-space is parted alone")
                first, last, bend = self._along_normal(gaps, groups, ends, length, spaces)
            else:
                first, last, bend = self._straight(gaps, groups, ends, length)
            require(first > 0 and (last > 0 or (last == 0 and span.until is not None)), "n: the planes leave no gap")
            rest = bend - first - last
            require(rest <= 0 or rest * rest < 4 * first * last, "until: the gap may close on the way")

    def _within(self, side: int, group: Numbers) -> Reach:
        """How far the atoms of a group reach, and how fast they swing, at most."""
        found = [self.reach[side][i] for i in group]
        known = [reach for reach in found if reach is not None]
        require(len(known) == len(found), "boxes: an atom of which it is not known how far it reaches")
        return Reach(max(reach.far for reach in known), max(reach.fast for reach in known))

    def _straight(
        self, gaps: tuple[Gap, Gap], groups: Sequence[Numbers], ends: tuple[Moment, Moment], length: Fraction
    ) -> tuple[Fraction, Fraction, Fraction]:
        """Gaps at the ends of a span along two directions of about unit length, and how far those between may bend."""
        within = [self._within(side, group) for side, group in enumerate(groups)]
        rooms, ways = [], []
        for gap, moment in zip(gaps, ends, strict=True):
            low, high = root(Fraction(dot(gap.n, gap.n)))
            off = sum((pose.error * reach.far for pose, reach in zip(moment.poses, within, strict=True)), NONE)
            rooms.append(gap.room / low - (gap.radius + off) * (high / low))
            ways.append(times(1 / low, gap.n))
        change = minus(ways[1], ways[0])
        bend = length * abs(dot(change, self.way))
        for motion, rate, reach in zip(self.courses, self.rates, within, strict=True):
            if rate:
                turn = max(_long(cross(motion.angular, n)) for n in ways)
                bend += length * length / 2 * turn * reach.fast
                bend += length * _long(cross(motion.angular, change)) * reach.fast / rate
        return rooms[0], rooms[1], bend

    def _along_normal(
        self,
        gaps: tuple[Gap, Gap],
        groups: Sequence[Numbers],
        ends: tuple[Moment, Moment],
        length: Fraction,
        spaces: Sequence[bool],
    ) -> tuple[Fraction, Fraction, Fraction]:
        """The same along a half-space's normal, which turns with it."""
        half = 0 if spaces[0] else 1
        u, w, n = self.courses[half].angular, self.courses[1 - half].angular, gaps[0].n
        size = root(Fraction(dot(n, n)))[0]
        turn, other = _long(cross(u, n)) / size, _long(cross(w, n)) / size
        seen = reach = NONE
        if all(spaces):
            require(list(u) == list(w) or not turn + other, "n: half-spaces that do not stay facing each other")
        else:
            within = self._within(1 - half, groups[1 - half])
            reach = within.far
            if not turn:
                seen = other * within.fast
            elif list(u) != list(w):
                rate = self.rates[1 - half]
                seen = ((self.rates[half] + 2 * rate) * turn + rate * rate) * reach
        across = max(_long(cross(u, moment.way)) for moment in ends)
        sway = turn * (across + 2 * _long(self.way))
        rooms = [gap.width - self._off(moment, half, reach) for gap, moment in zip(gaps, ends, strict=True)]
        return rooms[0], rooms[1], length * length / 2 * (sway + seen)

    def _off(self, moment: Moment, half: int, reach: Fraction) -> Fraction:
        """How far a gap may be off along a half-space's normal: by the pose of that, and of what reaches so far."""
        errors = moment.poses[half].error, moment.poses[1 - half].error
        return errors[0] * (_long(moment.way) + reach) + errors[1] * reach

    def touch(self, claim: Touch) -> Bound:
        """Time of a contact."""
        time = rational(claim.time, "time")
        require(0 <= time <= 1, "time: not from 0 to 1")
        moment = self.at(time)
        bound = bounds_of(claim.claim, moment.sides)[1]
        ofs = (claim.claim.of_a, claim.claim.of_b) if isinstance(claim.claim, Part) else (None, None)
        groups = [_taken(side, of) for side, of in zip(moment.sides, ofs, strict=True)]
        spaces = [is_space(side.atoms[group[0]]) for side, group in zip(moment.sides, groups, strict=True)]
        far = [NONE if space else self._within(i, groups[i]).far for i, space in enumerate(spaces)]
        if all(spaces):
            self._facing(moment, groups, bound)
        if any(spaces):
            half = 0 if spaces[0] else 1
            off = self._off(moment, half, far[1 - half])
        else:
            off = sum((pose.error * reach for pose, reach in zip(moment.poses, far, strict=True)), NONE)
        require(bound <= -off, "time: not proven to touch then")
        return time

    def _facing(self, moment: Moment, groups: Sequence[Numbers], bound: Bound) -> None:
        """Refuse half-spaces that overlap only if their normals are not where their poses say."""
        atoms: list[Any] = [side.atoms[group[0]] for side, group in zip(moment.sides, groups, strict=True)]
        n, m = (atom.planes[0][0] for atom in atoms)
        error = moment.poses[0].error + moment.poses[1].error
        tilted = dot(cross(n, m), cross(n, m)) > error * error * dot(n, n) * dot(m, m)
        u, w = (motion.angular for motion in self.courses)
        together = list(u) == list(w) or not any([*cross(u, n), *cross(w, m)])
        require(tilted or (together and bound > -math.inf), "time: half-spaces that may face each other")


def _taken(side: Union, of: Any) -> Numbers:
    """Atoms that reach as far as what a claim takes: itself, or for a piece of a mesh all that are bounded."""
    if of is None:
        side.alone()
        return [0]
    if type(of) is int:
        return [of]
    return [i for i, atom in enumerate(side.atoms) if not is_space(atom)]
