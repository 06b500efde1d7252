"""Print the worst errors of the formulas of impacts: ``python -m tests.impact_accuracy [scenes] [seed]``.

Doubles are held against the same formulas in fractions. Errors of a velocity are in units in the last place of the
largest velocity of the scene, before or after, of the bodies or at the contact; and relative to the largest coordinate
of that very velocity, before or after. With the times of batches of 10 000, and of a single impact.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from refimpl.impacts import (
    impact_of_bodies,
    impact_of_particles,
    impact_on_line,
    join_bodies,
    merge_particles,
)
from refimpl.impacts.reading import fractions
from refimpl.linear import cross
from tests.impact_scenes import Scene, wide_scenes

BATCH = 10_000


@dataclass
class Errors:
    """Worst of what was seen of a formula: in ulp of the scene's largest velocity, and relative to each velocity."""

    ulp: float = 0.0
    relative: float = 0.0

    def see(self, found: Any, true: Any, before: Any, largest: Any = 0.0) -> None:
        """Compare velocities (n) or (n, 3) with the true ones, and with those before."""
        found, before = (np.asarray(v, dtype=float).reshape(len(found), -1) for v in (found, before))
        error = np.abs((fractions(found) - np.asarray(true).reshape(found.shape)).astype(float)).max(axis=1)
        own = np.maximum(np.abs(found).max(axis=1), np.abs(before).max(axis=1))
        scene = np.maximum(own, largest)
        moves = own > 0
        assert not error[~moves].any()
        self.ulp = max(self.ulp, float((error[moves] / np.spacing(scene[moves])).max(initial=0.0)))
        self.relative = max(self.relative, float((error[moves] / own[moves]).max(initial=0.0)))


Line = tuple[Any, ...]


def lines(rng: np.random.Generator, n: int) -> Line:
    """Velocities of 12 decades, inverse masses of 24, and some immovable."""
    speeds = rng.normal(size=(2, n)) * 10 ** rng.uniform(-6, 6, (2, n))
    masses = 10 ** rng.uniform(-12, 12, (2, n)) * (rng.random((2, n)) > 0.05)
    return (*speeds, *masses, rng.random(n))


def particles(rng: np.random.Generator, n: int) -> Line:
    """The same in space, with normals of any length."""
    speeds = rng.normal(size=(2, n, 3)) * 10 ** rng.uniform(-3, 3, (2, n, 1))
    masses = 10 ** rng.uniform(-12, 12, (2, n)) * (rng.random((2, n)) > 0.05)
    return (*speeds, *masses, rng.normal(size=(n, 3)) * 10 ** rng.uniform(-9, 9, (n, 1)), rng.random(n))


def of_line(n: int, rng: np.random.Generator) -> tuple[Callable[[], Any], Callable[[], Iterator[Any]]]:
    given = lines(rng, n)
    return lambda: impact_on_line(*given), lambda: _pairs(impact_on_line, given)


def _pairs(formula: Callable[..., Any], given: Line) -> Iterator[Any]:
    found, true = formula(*given), formula(*map(fractions, given))
    speeds = [np.abs(v).reshape(len(v), -1).max(axis=1) for v in (*given[:2], found.velocity_a, found.velocity_b)]
    largest = np.max(speeds, axis=0)
    yield found.velocity_a, true.velocity_a, given[0], largest
    yield found.velocity_b, true.velocity_b, given[1], largest


def of_particles(**options: Any) -> Any:
    def formula(*given: Any) -> Any:
        return impact_of_particles(
            *given, **{k: v if given[0].dtype == float else fractions(v) for k, v in options.items()}
        )

    def prepared(n: int, rng: np.random.Generator) -> Any:
        given = particles(rng, n)
        return lambda: formula(*given), lambda: _pairs(formula, given)

    return prepared


def of_merging(n: int, rng: np.random.Generator) -> Any:
    given = particles(rng, n)[:4]
    return lambda: merge_particles(*given), lambda: _pairs(merge_particles, given)


def of_bodies(smooth: bool, **ranges: float) -> Any:
    def prepared(n: int, rng: np.random.Generator) -> Any:
        scene = wide_scenes(rng, n, **ranges)
        scene = scene.without_friction() if smooth else scene
        return lambda: impact_of_bodies(*scene.question), lambda: _body_pairs(scene, impact_of_bodies)

    return prepared


def of_joining(n: int, rng: np.random.Generator) -> Any:
    scene = wide_scenes(rng, n)
    return lambda: join_bodies(scene.a, scene.b), lambda: _body_pairs(scene, lambda a, b, *_: join_bodies(a, b))


def _body_pairs(scene: Scene, formula: Callable[..., Any]) -> Iterator[Any]:
    found, true = formula(*scene.question), formula(*scene.exact().question)
    ends = [(getattr(scene, name), getattr(found, name), getattr(true, name)) for name in ("a", "b")]
    speeds = []
    for before, after, _ in ends:
        arm = scene.point - before.position
        for body in (before, after):
            speeds += [body.velocity, cross(np.asarray(body.angular_velocity), arm)]
    largest = np.abs(np.array(speeds)).max(axis=(0, 2))
    for before, after, truly in ends:
        yield after.velocity, truly.velocity, before.velocity, largest
        yield after.angular_velocity, truly.angular_velocity, before.angular_velocity, 0.0


FORMULAS: dict[str, Callable[[int, np.random.Generator], Any]] = {
    "on a line": of_line,
    "particles": of_particles(),
    "particles, damped": of_particles(damping=np.float64(0.3)),
    "particles, Coulomb": of_particles(friction=np.float64(0.3)),
    "particles, merged": of_merging,
    "bodies": of_bodies(True),
    "bodies, Coulomb": of_bodies(False),
    "bodies, condition to 1e14": of_bodies(False, condition=1e14),
    "bodies, mass ratio to 1e24": of_bodies(False, ratio=1e24),
    "bodies, joined": of_joining,
}


def measure(name: str, n: int, seed: int) -> Errors:
    """Worst errors of a formula over `n` scenes."""
    worst = Errors()
    for found, true, before, largest in FORMULAS[name](n, np.random.default_rng(seed))[1]():
        worst.see(found, true, before, largest)
    return worst


def milliseconds(name: str, n: int) -> float:
    """Best processor time of five."""
    run = FORMULAS[name](n, np.random.default_rng(0))[0]
    times = []
    for _ in range(5):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return 1e3 * min(times)


def main(arguments: list[str]) -> None:
    """Measure, and print the table."""
    n, seed = [*map(int, arguments), *(1000, 1)[len(arguments) :]]
    table = Table("formula", "scenes", "worst, ulp of the largest", "worst, relative", f"ms of {BATCH}", "ms of 1")
    for name in FORMULAS:
        worst = measure(name, n, seed)
        times = (f"{milliseconds(name, rows):.1f}" for rows in (BATCH, 1))
        table.add_row(name, str(n), f"{worst.ulp:.3f}", f"{worst.relative:.2e}", *times)
    Console(width=140).print(table)
    print(f"rounding once: {0.5:.3f} ulp, {float(Fraction(1, 2**53)):.2e}")


if __name__ == "__main__":
    main(sys.argv[1:])
