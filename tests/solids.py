"""Meshes that the tests share: prisms, tori, boxes with cavities, all given by formulas."""

from __future__ import annotations

import numpy as np

from refimpl.linear import Array
from refimpl.meshes import Triangles

Mesh = tuple[Array, Triangles]

L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
U_SHAPE = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]


def box(lower: object = (0, 0, 0), upper: object = (1, 1, 1)) -> Mesh:
    """An axis-aligned box."""
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return low + corners * (high - low), np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def prism(outline: list[tuple[float, float]], height: float = 1.0) -> Mesh:
    """A prism over a simple polygon that turns anticlockwise."""
    n = len(outline)
    flat = np.array(outline, dtype=float)
    vertices = np.concatenate([np.c_[flat, np.zeros(n)], np.c_[flat, np.full(n, height)]])
    faces = [f for i in range(n) for j in [(i + 1) % n] for f in ((i, j, j + n), (i, j + n, i + n))]
    for a, b, c in _ears(outline):
        faces += [(a, c, b), (a + n, b + n, c + n)]
    return vertices, np.array(faces)


def _ears(outline: list[tuple[float, float]]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon, ear by ear."""
    left, found = list(range(len(outline))), []

    def area(i: int, j: int, k: int) -> float:
        (a, b), (c, d), (e, f) = outline[i], outline[j], outline[k]
        return (c - a) * (f - b) - (d - b) * (e - a)

    while len(left) > 3:
        for at in range(len(left)):
            i, j, k = left[at - 1], left[at], left[(at + 1) % len(left)]
            others = [p for p in left if p not in (i, j, k)]
            if area(i, j, k) > 0 and not any(
                area(i, j, p) >= 0 and area(j, k, p) >= 0 and area(k, i, p) >= 0 for p in others
            ):
                found.append((i, j, k))
                del left[at]
                break
    return [*found, tuple(left)]  # type: ignore[list-item]


def torus(around: int = 12, across: int = 8, ring: float = 1.0, tube: float = 0.4) -> Mesh:
    """A torus about the z axis."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    x = (ring + tube * np.cos(b)) * np.cos(a)
    y = (ring + tube * np.cos(b)) * np.sin(a)
    vertices = np.stack([x, y, tube * np.sin(b)], axis=-1).reshape(-1, 3)

    def at(i: int, j: int) -> int:
        return (i % around) * across + j % across

    faces = []
    for i in range(around):
        for j in range(across):
            faces += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    return vertices, np.array(faces)


def together(*meshes: Mesh) -> Mesh:
    """Several meshes as one list of faces."""
    starts = np.cumsum([0] + [len(v) for v, _ in meshes])
    return (
        np.concatenate([v for v, _ in meshes]),
        np.concatenate([t + s for (_, t), s in zip(meshes, starts, strict=False)]),
    )


def hollow_box(inner: float = 0.5) -> Mesh:
    """The box from −1 to 1 with a box-shaped cavity."""
    v, t = box((-inner,) * 3, (inner,) * 3)
    return together(box((-1, -1, -1), (1, 1, 1)), (v, t[:, ::-1]))


def turned(mesh: Mesh, seed: int) -> Mesh:
    """A mesh in general position: turned, shifted, scaled, with rounded vertices."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    return mesh[0] @ q.T * rng.uniform(0.1, 10) + rng.normal(size=3), mesh[1]


SOLIDS = {
    "box": box(),
    "L": prism(L_SHAPE),
    "U": prism(U_SHAPE),
    "torus": torus(),
    "hollow": hollow_box(),
    "two": together(box(), box((2, 0, 0), (3, 1, 1))),
}
