"""The proxies: what is tested for collision, as immutable data.

The numbers stored are the shape: a double is an exact rational, and each constructor's docstring says which
closed set its numbers mean. Fields are arrays whose leading axes are batch axes; fields broadcast together.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import (
    Array,
    apply,
    as_floats,
    dot,
    largest,
    norm,
    power_of_two,
    quaternion_product,
    rotation_matrix,
    scale,
)


class ShapeError(ValueError):
    """A proxy was given numbers that mean no set; the text names the field and the value."""


class UnsupportedOperation(TypeError):
    """A proxy was asked for something its type does not have; the text names the type that does."""


def _number(*, minimum: float | None = None, open_end: bool = False) -> Any:
    return field(metadata={"width": 0, "minimum": minimum, "open_end": open_end})


def _vector(*, width: int = 3, minimum: float | None = None, nonzero: bool = False) -> Any:
    return field(metadata={"width": width, "minimum": minimum, "nonzero": nonzero})


_LAYOUTS: dict[type[Proxy], tuple[tuple[str, int], ...]] = {}


def _layout(kind: type[Proxy]) -> tuple[tuple[str, int], ...]:
    """Names and widths of a type's fields, in order; width 0 is a single number."""
    if kind not in _LAYOUTS:
        _LAYOUTS[kind] = tuple((f.name, f.metadata["width"]) for f in fields(kind))
    return _LAYOUTS[kind]


@dataclass(frozen=True, eq=False, repr=False)
class Proxy:
    """What all proxies share: validation, batches, packing into rows of numbers, isometries."""

    is_solid: ClassVar[bool] = True

    def __post_init__(self) -> None:
        columns = []
        for spec in fields(self):
            width = spec.metadata["width"]
            value = self._numbers(spec.name, getattr(self, spec.name))
            if width and (value.ndim == 0 or value.shape[-1] != width):
                raise ShapeError(
                    f"{self._name(spec.name)}: expected {width} numbers, got an array of shape {value.shape}"
                )
            self._check(spec, value)
            columns.append(value)
        self._store(columns)
        self._check_together()

    def _name(self, name: str) -> str:
        return f"{type(self).__name__}.{name}"

    def _numbers(self, name: str, value: Any) -> Array:
        try:
            return as_floats(value)
        except (TypeError, ValueError, OverflowError) as error:
            raise ShapeError(f"{self._name(name)}: not an array of real numbers: {value!r} ({error})") from None

    def _check(self, spec: Any, value: Array) -> None:
        rules = spec.metadata
        self._refuse(spec.name, value, ~np.isfinite(value), "must be finite")
        if rules.get("minimum") is not None:
            low = rules["minimum"]
            if rules.get("open_end"):
                self._refuse(spec.name, value, value <= low, f"must be greater than {low:g}")
            else:
                self._refuse(spec.name, value, value < low, f"must be at least {low:g}")
        if rules.get("nonzero"):
            self._refuse(spec.name, value, np.all(value == 0, axis=-1), "must not be zero")

    def _refuse(self, name: str, value: Array, bad: Any, why: str) -> None:
        if np.any(bad):
            where = tuple(int(i) for i in np.argwhere(bad)[0])
            at = f" at index {where}" if where else ""
            raise ShapeError(f"{self._name(name)} {why}, got {np.asarray(value)[where].tolist()!r}{at}")

    def _check_together(self) -> None:
        """Check what no field can check alone."""

    def _store(self, columns: list[Array]) -> None:
        """Give every field the common batch shape, and close it against writing."""
        layout = _layout(type(self))
        batches = [c.shape[:-1] if w else c.shape for c, (_, w) in zip(columns, layout, strict=True)]
        try:
            batch = np.broadcast_shapes(*batches)
        except ValueError:
            named = ", ".join(f"{n} {b}" for (n, _), b in zip(layout, batches, strict=True))
            raise ShapeError(f"{type(self).__name__}: batch shapes do not broadcast: {named}") from None
        for (name, width), column in zip(layout, columns, strict=True):
            full = np.broadcast_to(column, (*batch, width) if width else batch)
            full.flags.writeable = False
            object.__setattr__(self, name, full)

    @classmethod
    def _trusted(cls, *columns: Array) -> Self:
        """Build without validation, from arrays that this package computed from a valid shape."""
        shape = object.__new__(cls)
        shape._store([np.asarray(c) for c in columns])
        return shape

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Leading axes shared by all fields; ``()`` for a single proxy."""
        name, width = _layout(type(self))[0]
        shape: tuple[int, ...] = getattr(self, name).shape
        return shape[:-1] if width else shape

    def __getitem__(self, index: Any) -> Self:
        """Proxies at `index` of the batch axes."""
        if not isinstance(index, tuple):
            index = (index,)
        columns = []
        for name, width in _layout(type(self)):
            value = getattr(self, name)
            columns.append(value[(*index, Ellipsis, slice(None))] if width else value[index])
        return self._trusted(*columns)

    def __repr__(self) -> str:
        """Name every field in full precision; a large batch is named by its shape."""
        if np.prod(self.batch_shape, dtype=int) > 4:
            return f"{type(self).__name__}(<batch of shape {self.batch_shape}>)"
        values = ", ".join(f"{name}={getattr(self, name).tolist()!r}" for name, _ in _layout(type(self)))
        return f"{type(self).__name__}({values})"

    def __len__(self) -> int:
        if not self.batch_shape:
            raise TypeError(f"a single {type(self).__name__} has no length")
        return self.batch_shape[0]

    @classmethod
    def width(cls) -> int:
        """How many numbers one proxy of this type is."""
        return sum(max(w, 1) for _, w in _layout(cls))

    def pack(self) -> Array:
        """All fields side by side, in the constructor's order; shape (..., width)."""
        parts = [getattr(self, n) if w else getattr(self, n)[..., None] for n, w in _layout(type(self))]
        return np.concatenate(parts, axis=-1)

    @classmethod
    def unpack(cls, rows: Array) -> Self:
        """Build from the rows that `pack` gives; validated like any constructor call."""
        return cls(*cls._split(np.asarray(rows, dtype=np.float64)))

    @classmethod
    def _split(cls, rows: Array) -> list[Array]:
        parts, start = [], 0
        for _, width in _layout(cls):
            parts.append(rows[..., start : start + width] if width else rows[..., start])
            start += max(width, 1)
        return parts

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent, per proxy."""
        return largest(self.pack())

    @property
    def reference_point(self) -> Array:
        """A point by which the proxy is placed: its centre where it has one; shape (..., 3)."""
        raise NotImplementedError

    def translated(self, offset: Any) -> Self:
        """Move by `offset` (..., 3)."""
        raise NotImplementedError

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin by the quaternion `rotation` (..., 4), x y z w, of any non-zero length."""
        raise NotImplementedError

    def scaled(self, factor: Any) -> Self:
        """Scale uniformly about the origin by `factor` > 0."""
        scale_by = as_positive(factor)
        if len(np.shape(scale_by)) > len(self.batch_shape):
            name = type(self).__name__
            raise UnsupportedOperation(
                f"a {name} scales uniformly, by one factor for each proxy: {np.asarray(factor).tolist()!r} is uneven; "
                "scale a mesh or a hull instead, or build each shape from its own numbers"
            )
        return self._scaled(scale_by)

    def _scaled(self, factor: Array) -> Self:
        raise NotImplementedError

    def transformed(self, rotation: Any, translation: Any) -> Self:
        """Turn about the origin, then move: the isometry x ↦ R x + translation."""
        return self.rotated(rotation).translated(translation)


