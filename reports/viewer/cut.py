"""Bodies brought into the picture: what is far larger is cut off beyond its rim, what is far smaller becomes a dot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from refimpl.linear import Array, norm
from reports.viewer.frame import Frame, clipped
from reports.viewer.meshes import Face
from reports.viewer.solids import BEYOND_DRAWING, Dot, Lathe, Line, Mesh, Plane, Solid, is_finite

BEYOND = 3.0
"""Half of the cube, in radii of the picture, to which large bodies are cut."""

FLAT = 12.0
"""Radius of a curved body, in radii of the picture, from which on its surface looks flat."""

RIM = 1.45
"""Radius to which endless planes and rays are drawn."""

SPECK = 0.008
"""Radius of a body, in radii of the picture, below which it is drawn as a dot."""

BISECTIONS = 200


@dataclass(frozen=True)
class Shown:
    """What is drawn of one body, placed in the picture; and in words, how that differs from the body."""

    parts: list[Solid]
    notes: list[str]


def shown(name: str, body: list[Solid], frame: Frame) -> Shown:
    """Place a body in the picture and cut it to fit."""
    placed: list[Solid] = []
    notes: dict[str, None] = {}
    for part in body:
        for piece, note in _shown(_place(part, frame)):
            notes[note] = None
            if piece is not None and is_finite(piece):
                placed.append(piece)
            elif piece is not None:
                notes[BEYOND_DRAWING] = None
    return Shown(placed, [f"{name} {note}" for note in notes if note])


def _place(part: Solid, frame: Frame) -> Solid:
    match part:
        case Lathe():
            return replace(part, center=frame.place(part.center), axes=part.axes / frame.radius)
        case Mesh():
            return replace(part, vertices=frame.place(part.vertices))
        case Plane():
            return replace(part, foot=frame.place(part.foot))
        case Line():
            return replace(part, start=frame.place(part.start), end=frame.place(part.end))
        case Dot():
            return Dot(frame.place(part.at))


def _shown(part: Solid) -> Iterator[tuple[Solid | None, str]]:
    """A placed part cut to the picture, and how that is told."""
    corners = part.corners()
    if len(corners) and not isinstance(part, Line | Dot):
        low, high = corners.min(axis=0), corners.max(axis=0)
        if norm(high - low) < 2 * SPECK:
            why = "is too small for this picture" if np.any(high > low) else "has no size"
            yield Dot(low / 2 + high / 2), f"{why}: it is drawn as a dot"
            return
        if np.any(low > BEYOND) or np.any(high < -BEYOND):
            yield None, "lies in part outside the picture"
            return
        if np.any(high > 2 * BEYOND) or np.any(low < -2 * BEYOND):
            yield _cut(part)
            return
    if isinstance(part, Lathe) and part.kind != "ball" and norm(part.axes[0]) < SPECK / 4:
        sweep = part.axes[2] * (part.half if part.kind == "rod" else 1.0)
        part = Line(part.center - sweep, part.center + sweep)
    if isinstance(part, Line):
        line = clipped(part, RIM if part.endless else BEYOND)
        yield line, "" if line else "passes outside the picture"
    elif isinstance(part, Plane):
        off = bool(abs(float(part.foot @ part.normal)) > 1.2)
        yield (None, "lies outside the picture") if off else (part, "")
    else:
        yield part, ""


LARGE = "is far larger than the picture: only what is near is drawn"
AROUND = "is far larger than the picture and surrounds all that is seen"


def _cut(part: Solid) -> tuple[Solid | None, str]:
    """What is near of a large body."""
    if isinstance(part, Mesh):
        mesh = _cut_mesh(part)
        return mesh, LARGE if mesh else AROUND if _surrounds(part) else "lies in part outside the picture"
    assert isinstance(part, Lathe)
    foot, normal = nearest(part, np.zeros(3))
    if foot @ normal > RIM:
        return None, AROUND
    if float(norm(part.axes[0])) > FLAT:
        return Plane(foot, normal), LARGE
    return (part if part.kind == "ball" else _shortened(part)), LARGE


def _surrounds(part: Mesh) -> bool:
    """Whether the middle of the picture lies behind every face, as in a convex body."""
    rings = [part.vertices[list(face)] for face in part.faces if len(face) > 2]
    return all(float(newell(ring) @ ring[0]) >= 0 for ring in rings)


def newell(ring: Array) -> Array:
    """Normal of a polygon, as long as twice its area (Newell's sum)."""
    return np.asarray(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0))


