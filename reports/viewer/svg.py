"""The still picture: a small SVG without script or style of its own, and the same as a file that stands alone."""

from __future__ import annotations

import math
from functools import cache
from html import escape
from importlib.resources import files

import numpy as np

from oracles.outcome import Bucket
from refimpl.linear import Array, perpendicular
from reports import text
from reports.viewer.cut import RIM, newell
from reports.viewer.frame import View
from reports.viewer.marks import LAYERS, Mark
from reports.viewer.scene import Picture, picture_of
from reports.viewer.solids import Dot, Lathe, Line, Mesh, Plane, Solid

WIDE, HIGH, SCALE = 640, 480, 208
"""Size of the drawing, and how long the picture's radius is in it."""

TITLE_LENGTH = 160
HATCHES = 4
"""Strokes on each side of the middle that mark the inside of a half-space."""


def still(picture: Picture) -> str:
    """Return the SVG as a page embeds it: the page's style has its colours."""
    return f'<svg class="still" viewBox="{-WIDE // 2} {-HIGH // 2} {WIDE} {HIGH}" role="img">{_inside(picture)}</svg>'


def picture(bucket: Bucket) -> str:
    """Return the SVG as a file of its own, in colours that suit a light and a dark page."""
    made = picture_of(bucket)
    notes = f"<desc>{_text(' '.join(made.notes))}</desc>" if made.notes else ""
    box = f'viewBox="{-WIDE // 2} {-HIGH // 2} {WIDE} {HIGH}" width="{WIDE}" height="{HIGH}"'
    root = f'<svg xmlns="http://www.w3.org/2000/svg" class="still alone" {box} role="img">'
    title, drawing = _inside(made).split("</title>", 1)
    return f"{root}{title}</title>{notes}<style>{_style()}</style>{drawing}</svg>\n"


@cache
def _style() -> str:
    lines = files("reports.viewer").joinpath("still.css").read_text(encoding="utf-8").splitlines()
    return "".join(line.strip() for line in lines)


def _inside(picture: Picture) -> str:
    brush = _Brush(picture.view)
    bodies = [("b", part) for part in picture.b] + [("a", part) for part in picture.a]
    bodies.sort(key=lambda body: (not isinstance(body[1], Plane), brush.nearness(body[1])))
    drawn = [brush.body(name, part) for name, part in bodies]
    if picture.names is None:
        drawn += [brush.letter(name.upper(), parts) for name, parts in (("a", picture.a), ("b", picture.b)) if parts]
    drawn += [brush.body("proof wire", part) for part in picture.ghost]
    for layer in LAYERS:
        drawn += [brush.mark(mark) for mark in picture.marks if mark.layer == layer]
    drawn += [
        f'<text class="{layer} said" x="{12 - WIDE // 2}" y="{24 * line + 28 - HIGH // 2}">{_text(words)}</text>'
        for line, (layer, words) in enumerate(picture.said)
    ]
    return f"<title>{_text(text.visible(picture.label, limit=TITLE_LENGTH))}</title>" + "".join(drawn)


def _text(words: str) -> str:
    """Words as XML holds them, which has no place for surrogates and control characters."""
    return escape("".join(c if c.isprintable() else "�" for c in words))


