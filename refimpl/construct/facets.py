"""Faces of the hull of points, exactly, whatever the ratio of their coordinates along different axes.

Stretching along the axes keeps a hull's faces. So each axis is brought to about 1 by its own power of two.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from refimpl.construct.cloud import Cloud, scaled
from refimpl.construct.formulas import Polynomial, about_one, along, off_slab
from refimpl.faces import from_vertices
from refimpl.linear import Array
from refimpl.proxy import ShapeError


class Side(NamedTuple):
    """Points lie where normal·x + k ≤ 0, or where it is 0."""

    normal: list[Fraction]
    k: Fraction
    flat: bool = False

    def formulas(self) -> list[Polynomial]:
        """Polynomials that are at most 0 there and nowhere else, of about 1."""
        way, size = about_one(self.normal)
        level = -self.k / size
        return off_slab(way, level, level) if self.flat else [along(way, level)]


def sides_around(vertices: Array, cloud: Cloud) -> tuple[list[Side], list[int]]:
    """Faces of the hull of vertices, in a cloud's units, and which vertices are its corners.

    Raises
    ------
    ShapeError
        Where coordinates along one axis differ by so much that no power of two brings them all into the doubles.
    """
    tops = np.frexp(np.max(np.abs(vertices), axis=0))[1].tolist()
    level = np.stack([scaled(vertices[:, i], -top) for i, top in enumerate(tops)], axis=1)
    if any(np.any(scaled(level[:, i], top) != vertices[:, i]) for i, top in enumerate(tops)):
        raise ShapeError(
            "coordinates along one axis differ by more than a factor of 2^1000, which no hull is found for"
        )
    faces = from_vertices(level)
    units = [Fraction(2) ** (faces.exponent + top) / cloud.unit for top in tops]  # of a whole coordinate
    *corner, last = faces.corners[0]
    found = [Side([n / u for n, u in zip(normal, units, strict=True)], Fraction(k)) for *normal, k in faces.planes]
    for normal in faces.normals:
        height = sum((Fraction(n * x, last) for n, x in zip(normal, corner, strict=True)), Fraction(0))
        found.append(Side([n / u for n, u in zip(normal, units, strict=True)], -height, True))
    return found, faces.kept_vertices
