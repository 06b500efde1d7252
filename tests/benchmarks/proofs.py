"""Print how long proofs of meshes of a thousand faces take: ``python -m tests.benchmarks.proofs [words]``.

Checking is asked to stay under 100 ms. The machine's own speed is measured beside it, by a fixed loop of plain Python
on integers.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track
from rich.table import Table

from refimpl.proof import certify, check, checker, to_json
from refimpl.shapes import (
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Polyhedron,
    Proxy,
    Ray,
    Sphere,
)
from tests import solids
from tests.benchmarks.scenes import globe
from tests.test_checker import OF_IMPACTS, OF_SETS, OF_SWEEPS

ASKED = 0.1
"""Seconds for a check."""

IDLE = 0.0062
"""Seconds of the loop on an idle machine of the year 2024."""
TURN, PLACE = (1, 2, 3, 4), (0.1, 0.2, 0.3)
Scene = Callable[[], tuple[Proxy, Proxy]]


def torus(tube: float = 0.4) -> Polyhedron:
    """A torus of 960 faces in general position."""
    return Polyhedron(*solids.torus(48, 10, 1.0, tube)).rotated(TURN).translated(PLACE)


def linked(tube: float, x: float = 1.0) -> tuple[Polyhedron, Polyhedron]:
    """Two such tori, one through the hole of the other: 1 − 2·tube apart, or nearly."""
    across = Polyhedron(*solids.torus(48, 10, 1.0, tube), (x, 0, 0), (1, 0, 0, 1))
    return torus(tube), across.rotated(TURN).translated(PLACE)


def ball() -> Polyhedron:
    """A bumpy ball of 1 000 faces."""
    return Polyhedron(*globe(26, 20, 0.1), (0.1, 0.2, 0.3), TURN)


def shell() -> Polyhedron:
    """A ball with a cavity: 1 008 faces."""
    outer, inner = globe(15, 18), globe(15, 18)
    return Polyhedron(*solids.together(outer, (0.8 * inner[0], inner[1][:, ::-1])), (0.1, 0.2, 0.3), TURN)


def hull(x: float) -> ConvexPolyhedron:
    """A hull of 1 000 faces, given by vertices."""
    return ConvexPolyhedron.from_vertices(globe(26, 20)[0], (x, 0.2, 0.3), TURN)


def cut(x: float) -> ConvexPolyhedron:
    """The same, given by planes."""
    return ConvexPolyhedron(hull(0).hull.planes, (x, 0.2, 0.3), TURN)


SCENES: dict[str, Scene] = {
    "tori far apart": lambda: (torus(), linked(0.4, 4.0)[1]),
    "tori close": lambda: (torus(), torus().translated((0.5, 0.4, 0.85))),
    "tori linked": lambda: linked(0.4),
    "tori linked tightly": lambda: linked(0.49),
    "tori linked, nearly touching": lambda: linked(0.4, 1.1999),
    "tori that cross": lambda: linked(0.4, 1.5),
    "balls close": lambda: (ball(), ball().translated((1.9, 0.9, 0.4))),
    "balls that overlap": lambda: (ball(), ball().translated((1.2, 0.5, 0.2))),
    "balls that overlap deeply": lambda: (ball(), ball().translated((0.1, 0.05, 0.02))),
    "mesh in a cavity": lambda: (shell(), Polyhedron(0.3 * globe(16, 16, 0.1)[0], globe(16, 16)[1], (0.3, 0.1, 0.3))),
    "sphere in a cavity": lambda: (shell(), Sphere((0.3, 0.1, 0.3), 0.4)),
    "torus around a capsule": lambda: (torus(), Capsule((0.1, 0.2, 0.3), (1.1, 1.2, 0.3), 0.1)),
    "torus and sphere": lambda: (torus(), Sphere((0.1, 0.2, 0.3), 0.4)),
    "torus and box": lambda: (torus(), Box((0.1, 0.2, 0.3), (0.2, 0.3, 0.1), (1, 1, 2, 3))),
    "torus and ellipsoid": lambda: (torus(), Ellipsoid((0.1, 0.2, 0.3), (0.2, 0.3, 0.1), (1, 1, 2, 3))),
    "torus and cylinder": lambda: (torus(), Cylinder((0.1, 0.2, 0.3), (0.2, 0.3, 1.0), 0.2)),
    "torus and half-space": lambda: (torus(), HalfSpace((1, 2, 3), 9)),
    "torus and k-DOP": lambda: (torus(), KDOP.around([(0, 0, 0), (0.3, 0, 0.1), (0, 0.2, 0.1)], 26)),
    "torus and composite": lambda: (
        torus(),
        Composite([Sphere((0.1, 0.2, 0.3), 0.2), Cylinder((0.1, 0.2, 0.3), (0.2, 0.3, 1.0), 0.1)]),
    ),
    "ball with a box inside": lambda: (ball(), Box((0.1, 0.2, 0.3), (0.2, 0.3, 0.1), (1, 1, 2, 3))),
    "ball and half-space, overlapping": lambda: (HalfSpace((1, 2, 3), 0), ball()),
    "ray onto a torus": lambda: (Ray((5, 4, 3), (-4.9, -4.7, -3.0)), torus()),
    "ray past a torus": lambda: (Ray((0.1, 0.2, 0.3), (1, 2.0, 1)), torus()),
    "hulls apart": lambda: (hull(0.1), hull(2.4)),
    "hulls that overlap": lambda: (hull(0.1), hull(1.1)),
    "hulls of planes apart": lambda: (cut(0.1), cut(2.4)),
    "hulls of planes that overlap": lambda: (cut(0.1), cut(1.1)),
}


def loop() -> float:
    """Seconds of a fixed loop in plain Python."""
    began = time.process_time()
    total = 0
    for i in range(30_000):
        total += (i * 0x9E3779B97F4A7C15) ^ total >> 3
    return time.process_time() - began


def best(work: Callable[[], Any], repeats: int = 5) -> float:
    """Least of several runs."""
    times = []
    for _ in range(repeats):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def trusted_lines(names: tuple[str, ...]) -> int:
    """Lines of what has to be believed, docstrings and blank lines among them."""
    folder = Path(str(checker.__file__)).parent
    return sum(len((folder / f"{name}.py").read_text(encoding="utf-8").splitlines()) for name in names)


def main(words: list[str]) -> None:
    """Measure the scenes that a word names, or all."""
    heads = ("scene", "certify s", "lower", "upper", "check ms", "loop ms", "kB of JSON", f"≤ {1e3 * ASKED:.0f} ms")
    table = Table(
        *heads,
        title=f"What has to be believed: {trusted_lines(OF_SETS)} lines, for impacts {trusted_lines(OF_IMPACTS)} more, "
        f"for sweeps {trusted_lines(OF_SWEEPS)}",
        title_justify="left",
    )
    chosen = [name for name in SCENES if not words or any(word in name for word in words)]
    for name in track(chosen, description="measuring", transient=True):
        a, b = SCENES[name]()
        began = time.process_time()
        certificate = certify(a, b)
        made = time.process_time() - began
        checked, beside = best(lambda: check(certificate, a, b)), best(loop)  # noqa: B023
        table.add_row(
            name,
            f"{made:.2f}",
            f"{float(certificate.lower):.6g}",
            f"{float(certificate.upper):.6g}",
            f"{1e3 * checked:.0f}",
            f"{1e3 * beside:.0f}",
            f"{len(str(to_json(certificate))) / 1e3:.0f}",
            "✓" if checked <= ASKED * max(1.0, beside / IDLE) else "more",
        )
    Console(width=150).print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