def as_positive(factor: Any) -> Array:
    """Check a scaling factor: one positive number per proxy."""
    value = as_floats(factor)
    if not np.all(np.isfinite(value) & (value > 0)):
        raise UnsupportedOperation(f"a scaling factor must be positive and finite, got {value.tolist()!r}")
    return value


def as_offset(offset: Any) -> Array:
    """Check a translation: vectors (..., 3), finite."""
    v = as_floats(offset)
    if v.ndim == 0 or v.shape[-1] != 3 or not np.all(np.isfinite(v)):
        raise ShapeError(f"a translation is a finite vector (x, y, z), got {np.asarray(offset).tolist()!r}")
    return v


def as_quaternion(rotation: Any) -> Array:
    """Check a rotation: a quaternion (x, y, z, w), finite and not zero."""
    q = as_floats(rotation)
    if q.ndim == 0 or q.shape[-1] != 4 or not np.all(np.isfinite(q)) or np.any(np.all(q == 0, axis=-1)):
        raise ShapeError(f"a rotation is a non-zero quaternion (x, y, z, w), got {np.asarray(rotation).tolist()!r}")
    return q


def _turn(rotation: Any, v: Array) -> Array:
    return apply(rotation_matrix(as_quaternion(rotation)), v)


@dataclass(frozen=True, eq=False, repr=False)
class Point(Proxy):
    """The set {position}.

    Parameters
    ----------
    position : (..., 3)
    """

    is_solid: ClassVar[bool] = False
    position: Array = _vector()

    if TYPE_CHECKING:

        def __init__(self, position: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The position."""
        return self.position

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.position + as_offset(offset))

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.position))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.position))


@dataclass(frozen=True, eq=False, repr=False)
class Ray(Proxy):
    """The set {origin + t·direction, t ≥ 0}; t counts in units of the direction's length.

    Parameters
    ----------
    origin : (..., 3)
    direction : (..., 3)
        Of any non-zero length.
    """

    is_solid: ClassVar[bool] = False
    origin: Array = _vector()
    direction: Array = _vector(nonzero=True)

    if TYPE_CHECKING:

        def __init__(self, origin: ArrayLike, direction: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The origin."""
        return self.origin

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of the origin: the direction's length is no length of the scene."""
        return largest(self.origin)

    def at(self, t: Any) -> Array:
        """Points at times `t`."""
        return self.origin + scale(np.asarray(t, dtype=np.float64), self.direction)

    def translated(self, offset: Any) -> Self:
        """Move the origin by `offset`."""
        return type(self)(self.origin + as_offset(offset), self.direction)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin of the coordinates."""
        return type(self)(_turn(rotation, self.origin), _turn(rotation, self.direction))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.origin), scale(factor, self.direction))


@dataclass(frozen=True, eq=False, repr=False)
class Sphere(Proxy):
    """The ball ‖x − center‖ ≤ radius.

    Parameters
    ----------
    center : (..., 3)
    radius : (...)
        Greater than 0: the sphere of radius 0 is a `Point`.
    """

    center: Array = _vector()
    radius: Array = _number(minimum=0.0, open_end=True)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.radius)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.center), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), factor * self.radius)


@dataclass(frozen=True, eq=False, repr=False)
class Capsule(Proxy):
    """Every point within `radius` of the segment from `p` to `q`.

    Parameters
    ----------
    p, q : (..., 3)
        End points of the inner segment; equal ones make a ball.
    radius : (...)
        At least 0; a capsule of radius 0 is a segment.
    """

    p: Array = _vector()
    q: Array = _vector()
    radius: Array = _number(minimum=0.0)

    if TYPE_CHECKING:

        def __init__(self, p: ArrayLike, q: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The middle of the segment."""
        return self.p / 2 + self.q / 2

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset)
        return type(self)(self.p + shift, self.q + shift, self.radius)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.p), _turn(rotation, self.q), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.p), scale(factor, self.q), factor * self.radius)


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpace(Proxy):
    """The set normal·x + k ≤ 0; the solid lies behind the plane, the normal points out of it.

    Parameters
    ----------
    normal : (..., 3)
        Of any non-zero length.
    k : (...)
        In units of the normal's length: the plane's signed distance from the origin is −k/‖normal‖.
    """

    normal: Array = _vector(nonzero=True)
    k: Array = _number()

    def _check_together(self) -> None:
        with np.errstate(over="ignore"):
            self._refuse("k", self.k, ~np.isfinite(self.magnitude), "puts the plane beyond the largest float")

    if TYPE_CHECKING:

        def __init__(self, normal: ArrayLike, k: ArrayLike) -> None: ...

    @property
    def magnitude(self) -> Array:
        """Distance of the plane from the origin: the normal's length is no length of the scene."""
        exponent = power_of_two(largest(self.normal))
        return np.abs(np.ldexp(self.k, -exponent)) / norm(np.ldexp(self.normal, -exponent[..., None]))

    @property
    def reference_point(self) -> Array:
        """The point of the plane nearest to the origin."""
        exponent = power_of_two(largest(self.normal))
        n = np.ldexp(self.normal, -exponent[..., None])
        return scale(-np.ldexp(self.k, -exponent) / dot(n, n), n)

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.normal, self.k - dot(self.normal, as_offset(offset)))

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.normal), self.k)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(self.normal, factor * self.k)


