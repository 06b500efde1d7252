"""Unions of other proxies."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from refimpl.linear import Array, largest
from refimpl.proxy import Proxy, ShapeError
from refimpl.shapes.boxes import AABB, Box
from refimpl.shapes.convex import ConvexPolyhedron
from refimpl.shapes.curved import Cylinder, Ellipsoid
from refimpl.shapes.polyhedron import Polyhedron
from refimpl.shapes.polytopes import KDOP
from refimpl.shapes.simple import Capsule, HalfSpace, Sphere


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Composite(Proxy):
    """The union of its parts.

    Parameters
    ----------
    parts : sequence of solids, at least one
        Any of the solid proxies, half-spaces and other composites among them; they may overlap. Their batch shapes
        broadcast to a common one.
    """

    header: ClassVar[int] = 1
    parts: ClassVar[tuple[Proxy, ...]]
    mesh: ClassVar[Polyhedron | None] = None
    """The mesh of which the parts are the faces, where they are: see `of_faces`."""

    def __init__(self, parts: Sequence[Proxy]) -> None:
        if isinstance(parts, Proxy) or not isinstance(parts, Sequence):
            raise ShapeError(f"Composite.parts: expected a sequence of solids, got {type(parts).__name__}")
        if not parts:
            raise ShapeError("Composite.parts: a union of no parts is empty")
        for i, part in enumerate(parts):
            if type(part) not in CODES:
                raise ShapeError(f"Composite.parts[{i}]: expected a solid proxy, got {type(part).__name__}")
        try:
            batch = np.broadcast_shapes(*(part.batch_shape for part in parts))
        except ValueError:
            named = ", ".join(f"{type(part).__name__} {part.batch_shape}" for part in parts)
            raise ShapeError(f"Composite.parts: batch shapes do not broadcast: {named}") from None
        object.__setattr__(self, "parts", tuple(part.broadcast_to(batch) for part in parts))

    @classmethod
    def of_faces(cls, mesh: Polyhedron) -> Self:
        """Give the surface of a mesh: the union of its faces, each a flat hull of its three corners.

        The parts are made when they are asked for; a batch of poses of one mesh is moved, sliced and answered as one.
        """
        made = object.__new__(cls)
        object.__setattr__(made, "mesh", mesh)
        return made

    def __getattr__(self, name: str) -> Any:
        """Make the parts of a surface, at the first call."""
        if name != "parts" or self.mesh is None:
            raise AttributeError(f"a {type(self).__name__} has no attribute {name!r}")
        pose = self.mesh.position, self.mesh.rotation
        parts = tuple(ConvexPolyhedron.from_vertices(corners, *pose) for corners in self.mesh.solid.corners)
        object.__setattr__(self, "parts", parts)
        return parts

    def _each(self, change: Callable[[Any], Proxy]) -> Self:
        """Apply one change to every part."""
        made = object.__new__(type(self))
        object.__setattr__(made, "parts", tuple(change(part) for part in self.parts))
        return made

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        if self.mesh is not None:
            return self.of_faces(self.mesh._mapped(change))
        return self._each(lambda part: part._mapped(change))

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Leading axes shared by all parts."""
        return self.mesh.batch_shape if self.mesh is not None else self.parts[0].batch_shape

    @property
    def sizes(self) -> tuple[int, ...]:
        """The number of parts."""
        return (len(self.parts if self.mesh is None else self.mesh.triangles),)

    @property
    def storage(self) -> int:
        """How many numbers one proxy of this batch is."""
        return 1 + sum(2 + int(part.pack().shape[-1]) for part in self.parts)

    def pack(self) -> Array:
        """The number of parts; then for each its type's code, the length of its row, and the row."""
        batch = self.batch_shape
        columns = [np.full((*batch, 1), float(len(self.parts)))]
        for part in self.parts:
            row = part.pack()
            head = np.array([CODES[type(part)], row.shape[-1]], dtype=np.float64)
            columns += [np.broadcast_to(head, (*batch, 2)), row]
        return np.concatenate(columns, axis=-1)

    @classmethod
    def unpack(cls, rows: Array) -> Self:
        """Build from the rows that `pack` gives; the rows of one batch must have the same types in the same order."""
        numbers = np.asarray(rows, dtype=np.float64)
        (count,) = cls._read_sizes(numbers)
        parts, at = [], 1
        for _ in range(count):
            head = numbers[..., at : at + 2].reshape(-1, 2)
            if head.shape[-1] < 2 or not len(head) or not np.all(head == head[0]) or head[0, 0] not in KINDS:
                cls._refuse_rows("expected the same known code and length of a part in all rows")
            code, length = head[0].tolist()
            stop = at + 2 + length
            if not length >= 0 or length != int(length) or stop > numbers.shape[-1]:
                cls._refuse_rows(
                    f"a part cannot be {length:g} numbers long, where {numbers.shape[-1] - at - 2} are left"
                )
            at, start = int(stop), at + 2
            kind = KINDS[code]
            parts.append(kind.unpack(numbers[..., start:at]))
        if at != numbers.shape[-1]:
            cls._refuse_rows(f"expected rows of {at} numbers, got an array of shape {numbers.shape}")
        return cls(parts)

    def rebuilt(self, rows: Array) -> Self:
        """Give a composite of the same parts from other packed rows."""
        made, at = [], 1
        for part in self.parts:
            stop = at + 2 + part.pack().shape[-1]
            made.append(part.rebuilt(rows[..., at + 2 : stop]))
            at = stop
        return type(self)(made)

    def identity(self) -> tuple[tuple[Hashable, ...], Array]:
        """The parts' types and forms, and their rows side by side; of a surface the mesh's."""
        if self.mesh is not None:
            form, poses = self.mesh.identity()
            return ("faces", *form), poses
        own = [(type(part).__name__, *part.identity()) for part in self.parts]
        batch = self.batch_shape
        flat = [np.reshape(row, (*batch, math.prod(row.shape[len(batch) :]))) for _, _, row in own]
        rows = np.concatenate(flat, axis=-1)
        return tuple((name, form) for name, form, _ in own), rows

    def __repr__(self) -> str:
        """Name the parts."""
        return f"Composite([{', '.join(map(repr, self.parts))}])"

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent of any part."""
        if self.mesh is not None:
            return np.asarray(np.maximum(largest(self.mesh.position), np.max(np.abs(self.mesh.solid.corners))))
        return np.asarray(np.max([part.magnitude for part in self.parts], axis=0))

    @property
    def reference_point(self) -> Array:
        """The mean of the parts' reference points."""
        count = float(len(self.parts))
        return np.asarray(np.cumsum([part.reference_point / count for part in self.parts], axis=0)[-1])

    def translated(self, offset: Any) -> Self:
        """Move all parts by `offset`."""
        if self.mesh is not None:
            return self.of_faces(self.mesh.translated(offset))
        return type(self)([part.translated(offset) for part in self.parts])

    def rotated(self, rotation: Any) -> Self:
        """Turn all parts about the origin; raises where a part cannot be turned."""
        return type(self)([part.rotated(rotation) for part in self.parts])

    def _scaled(self, factor: Array) -> Self:
        return type(self)([part._scaled(factor) for part in self.parts])

    def _stretched(self, factors: Array) -> Self:
        return type(self)([part._stretched(factors) for part in self.parts])

    def times_power(self, exponent: Any) -> Self:
        """Scale all parts by 2^exponent."""
        return self._each(lambda part: part.times_power(exponent))


CODES: dict[type[Proxy], float] = {
    Sphere: 1.0,
    Capsule: 2.0,
    HalfSpace: 3.0,
    AABB: 4.0,
    Box: 5.0,
    KDOP: 6.0,
    Ellipsoid: 7.0,
    Cylinder: 8.0,
    ConvexPolyhedron: 9.0,
    Polyhedron: 10.0,
    Composite: 11.0,
}
"""Number of each type that may be a part, in a packed composite."""

KINDS = {code: kind for kind, code in CODES.items()}
