"""What the HTML report embeds: a figure per bucket, with the scene as data and a still picture; script and style."""

from __future__ import annotations

import json
import re
from functools import cache
from importlib.resources import files
from typing import Any

from markupsafe import Markup, escape

from oracles.outcome import Bucket
from refimpl.linear import Array
from reports.viewer.scene import Picture, picture_of
from reports.viewer.solids import Dot, Lathe, Line, Mesh, Plane, Solid
from reports.viewer.svg import still

SCRIPTS = ("camera.js", "bodies.js", "paint.js", "marks.js", "figure.js")
UNITS = 10_000
"""Coordinates are sent in whole 1/10 000 of the picture's radius."""


def scene_data(bucket: Bucket) -> dict[str, Any]:
    """The scene as JSON for the script.

    ``a``, ``b`` and ``ghost`` are lists of bodies, each ``[kind, numbers, …]``; ``marks`` are ``[layer, kind, six
    numbers, label]``; ``view`` is azimuth and elevation in degrees; ``size`` the radius of the picture in the scene's
    lengths, null where no double holds it; ``engine`` is a text, ``said`` a list of ``[layer, text]``. What is drawn is
    said by the still picture's title.
    """
    return _data(picture_of(bucket))


def _data(picture: Picture) -> dict[str, Any]:
    found: dict[str, Any] = {
        "engine": picture.engine,
        "said": [list(words) for words in picture.said],
        "view": [picture.view.azimuth, picture.view.elevation],
        "size": float(f"{picture.size:.6g}") if 0 < picture.size < float("inf") else None,
        "a": [_body(part) for part in picture.a],
        "b": [_body(part) for part in picture.b],
        "marks": [[m.layer, m.kind, [*_whole(m.at), *_whole(m.to)], m.label] for m in picture.marks],
    }
    if picture.ghost:
        found["ghost"] = [_body(part) for part in picture.ghost]
    if picture.names is not None:
        found["names"] = dict(zip("ab", picture.names, strict=True))
    return found


def _body(part: Solid) -> list[Any]:
    match part:
        case Lathe():
            return [part.kind, [*_whole(part.center), *_whole(part.axes.ravel())], round(part.half, 4)]
        case Mesh():
            return ["mesh", _whole(part.vertices.ravel()), [list(face) for face in part.faces]]
        case Plane():
            return ["plane", [*_whole(float(part.foot @ part.normal) * part.normal), *_whole(part.normal)]]
        case Line():
            return ["ray" if part.endless else "line", [*_whole(part.start), *_whole(part.end)]]
        case Dot():
            return ["dot", _whole(part.at)]


def _whole(numbers: Array) -> list[int]:
    return [round(x * UNITS) for x in numbers.tolist()]


def static_svg(bucket: Bucket) -> str:
    """The still picture, for a page that has the style of `style`."""
    return still(picture_of(bucket))


def figure(bucket: Bucket) -> Markup:
    """The whole figure: the still picture, which the script makes an interactive one, with its notes."""
    return embedded(picture_of(bucket))


def embedded(picture: Picture) -> Markup:
    """Any picture as a figure of a page that has `style` and `script`."""
    data = json.dumps(_data(picture), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    quoted = data.replace("&", "&amp;").replace("'", "&#39;").replace("<", "&lt;").replace(">", "&gt;")
    notes = f"<figcaption>{escape(' '.join(picture.notes))}</figcaption>" if picture.notes else ""
    return Markup(f"<figure class=\"scene\" data-scene='{quoted}'>{still(picture)}{notes}</figure>")


@cache
def script() -> str:
    """The viewer as one script, without comments and blanks that mean nothing."""
    lines = (COMMENT.sub("", line).strip() for name in SCRIPTS for line in _own(name).splitlines())
    code = "\n".join(line for line in lines if line)
    return f"(() => {{\n'use strict';\n{STRING.sub(_tight, code)}\n}})();\n"


COMMENT = re.compile(r"(?:^|\s)\s*// .*$")
STRING = re.compile(
    r"(?P<string>'[^'\n]*'|`[^`]*`)"
    r"|\s*(?P<sign>=>|[=!]==|[<>]=|&&|\|\||[-+*]=|[=?:*<>&,;{}()\[\]])\s*"
    r"| (?P<term>[-+/]) (?![-+])"
)
"""A text, which stays as it is; or a sign, around which blanks mean nothing: each statement ends with a semicolon."""


def _tight(found: re.Match[str]) -> str:
    return found["string"] or found["sign"] or found["term"]


@cache
def style() -> str:
    """Style sheet of the figures, light and dark."""
    return _own("still.css") + _own("viewer.css")


def _own(name: str) -> str:
    return files("reports.viewer").joinpath(name).read_text(encoding="utf-8")
