"""Study: how far a bounce off a plane is from the formula in PyBullet as it comes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oracles.bounces import Bounces, measured
from reports.bounces import as_markdown
from reports.studies.plots import COLOURS, MARKS, figure


def courses() -> Bounces:
    """Measure all restitutions, speeds and moments."""
    return measured()


def draw(found: Bounces, path: Path) -> None:
    """Rebound against speed: the median as a line, all moments within a step as a band; the formula dotted."""
    with figure(path) as (axis,):
        for i, (e, shares) in enumerate(zip(found.restitutions, found.shares, strict=True)):
            colour = COLOURS[i]
            axis.fill_between(found.speeds, shares.min(axis=1), shares.max(axis=1), color=colour, alpha=0.15, lw=0)
            axis.plot(
                found.speeds, np.median(shares, axis=1), color=colour, marker=MARKS[i], markersize=4, label=f"e = {e:g}"
            )
            axis.axhline(e, color=colour, linestyle=":", linewidth=1)
        axis.set_xscale("log")
        axis.set_xlabel("speed of approach")
        axis.set_ylabel("speed after, as a share of that")
        axis.legend(fontsize="small", ncols=len(found.restitutions), loc="upper center", bbox_to_anchor=(0.5, 1.12))


def told(found: Bounces) -> str:
    """Markdown table, as `proxyproof bounces` prints it."""
    return as_markdown(found).strip()
