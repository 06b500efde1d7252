"""Pictures of buckets: an interactive scene for the page, and the same scene as a still SVG.

A picture is made once, as data (`scene`), from a bucket's witness: `solids` turns the proxies into things that can be
drawn, `frame` chooses what part of space is shown and from where, `marks` finds the points, arrows and planes of the
answers and of the proof. `svg` draws it in Python, and the script (`*.js`) in the browser. Nothing here judges: these
are floats for the eye.
"""

from reports.viewer.model import model_figure, model_picture
from reports.viewer.page import figure, scene_data, script, static_svg, style
from reports.viewer.svg import picture

__all__ = ["figure", "model_figure", "model_picture", "picture", "scene_data", "script", "static_svg", "style"]