def _shortened(part: Lathe) -> Lathe:
    """A rod or can cut to what is near the middle."""
    length = float(norm(part.axes[2]))
    axis, half = part.axes[2] / length, length * (part.half if part.kind == "rod" else 1.0)
    middle = float(part.center @ axis)
    reach = BEYOND + float(norm(part.axes[0]))
    low, high = max(middle - half, -reach), min(middle + half, reach)
    center = part.center + ((low + high) / 2 - middle) * axis
    if part.kind == "rod":
        return replace(part, center=center, half=(high - low) / 2 / length)
    return replace(part, center=center, axes=np.stack([*part.axes[:2], (high - low) / 2 * axis]))


def nearest(part: Lathe, point: Array) -> tuple[Array, Array]:
    """Point of a curved surface nearest to a point, and its outward normal."""
    lengths = norm(part.axes)
    frame = part.axes / lengths[:, None]
    local = frame @ (point - part.center)
    if part.kind == "ball":
        foot, normal = _nearest_of_ellipsoid(local, lengths)
    elif part.kind == "rod":
        inner = np.array([0.0, 0.0, np.clip(local[2], -part.half * lengths[2], part.half * lengths[2])])
        normal = _unit(local - inner)
        foot = inner + lengths[0] * normal
    else:
        foot, normal = _nearest_of_can(local, lengths)
    return part.center + foot @ frame, normal @ frame


def _nearest_of_ellipsoid(local: Array, radii: Array) -> tuple[Array, Array]:
    """Bisect for the multiplier t of y + t y / r² = local, Σ (y / r)² = 1."""
    shares = np.abs(local) / radii
    least = float(radii.min())
    low, high = -least * least, least * float(norm(local)) + float(radii.max()) * float(norm(local))
    for _ in range(BISECTIONS):
        middle = low / 2 + high / 2
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            outside = np.nansum((shares * radii**2 / (radii**2 + middle)) ** 2) > 1
        low, high = (middle, high) if outside else (low, middle)
    foot = local * radii**2 / np.maximum(radii**2 + high, np.finfo(float).tiny)
    size = float(norm(foot / radii))
    foot = foot / size if size > 0 else radii * np.eye(3)[int(np.argmin(radii))]
    return foot, _unit(foot / radii**2)


def _nearest_of_can(local: Array, lengths: Array) -> tuple[Array, Array]:
    """Clamp to the solid; from within it, leave by the side or the end that is nearer."""
    radius, half = float(lengths[0]), float(lengths[2])
    side, end = _unit(local * [1, 1, 0]), np.array([0.0, 0.0, math.copysign(1.0, local[2])])
    away = math.hypot(local[0], local[1])
    foot = min(away, radius) * side + min(abs(float(local[2])), half) * end
    if away > radius or abs(local[2]) > half:
        return foot, _unit(local - foot)
    if radius - away < half - abs(local[2]):
        return foot + (radius - away) * side, side
    return foot + (half - abs(float(local[2]))) * end, end


def _unit(v: Array) -> Array:
    """Direction of a vector; x for none, which lies across a can's axis."""
    size = float(norm(v))
    return v / size if size > 0 else np.array([1.0, 0.0, 0.0])


def _cut_mesh(part: Mesh) -> Mesh | None:
    """Faces cut to the cube around the middle (Sutherland and Hodgman 1974)."""
    corners: dict[tuple[float, ...], int] = {}
    faces: list[Face] = []
    for face in part.faces:
        ring = [part.vertices[i] for i in face]
        for axis in range(3):
            for side in (1.0, -1.0):
                ring = _behind(ring, axis, side)
        cut = [corners.setdefault(tuple(np.round(x, 6).tolist()), len(corners)) for x in ring]
        kept = tuple(dict.fromkeys(cut))
        if len(kept) > 2:
            faces.append(kept)
    return Mesh(np.array(list(corners)), tuple(faces)) if faces else None


def _behind(ring: list[Array], axis: int, side: float) -> list[Array]:
    """The part of a polygon on one side of a face of the cube."""
    heights = [BEYOND - side * float(x[axis]) for x in ring]
    found: list[Array] = []
    for (p, above), (q, next_above) in zip(
        zip(ring, heights, strict=True), zip(ring[1:] + ring[:1], heights[1:] + heights[:1], strict=True), strict=True
    ):
        if above >= 0:
            found.append(p)
        if (above >= 0) != (next_above >= 0):
            found.append(p + above / (above - next_above) * (q - p))
    return found
