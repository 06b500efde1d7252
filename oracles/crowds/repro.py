"""Scripts that ask a broad phase alone for the pairs of one crowd, and check by fractions what it must name."""

from __future__ import annotations

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.crowds.engine import BroadPhaseEngine

SCRIPT = '''"""Broad phase of {engine}: a pair of bodies whose bounding boxes overlap has to be named.

Exit status: 1 when the pair is missing, 0 when it is named.
"""

import sys
from fractions import Fraction
{imports}

# is it a ball; centre; half extents; where the centre was when the engine was given the body
BODIES = [
{bodies}]
PAIR = {pair}


def overlap(i, j):
    """Least overlap of two bounding boxes along any axis, exactly."""
    sides = []
    for k in range(3):
        (c, h), (d, g) = ((Fraction(b[1][k]), Fraction(b[2][k])) for b in (BODIES[i], BODIES[j]))
        sides.append(h + g - abs(c - d))
    return min(sides)


{ask}

named = sorted({{tuple(sorted(pair)) for pair in pairs(BODIES)}})
print("named:", named)
print("bounding boxes of", PAIR, "overlap by", float(overlap(*PAIR)), "along every axis, or more")
missing = overlap(*PAIR) >= 0 and PAIR not in named
print("missing" if missing else "as it should be")
sys.exit(1 if missing else 0)
'''


def crowd_script(solver: BroadPhaseEngine, engine: str, crowd: BoxCrowd, pair: Pair) -> str:
    """Write the script; empty where the adapter has no text for its calls."""
    if not solver.script:
        return ""
    columns = (crowd.balls.tolist(), crowd.center.tolist(), crowd.half.tolist(), crowd.before.tolist())
    bodies = "".join(f"    {row!r},\n" for row in zip(*columns, strict=True))
    imports, _, ask = solver.script.partition("\n\n")
    return SCRIPT.format(engine=engine, imports=imports, bodies=bodies, pair=pair, ask=ask.strip("\n"))
