"""By what method the first contact of each pair of types is found: a column of the pair table."""

from __future__ import annotations

from typing import NamedTuple

from refimpl.proxy import Proxy
from refimpl.shapes import HalfSpace, Point, Ray
from refimpl.sweeps.translations import CASTS
from refimpl.sweeps.unions import UNIONS


class Methods(NamedTuple):
    """How a pair's first contact is found in translation, and in rigid motions, which may turn."""

    translation: str
    rigid: str


def methods_of(a: type[Proxy], b: type[Proxy]) -> Methods | None:
    """Name the methods of a pair of types, in the order of the pair table; None for rays, which do not move.

    Flat proxies have no rigid motions.
    """
    if issubclass(a, Ray):
        return None
    if a.dimension == 2:
        return Methods("ray cast against the difference", "–")
    if a in UNIONS or b in UNIONS:
        return Methods("first of the pieces", "first of the pieces")
    if a is Point:
        way = "ray cast"
    elif (a, b) in CASTS:
        way = "ray cast against the difference"
    elif HalfSpace in (a, b):
        way = "height over speed"
    else:
        way = "Newton on the signed distance"
    return Methods(way, "conservative advancement")
