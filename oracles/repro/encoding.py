"""Shapes and certificates as plain data of a script: what the checker of `oracles.repro.pieces` reads."""

from __future__ import annotations

from typing import Any

from oracles.motion import Motion
from oracles.world import is_flat
from refimpl import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Ray,
    Sphere,
    flat,
)
from refimpl.proof import Certificate, to_json

SOLIDS, UNIONS, RAYS = "solids", "unions", "rays"
FIELDS: dict[type[Proxy], tuple[str, ...]] = {
    Point: ("position",),
    Ray: ("origin", "direction"),
    Sphere: ("center", "radius"),
    Capsule: ("p", "q", "radius"),
    HalfSpace: ("normal", "k"),
    AABB: ("lower", "upper"),
    Box: ("center", "half_extents", "rotation"),
    KDOP: ("directions", "lower", "upper"),
    Ellipsoid: ("center", "radii", "rotation"),
    Cylinder: ("p", "q", "radius"),
    ConvexPolyhedron: ("numbers", "position", "rotation"),
    Polyhedron: ("vertices", "triangles", "position", "rotation"),
    flat.FlatPoint: ("position",),
    flat.FlatRay: ("origin", "direction"),
    flat.Disc: ("center", "radius"),
    flat.Segment: ("p", "q", "radius"),
    flat.Rectangle: ("lower", "upper"),
    flat.ConvexPolygon: ("numbers",),
}


class NotWritten(ValueError):
    """A certificate that no script can carry."""


def shape_data(shape: Proxy) -> dict[str, Any]:
    """A proxy by the names of its fields."""
    data: dict[str, Any] = {"type": type(shape).__name__}
    if isinstance(shape, Composite):
        return data | {"parts": [shape_data(part) for part in shape.parts]}
    if isinstance(shape, ConvexPolyhedron | flat.ConvexPolygon):
        data["given"] = shape.given
    return data | {name: getattr(shape, name).tolist() for name in FIELDS[type(shape)]}


def motion_data(motion: Motion) -> dict[str, Any]:
    """How two bodies move and where they meet."""
    return motion.to_json()


def kind_of(a: Proxy, b: Proxy) -> str:
    """Which of the checker's ways a certificate about two proxies takes."""
    if isinstance(a, Ray) or isinstance(b, Ray):
        return RAYS
    return UNIONS if isinstance(a, Composite | Polyhedron) or isinstance(b, Composite | Polyhedron) else SOLIDS


def claims_data(certificate: Certificate, a: Proxy, b: Proxy) -> list[dict[str, Any]]:
    """Claims of a certificate, each by the name of what the checker does with it.

    Raises
    ------
    NotWritten
        For claims that mean nothing about these proxies.
    """
    if isinstance(b, Ray):
        raise NotWritten("a ray is the first of two proxies")
    if is_flat(b) and kind_of(a, b) == SOLIDS:
        return [_of_flat(claim) for claim in to_json(certificate)["claims"]]
    rewrite = {SOLIDS: _of_solids, UNIONS: _of_unions, RAYS: _of_rays}[kind_of(a, b)]
    return [rewrite(claim) for claim in to_json(certificate)["claims"]]


def _of_solids(claim: dict[str, Any]) -> dict[str, Any]:
    kind = claim["kind"]
    if kind in ("cover", "part") or claim.get("until") is not None or claim.get("time") is not None:
        raise NotWritten(f"a {kind} of convex solids")
    if kind == "core" and claim["directions"]:
        kind = "endless"
    return {**_without(claim, "until", "time", "directions"), "kind": kind}


def _of_flat(claim: dict[str, Any]) -> dict[str, Any]:
    found = _of_solids(claim)
    if found["kind"] == "core" and not found["triangles"] and len(found["pairs"]) > 1:
        return {"kind": "around", "pairs": found["pairs"]}
    return found


def _of_unions(claim: dict[str, Any]) -> dict[str, Any]:
    if claim["kind"] == "separated":
        return {"kind": "cover", "tree": _tree(claim), "shift": [0, 0, 0], "places": [[], []]}
    if claim["kind"] == "cover" and claim["until"] is None:
        return {**_without(claim, "until"), "tree": _tree(claim["tree"])}
    if claim["kind"] == "part":
        choices = {side: _choice(claim[side]) for side in ("of_a", "of_b")}
        return {"kind": "part", **choices, "claim": _of_solids(claim["claim"])}
    raise NotWritten(f"a {claim['kind']} of unions")


def _of_rays(claim: dict[str, Any]) -> dict[str, Any]:
    if claim["kind"] == "separated":
        return {"kind": "free", "tree": _tree(claim), "until": claim["until"]}
    if claim["kind"] == "cover" and not any(claim["shift"]):
        return {"kind": "free", "tree": _tree(claim["tree"]), "until": claim["until"]}
    inner, of_b = (claim["claim"], claim["of_b"]) if claim["kind"] == "part" else (claim, None)
    if inner["kind"] == "common" and inner["time"] is not None:
        return {"kind": "hit", "time": inner["time"], "p": inner["p"], "of_b": _choice(of_b)}
    raise NotWritten(f"a {inner['kind']} of a ray")


def _choice(choice: Any) -> Any:
    """Which part is meant: a piece of a mesh with its tree."""
    if not isinstance(choice, list):
        return choice
    number, piece = choice
    return [number, {**piece, "tree": _tree(piece["tree"])}]


def _tree(node: dict[str, Any]) -> dict[str, Any]:
    """A tree, without what means nothing in its leaves."""
    if node["kind"] == "separated":
        return _without(node, "until")
    return {**node, "branches": [_tree(branch) for branch in node["branches"]]}


def _without(claim: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in claim.items() if name not in names}