@dataclass(frozen=True, eq=False, repr=False)
class AABB(Proxy):
    """The axis-aligned box lower ≤ x ≤ upper.

    Parameters
    ----------
    lower, upper : (..., 3)
        Corners, lower ≤ upper in every coordinate; equal ones make the box flat.
    """

    lower: Array = _vector()
    upper: Array = _vector()

    def _check_together(self) -> None:
        self._refuse("upper", self.upper, self.upper < self.lower, "must not be below AABB.lower")

    if TYPE_CHECKING:

        def __init__(self, lower: ArrayLike, upper: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.lower / 2 + self.upper / 2

    def to_box(self) -> Box:
        """The same set as a `Box`, which can be rotated; its centre and extents are rounded."""
        identity = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (*self.batch_shape, 4))
        return Box._trusted(self.reference_point, self.upper / 2 - self.lower / 2, identity)

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset)
        return type(self)(self.lower + shift, self.upper + shift)

    def rotated(self, rotation: Any) -> Self:  # noqa: ARG002  there is none that works
        """Raise: an axis-aligned box does not stay one."""
        raise UnsupportedOperation("an AABB cannot be rotated: it stays aligned with the axes; use Box (AABB.to_box())")

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.lower), scale(factor, self.upper))


@dataclass(frozen=True, eq=False, repr=False)
class Box(Proxy):
    """The set center + R(rotation)·y with |y_i| ≤ half_extents_i.

    Parameters
    ----------
    center : (..., 3)
    half_extents : (..., 3)
        At least 0; zeros make the box flat.
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.
    """

    center: Array = _vector()
    half_extents: Array = _vector(minimum=0.0)
    rotation: Array = _vector(width=4, nonzero=True)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, half_extents: ArrayLike, rotation: ArrayLike) -> None: ...

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent: a quaternion's length is no length of the scene."""
        return np.maximum(largest(self.center), largest(self.half_extents))

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.half_extents, self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        q = as_quaternion(rotation)
        product = quaternion_product(q / largest(q)[..., None], self.rotation / largest(self.rotation)[..., None])
        return type(self)(_turn(rotation, self.center), self.half_extents, product)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), scale(factor, self.half_extents), self.rotation)
