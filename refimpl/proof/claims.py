"""What a certificate may claim: the kinds of proof, and their meaning.

Part of what has to be believed; `bounds` computes what each claim proves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from refimpl.proof.vectors import Number, Vector

Bound: TypeAlias = Fraction | float  # a float only for ±∞
Weights: TypeAlias = tuple[tuple[int, Number], ...]
"""Shares of numbered things, up to a common factor: of the vertices that mean a point, of the planes across n."""
Faces: TypeAlias = tuple[tuple[tuple[int, Weights], ...], tuple[tuple[int, Weights], ...]]
"""For polytopes given by planes, of A and of B: an atom's number (0, if it is alone), and shares of planes across n."""
Place: TypeAlias = Vector | Weights
"""A point of a proxy: its coordinates, or the weights of its vertices if the proxy is given by vertices."""


@dataclass(frozen=True)
class Separated:
    """σ ≥ L > 0: planes across `n`, from A to B, leave a gap. For a ray: up to the time `until`, or ever.

    `faces` are needed for a polytope that is given by planes: shares λ of its planes with n ∥ Σ λᵢ nᵢ in A, −n in B.
    """

    n: Vector
    until: Number | None = None
    faces: Faces = ((), ())


@dataclass(frozen=True)
class Escape:
    """σ ≥ −D: moving B along `n`, a direction from A to B, by a length D ≥ 0 separates the interiors."""

    n: Vector
    faces: Faces = ((), ())


@dataclass(frozen=True)
class Near:
    """σ ≤ ‖a − b‖, as `a` lies in A and `b` in B."""

    a: Place
    b: Place


@dataclass(frozen=True)
class Common:
    """σ ≤ 0, as the point `p` lies in both. For a ray, in place of `p`: the ray is inside at `time`.

    `p` with a `time` is where the ray is then, for a solid whose points are given by weights.
    """

    p: Place | None
    time: Number | None = None


@dataclass(frozen=True)
class Core:
    """σ ≤ −r − r_A − r_B: a closed polytope of points a_j − b_j of the cores holds a ball of radius r at 0.

    `pairs` are the (a_j, b_j), `triangles` their indices, counter-clockwise seen from outside. One pair and
    no triangle: σ ≤ ‖a − b‖ − r_A − r_B ≤ 0; more, in the plane: `plane.polygon`. With `directions`, the pairs are
    recession directions (u_j, v_j) of A and B, and a closed polytope proves A ⊖ B to be the whole space: σ = −∞.
    """

    pairs: tuple[tuple[Place, Place], ...]
    triangles: tuple[tuple[int, int, int], ...] = ()
    directions: bool = False


@dataclass(frozen=True)
class Inscribed:
    """σ ≤ −r − r_A − r_B: the cores hold ellipsoids whose difference holds the ball of `radius` r around 0.

    The ellipsoid in A is {a + P u : ‖u‖ ≤ 1}, with P's three columns in `p`; the one in B likewise, with Q's in `q`.
    So A ⊖ B holds a − b + (P − Q) u for all ‖u‖ ≤ 1. The `shares` are the numbers by which `sets.ball_in_ball` sees
    that the first lies in A, the second in B, and the ball in their difference. This is what proves depths that whole
    circles or spheres of directions share, which a polytope only approaches.
    """

    a: Place
    p: tuple[Vector, Vector, Vector]
    b: Place
    q: tuple[Vector, Vector, Vector]
    radius: Number
    shares: tuple[Number, Number, Number]


@dataclass(frozen=True)
class Split:
    """A tree of directions over two sets of atoms: those of one side are parted, `first` and all the others.

    Each of `branches` is a `Split` of what it is given, or a `Separated` of it all. So a tree covers every pair of
    atoms by its form.
    """

    side: int
    first: tuple[int, ...]
    branches: tuple[Tree, Tree]


@dataclass(frozen=True)
class Cover:
    """For unions: σ ≥ L, or σ ≥ −‖shift‖: with B moved by `shift` all their atoms are apart, and nothing is inside.

    The atoms of a union are its convex parts and the triangles of its meshes, numbered in that order. A mesh takes
    part by its surface alone, so it must also be shown that nothing of the other lies wholly inside the solid: where
    one has a mesh, `places` give a point of each convex part of the other. For a ray, `until` means as in `Separated`.
    """

    tree: Tree
    shift: Vector = (0, 0, 0)
    places: tuple[tuple[Place, ...], tuple[Place, ...]] = ((), ())
    until: Number | None = None


@dataclass(frozen=True)
class Piece:
    """A convex piece of a solid mesh: the hull of some points of the world, widened by a ball of `radius`.

    No triangle of the mesh enters its interior, which `tree` shows by planes between the piece (an atom of its own,
    the side 0) and the triangles (side 1); and the mean of the points lies in the solid. So all of it does.
    """

    vertices: tuple[Vector, ...]
    tree: Tree
    radius: Number = 0


@dataclass(frozen=True)
class Part:
    """For unions: σ ≤ what `claim` proves about a convex part of A and one of B: more parts only meet sooner.

    `of_a` and `of_b` choose: the number of an atom, a `Piece` of the mesh that is the part of that number, or None
    for a convex proxy itself.
    """

    of_a: int | tuple[int, Piece] | None
    of_b: int | tuple[int, Piece] | None
    claim: Simple


Tree: TypeAlias = Split | Separated
Simple: TypeAlias = Separated | Escape | Near | Common | Core | Inscribed
Claim: TypeAlias = Simple | Cover | Part


@dataclass(frozen=True)
class Certificate:
    """Claims about one pair of proxies, and the bounds that whoever made it believes them to prove."""

    claims: tuple[Claim, ...]
    lower: Bound = -math.inf
    upper: Bound = math.inf
