"""Polytopes given by planes, as the search sees them: their exact corners, and directions as sums of normals.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from refimpl.proof.bodies import Corners, Mix, placed
from refimpl.proof.claims import Place, Weights
from refimpl.proof.points import Vector, cross, dot, doubles, exact, minus, rationals

FEW = 40  # planes of which all triples are tried
MEETING = 8  # planes at one corner of which all triples are tried
KEPT = 256  # polytopes whose corners are remembered
NEAR = 1e-9  # relative; planes that come so near to a corner may pass through it


class Planes(Corners):
    """A polytope given by planes: a certificate has to show a direction as a sum of normals."""

    def __init__(self, planes: Any, position: Vector, columns: Sequence[Vector], hull: Callable[[], Any]) -> None:
        self.planes, self.position, self.columns = [rationals(plane) for plane in planes], position, columns
        found = corners_of(planes, hull)
        self.active = [active for _, active in found]
        super().__init__([placed(corner, position, columns) for corner, _ in found])
        self.middle = self.floats.mean(axis=0).tolist()

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return [placed(plane[:3], (0, 0, 0), self.columns) for plane in self.planes]

    def levels(self) -> list[Fraction]:
        """Offset k of each plane in the world: normal·x + k ≤ 0."""
        pairs = zip(self.normals(), self.planes, strict=True)
        return [plane[3] - dot(normal, self.position) for normal, plane in pairs]

    def faces(self, n: Vector) -> Weights:
        """Shares of the planes through the farthest corner."""
        local = tuple(dot(column, n) for column in self.columns)
        return cone(local, [(i, self.planes[i][:3]) for i in self.active[self.farthest(n)]])

    def place(self, point: Vector, mix: Mix = ()) -> Place:
        """Doubles, drawn in a little if that makes them lie inside; or else the exact point."""
        if not mix:
            return point
        for inwards in (0.0, 2.0**-52, 2.0**-50, 2.0**-47):
            here = doubles(point)
            drawn = tuple(c + inwards * (float(m) - c) for c, m in zip(here, self.middle, strict=True))
            if self.holds(drawn):
                return drawn
        return self.mean(mix)

    def holds(self, point: Vector) -> bool:
        """Whether a point lies inside, exactly."""
        offset = minus(exact(point), self.position)
        local = tuple(dot(column, offset) for column in self.columns)
        return all(dot(plane, local) + plane[3] <= 0 for plane in self.planes)


_KNOWN: dict[bytes, list[tuple[Vector, list[int]]]] = {}


def corners_of(planes: Any, hull: Callable[[], Any]) -> list[tuple[Vector, list[int]]]:
    """Exact intersections of three planes behind all others, and which planes go through each.

    Few planes are all tried; of many, those near to the corners of the hull that floats give.
    """
    key = planes.tobytes()
    if key not in _KNOWN:
        if len(_KNOWN) > KEPT:
            _KNOWN.clear()
        unit = planes / np.sqrt((planes[:, :3] ** 2).sum(axis=1))[:, None]
        triples = _triples(unit) if len(planes) <= FEW else _triples_near(unit, hull())
        _KNOWN[key] = _exact_corners(planes, unit, triples)
    return _KNOWN[key]


def _exact_corners(planes: Any, unit: Any, triples: Iterable[Sequence[int]]) -> list[tuple[Vector, list[int]]]:
    found: dict[Vector, list[int]] = {}
    ints = [_integers(plane) for plane in planes.tolist()]
    for i, j, k in triples:
        x, y, z, w = _meet(ints[i], ints[j], ints[k])
        place = x, y, z
        if w == 0:
            continue
        largest = max(map(abs, (x, y, z, w)))
        about = np.array([c / largest for c in place])
        level = unit[:, :3] @ about + unit[:, 3] * (w / largest)
        near = np.nonzero(level > -NEAR * (1e-300 + np.max(np.abs(about))))[0].tolist()
        sides = [(i, dot(ints[i][:3], place) + ints[i][3] * w) for i in near]
        if all(side <= 0 for _, side in sides):
            corner = Fraction(x, w), Fraction(y, w), Fraction(z, w)
            found[corner] = [i for i, side in sides if side == 0]
    return list(found.items())


def _integers(plane: Sequence[float]) -> tuple[int, int, int, int]:
    """The same plane, by integers."""
    ratios = [c.as_integer_ratio() for c in plane]
    unit = max(q for _, q in ratios)  # powers of two
    a, b, c, k = (p * (unit // q) for p, q in ratios)
    return a, b, c, k


def _triples_near(unit: Any, corners: Any) -> Iterator[tuple[int, ...]]:
    """Triples of planes that nearly meet in a corner."""
    for corner in corners:
        level = np.abs(unit[:, :3] @ corner + unit[:, 3])
        near = np.nonzero(level <= NEAR * np.max(np.abs(corners)))[0]
        yield from combinations(near[np.argsort(level[near], kind="stable")][:MEETING].tolist(), 3)


def _triples(unit: Any) -> list[tuple[int, ...]]:
    """Triples of planes that meet, in floats, behind all others or nearly so."""
    triples = np.array(list(combinations(range(len(unit)), 3)))
    normals, k = unit[triples, :3], unit[triples, 3]
    volumes = np.einsum("ij,ij->i", normals[:, 0], np.cross(normals[:, 1], normals[:, 2]))
    triples, normals, k, volumes = (x[np.abs(volumes) > 1e-14] for x in (triples, normals, k, volumes))
    points = (
        -(
            k[:, :1] * np.cross(normals[:, 1], normals[:, 2])
            + k[:, 1:2] * np.cross(normals[:, 2], normals[:, 0])
            + k[:, 2:] * np.cross(normals[:, 0], normals[:, 1])
        )
        / volumes[:, None]
    )
    worst = np.max(points @ unit[:, :3].T + unit[:, 3], axis=1)
    slack = NEAR * (np.max(np.abs(unit[:, 3])) + np.max(np.abs(points), axis=1))
    chosen: list[tuple[int, ...]] = triples[worst <= slack].tolist()
    return chosen


def _meet(*planes: Sequence[int]) -> tuple[int, int, int, int]:
    """Point that three planes have in common, times the last number ≥ 0; this is 0 if there is none (Cramer)."""
    u, v, w = ((plane[0], plane[1], plane[2]) for plane in planes)
    a, b, c = (plane[3] for plane in planes)
    vw, wu, uv = cross(v, w), cross(w, u), cross(u, v)
    volume = dot(u, vw)
    sign = -1 if volume > 0 else 1
    x, y, z = (sign * (a * p + b * q + c * r) for p, q, r in zip(vw, wu, uv, strict=True))
    return x, y, z, -sign * volume


def cone(n: Vector, normals: Sequence[tuple[int, Vector]]) -> Weights:
    """Shares ≥ 0 of up to three normals that add up to n, exactly; none if n is not in their cone (Carathéodory)."""
    for i, u in normals:
        if not any(cross(u, n)) and dot(u, n) > 0:
            return ((i, 1),)
    for (i, u), (j, v) in combinations(normals, 2):
        across = cross(u, v)
        if any(across) and dot(across, n) == 0:
            of_u, of_v = dot(cross(n, v), across), dot(cross(u, n), across)
            if of_u >= 0 and of_v >= 0:
                return (i, of_u), (j, of_v)
    for (i, u), (j, v), (k, w) in combinations(normals, 3):
        volume = dot(u, cross(v, w))
        if volume != 0:
            sizes = [x / volume for x in (dot(n, cross(v, w)), dot(n, cross(w, u)), dot(n, cross(u, v)))]
            if min(sizes) >= 0:
                return tuple(zip((i, j, k), sizes, strict=True))
    return ()
