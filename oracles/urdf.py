"""Collision elements of a URDF file: boxes, spheres, cylinders, capsules and meshes of a robot's links, at zero pose.

Only what collides is read: links with their collision elements, and the joints' fixed placements, which put all links
into the frame of the root link. The files are strangers': no document type and so no entities, limits on size and
depth, and one error that names the element and its line.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np

from oracles.meshfiles import LARGEST_COORDINATE, ModelError
from refimpl.linear import Array, apply, quaternion_product, rotation_matrix

DEEPEST, MOST_NODES = 40, 100_000
LONGEST_SHOWN = 80


@dataclass(frozen=True)
class Pose:
    """The motion x ↦ position + R(rotation)·x."""

    position: Array
    rotation: Array

    def after(self, outer: Pose) -> Pose:
        """Make this pose's frame part of another's."""
        position = outer.position + apply(rotation_matrix(outer.rotation), self.position)
        return Pose(position, quaternion_product(outer.rotation, self.rotation))


ORIGIN = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


@dataclass(frozen=True)
class Element:
    """One collision element, in the frame of the root link.

    Attributes
    ----------
    sort
        "box", "sphere", "cylinder", "capsule" or "mesh".
    sizes
        Full extents of a box; radius; radius and length (without a capsule's caps), along z; scale of a mesh.
    file
        What a mesh element says about where its mesh is.
    where
        The link, and the line in the file.
    """

    sort: str
    sizes: tuple[float, ...]
    pose: Pose
    where: str
    file: str = ""


@dataclass
class _Node:
    tag: str
    attributes: Mapping[str, str]
    line: int
    children: list[_Node] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[_Node]:
        """Children of a name."""
        return (child for child in self.children if child.tag == tag)

    def one(self, tag: str) -> _Node | None:
        """First child of a name."""
        return next(self.all(tag), None)

    @property
    def where(self) -> str:
        """Tag, name if there is one, and line."""
        name = self.attributes.get("name", "")
        return f"<{shown(self.tag)}{f' {shown(name)}' if name else ''}> in line {self.line}"

    def text(self, attribute: str) -> str:
        """Attribute that must be there."""
        if attribute not in self.attributes:
            raise ModelError(f"{self.where} has no attribute {attribute}")
        return self.attributes[attribute]

    def numbers(self, attribute: str, count: int, default: str | None = None) -> tuple[float, ...]:
        """Finite numbers of an attribute, of a size that a model may have."""
        said = self.text(attribute) if default is None else self.attributes.get(attribute, default)
        try:
            numbers = tuple(float(word) for word in said.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(abs(x) <= LARGEST_COORDINATE for x in numbers):
            wanted = "a number" if count == 1 else f"{count} numbers"
            raise ModelError(f"{self.where}: {attribute} must be {wanted} up to 1e9, got {shown(said)!r}")
        return numbers

    def lengths(self, attribute: str, count: int) -> tuple[float, ...]:
        """The same, all greater than 0."""
        numbers = self.numbers(attribute, count)
        if not all(x > 0 for x in numbers):
            raise ModelError(f"{self.where}: {attribute} must be greater than 0, got {shown(self.text(attribute))!r}")
        return numbers


def shown(text: str) -> str:
    """A stranger's text, cut to length."""
    return text if len(text) <= LONGEST_SHOWN else text[:LONGEST_SHOWN] + "…"


def collision_elements(data: bytes) -> tuple[Element, ...]:
    """Collision elements of a URDF file.

    Parameters
    ----------
    data
        The file's content.

    Raises
    ------
    ModelError
        Naming the element and its line: for what is no URDF, has no collision element, a size that is none, a shape
        that is not known, or joints that do not make a tree.
    """
    root = _tree(data)
    if root.tag != "robot":
        raise ModelError(f"is no URDF: its root element is {root.where}, not <robot>")
    poses = _link_poses(root)
    found = tuple(
        _element(collision, link, poses[link.attributes["name"]])
        for link in root.all("link")
        for collision in link.all("collision")
    )
    if not found:
        raise ModelError("has no collision element")
    return found


def link_elements(data: bytes, sort: str) -> dict[str, tuple[Element, ...]]:
    """Shapes of each link of a URDF file, in the frame of that link; links without any are left out.

    Parameters
    ----------
    data
        The file's content.
    sort : {"collision", "visual"}

    Raises
    ------
    ModelError
        As for `collision_elements`; the joints do not matter here.
    """
    root = _tree(data)
    if root.tag != "robot":
        raise ModelError(f"is no URDF: its root element is {root.where}, not <robot>")
    found: dict[str, tuple[Element, ...]] = {}
    for link in root.all("link"):
        name = link.text("name")
        if name in found:
            raise ModelError(f"{link.where}: there is a link of that name above it")
        found[name] = tuple(_element(node, link, ORIGIN) for node in link.all(sort))
    return {name: elements for name, elements in found.items() if elements}


def _tree(data: bytes) -> _Node:
    """Parse without entities of its own, which is how a small file becomes a huge one."""
    parser = expat.ParserCreate()
    document = _Node("", {}, 0)
    path, count = [document], 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        node = _Node(tag, attributes, parser.CurrentLineNumber)
        if len(path) > DEEPEST or count > MOST_NODES:
            raise ModelError(f"is too large: {node.where} is nested too deeply or has too many before it")
        path[-1].children.append(node)
        path.append(node)

    def end(_: str) -> None:
        path.pop()

    def refuse(*_: object) -> None:
        raise ModelError(f"line {parser.CurrentLineNumber}: a document type is not read, as it may define entities")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ModelError(f"is no XML: {error}") from None
    except (ValueError, LookupError) as error:  # an encoding that is none
        raise ModelError(f"is no XML: {shown(str(error))}") from None
    return document.children[0]


def _link_poses(robot: _Node) -> dict[str, Pose]:
    """Pose of every link in the frame of the root link, all joints at 0."""
    links: dict[str, _Node] = {}
    for link in robot.all("link"):
        name = link.text("name")
        if name in links:
            raise ModelError(f"{link.where}: a link of that name stands in line {links[name].line}")
        links[name] = link
    above: dict[str, tuple[str, Pose]] = {}
    for joint in robot.all("joint"):
        parent, child = (_end(joint, end, links) for end in ("parent", "child"))
        if child in above:
            raise ModelError(f"{joint.where}: link {shown(child)} has two parents")
        above[child] = parent, _origin(joint)
    free = [name for name in links if name not in above]
    if len(free) > 1:
        raise ModelError(f"links {shown(free[0])} and {shown(free[1])} both hang on no joint")
    return _down_the_tree(links, above)


def _end(joint: _Node, end: str, links: Mapping[str, _Node]) -> str:
    node = joint.one(end)
    if node is None:
        raise ModelError(f"{joint.where} has no <{end}>")
    name = node.text("link")
    if name not in links:
        raise ModelError(f"{node.where}: there is no link {shown(name)}")
    return name


def _down_the_tree(links: Iterable[str], above: Mapping[str, tuple[str, Pose]]) -> dict[str, Pose]:
    """Poses of all links, each of which hangs on the joint above it."""
    poses: dict[str, Pose] = {}
    for link in links:
        chain, here = {}, link
        while here not in poses and here in above:
            if here in chain:
                raise ModelError(f"the joints above link {shown(link)} run in a circle")
            parent, joint = above[here]
            chain[here], here = joint, parent
        pose = poses.setdefault(here, ORIGIN)
        for name, joint in reversed(chain.items()):
            poses[name] = pose = joint.after(pose)
    return poses


def _origin(node: _Node) -> Pose:
    """The <origin> of a node: roll, pitch and yaw are turns about x, y and z, which stay where they are, in turn."""
    origin = node.one("origin")
    if origin is None:
        return ORIGIN
    angles = origin.numbers("rpy", 3, "0 0 0")
    rotation = ORIGIN.rotation
    for axis, angle in enumerate(angles):
        turn = np.zeros(4)
        turn[axis], turn[3] = math.sin(angle / 2), math.cos(angle / 2)
        rotation = quaternion_product(turn, rotation)
    return Pose(np.array(origin.numbers("xyz", 3, "0 0 0")), rotation)


def _element(collision: _Node, link: _Node, frame: Pose) -> Element:
    geometry = collision.one("geometry")
    if geometry is None or not geometry.children:
        raise ModelError(f"{collision.where}, {link.where}, has no geometry")
    shape = geometry.children[0]
    pose, where = _origin(collision).after(frame), f"{shape.where}, {link.where}"
    match shape.tag:
        case "box":
            return Element("box", shape.lengths("size", 3), pose, where)
        case "sphere":
            return Element("sphere", shape.lengths("radius", 1), pose, where)
        case "cylinder" | "capsule":
            sizes = shape.lengths("radius", 1) + shape.lengths("length", 1)
            return Element(shape.tag, sizes, pose, where)
        case "mesh":
            scale = shape.numbers("scale", 3, "1 1 1")
            if not all(scale):
                raise ModelError(f"{where}: scale must not be 0, got {shown(shape.text('scale'))!r}")
            return Element("mesh", scale, pose, where, shape.text("filename"))
    raise ModelError(f"{where}: {shown(shape.tag)} is no shape that is read")
