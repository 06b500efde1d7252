"""Study: which speeds, thicknesses and time steps let a ball through a wall, by static and by dynamic detection."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oracles.tunnelling import MOMENTS, RADIUS, Tunnelling, expected, measured
from reports.studies.plots import COLOURS, MARKS, figure

STATIC = ("stepping", "PyBullet", "PyBullet, CCD")


def courses() -> Tunnelling:
    """Measure all flights, by all who look."""
    return measured()


def draw(found: Tunnelling, path: Path) -> None:
    """Share of the moments at which the ball tunnels, against the way of a step; static detection left of dynamic."""
    ways = np.array([flight.advance / flight.overlap for flight in found.flights])
    order = np.argsort(ways, kind="stable")
    line = np.geomspace(1, ways.max())
    dynamic = tuple(name for name in found.shares if name not in STATIC)
    with figure(path, columns=2, width=9.0) as axes:
        for axis, names in zip(axes, (STATIC, dynamic), strict=True):
            axis.plot([ways.min(), *line], [0, *(1 - 1 / line)], color="black", linestyle=":", label="1 − 1/x")
            if names == STATIC:
                axis.plot(line / 2, 1 - 1 / line, color="grey", linestyle=":", label="1 − 1/(2x)")
            for i, name in enumerate(names):
                style = {"color": COLOURS[i], "marker": MARKS[i], "markersize": 7 - i, "linestyle": "none"}
                axis.plot(ways[order], found.shares[name][order], **style, label=name.replace("`", ""))
            axis.set_xscale("log")
            axis.set_xlabel("way of a time step / way of the overlap")
            axis.legend(fontsize="x-small")
        axes[0].set_ylabel("share of arrivals that tunnel")
        axes[0].set_title("static", fontsize="medium")
        axes[1].set_title("dynamic", fontsize="medium")


def told(found: Tunnelling) -> str:
    """Markdown table: each flight, and who let how many through."""
    lines = [
        f"Arrivals of {MOMENTS} that tunnel; the ball's radius is {RADIUS:g}. Below 1 in the fourth column no step can "
        f"miss the wall; the fifth is what {MOMENTS} arrivals come to by 1 − 1/x.\n",
        "| time step | thickness | speed | way of a step / overlap | expected | " + " | ".join(found.shares) + " |",
        "| --- " * (5 + len(found.shares)) + "|",
    ]
    for i, flight in enumerate(found.flights):
        counts = " | ".join(f"{round(share[i] * MOMENTS)}" for share in found.shares.values())
        way = f"{flight.advance / flight.overlap:.2f} | {expected(flight) * MOMENTS:.1f}"
        lines.append(
            f"| 1/{round(1 / flight.time_step)} | {flight.thickness:g} | {flight.speed:g} | {way} | {counts} |"
        )
    return "\n".join(lines)