class _Brush:
    """Draws bodies and marks from one point of view; y points downwards on the paper."""

    def __init__(self, view: View) -> None:
        right, up, self.eye = view.axes
        self.paper = np.stack([right, -up], axis=-1)

    def flat(self, places: Array) -> Array:
        """Places on the paper."""
        return np.asarray(SCALE * (places @ self.paper))

    def nearness(self, part: Solid) -> float:
        """How near a body is to the eye."""
        corners = part.corners()
        return float(np.mean(corners, axis=0) @ self.eye) if len(corners) else 0.0

    def body(self, name: str, part: Solid) -> str:
        """A body in its colour."""
        match part:
            case Lathe():
                return self._lathe(name, part)
            case Mesh():
                return _path(name, self._faces(part))
            case Plane():
                return self._plane(name, part)
            case Line():
                return _path(f"{name} wire", self._line(part))
            case Dot():
                return _circle(name, self.flat(part.at), 6)

    def _lathe(self, name: str, part: Lathe) -> str:
        center, axes = self.flat(part.center), self.flat(part.axes)
        if part.kind == "ball":
            return _ellipse(name, center, axes)
        sweep = axes[2] * (part.half if part.kind == "rod" else 1.0)
        around = axes if part.kind == "rod" else axes[:2]
        outline = _swept(name, center, around, sweep)
        if part.kind == "rod":
            return outline
        side = 1.0 if part.axes[2] @ self.eye > 0 else -1.0
        return outline + _ellipse(f"{name} wire", center + side * sweep, around)

    def _faces(self, part: Mesh) -> str:
        """Those faces that look towards the eye, or all of a mesh that has none."""
        front = [face for face in part.faces if len(face) < 3 or newell(part.vertices[list(face)]) @ self.eye > 0]
        flat = self.flat(part.vertices)
        return "".join(_ring(flat[list(face)]) for face in front or part.faces)

    def _plane(self, name: str, part: Plane) -> str:
        """A disc of the plane, with strokes on the side of the solid."""
        middle, across = _disc(part.foot, part.normal)
        along = max(across, key=lambda axis: abs(float(axis @ self.paper[:, 0])))
        strokes = "".join(
            self._line(Line(start, start - 0.12 * part.normal - 0.05 * along))
            for start in (middle + k / HATCHES * 0.8 * along for k in range(-HATCHES, HATCHES + 1))
        )
        return _ellipse(f"{name} disc", self.flat(middle), self.flat(across)) + _path(f"{name} wire", strokes)

    def _line(self, part: Line) -> str:
        start, end = self.flat(np.stack([part.start, part.end]))
        head = _head(start, end) if part.endless else ""
        return f"M{_xy(start)}L{_xy(end)}{head}"

    def letter(self, name: str, parts: list[Solid]) -> str:
        """The body's name, beside its largest part."""
        way = np.array([-0.6 if name == "A" else 0.6, -1.0])
        flat = np.concatenate([self._outermost(part, way) for part in parts])
        outward = np.clip(flat[np.argmax(flat @ way)], -SCALE, SCALE)
        x, y = np.clip(outward - np.array([0, 8]), [-WIDE / 2 + 20, -HIGH / 2 + 30], [WIDE / 2 - 20, HIGH / 2 - 12])
        return f'<text class="{name.lower()}" x="{x:.0f}" y="{y:.0f}">{name}</text>'

    def _outermost(self, part: Solid, way: Array) -> Array:
        """Places of a body, among them the one that is farthest along a way on the paper."""
        if isinstance(part, Plane):
            return self.flat(_disc(part.foot, part.normal)[0])[None]
        if not isinstance(part, Lathe):
            return self.flat(part.corners())
        axes = self.flat(part.axes)
        sweep = axes[2] * (part.half if part.kind == "rod" else 1.0 if part.kind == "can" else 0.0)
        around = axes[:2] if part.kind == "can" else axes
        along = around @ way
        reach = around.T @ along / max(math.hypot(*along), 1e-9)
        return np.asarray(self.flat(part.center) + reach + math.copysign(1.0, sweep @ way) * sweep)[None]

    def mark(self, mark: Mark) -> str:
        """A mark in the colour of its layer."""
        at, to = self.flat(mark.at), self.flat(mark.to)
        match mark.kind:
            case "dot":
                return _circle(mark.layer, at, 7 if mark.layer == "engine" else 4)
            case "plane":
                middle, across = _disc(mark.at, mark.to, 0.9)
                return _ellipse("proof disc", self.flat(middle), self.flat(across))
            case "arrow" | "spin":
                tip = at + (to - at) * 1.12
                label = f'<text class="{mark.layer} word" x="{tip[0]:.0f}" y="{tip[1]:.0f}">{_text(mark.label)}</text>'
                heads = _head(at, to) + (_head(at, at + 0.9 * (to - at)) if mark.kind == "spin" else "")
                return _path(mark.layer, f"M{_xy(at)}L{_xy(to)}{heads}") + label
            case _:
                return _path(mark.layer, f"M{_xy(at)}L{_xy(to)}")


def _disc(foot: Array, normal: Array, rim: float = RIM) -> tuple[Array, Array]:
    """Middle of the part of a plane that is drawn, and two of its radii at right angles."""
    level = float(foot @ normal)
    first = perpendicular(normal)
    radius = math.sqrt(max(0.3, rim * rim - level * level))
    return level * normal, radius * np.stack([first, np.cross(normal, first)])


def _xy(point: Array) -> str:
    return f"{point[0]:.0f} {point[1]:.0f}"


def _ring(points: Array) -> str:
    return f"M{_xy(points[0])}L{' '.join(map(_xy, points[1:]))}Z"


def _path(name: str, data: str) -> str:
    return f'<path class="{name}" d="{data}"/>' if data else ""


def _circle(name: str, at: Array, radius: int) -> str:
    return f'<circle class="{name} dot" cx="{at[0]:.0f}" cy="{at[1]:.0f}" r="{radius}"/>'


def _axes_of(axes: Array) -> tuple[float, float, float]:
    """Radii and turn in degrees of the ellipse that the images of orthogonal axes span."""
    _, radii, turned = np.linalg.svd(axes, full_matrices=False)
    return float(radii[0]), float(radii[1]), math.degrees(math.atan2(turned[0, 1], turned[0, 0]))


def _ellipse(name: str, center: Array, axes: Array) -> str:
    rx, ry, turn = _axes_of(axes)
    place = f'cx="{center[0]:.0f}" cy="{center[1]:.0f}"'
    if round(rx) == round(ry):
        return f'<circle class="{name}" {place} r="{rx:.0f}"/>'
    spin = f' transform="rotate({turn:.0f} {_xy(center)})"' if round(turn) % 180 else ""
    return f'<ellipse class="{name}" {place} rx="{rx:.0f}" ry="{ry:.0f}"{spin}/>'


def _swept(name: str, center: Array, axes: Array, sweep: Array) -> str:
    """Outline of an ellipse that is swept from −sweep to +sweep."""
    if math.hypot(*sweep) < 0.5:
        return _ellipse(name, center, axes)
    rx, ry, turn = _axes_of(axes)
    across = axes @ np.array([sweep[1], -sweep[0]])
    side = axes.T @ across / max(math.hypot(*across), 1e-9)
    arc = f"A{rx:.0f} {max(ry, 0.1):.3g} {turn:.0f} 0 1 "
    ends = [center + sweep + side, center + sweep - side, center - sweep - side, center - sweep + side]
    return _path(name, f"M{_xy(ends[0])}{arc}{_xy(ends[1])}L{_xy(ends[2])}{arc}{_xy(ends[3])}Z")


def _head(start: Array, end: Array) -> str:
    """Head of an arrow, as a part of its path."""
    length = math.hypot(*(end - start))
    if length < 2:
        return ""
    way = (end - start) / length * min(14.0, length / 2)
    across = np.array([-way[1], way[0]]) * 0.4
    return f"M{_xy(end - way + across)}L{_xy(end)} {_xy(end - way - across)}"
