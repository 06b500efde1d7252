"""Claims about unions: trees of directions for the lower bound, a pair of convex parts for the upper.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain, islice
from typing import Any, NamedTuple

import numpy as np

from refimpl.linear import rotation_matrix
from refimpl.proof.atoms import (
    Atom,
    Directions,
    Floats,
    Group,
    Unproven,
    atoms_of,
    boxes_of,
    near_pairs,
    parts_of,
)
from refimpl.proof.bodies import Corners
from refimpl.proof.checker import check
from refimpl.proof.claims import Certificate, Claim, Core, Cover, Part, Piece, Place, Weights
from refimpl.proof.convex import convex_claims, reference
from refimpl.proof.mirror import mirrored
from refimpl.proof.points import Vector
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.search import Grid, deepest
from refimpl.proof.simple import simple_claims
from refimpl.proof.times import SIMPLE, proven
from refimpl.shapes import AABB, Box, ConvexPolyhedron, HalfSpace, Point, Polyhedron, Proxy, Sphere

TIGHT = 2.0**-44  # relative to the scene: how much narrower than the upper bound the lower may be asked for
DEEPEST = 2  # pairs of pieces that are proven
AT_CENTRE: Weights = ((0, 1),)
PAIRS = 40  # of atoms or pieces, that are looked at exactly
DRAWN = 1e-13  # relative: how far a piece's corners are drawn in from the surface of its mesh
STRETCHES = (
    1e-15,
    1e-13,
    1e-12,
    1e-10,
    1e-8,
    1e-6,
    1e-4,
    1e-2,
)  # relative to the scene: longer than a translation that separates


class Choice(NamedTuple):
    """A convex part of a union: how a claim says it, and the proxy that it is."""

    of: Any
    shape: Proxy


def union_claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    """Make a claim for each side, where one is found."""
    size = max(float(a.magnitude), float(b.magnitude))
    guess = reference(a, b)
    sigma = float(guess.distance) if guess is not None else math.inf
    normal: Vector | None = tuple(guess.normal.tolist()) if guess is not None else None
    upper = _nearest(a, b, guess, size) if sigma > 0 else _overlapping(a, b, -sigma * np.array(normal), size)
    found: list[Claim] = [upper[1]] if upper else []
    guesses = [normal] if normal and any(normal) else []
    covers: Iterator[Cover] = _moved(a, b, sigma, normal, size)
    if upper and upper[0] > 0:
        least = max(float(upper[0]) - TIGHT * size, 0.5 * float(upper[0]))
        covers = chain(_covers(a, b, np.zeros(3), least, guesses), covers)
    found += islice((cover for cover in covers if _holds(cover, a, b)), 1)
    return tuple(found)


def _holds(claim: Claim, a: Proxy, b: Proxy) -> bool:
    try:
        check(Certificate((claim,)), a, b)
    except InvalidCertificate:
        return False
    return True


# ---------------------------------------------------------------------------------------- lower bounds


def _covers(a: Proxy, b: Proxy, shift: Floats, least: float, guesses: Sequence[Vector]) -> Iterator[Cover]:
    """Proof that all atoms are at least so far apart, B moved by `shift`."""
    try:
        tree = Directions(least, guesses).build(atoms_of(a), atoms_of(b, shift))
    except Unproven:
        return
    x, y, z = shift.tolist()
    yield Cover(tree, (x, y, z), (places_of(a), places_of(b)))


def places_of(shape: Proxy) -> tuple[Place, ...]:
    """A point of each convex part."""
    return tuple(_inner(part) for part in parts_of(shape) if not isinstance(part, Polyhedron))


def _inner(part: Proxy) -> Place:
    """A point that lies inside in spite of rounding."""
    x, y, z = part.reference_point.tolist()
    core = Atom(0, part).body
    if isinstance(part, HalfSpace):
        n = part.normal / float(np.max(np.abs(part.normal)))
        x, y, z = (part.reference_point - 1e-6 * max(abs(x), abs(y), abs(z)) * n).tolist()
    elif isinstance(core, Corners) and not isinstance(part, AABB | Box):
        return core.place(core.corner(0), [(0, 1)])
    return x, y, z


def _moved(a: Proxy, b: Proxy, sigma: float, normal: Vector | None, size: float) -> Iterator[Cover]:
    """Translations that separate: the reference's, a little longer; then those that separate the hulls."""
    if normal is not None and math.isfinite(sigma):
        for stretch in STRETCHES:
            shift = (max(-sigma, 0.0) + stretch * size) * np.array(normal)
            yield from _covers(a, b, shift, 0.25 * stretch * size, [normal])
    spaces = any(atom.is_space for atom in (*atoms_of(a), *atoms_of(b)))
    if spaces:
        return
    one, other = Group(atoms_of(a)), Group(atoms_of(b))
    for n in deepest(Grid(one, other)).normals:
        largest = max(abs(c) for c in n)
        way = np.array([float(Fraction(c, largest)) for c in n])
        way /= math.sqrt(way @ way)
        unit: Vector = tuple(way.tolist())
        back: Vector = tuple((-way).tolist())
        depth = way @ (np.array(one.support(unit)[0]) - np.array(other.support(back)[0]))
        yield from _covers(a, b, (float(depth) + 1e-12 * size) * way, 0.25e-12 * size, [unit])


