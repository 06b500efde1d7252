"""Make certificates of the first contact of proxies in rigid motion.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.linear import Array
from refimpl.motions import Motion
from refimpl.proof.atoms import Atom, Directions, Unproven, atoms_of, near_pairs
from refimpl.proof.certify import certify
from refimpl.proof.claims import Claim, Part, Place, Separated, Split, Tree, Weights
from refimpl.proof.convex import plain
from refimpl.proof.planes import Planes
from refimpl.proof.points import Vector, exact, opposite, round_down, round_up
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.rigid import Boxes, Moment, Scene, Span, Spans, Touch, check_rigid
from refimpl.proof.rigid_bodies import moved_body, overlap
from refimpl.proof.rigid_poses import Pose
from refimpl.proof.rigid_reach import WAYS
from refimpl.proof.sweeps import SweepCertificate
from refimpl.proof.union_search import places_of
from refimpl.proof.unions import Mesh, Union
from refimpl.queries import distance
from refimpl.shapes import Composite, HalfSpace, Polyhedron, Proxy
from refimpl.sweeps import sweep
from refimpl.sweeps.rigid_bodies import turnable, turning
from refimpl.sweeps.rigid_march import March
from refimpl.sweeps.rigid_pairs import paired

UNION = Composite | Polyhedron
MOST_PAIRS = 4
"""So many pairs of atoms are tried."""
DEEPEST = 24
"""So often a span is halved before it is given up."""
NEARER, LEFT = 1 / 16, 1e-12
"""Part of the time up to the contact of unions that is left for later, where it cannot be done at once; and how little
of it may be left out."""
LATER = (0.0, 1e-12, 1e-11, 1e-10, 4e-10)
"""So much after the contact found in doubles an overlap is tried to be proven."""


@np.errstate(over="ignore", under="ignore", invalid="ignore")
def certify_rigid(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> SweepCertificate:
    """Prove from both sides when two single proxies in rigid motion first meet; see `certify_sweep`."""
    search = RigidSearch(a, b, motion_a, motion_b)
    claims = search.claims()
    lower, upper = check_rigid(SweepCertificate(claims), a, b, motion_a, motion_b)
    return SweepCertificate(claims, round_down(lower), round_up(upper) + 0.0)


class RigidSearch:
    """Two single proxies in motion, and what is proven about them."""

    def __init__(self, a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> None:
        self.shapes, self.motions = (a, b), (motion_a, motion_b)
        self.scene = Scene(self.shapes, self.motions)
        self.atoms = atoms_of(a), atoms_of(b)
        self.solids = Union(self.scene.parts[0]), Union(self.scene.parts[1])
        self.known: dict[float, Moment] = {}

    def claims(self) -> tuple[Any, ...]:
        """Claims about the contact at the start, or about spans without one and about the first one."""
        boxes = self._boxes()
        self.scene.boxes(boxes)
        given = (boxes,) if boxes.of_a or boxes.of_b else ()
        found = sweep(*self.shapes, *self.motions)
        if found.hit and found.t == 0:
            return (*given, *self._at_start())
        spans = self._spans(1.0 if not found.hit else float(found.t_lower), bool(found.hit))
        free = (Spans(tuple(spans), self._places()),) if spans else ()
        touch = self._touch(float(found.t)) if found.hit else ()
        return (*given, *free, *touch)

    # ----------------------------------------------------------------------------------------- spans

    def _spans(self, end: float, open_end: bool) -> list[Span]:
        """Spans from the start up to a time; up to 1 and then, unless the end is open."""
        found: list[Span] = []
        if open_end and any(isinstance(shape, UNION) for shape in self.shapes):
            with suppress(Unproven):
                found += self._nearer(0.0, end)
            return found
        times = [t for t in self._times(end) if 0 < t < end]
        for start, stop in zip([0.0, *times], [*times, end], strict=True):
            if stop <= start:
                continue
            try:
                found += self._between(start, stop, 0)
            except Unproven:
                return found
        if found and not open_end:
            last = Span(found[-1].before, found[-1].after, None)
            found[-1] = last
        return found

    def _nearer(self, start: float, end: float) -> Iterator[Span]:
        """Spans that lead to a contact of unions, ever shorter ones, for the planes hold the less long the nearer."""
        while (span := self._at_once(start, end)) is None:
            if end - start < LEFT:
                raise Unproven
            until = end - NEARER * (end - start)
            yield from self._between(start, until, 0)
            start = until
        yield span

    def _between(self, start: float, stop: float, depth: int) -> Iterator[Span]:
        """Spans that lead from one time to another."""
        span = self._at_once(start, stop)
        if span is not None:
            yield span
            return
        middle = start + (stop - start) / 2
        if depth > DEEPEST or not start < middle < stop:
            raise Unproven
        yield from self._between(start, middle, depth + 1)
        yield from self._between(middle, stop, depth + 1)

    def _at_once(self, start: float, stop: float) -> Span | None:
        """A single span from one time to another, where one is found."""
        ends, length = (self.moment(start), self.moment(stop)), Fraction(stop) - Fraction(start)
        for before, after in self._directions(start, stop):
            span = Span(self._tree(before, ends[0]), self._tree(after, ends[1]), stop)
            with suppress(InvalidCertificate):
                self.scene.stays_apart(span, ends, length)
                return span
        return None

    def moment(self, time: float) -> Moment:
        """Both sides at a time, exactly."""
        if time not in self.known:
            self.known[time] = self.scene.at(Fraction(time))
        return self.known[time]

    def _times(self, end: float) -> list[float]:
        """Times at which advancing has stopped."""
        if any(isinstance(shape, UNION) for shape in self.shapes):
            return []
        march = March(self._pairs(), np.array([end]), trail=[])
        march.run()
        assert march.trail is not None
        return sorted({float(t[0]) for t in march.trail})

    def _pairs(self) -> Any:
        (a, b), (one, other) = self.shapes, self.motions
        if isinstance(b, HalfSpace) and not isinstance(a, HalfSpace):
            a, b, one, other = b, a, other, one
        return paired(*(turning(s.broadcast_to((1,)), m.broadcast_to((1,))) for s, m in ((a, one), (b, other))))

    def _directions(self, start: float, stop: float) -> Iterator[tuple[Tree, Tree]]:
        """Pairs of trees to try, with directions in doubles."""
        if any(isinstance(shape, UNION) for shape in self.shapes):
            for time in (start + (stop - start) / 2, stop, start):
                tree = self._parted(time)
                if tree is not None:
                    yield tree, tree
            return
        n, m = self._normal(start), self._normal(stop)
        middle = n + m
        for first, last in ((n, m), (middle, middle), (m, m), (n, n)):
            if np.any(first) and np.any(last):
                yield Separated(_vector(first)), Separated(_vector(last))

    def _normal(self, time: float) -> Array:
        """Direction from A to B at a time."""
        turned = isinstance(self.shapes[1], HalfSpace) and not isinstance(self.shapes[0], HalfSpace)
        normal: Array = self._pairs().state(np.array([time])).normal[0]
        return -normal if turned else normal

    def _parted(self, time: float) -> Tree | None:
        """Tree of directions that part all atoms at a time."""
        try:
            return Directions(0.0, []).build(*self._placed(time))
        except Unproven:
            return None

    def _tree(self, tree: Tree, moment: Moment) -> Tree:
        """A tree as it is at a moment: half-spaces with their own normals, shares of planes across directions."""
        numbers = [list(range(len(atoms))) for atoms in self.atoms]
        return self._filled(tree, moment, numbers)

    def _filled(self, tree: Tree, moment: Moment, groups: Sequence[Sequence[int]]) -> Tree:
        if isinstance(tree, Split):
            first = set(tree.first)
            parted = [[i for i in groups[tree.side] if (i in first) == inside] for inside in (True, False)]
            one, other = (
                self._filled(branch, moment, [part, groups[1]] if tree.side == 0 else [groups[0], part])
                for branch, part in zip(tree.branches, parted, strict=True)
            )
            return Split(tree.side, tree.first, (one, other))
        n = self._own_normal(moment, groups) or plain(tree.n)
        faces = [self._faces(side, group, n, moment.poses[side]) for side, group in enumerate(groups)]
        return Separated(n, None, (faces[0], faces[1]))

    def _own_normal(self, moment: Moment, groups: Sequence[Sequence[int]]) -> Vector | None:
        """Normal of the half-space among some atoms, from A to B."""
        for side, group in enumerate(groups):
            for i in group:
                if self.atoms[side][i].is_space:
                    atom: Any = moment.sides[side].atoms[i]
                    normal: Vector = tuple(atom.planes[0][0])
                    return normal if side == 0 else opposite(normal)
        return None

    def _faces(self, side: int, group: Sequence[int], n: Vector, pose: Pose) -> tuple[tuple[int, Weights], ...]:
        way = exact(n) if side == 0 else opposite(exact(n))
        bounded = ((i, self.atoms[side][i].body) for i in group if self.atoms[side][i].corners is None)
        return tuple((i, moved_body(body, pose).faces(way)) for i, body in bounded if isinstance(body, Planes))

    def _boxes(self) -> Boxes:
        """Shares of planes across the axes."""
        of: list[tuple[Any, ...]] = []
        for atoms in self.atoms:
            bounded = ((i, atom.body) for i, atom in enumerate(atoms) if atom.corners is None)
            of.append(
                tuple((i, tuple(body.faces(exact(n)) for n in WAYS)) for i, body in bounded if isinstance(body, Planes))
            )
        return Boxes(*of)

    def _places(self) -> tuple[tuple[Place, ...], tuple[Place, ...]]:
        """Points of the convex parts, where the other side has a mesh."""
        one, other = (places_of(shape) for shape in self.shapes)
        meshes = [any(isinstance(part, Mesh) for part in parts) for parts in self.scene.parts]
        return one if meshes[1] else (), other if meshes[0] else ()

    # --------------------------------------------------------------------------------------- contact

    def _at_start(self) -> tuple[Touch, ...]:
        """The claim that they overlap from the start."""
        claims = (Touch(0.0, claim) for claim in certify(*self.shapes).claims)
        return next(((claim,) for claim in claims if self._holds(claim)), ())

    def _holds(self, claim: Touch) -> bool:
        try:
            self.scene.touch(claim)
        except InvalidCertificate:
            return False
        return True

    def _touch(self, time: float) -> tuple[Touch, ...]:
        """The claim that they overlap at a time, or soon after."""
        for later in LATER:
            soon = min(time + later, 1.0)
            for claim in self._overlaps(soon):
                if self._holds(found := Touch(soon, claim)):
                    return (found,)
        return ()

    def _overlaps(self, time: float) -> Iterator[Claim]:
        """Claims that atoms are in each other at a time, the deepest first."""
        moment = self.moment(time)
        for i, j in self._deepest(time):
            atoms = self.atoms[0][i], self.atoms[1][j]
            solids: Any = self.solids[0].atoms[i], self.solids[1].atoms[j]
            claim: Any = overlap(atoms, moment.poses, solids)
            if claim is not None:
                of = [None if len(self.atoms[side]) == 1 else k for side, k in enumerate((i, j))]
                yield claim if of == [None, None] else Part(of[0], of[1], claim)

    def _deepest(self, time: float) -> list[tuple[int, int]]:
        """Pairs of atoms that overlap most at a time."""
        if len(self.atoms[0]) == len(self.atoms[1]) == 1:
            return [(0, 0)]
        one, other = self._placed(time)
        size = 1e-9 * float(max(shape.magnitude for shape in self.shapes))
        found = [
            (float(distance(one[i].shape, other[j].shape).distance), i, j) for i, j in near_pairs(one, other, size)
        ]
        return [(i, j) for depth, i, j in sorted(found)[:MOST_PAIRS] if depth <= 0]

    def _placed(self, time: float) -> tuple[list[Atom], list[Atom]]:
        """Atoms at a time, in doubles."""
        one, other = (m.placed(_turnable(s), time) for s, m in zip(self.shapes, self.motions, strict=True))
        return atoms_of(one), atoms_of(other)


def _turnable(shape: Proxy) -> Proxy:
    """The same set of a type that can be turned, part by part."""
    if isinstance(shape, Composite):
        return Composite([_turnable(part) for part in shape.parts])
    return shape if isinstance(shape, Polyhedron) else turnable(shape)


def _vector(n: Any) -> Vector:
    x, y, z = np.asarray(n, dtype=np.float64).tolist()
    return plain((x, y, z))
