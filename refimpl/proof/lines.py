"""Convex polygons given by lines, as the search sees them: polytopes in the plane z = 0 whose corners are exact.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from refimpl.flat.corners import clipped, whole_lines, wrapped
from refimpl.proof.bodies import Corners
from refimpl.proof.planes import Planes
from refimpl.proof.points import AXES, ZERO, dot, rationals


class Lines(Planes):
    """A convex polygon given by lines: a certificate has to show a direction as a sum of their normals."""

    def __init__(self, lines: Any) -> None:
        self.planes, self.position, self.columns = [], ZERO, AXES
        for x, y, k in map(rationals, lines):
            self.planes.append((x, y, Fraction(0), k))
        corners = [(Fraction(x, w), Fraction(y, w), Fraction(0)) for x, y, w in wrapped(clipped(whole_lines(lines)))]
        self.active = [[i for i, n in enumerate(self.planes) if dot(n, corner) + n[3] == 0] for corner in corners]
        Corners.__init__(self, corners)
        self.middle = self.floats.mean(axis=0).tolist()
