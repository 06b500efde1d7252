"""Convex bodies where a pose takes them, exactly, for the search of claims about a moment of a motion.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.proof.atoms import Atom
from refimpl.proof.bodies import Body, Corners, Curved
from refimpl.proof.claims import Certificate, Claim, Common, Core, Inscribed, Near
from refimpl.proof.convex import Search
from refimpl.proof.exact import features
from refimpl.proof.mirror import mirrored
from refimpl.proof.planes import Planes
from refimpl.proof.points import Vector, along, dot, doubles, exact
from refimpl.proof.rigid_poses import Pose, moved
from refimpl.proof.sets import Solid
from refimpl.proof.unions import Union
from refimpl.proof.vectors import minus
from refimpl.shapes import HalfSpace, Proxy


def _three(v: Any) -> Vector:
    x, y, z = v
    return x, y, z


def moved_body(body: Body, pose: Pose) -> Body:
    """A body where a pose takes it."""

    def carried(point: Vector) -> Vector:
        return _three(pose.carried(point))

    if isinstance(body, Corners):
        found = copy(body)
        found.corners = [carried(corner) for corner in body.corners]
        found.floats = np.array([doubles(corner) for corner in found.corners])
        found.flat = [_three(pose.turned(n)) for n in body.flat]
        if isinstance(found, Planes):
            found.position = carried(found.position)
            found.columns = [_three(pose.turned(column)) for column in found.columns]
            found.middle = found.floats.mean(axis=0).tolist()
        return found
    if isinstance(body, Curved):
        centre, axes = body.exact
        return Curved(carried(centre), [_three(pose.turned(axis)) for axis in axes], body.flat)
    return body


def moved_space(half: HalfSpace, pose: Pose) -> HalfSpace:
    """A half-space where a pose takes it, in exact numbers."""
    n, k = [Fraction(x) for x in half.normal.tolist()], Fraction(half.k.tolist())
    normal = pose.turned(n)
    offset = k + dot(_three(n), _three(pose.center)) - dot(_three(normal), _three(pose.place))
    fields: tuple[Any, Any] = np.array(normal, dtype=object), np.array(offset, dtype=object)
    return HalfSpace._trusted(*fields)


class MovedSearch(Search):
    """Two convex atoms at a moment, and the best claims about them so far; a half-space comes first."""

    def __init__(self, atoms: Sequence[Atom], poses: Sequence[Pose], solids: Sequence[Solid]) -> None:
        one, other = (
            moved_space(atom.shape, pose) if isinstance(atom.shape, HalfSpace) else atom.shape
            for atom, pose in zip(atoms, poses, strict=True)
        )
        self.shapes: tuple[Proxy, Proxy] = one, other
        self.solids = Union([solids[0]]), Union([solids[1]])
        self.bodies = moved_body(atoms[0].body, poses[0]), moved_body(atoms[1].body, poses[1])
        self.radius = self.bodies[0].radius + self.bodies[1].radius
        self.lower, self.upper = (-math.inf, None), (math.inf, None)
        self.size = Fraction(max((body.extent for body in self.bodies if type(body) is not Body), default=1.0))

    def _reference(self) -> None:
        """The pair table knows no exact poses."""


def overlap(atoms: Sequence[Atom], poses: Sequence[Pose], solids: Sequence[Solid]) -> Claim | None:
    """Claim about how deep two convex atoms are in each other in poses; `solids` are they as the checker reads them.

    It is searched near the origin, where the numbers are small, and then moved to its place.
    """
    bodies = [moved_body(atom.body, pose) for atom, pose in zip(atoms, poses, strict=True)]
    bounded = [body for body in bodies if type(body) is not Body]
    around = [Fraction(round(c)) for c in bounded[0].support((1.0, 0.0, 0.0))[0]] if bounded else [Fraction(0)] * 3
    near = [pose._replace(place=minus(pose.place, around)) for pose in poses]
    claim = _overlap(atoms, near, [moved([s], pose).atoms[0] for s, pose in zip(solids, near, strict=True)])
    return None if claim is None else _shifted(claim, _three(around))


def _overlap(atoms: Sequence[Atom], poses: Sequence[Pose], solids: Sequence[Any]) -> Claim | None:
    spaces = [isinstance(atom.shape, HalfSpace) for atom in atoms]
    if all(spaces):
        one, other = (moved_space(atom.shape, pose) for atom, pose in zip(atoms, poses, strict=True))  # type: ignore[arg-type]
        found = features(one, other)
        return Core(tuple(found.pairs), tuple(found.triangles), found.directions)
    if spaces[1]:
        claim = _overlap(atoms[::-1], poses[::-1], solids[::-1])
        return None if claim is None else mirrored(Certificate((claim,))).claims[0]
    search = MovedSearch(atoms, poses, solids)
    search.claims()
    return search.upper[1]


def _shifted(claim: Any, by: Vector) -> Claim:
    """A claim about two proxies as one about both moved by the same way."""

    def place(p: Any) -> Any:
        return p if p is None or isinstance(p[0], tuple) else along(exact(p), 1, by)

    if not any(by) or (isinstance(claim, Core) and claim.directions):
        return claim  # type: ignore[no-any-return]
    match claim:
        case Core(pairs, triangles):
            return Core(tuple((place(p), place(q)) for p, q in pairs), triangles)
        case Common(p):
            return Common(place(p))
        case Near(p, q):
            return Near(place(p), place(q))
        case Inscribed():
            return replace(claim, a=place(claim.a), b=place(claim.b))
    raise TypeError(f"not a claim about an overlap: {claim!r}")
