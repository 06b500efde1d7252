"""Contacts of overlapping unions, pair by pair of convex atoms, and the bounds of their depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array
from refimpl.overlaps import Contacts, Overlap, apart_or_overlapping
from refimpl.proxy import Proxy, ShapeError
from refimpl.results import Separation

__all__ = ["Contacts", "Manifold", "contacts"]


@dataclass(frozen=True)
class Manifold:
    """How two proxies touch and overlap.

    Attributes
    ----------
    separation : Separation
        What `distance` answers.
    depth_interval : (2,)
        The shortest translation of B that separates has a length between these: at least that of the deepest pair of
        atoms, at most that of a translation that was found to separate; (0, 0) where the proxies are apart, and inf
        at the end where none was found.
    contacts : Contacts
        One for each overlapping pair of convex atoms, the deepest first.
    """

    separation: Separation
    depth_interval: Array
    contacts: Contacts


def contacts(a: Proxy, b: Proxy) -> Manifold:
    """Contacts of two single solids, or of a point and a solid.

    Parameters
    ----------
    a, b : proxies without batch axes
        Convex ones have one contact at most.

    Returns
    -------
    Manifold
    """
    for x in (a, b):
        if x.batch_shape:
            raise ShapeError(
                f"contacts are of single proxies, got a batch of shape {x.batch_shape}: take them by index"
            )
    found: Overlap = apart_or_overlapping(a, b)
    upper = max(0.0, -float(found.separation.distance))
    return Manifold(found.separation, np.array([min(found.lower, upper), upper]), found.contacts)
