"""The survey of bounding volumes: whether they contain every point, and how much smaller they could be.

Both are proven in fractions. That a volume leaves a point out, by the point. That it could be smaller: of a sphere by
weights of the points that bound every enclosing sphere's radius from below, of boxes and cylinders by a smaller one
that contains all points.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from oracles.surveys.bounding_clouds import EACH, REGIMES
from oracles.surveys.bounding_shapes import (
    Affine,
    Ball,
    Barrel,
    Exact,
    Ground,
    ball_of,
    barrel_of,
    brick_of,
    exact,
    numbers,
)
from oracles.surveys.survey import REFERENCE, Case, Judgement, Library, Survey
from refimpl.linear import Array

HERE = "oracles.surveys.bounding_engines"
MOST = 512
"""Points of a cloud that is read."""
NEEDS = MappingProxyType({"box-size": 3, "cylinder-size": 3, "cylinder-contains": 2})
"""Dimensions that a cloud needs for a question."""


class Bounding(Survey):
    """Bounding volumes of points."""

    name = "bounding"
    title = "Bounding volumes"
    about = (
        "Points, and a bounding volume around them: whether it contains all of them, and how much smaller it could be. "
        "Both are proven in exact arithmetic: a point that is left out, the radius below which no enclosing sphere is, "
        "a smaller box or cylinder that contains all points."
    )
    questions: ClassVar = MappingProxyType(
        {
            "sphere-contains": "A sphere around all points; off by how far one is outside, in extents of the cloud",
            "sphere-size": "The smallest sphere; off by how much its radius exceeds the least, relative",
            "box-contains": "An oriented box around all points; off by how far a point is outside, in extents",
            "box-size": "The least box; off by how much its volume exceeds a smaller one's, relative",
            "cylinder-contains": "A cylinder around all points; off by how far a point is outside, in extents",
            "cylinder-size": "The least cylinder; off by how much its volume exceeds a smaller one's, relative",
            "hull": "Corners of the convex hull; off by how far a point is outside of theirs, in extents",
            "centre": "Centre of the box along the axes; off by how far it is from the exact one, in extents",
        }
    )
    regimes: ClassVar = MappingProxyType({name: recipe.why for name, recipe in REGIMES.items()})
    engines: ClassVar = MappingProxyType(
        {
            REFERENCE: Library(f"{HERE}:Reference", "refimpl", "proxyproof"),
            "trimesh": Library(f"{HERE}:Trimesh", "trimesh", "trimesh (the extra 'meshes')"),
            "miniball": Library(f"{HERE}:Miniball", "miniball", "miniball (the extra 'bounding')"),
            "fcl": Library(f"{HERE}:Fcl", "fcl", "python-fcl (the extra 'fcl')", "python-fcl"),
        }
    )
    each: ClassVar = 5.0

    def cases(self, seed: int) -> list[Case]:
        """Every regime, before all questions that it has an answer to."""
        found = []
        for number, (regime, recipe) in enumerate(REGIMES.items()):
            rng = np.random.default_rng([seed, number])
            clouds = [{"points": recipe.make(rng).tolist()} for _ in range(EACH)]
            asked = [q for q in self.questions if recipe.dimension >= NEEDS.get(q, 0)]
            found += [Case(question, regime, data) for question in asked for data in clouds]
        return found

    def judge(self, case: Case, answer: Any) -> Judgement:
        """Compare with what is proven."""
        points = points_in(case.data)
        shape, _, aspect = case.question.partition("-")
        if shape == "hull":
            return _outside(Ground(points).beyond_hull(numbers(answer["vertices"], 3, MOST)), points, "the hull")
        if shape == "centre":
            return _centre(points, exact(answer["center"], 3))
        volume = READERS[shape](answer)
        if aspect == "contains":
            return _outside(volume.beyond(points), points, f"the {shape}")
        return _larger(case.question, points, volume)

    def check(self, case: Case) -> None:
        """Refuse anything but a cloud of a few points."""
        if case.question not in self.questions:
            raise ValueError(f"no question {case.question!r} about bounding volumes")
        points_in(case.data)

    def size(self, case: Case) -> float:
        """Largest extent of the cloud."""
        return extent(points_in(case.data))

    def special(self, case: Case) -> str:
        """Whether the points are flat, and whether any of them coincide."""
        points = points_in(case.data)
        said = ["flat"] if dimension(points) < 3 else []
        said += ["repeated points"] if len(np.unique(points, axis=0)) < len(points) else []
        return ", ".join(said)

    def simpler(self, case: Case) -> Iterator[Case]:
        """Halves of the points, then all but one; then plainer coordinates."""
        for points in _simpler(case.data["points"]):
            if dimension(np.array(points)) >= NEEDS.get(case.question, 0):
                yield Case(case.question, case.regime, {"points": points})

    def written(self, case: Case) -> str:
        """Points as an array."""
        return f"numpy.array({json.dumps(case.data['points'])})"


def _simpler(points: list[list[float]]) -> Iterator[list[list[float]]]:
    """Halves of the points, all but one of them, and plainer coordinates."""
    n = len(points)
    yield from (part for part in (points[: n // 2], points[n // 2 :], points[::2], points[1::2]) if 0 < len(part) < n)
    yield from (points[:i] + points[i + 1 :] for i in range(n if 1 < n <= 24 else 0))
    size = max(max(map(abs, row)) for row in points)
    for digits in (0, 1, 2) if size else ():
        places = digits - math.floor(math.log10(size))
        plain = [[round(v, places) + 0.0 for v in row] for row in points]
        if len(repr(plain)) < len(repr(points)):
            yield plain


def dimension(points: Array) -> int:
    """How many dimensions a cloud spreads in, up to rounding."""
    return int(np.linalg.matrix_rank((points - points[0]) / extent(points), tol=1e-13))


READERS: Mapping[str, Callable[[Any], Ball | Affine | Barrel]] = MappingProxyType(
    {"sphere": ball_of, "box": brick_of, "cylinder": barrel_of}
)


def points_in(data: Mapping[str, Any]) -> Array:
    """Points (n, 3) of a case; raises ValueError, TypeError or LookupError for anything else."""
    return numbers(data["points"], 3, MOST)


def extent(points: Array) -> float:
    """Largest extent of a cloud along an axis; for a single point the size of its coordinates, or 1."""
    found = float(np.max(np.ptp(points, axis=0)))
    return found or float(np.max(np.abs(points))) or 1.0


def _outside(beyond: tuple[float, int], points: Array, what: str) -> Judgement:
    """`beyond`: how far at least the farthest point is outside, and which one."""
    far, which = beyond
    if far <= 0:
        return Judgement(0.0, f"every point is in {what}")
    place = points[which].tolist()
    return Judgement(far / extent(points), f"{place} is at least {far:.3g} outside of {what}", {"point": which})


def _centre(points: Array, center: Exact) -> Judgement:
    low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    truth = [(Fraction(a) + Fraction(b)) / 2 for a, b in zip(low, high, strict=True)]
    off = float(max(abs(a - b) for a, b in zip(center, truth, strict=True)))
    return Judgement(
        off / extent(points), f"the exact centre is {[float(v) for v in truth]}", {"lower": low, "upper": high}
    )


def _larger(question: str, points: Array, volume: Any) -> Judgement:
    """How much larger a volume is than one that is proven to do."""
    if question == "sphere-size":
        bound, proof = _least_square(points.tobytes())
        if not bound:
            return Judgement(float(volume.radius) / extent(points), "around one point every radius is too large", proof)
        ratio = math.sqrt(volume.radius**2 / bound)
        return Judgement(max(0.0, ratio - 1), f"no enclosing sphere has a radius below {math.sqrt(bound):.17g}", proof)
    least, proof = (_small_box if question == "box-size" else _small_cylinder)(points.tobytes())
    found = volume.volume()
    words = f"a volume of {least:.9g} contains all points, this is {found:.9g}"
    return Judgement(max(0.0, found / least - 1) if least > 0 else 0.0, words, proof)


def _again(content: bytes) -> Array:
    return np.frombuffer(content).reshape(-1, 3)


@lru_cache(maxsize=512)
def _least_square(content: bytes) -> tuple[Fraction, Any]:
    from refimpl.construct.optimality import check_sphere, prove_sphere  # noqa: PLC0415  slow to import

    proof = prove_sphere(_again(content))
    said = {"touching": list(proof.points), "weights": [str(w) for w in proof.weights]}
    return check_sphere(_again(content), proof), said


@lru_cache(maxsize=512)
def _small_box(content: bytes) -> tuple[float, Any]:
    from refimpl.construct import least_box  # noqa: PLC0415  slow to import

    found = least_box(_again(content))
    said = {name: getattr(found, name).tolist() for name in ("center", "half_extents", "rotation")}
    return _proven(brick_of(said), content), said


@lru_cache(maxsize=512)
def _small_cylinder(content: bytes) -> tuple[float, Any]:
    from refimpl.construct import cylinder  # noqa: PLC0415  slow to import

    found = cylinder(_again(content))
    said = {name: getattr(found, name).tolist() for name in ("p", "q", "radius")}
    return _proven(barrel_of(said), content), said


def _proven(volume: Affine | Barrel, content: bytes) -> float:
    """Volume of what contains all points; 0, which proves nothing, where it does not."""
    return volume.volume() if volume.beyond(_again(content))[0] <= 0 else 0.0
