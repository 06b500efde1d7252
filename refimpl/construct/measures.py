"""How good a proxy is: volumes that it shares with a mesh, and distances of the surfaces."""

from refimpl.construct.overlap import Overlap, Volume, proxy_volume, volume_overlap
from refimpl.construct.surface_distance import OneSided, SurfaceDistance, surface_distance

__all__ = ["OneSided", "Overlap", "SurfaceDistance", "Volume", "proxy_volume", "surface_distance", "volume_overlap"]