# ---------------------------------------------------------------------------------------- upper bounds


def _best(pairs: Iterable[tuple[Choice, Choice]]) -> tuple[Any, Part] | None:
    """The pair of convex parts that proves the least upper bound."""
    found = []
    for one, other in pairs:
        for claim in _convex(one.shape, other.shape):
            bound = proven(claim, one.shape, other.shape)[1]
            if bound < math.inf:
                found.append((bound, Part(one.of, other.of, claim)))
    return min(found, key=lambda pair: pair[0], default=None)


def _convex(a: Proxy, b: Proxy) -> tuple[Any, ...]:
    """Claims about two convex parts."""
    if isinstance(b, HalfSpace) and not isinstance(a, HalfSpace):
        return mirrored(Certificate(_convex(b, a))).claims
    return simple_claims(a, b) if isinstance(a, SIMPLE) and isinstance(b, SIMPLE) else convex_claims(a, b)


def _nearest(a: Proxy, b: Proxy, guess: Any, size: float) -> tuple[Any, Part] | None:
    """The nearest pair of atoms: among those at the reference's witness points, or else in the nearest boxes."""
    of_a, of_b = atoms_of(a), atoms_of(b)
    if guess is not None and guess.distance > 0:
        near = [(i, j) for i in _around(of_a, guess.on_a, size) for j in _around(of_b, guess.on_b, size)]
    else:
        near = near_pairs(of_a, of_b, 0.0)
    if len(near) > PAIRS:
        near = sorted(near, key=lambda pair: _distance(of_a[pair[0]].shape, of_b[pair[1]].shape))
    return _best((Choice(i, of_a[i].shape), Choice(j, of_b[j].shape)) for i, j in near[:PAIRS])


def _around(atoms: Sequence[Atom], point: Floats, size: float) -> list[int]:
    """Atoms whose boxes hold a point, or nearly."""
    low, high = boxes_of(atoms)
    beyond = np.max(np.maximum(low - point, point - high), axis=1)
    return [int(i) for i in np.nonzero(beyond <= 1e-9 * size)[0]]


def _distance(one: Proxy, other: Proxy) -> float:
    found = reference(one, other)
    return float(found.distance) if found is not None else math.inf


def _overlapping(a: Proxy, b: Proxy, move: Floats, size: float) -> tuple[Any, Part] | None:
    """The deepest pair of convex parts and pieces."""
    depth = math.sqrt(move @ move)
    of_a, of_b = _solids(a), _solids(b)
    pairs = [(of_a[i], of_b[j]) for i, j in _by_overlap(of_a, of_b)]
    ranked = sorted((_distance(p.shape, q.shape), i) for i, (p, q) in enumerate(pairs))
    chosen = [pairs[i] for rank, i in ranked[:DEEPEST] if rank <= 0]
    found = [pair for pair in _balls(a, b, depth) if _holds(pair[1], a, b)]
    best = _best(_drawn_pairs(chosen, size))
    if best is not None and _holds(best[1], a, b):
        found.append(best)
    return min(found, key=lambda pair: pair[0]) if found else _nearest(a, b, None, size)


