"""The flat world: proxies of the plane, asked through the same door as those of space.

`refimpl.distance`, `intersect`, `collide`, `raycast`, `sweep` and `certify` take flat proxies as they take solid ones,
with vectors of two numbers; `table` names the algorithm of each pair of flat types. A `Sprite` is no such proxy but a
mask of pixels, with questions of its own (`refimpl.flat.sprites`).
"""

from refimpl.flat.base import Flat
from refimpl.flat.pairs import table
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.flat.sprites import Sprite
from refimpl.motions import FlatTranslation

__all__ = [
    "ConvexPolygon",
    "Disc",
    "Flat",
    "FlatPoint",
    "FlatRay",
    "FlatTranslation",
    "Rectangle",
    "Segment",
    "Sprite",
    "table",
]
