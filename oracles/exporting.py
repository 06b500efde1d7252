"""Proxies written for other programs: as JSON, and as a URDF whose collision elements they are.

A URDF has boxes, spheres, cylinders, and in PyBullet capsules. Other convex solids stand beside it as meshes, of which
physics engines take the convex hull; an ellipsoid becomes a hull with flat faces around it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from oracles.scene import shape_from_json, shape_to_json
from refimpl.linear import Array, norm, perpendicular, rotation_matrix
from refimpl.mass import MassProperties
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Proxy,
    Sphere,
    UnsupportedOperation,
)

FORMAT = "proxyproof-proxies"
LARGEST_TEXT = 64 * 2**20
"""Characters of a file of proxies that are read."""
LEVELS = 3
"""How often the faces of an icosahedron are divided for the hull around an ellipsoid: 1280 triangles."""
STILL = np.eye(3)


# -- JSON ----------------------------------------------------------------------------------------------------


def proxies_to_json(model: str, proxies: Mapping[str, Proxy]) -> str:
    """Named proxies as JSON, every bit of them; `proxies_from_json` reads it back."""
    data = {
        "format": FORMAT,
        "model": model,
        "proxies": {name: shape_to_json(proxy) for name, proxy in proxies.items()},
    }
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def proxies_from_json(text: str) -> dict[str, Proxy]:
    """Proxies of a file that `proxies_to_json` wrote; raises `ValueError` for anything else, whoever made it."""
    if len(text) > LARGEST_TEXT:
        raise ValueError(f"not a file of proxies: more than {LARGEST_TEXT} characters")
    try:
        data = json.loads(text)
        if data["format"] != FORMAT:
            raise ValueError(f"not a file of proxies: its format is {str(data['format'])[:40]!r}, not {FORMAT!r}")
        return {str(name): shape_from_json(shape) for name, shape in data["proxies"].items()}
    except RecursionError:
        raise ValueError("not a file of proxies: it is nested too deeply") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not a file of proxies: {type(error).__name__}: {error}") from None


# -- URDF ----------------------------------------------------------------------------------------------------


@dataclass
class Robot:
    """A URDF and what stands beside it.

    Attributes
    ----------
    files
        Name and content of each file; the first one is the URDF.
    notes
        How its solids differ from the proxy's, in sentences.
    """

    name: str
    files: dict[str, bytes] = field(default_factory=dict)
    notes: dict[str, None] = field(default_factory=dict)


_Geometry = tuple[str, dict[str, str], Array, Array]
"""Tag, attributes, position and axes (in columns) of one collision element."""


def urdf(proxy: Proxy, name: str, *, matter: MassProperties | None = None, mass: float = 1.0) -> Robot:
    """One link whose collision elements are a proxy, or its parts.

    Parameters
    ----------
    name
        Of the robot; its files are named after it.
    matter
        Mass properties of the solid that the proxy stands for, in the same frame: the link's inertia. Without it the
        link has none, and is fixed in PyBullet's eyes.
    mass
        Of the link.

    Raises
    ------
    UnsupportedOperation
        For a proxy that no URDF holds: half-spaces, rays, points, concave meshes (decompose them first).
    """
    robot = Robot(name)
    root = ET.Element("robot", name=name)
    link = ET.SubElement(root, "link", name=name)
    if matter is not None:
        _inertial(link, matter, mass)
    for tag, attributes, position, axes in _geometries(proxy, robot):
        collision = ET.SubElement(link, "collision")
        ET.SubElement(collision, "origin", xyz=_words(position), rpy=_words(_roll_pitch_yaw(axes)))
        ET.SubElement(ET.SubElement(collision, "geometry"), tag, attributes)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    robot.files = {f"{name}.urdf": text + b"\n", **robot.files}
    return robot


def _words(numbers: Any) -> str:
    """Numbers with every bit."""
    return " ".join(repr(float(x) + 0.0) for x in np.ravel(numbers))


def _inertial(link: ET.Element, matter: MassProperties, mass: float) -> None:
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_words(matter.barycentre), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=_words(mass))
    tensor = matter.of_mass(mass)
    names = {f"i{a}{b}": _words(tensor[i, j]) for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i <= j}
    ET.SubElement(inertial, "inertia", names)


def _roll_pitch_yaw(axes: Array) -> tuple[float, float, float]:
    """Turns about x, then y, then z, which stay where they are; where y's is a right angle, none about z."""
    r = axes.tolist()
    level = math.hypot(r[0][0], r[1][0])
    pitch = math.atan2(-r[2][0], level)
    if level < 1e-12:
        return math.atan2(-r[1][2], r[1][1]), pitch, 0.0
    return math.atan2(r[2][1], r[2][2]), pitch, math.atan2(r[1][0], r[0][0])


