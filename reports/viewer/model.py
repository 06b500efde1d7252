"""The picture of a model and a proxy of it, one over the other."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from refimpl.shapes import Polyhedron, Proxy
from reports.viewer.cut import shown
from reports.viewer.frame import View, choose, exponent_of
from reports.viewer.page import embedded
from reports.viewer.scene import Picture
from reports.viewer.solids import few_triangles_of, solids

MODEL_TRIANGLES, PROXY_TRIANGLES = 1000, 600
MOST_PARTS = 64
FROM = View(-55.0, 18.0)


def model_picture(model: Polyhedron, proxy: Proxy, name: str) -> Picture:
    """Picture of a model, as A, and of a proxy of it that is called so, as B."""
    with np.errstate(all="ignore"):  # what cannot be held in doubles is left out
        exponent = exponent_of([float(model.magnitude), float(proxy.magnitude)])
        drawn = few_triangles_of(model, exponent, MODEL_TRIANGLES)
        told = f"the model is drawn with {drawn.told}" if drawn.told else ""
        bodies, words = solids(proxy, exponent, triangles=PROXY_TRIANGLES, most=MOST_PARTS)
        if proxy is model:
            bodies, words = bodies[:0], words[:0]
        frame = choose(exponent, [drawn], bodies or [drawn], [], float("nan"))
        a, b = shown("the model", [drawn], frame), shown(f"the {name}", bodies, frame)
        notes = [
            note for note in (told, *(f"the {name} is drawn with {one}" for one in words), *a.notes, *b.notes) if note
        ]
        return Picture(
            a=a.parts,
            b=b.parts,
            ghost=[],
            marks=[],
            view=FROM,
            size=frame.size,
            said=[],
            label=f"The model and its {name}" if bodies else "The model",
            notes=[f"{note[0].upper()}{note[1:]}." for note in notes],
            engine="",
            names=("model", name),
        )


def model_figure(model: Polyhedron, proxy: Proxy, name: str) -> Markup:
    """The same as a figure of a page."""
    return embedded(model_picture(model, proxy, name))
