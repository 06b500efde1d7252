"""A scene: two proxies and a query, of impacts and sweeps also their motion; with a name for where it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from oracles.course import Course
from oracles.motion import Motion
from oracles.world import WORLDS, is_flat
from refimpl.linear import Array
from refimpl.shapes import Proxy, Ray

DISTANCE, CONTACTS, BOOLEAN, RAYCAST = "distance", "contacts", "boolean", "raycast"
IMPACT, SWEEP = "impact", "sweep"
QUERIES = (DISTANCE, CONTACTS, BOOLEAN, IMPACT, SWEEP, RAYCAST)
MOVING = (IMPACT, SWEEP)
"""Queries whose scenes have a motion, and regimes of their own."""

MOST_NUMBERS = 1_000_000
"""No shape of a scene from a stranger may be larger."""

PAIRS: tuple[tuple[type[Proxy], type[Proxy]], ...] = tuple(pair for world in WORLDS for pair in world.table)
"""Every pair of types: those of space, then those of the plane."""
TYPES: dict[str, type[Proxy]] = {kind.__name__: kind for pair in PAIRS for kind in pair}


@dataclass(frozen=True)
class Cell:
    """One cell of the campaign: a query on a pair of types, in the order of the pair table."""

    query: str
    type_a: type[Proxy]
    type_b: type[Proxy]

    @property
    def pair(self) -> str:
        """Readable name of the pair, such as ``Sphere–Box``."""
        return f"{self.type_a.__name__}–{self.type_b.__name__}"


def cells() -> list[Cell]:
    """Every cell: rays are cast, all other pairs answer distance, contacts, the boolean, impacts and sweeps."""
    found = []
    for type_a, type_b in PAIRS:
        queries = (RAYCAST,) if issubclass(type_a, Ray) else (DISTANCE, CONTACTS, BOOLEAN, IMPACT, SWEEP)
        found += [Cell(query, type_a, type_b) for query in queries]
    return found


def cells_of(pair: tuple[type[Proxy], type[Proxy]]) -> list[Cell]:
    """Cells of one pair."""
    return [cell for cell in cells() if (cell.type_a, cell.type_b) == pair]


@dataclass(frozen=True)
class Scene:
    """Two single proxies and a query.

    Attributes
    ----------
    source
        Where the scene came from: regime, and (seed, shard, index) or the hunter's name.
    motion
        Of impacts how the two move and where they meet, of sweeps their ways; None of all others.
    """

    query: str
    a: Proxy
    b: Proxy
    regime: str
    source: str = ""
    motion: Motion | Course | None = None

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Numbers of both sides, as engines get them, not to be written to: those of the motion stand behind A's."""
        rows = packed_rows(self.a, self.b, self.motion)
        for numbers in rows:
            numbers.flags.writeable = False
        return rows

    @property
    def id(self) -> str:
        """Hash of the content: the query, the types and every bit of their numbers."""
        digest = hashlib.sha256(f"{self.query} {type(self.a).__name__} {type(self.b).__name__}".encode())
        for numbers in self.rows:
            digest.update(np.ascontiguousarray(numbers + 0.0, dtype="<f8").tobytes())
        return digest.hexdigest()[:12]

    @property
    def cell(self) -> Cell:
        """The cell to which it belongs."""
        return Cell(self.query, type(self.a), type(self.b))

    @cached_property
    def size(self) -> float:
        """Largest absolute coordinate, extent or way in the scene; of an impact the largest velocity."""
        return float(size_of(self.a, self.b, self.motion))

    @property
    def impact(self) -> Motion | None:
        """The motion of an impact; None of all others."""
        return self.motion if isinstance(self.motion, Motion) else None

    @property
    def course(self) -> Course | None:
        """The motions of a sweep; None of all others."""
        return self.motion if isinstance(self.motion, Course) else None

    def to_json(self) -> dict[str, Any]:
        """Plain data from which `from_json` rebuilds the scene to the bit."""
        shapes = [shape_to_json(s) for s in (self.a, self.b)]
        return {
            "query": self.query,
            "a": shapes[0],
            "b": shapes[1],
            "regime": self.regime,
            "source": self.source,
            **({} if self.motion is None else {"motion": self.motion.to_json()}),
        }

    @classmethod
    def from_json(cls, data: Any) -> Scene:
        """Rebuild a scene; raises `ValueError` for data that is none."""
        try:
            query, regime, source = (str(data[k])[:200] for k in ("query", "regime", "source"))
            a, b = (shape_from_json(data[k]) for k in ("a", "b"))
            motion = READ_MOTION[query](data["motion"]) if query in MOVING else None
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a scene: {error}") from None
        if query not in QUERIES:
            raise ValueError(f"not a scene: unknown query {query!r}; known are {', '.join(QUERIES)}")
        if is_flat(b) and motion is not None and motion.leaves_the_plane:
            raise ValueError("not a scene: flat proxies move in the plane, without turning")
        return cls(query, a, b, regime, source, motion)


READ_MOTION: dict[str, Callable[[Any], Motion | Course]] = {IMPACT: Motion.from_json, SWEEP: Course.from_json}
UNPACK_MOTION: dict[str, Callable[[Array], Motion | Course]] = {IMPACT: Motion.unpack, SWEEP: Course.unpack}


def size_of(a: Proxy, b: Proxy, motion: Motion | Course | None) -> Array:
    """Sizes of scenes, single or in batches, as `Scene.size` has them."""
    if isinstance(motion, Motion):
        return motion.speed
    size = np.maximum(a.magnitude, b.magnitude)
    return np.asarray(size if motion is None else np.maximum(size, motion.reach))


def packed_rows(a: Proxy, b: Proxy, motion: Motion | Course | None) -> tuple[Array, Array]:
    """Numbers of both sides, single or in batches; those of the motion stand behind A's."""
    first = a.pack() if motion is None else np.concatenate([a.pack(), motion.pack()], axis=-1)
    return first, b.pack()


def shape_to_json(shape: Proxy) -> dict[str, Any]:
    """Plain data from which `shape_from_json` rebuilds a proxy to the bit."""
    return {"type": type(shape).__name__, "numbers": shape.pack().tolist()}


def shape_from_json(data: Any) -> Proxy:
    """Rebuild a proxy; raises `ValueError`, or what indexing other data raises, for data that is none."""
    kind = TYPES.get(data["type"])
    if kind is None:
        raise ValueError(f"not a scene: unknown type {data['type']!r}; known are {', '.join(TYPES)}")
    numbers = data["numbers"]
    if not isinstance(numbers, list) or len(numbers) > MOST_NUMBERS:
        raise ValueError(f"not a scene: a {kind.__name__} is a list of at most {MOST_NUMBERS} numbers")
    if not kind.header and len(numbers) != kind.width():
        raise ValueError(f"not a scene: a {kind.__name__} has {kind.width()} numbers")
    return kind.unpack(np.array([float(x) for x in numbers]))


def readable(shape: Proxy) -> str:
    """Constructor call that rebuilds the proxy, in full precision."""
    return repr(shape)
