"""Study: what early rejects by bounding volumes are worth: ``python -m reports.studies.rejects [FOLDER]``.

Bodies stand around at random; each pair goes through the pipeline of `refimpl.world`. The time on pairs that do not
collide is what a bounding volume can save; it costs a test of its own on every pair. Times are processor time, of this
machine, and so on a page of their own: ``rejects.md``, which no test compares.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from refimpl import KDOP, Box, Capsule, Composite, ConvexPolyhedron, Cylinder, Ellipsoid, Proxy, aabb
from refimpl.bodies import Body
from refimpl.bounds import bounding_sphere
from refimpl.broadphase import ColumnSweep
from refimpl.linear import Array
from refimpl.mass import mass_properties
from refimpl.signs import Indices
from refimpl.world import World
from reports.studies.plots import COLOURS, StudyUnavailable, figure

HERE = Path(__file__).parent
COUNT, ROOM_EACH, SEED = 200, 1.6, 1
REPEATS = 5
STILL = (0.0, 0.0, 0.0, 1.0)
SIZES = np.array([1.0, 0.45, 0.3])
"""Half extents of the bodies, roughly: longish, as things are."""
NONE = "none"


def _hull() -> tuple[Proxy, Array]:
    way = np.random.default_rng(5).normal(size=(40, 3))
    corners = SIZES * way / np.linalg.norm(way, axis=1)[:, None]
    return ConvexPolyhedron.from_vertices(corners), corners


def _capsule() -> tuple[Proxy, Array]:
    """A capsule, and points whose hull contains it."""
    shape = Capsule([-0.6, 0, 0], [0.6, 0, 0], 0.4)
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return shape, signs * [1.0, 0.4, 0.4]


def _chair() -> tuple[Proxy, Array]:
    """Seat, back and four legs."""
    boxes = [Box([0.1, 0, 0], [0.4, 0.35, 0.05], STILL), Box([-0.35, 0, 0.5], [0.05, 0.35, 0.45], STILL)]
    boxes += [Box([x, y, -0.45], [0.05, 0.05, 0.4], STILL) for x in (-0.25, 0.4) for y in (-0.25, 0.25)]
    ends = [box.center + sign * box.half_extents for box in boxes for sign in (-1, 1)]
    lower, upper = np.min(ends, axis=0), np.max(ends, axis=0)
    return Composite(boxes), np.array([[(lower, upper)[i >> k & 1][k] for k in range(3)] for i in range(8)])


COLLIDERS: Mapping[str, Callable[[], tuple[Proxy, Array]]] = MappingProxyType(
    {"capsule": _capsule, "hull of 40 corners": _hull, "chair of six boxes": _chair}
)
"""Colliders, each with points whose hull contains it."""


def volumes(shape: Proxy, points: Array) -> dict[str, Proxy]:
    """Each type of bounding volume around the points, simply fitted, in their own axes."""
    box = aabb(shape)
    center, half = box.lower / 2 + box.upper / 2, box.upper / 2 - box.lower / 2
    long = int(np.argmax(half))
    axis = np.eye(3)[long]
    away = points - center
    along, across = away @ axis, np.linalg.norm(away - np.outer(away @ axis, axis), axis=1)
    radius = float(across.max()) * (1 + 1e-9)
    shaft = float(np.max(np.abs(along) - np.sqrt(radius**2 - across**2), initial=0.0)) * (1 + 1e-9)
    swell = float(np.sqrt(np.max(np.sum((away / half) ** 2, axis=1)))) * (1 + 1e-9)
    return {
        "Sphere": bounding_sphere(shape),
        "AABB": box,
        "Box": box.to_box(),
        "Capsule": Capsule(center - shaft * axis, center + shaft * axis, radius),
        "Cylinder": Cylinder(center - half[long] * axis, center + half[long] * axis, radius),
        "Ellipsoid": Ellipsoid(center, swell * half, STILL),
        "KDOP of 18 planes": KDOP.around(points, 18),
    }


class EveryPair(ColumnSweep):
    """No broad phase: every pair is a candidate."""

    def pairs(self) -> Indices:
        """All pairs."""
        return np.stack(np.triu_indices(len(self), 1), axis=-1)


class Course(NamedTuple):
    """One collider with one bounding volume: pairs, and seconds on all of them.

    `reject` is the time of the early rejects on pairs that do not collide, `miss` that of the collider on such pairs,
    `hit` that of both on pairs that collide.
    """

    collider: str
    volume: str
    broad: bool
    asked: int
    passed: int
    hits: int
    reject: float
    miss: float
    hit: float

    @property
    def wasted(self) -> float:
        """Share of the time that is spent on pairs that do not collide."""
        return (self.reject + self.miss) / (self.reject + self.miss + self.hit)


def course(collider: str, volume: str, *, broad: bool) -> Course:
    """Measure one combination."""
    shape, points = COLLIDERS[collider]()
    around = None if volume == NONE else volumes(shape, points)[volume]
    matter, rng = mass_properties(shape), np.random.default_rng(SEED)
    places = rng.uniform(0, ROOM_EACH * np.cbrt(COUNT), (COUNT, 3))
    bodies = [Body(shape, around, place, rng.normal(size=4), mass=1.0, matter=matter) for place in places]
    world = World(bodies, broad_phase=ColumnSweep() if broad else EveryPair())
    pairs = world.candidates()
    hits = np.asarray(world.collide(pairs).hit, dtype=bool)  # also compiles what is compiled
    met = np.ones(len(pairs), dtype=bool) if around is None else world.volumes_meet(pairs)
    if np.any(hits & ~met):
        raise AssertionError(f"{volume} around {collider} lost a pair")
    times = []
    for _ in range(REPEATS):
        reject, accept = (
            (0.0, 0.0) if around is None else (_seconds(world.volumes_meet, pairs[s]) for s in (~hits, hits))
        )
        miss, hit = (_seconds(world.collide, pairs[some]) for some in (met & ~hits, hits))
        times.append((reject, miss, accept + hit))
    reject, miss, hit = (median(column) for column in zip(*times, strict=True))
    return Course(collider, volume, broad, len(pairs), int(met.sum()), int(hits.sum()), reject, miss, hit)


def _seconds(stage: Callable[[Indices], object], pairs: Indices) -> float:
    """Processor time of a stage on some pairs."""
    if not len(pairs):
        return 0.0
    start = time.process_time()
    stage(pairs)
    return time.process_time() - start


def courses() -> list[Course]:
    """Measure all."""
    names = [NONE, *volumes(*_hull())]
    return [course(c, v, broad=broad) for c in COLLIDERS for broad in (False, True) for v in names]


def draw(found: list[Course], path: Path) -> None:
    """Time by what it is spent on, stacked; a panel for each collider, with and without a broad phase."""
    colliders = list(dict.fromkeys(one.collider for one in found))
    with figure(path, columns=len(colliders), width=10.0, height=4.6) as axes:
        for axis, collider in zip(axes, colliders, strict=True):
            mine = [one for one in found if one.collider == collider]
            names = [f"{one.volume}{' + broad phase' if one.broad else ''}" for one in mine]
            start = np.zeros(len(mine))
            for i, (name, what) in enumerate(
                (("hit", "pairs that collide"), ("miss", "collider on others"), ("reject", "volumes of others"))
            ):
                spent = 1e3 * np.array([getattr(one, name) for one in mine])
                axis.barh(names, spent, left=start, color=COLOURS[(2, 1, 4)[i]], label=what)
                start = start + spent
            axis.set_title(collider, fontsize="medium")
            axis.set_xlabel("processor time [ms]")
            axis.invert_yaxis()
            axis.tick_params(axis="y", labelsize=6)
        axes[0].legend(fontsize="x-small", loc="lower right")


def told(found: list[Course]) -> str:
    """Markdown table of pairs and times."""
    titles = ("collider", "broad phase", "bounding volume", "pairs", "left by the volumes", "collide")
    times = (
        "volumes of others [ms]",
        "collider on others [ms]",
        "pairs that collide [ms]",
        "on pairs that do not collide",
    )
    lines = [f"| {' | '.join((*titles, *times))} |", "| --- | --- | --- " + "| ---: " * 7 + "|"]
    for one in found:
        spent = " | ".join(f"{1e3 * seconds:.2f}" for seconds in (one.reject, one.miss, one.hit))
        pairs = f"{one.asked} | {one.passed} | {one.hits}"
        broad = "yes" if one.broad else "no"
        lines.append(f"| {one.collider} | {broad} | {one.volume} | {pairs} | {spent} | {100 * one.wasted:.0f} % |")
    return "\n".join(lines)


TEXT = (
    f"{COUNT} bodies at random, turned at random, {ROOM_EACH:g}³ of room for each; extents about 2, 0.9, 0.6. Every "
    "pair goes through bounding volumes and colliders, without a broad phase and with one. The first row of each group "
    f"has no bounding volumes. Processor time in milliseconds, medians of {REPEATS}: shares and order tell something, "
    "the times are of one machine. No volume lost a pair.\n\n"
    "Without a broad phase nine tenths of the time go to pairs that do not collide. A volume is worth its test if that "
    "is cheaper than the collider: balls, aligned boxes and capsules are, the more so the dearer the collider. Turned "
    "boxes, cylinders and ellipsoids fit better, but save time only around a union. Behind a broad phase there is "
    "little left to reject: none saves more there than the times differ from run to run, not even those that reject "
    "half of what is left. The AABB rejects nothing there: fitted to the turned body anew, it is the broad phase's box."
)


def main(arguments: list[str]) -> None:
    """Write the page and its plot."""
    folder = Path(arguments[0]) if arguments else HERE
    folder.mkdir(parents=True, exist_ok=True)
    found = courses()
    try:
        draw(found, folder / "rejects.svg")
    except StudyUnavailable as error:
        sys.exit(str(error))
    title = "# What early rejects are worth\n\nMade by `python -m reports.studies.rejects`.\n\n"
    plot = "\n\n![Time by what it is spent on](rejects.svg)\n\n"
    (folder / "rejects.md").write_text(title + TEXT + plot + told(found) + "\n", encoding="utf-8")
    print(folder / "rejects.md")


if __name__ == "__main__":
    main(sys.argv[1:])
