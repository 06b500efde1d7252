"""Study: five equal balls in a row, the first thrown at the others: Newton's cradle, reference beside engine.

No strings: a wall at either end throws the balls back. The lecture's answer is one impact after another, pair by
pair: each swaps the velocities, and one ball leaves at the far end. An engine that solves all contacts of a step at
once answers something else when the balls touch; both keep momentum and energy.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from oracles.engines.bullet_motion import Balls
from refimpl.impacts import impact_on_line
from refimpl.linear import Array
from reports.studies.plots import COLOURS, figure

BALLS, RADIUS, ROOM = 5, 0.5, 4.0
SPEED, RUN_UP = 2.0, 0.5
TIME_STEP, SECONDS = 1 / 240, 10.0
GAPS = (0.0, 1e-3)


class Course(NamedTuple):
    """Who simulates, the gaps between the balls, and at each time step the velocities."""

    who: str
    gap: float
    velocities: Array


def _start(gap: float) -> tuple[Array, Array, float]:
    """Places on the line, velocities, and how far the walls are from the middle."""
    places = np.asarray((np.arange(BALLS) - BALLS // 2) * (2 * RADIUS + gap))
    reach = float(places[-1]) + RADIUS + ROOM
    places[0] -= RUN_UP
    return places, np.eye(BALLS)[0] * SPEED, reach


def by_formula(gap: float) -> Course:
    """Reference: the next impact on the line, and the lecture's formula, one impact after the other."""
    places, velocities, reach = _start(gap)
    now, samples = 0.0, []
    for tick in TIME_STEP * np.arange(1, round(SECONDS / TIME_STEP) + 1):
        while True:
            wait, which = _next(places, velocities, reach)
            if now + wait > tick:
                break
            places, now = places + wait * velocities, now + wait
            velocities = _after(velocities, which)
        places, now = places + (tick - now) * velocities, tick
        samples.append(velocities)
    return Course("the formula", gap, np.array(samples))


def _next(places: Array, velocities: Array, reach: float) -> tuple[float, int]:
    """Time to the next impact, and between which two of wall, balls, wall it is."""
    x = np.concatenate([[-reach], places, [reach]])
    v = np.concatenate([[0.0], velocities, [0.0]])
    room = np.diff(x) - np.where(np.arange(BALLS + 1) % BALLS == 0, RADIUS, 2 * RADIUS)
    closing = -np.diff(v)
    waits = np.full(BALLS + 1, np.inf)
    np.divide(np.maximum(room, 0.0), closing, out=waits, where=closing > 0)
    return float(np.min(waits)), int(np.argmin(waits))


def _after(velocities: Array, which: int) -> Array:
    padded = np.concatenate([[0.0], velocities, [0.0]])
    inverse_mass = np.array([0.0, *[1.0] * BALLS, 0.0])
    pair = slice(which, which + 2)
    (a, b), (mass_a, mass_b) = padded[pair], inverse_mass[pair]
    found = impact_on_line(a, b, mass_a, mass_b, 1.0)
    padded[pair] = found.velocity_a, found.velocity_b
    return padded[1:-1]


def by_engine(gap: float, defaults: bool) -> Course:
    """PyBullet, with its default settings or with those under which it solves the formula."""
    places, velocities, reach = _start(gap)
    line = np.array([1.0, 0.0, 0.0])
    walls = [(-reach * line, line), (reach * line, -line)]
    who = "PyBullet by default" if defaults else "PyBullet, set to the formula"
    with Balls(
        RADIUS, np.outer(places, line), np.outer(velocities, line), walls, 1.0, TIME_STEP, defaults=defaults
    ) as world:
        steps = [world.step()[:, 0] for _ in range(round(SECONDS / TIME_STEP))]
    return Course(who, gap, np.array(steps))


def courses() -> list[Course]:
    """Simulate with all three, for each gap."""
    found = []
    for gap in GAPS:
        found += [by_formula(gap), by_engine(gap, defaults=False), by_engine(gap, defaults=True)]
    return found


def draw(found: list[Course], path: Path) -> None:
    """Kinetic energy and momentum against time; solid for touching balls, dashed for balls with gaps."""
    with figure(path, columns=2, width=9.0) as axes:
        whose = list(dict.fromkeys(course.who for course in found))
        for course in found:
            times = TIME_STEP * np.arange(1, len(course.velocities) + 1)
            style = {"color": COLOURS[whose.index(course.who)], "linestyle": "--" if course.gap else "-"}
            label = f"{course.who}, {f'gaps of {course.gap:g}' if course.gap else 'touching'}"
            axes[0].plot(times, np.sum(course.velocities**2, axis=1) / 2, **style, label=label)
            axes[1].plot(times, np.sum(course.velocities, axis=1), **style)
        axes[0].set_ylabel("kinetic energy")
        axes[0].set_ylim(0.0, 1.6 * SPEED**2 / 2)
        axes[1].set_ylabel("momentum (walls turn it round)")
        for axis in axes:
            axis.set_xlabel("time")
        axes[0].legend(fontsize="x-small")


def told(found: list[Course]) -> str:
    """Markdown table: velocities after the first impact of the row, and the energy at the end."""
    lines = ["| | gaps | velocities once the far ball has left | energy left |", "| --- | --- | --- | --- |"]
    for course in found:
        moved = np.flatnonzero(course.velocities[:, -1] > SPEED / 10)
        settled = course.velocities[min(moved[0] + 6, len(course.velocities) - 1)] if len(moved) else None
        shown = "–" if settled is None else ", ".join(f"{v + 0.0:.2f}" for v in np.round(settled, 2))
        left = np.sum(course.velocities[-1] ** 2) / SPEED**2
        lines.append(f"| {course.who} | {course.gap:g} | {shown} | {left:.2f} |")
    return "\n".join(lines)