def _geometries(proxy: Proxy, robot: Robot) -> Iterable[_Geometry]:
    if isinstance(proxy, Composite):
        for part in proxy.parts:
            yield from _geometries(part, robot)
        return
    write = GEOMETRIES.get(type(proxy))
    if write is None:
        raise UnsupportedOperation(
            f"a {type(proxy).__name__} cannot stand in a URDF: it has boxes, spheres, cylinders, capsules, and convex "
            "hulls of meshes; decompose a concave mesh into hulls"
        )
    yield write(proxy, robot)


def _box(box: Box, _: Robot) -> _Geometry:
    return "box", {"size": _words(2 * box.half_extents)}, box.center, rotation_matrix(box.rotation)


def _sphere(sphere: Sphere, _: Robot) -> _Geometry:
    return "sphere", {"radius": _words(sphere.radius)}, sphere.center, STILL


def _about_axis(shape: Capsule | Cylinder, robot: Robot) -> _Geometry:
    """Stand it on the middle of its segment, which lies along z and does not count the caps."""
    tag = type(shape).__name__.lower()
    if tag == "cylinder":
        robot.notes["PyBullet makes a prism of a cylinder, unless it is loaded with URDF_USE_IMPLICIT_CYLINDER"] = None
    length = float(norm(shape.q - shape.p))
    if tag == "capsule" and length == 0:  # no reader has to take a capsule without length
        return _sphere(Sphere(shape.p, shape.radius), robot)
    axis = (shape.q - shape.p) / length if length > 0 else STILL[2]
    across = perpendicular(axis)
    axes = np.stack([across, np.cross(axis, across), axis], axis=-1)
    sizes = {"radius": _words(shape.radius), "length": _words(length)}
    return tag, sizes, shape.p / 2 + shape.q / 2, axes


def _mesh(corners: Array, robot: Robot) -> dict[str, str]:
    """Write the hull of some corners as an OBJ file beside the URDF."""
    import trimesh  # noqa: PLC0415  an extra, and slow to import

    number = len(robot.files)
    hull = trimesh.convex.convex_hull(corners)
    file = f"{robot.name}-{number}.obj"
    text: str = hull.export(file_type="obj", include_normals=False, include_texture=False, header="", digits=17)
    robot.files[file] = text.encode()
    return {"filename": file}


def _convex(hull: ConvexPolyhedron, robot: Robot) -> _Geometry:
    return "mesh", _mesh(hull.hull.vertices, robot), hull.position, rotation_matrix(hull.rotation)


def _kdop(kdop: KDOP, robot: Robot) -> _Geometry:
    robot.notes["the k-DOP is written as the hull of its corners"] = None
    return "mesh", _mesh(kdop.hull.vertices, robot), np.zeros(3), STILL


def _ellipsoid(ellipsoid: Ellipsoid, robot: Robot) -> _Geometry:
    """A polyhedron around it: the icosphere's, pushed out until its faces touch the unit ball."""
    import trimesh  # noqa: PLC0415  an extra, and slow to import

    ball = trimesh.creation.icosphere(subdivisions=LEVELS)
    near = float(np.min(np.abs(np.sum(ball.face_normals * ball.triangles[:, 0], axis=1))))
    corners = np.array(ball.vertices) / (near * (1 - 1e-9))
    share = 100 * (1 / near - 1)
    robot.notes[f"the ellipsoid is written as a hull around it, up to {share:.1f} % larger"] = None
    return "mesh", _mesh(corners * ellipsoid.radii, robot), ellipsoid.center, rotation_matrix(ellipsoid.rotation)


GEOMETRIES: dict[type[Proxy], Callable[[Any, Robot], _Geometry]] = {
    AABB: lambda box, robot: _box(box.to_box(), robot),
    Box: _box,
    Sphere: _sphere,
    Capsule: _about_axis,
    Cylinder: _about_axis,
    ConvexPolyhedron: _convex,
    KDOP: _kdop,
    Ellipsoid: _ellipsoid,
}
"""What each type is written as."""