def _by_overlap(of_a: Sequence[Choice], of_b: Sequence[Choice]) -> list[tuple[int, int]]:
    """Pairs whose boxes overlap, the most first, as many as are looked at."""
    (low_a, high_a), (low_b, high_b) = (boxes_of([_as_atom(choice) for choice in side]) for side in (of_a, of_b))
    common = np.minimum(high_a[:, None], high_b[None]) - np.maximum(low_a[:, None], low_b[None])
    depth = np.min(common, axis=2)
    order = np.argsort(-depth, axis=None, kind="stable")[:PAIRS]
    found = [(int(k) // len(of_b), int(k) % len(of_b)) for k in order]
    return [(i, j) for i, j in found if depth[i, j] >= 0]


def _as_atom(choice: Choice) -> Atom:
    found = Atom(0, choice.shape)
    if isinstance(choice.of, tuple):
        found.corners = choice.of[1].corners
    return found


class _Rough(NamedTuple):
    """A piece of a mesh, not yet drawn in from its surface."""

    mesh: Polyhedron
    corners: Floats


def _solids(shape: Proxy) -> list[Choice]:
    """Convex parts, and pieces of meshes."""
    found: list[Choice] = []
    count = 0
    for k, part in enumerate(parts_of(shape)):
        if not isinstance(part, Polyhedron):
            found.append(Choice(count, part))
            count += 1
            continue
        count += len(part.triangles)
        matrix = rotation_matrix(part.rotation)
        for piece in part.pieces:
            world = piece.vertices @ matrix.T + part.position
            found.append(Choice((k, _Rough(part, world)), ConvexPolyhedron.from_vertices(world)))
    return found


def _drawn_pairs(pairs: Sequence[tuple[Choice, Choice]], size: float) -> Iterator[tuple[Choice, Choice]]:
    """Pairs of parts and pieces, these drawn in; without pieces too thin to be proven to lie inside."""
    for p, q in pairs:
        try:
            yield _drawn(p, size), _drawn(q, size)
        except Unproven:
            continue


def _drawn(choice: Choice, size: float, inner: Floats | None = None) -> Choice:
    """A rough piece as one that a claim can prove to lie inside its mesh: drawn in a little."""
    if not isinstance(choice.of, tuple):
        return choice
    number, rough = choice.of
    middle = rough.corners.mean(axis=0) if inner is None else inner
    reach = max(float(np.min(np.ptp(rough.corners, axis=0))), 1e-6 * size)
    drawn = middle + (1 - DRAWN * size / reach) * (rough.corners - middle)
    return Choice((number, _piece(rough.mesh, drawn)), ConvexPolyhedron.from_vertices(drawn))


def _piece(mesh: Polyhedron, corners: Floats) -> Piece:
    itself = Atom(0, ConvexPolyhedron.from_vertices(corners))
    tree = Directions(0.0, []).build([itself], atoms_of(mesh))
    rows = [tuple(row) for row in corners.tolist()]
    return Piece(tuple((x, y, z) for x, y, z in rows), tree)


def ball(mesh: Polyhedron, centre: Vector, radius: float) -> Piece:
    """A ball in a mesh, if it lies there."""
    itself = Atom(0, Sphere(centre, radius))
    return Piece((centre,), Directions(0.0, []).build([itself], atoms_of(mesh)), radius)


def _balls(a: Proxy, b: Proxy, depth: float) -> Iterator[tuple[Any, Part]]:
    """A point or a ball within a mesh: as deep as the surface is far from its centre."""
    for mesh, other, swap in ((a, b, False), (b, a, True)):
        if not isinstance(mesh, Polyhedron) or not isinstance(other, Point | Sphere):
            continue
        centre: Vector = tuple(other.reference_point.tolist())
        own = float(getattr(other, "radius", 0.0))
        radius = (depth - own) * (1 - 1e-12)
        if radius > 0:
            try:
                piece = ball(mesh, centre, radius)
            except Unproven:
                continue
            here: tuple[Place, Place] = (AT_CENTRE, centre)
            if swap:
                yield -radius - own, Part(None, (0, piece), Core((here[::-1],)))
            else:
                yield -radius - own, Part((0, piece), None, Core((here,)))


def around(shape: Proxy, point: Vector) -> Iterator[tuple[Any, Place | None]]:
    """Convex parts that hold a point, balls in meshes around it, and how a claim says the point."""
    count = 0
    for k, part in enumerate(parts_of(shape)):
        distance = _distance(Point(point), part)
        if not isinstance(part, Polyhedron):
            if distance <= 0:
                yield count, None
            count += 1
            continue
        count += len(part.triangles)
        if distance < 0:
            try:
                piece = ball(part, point, -0.5 * distance)
            except Unproven:
                continue
            yield (k, piece), AT_CENTRE
