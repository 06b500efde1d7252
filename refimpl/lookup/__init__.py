"""What proxies are also used for: what a camera sees, what a pointer points at, who sees whom, and who is where.

`Scene` holds many proxies in a bounding volume hierarchy. `perspective` makes a view frustum, and `in_view` says what
of a scene it shows; `pick` finds the first proxy on a ray, `line_of_sight` whether a segment is free, and `containing`
the proxies around a point.
"""

from refimpl.lookup.culling import culled_by, proof_of_absence, shows
from refimpl.lookup.frustum import frustum_of_matrix, perspective
from refimpl.lookup.picking import Pick, pick
from refimpl.lookup.scene import Scene
from refimpl.lookup.sight import Sight, line_of_sight
from refimpl.lookup.whereabouts import containing, in_view

__all__ = [
    "Pick",
    "Scene",
    "Sight",
    "containing",
    "culled_by",
    "frustum_of_matrix",
    "in_view",
    "line_of_sight",
    "perspective",
    "pick",
    "proof_of_absence",
    "shows",
]
