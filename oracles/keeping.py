"""Keeping what was made of the last few batches: queries and engines ask about the same rows one after the other."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from functools import wraps
from hashlib import sha1
from typing import Concatenate, ParamSpec, TypeVar

import numpy as np

from refimpl.linear import Array
from refimpl.proxy import Proxy

MOST_BATCHES = 8
"""A batch as it was drawn, and as each engine sees it for each query, for both sides."""

P = ParamSpec("P")
T = TypeVar("T")
K = TypeVar("K")
V = TypeVar("V")


_rows: OrderedDict[int, tuple[Proxy, Array]] = OrderedDict()
_contents: OrderedDict[int, tuple[Array, bytes]] = OrderedDict()


def rows_of(shape: Proxy) -> Array:
    """Packed numbers of a batch, the very same array each time: those of a mesh are many."""
    return _kept_of(_rows, shape, _packed)


def shape_of(rows: Array, kind: type[Proxy]) -> Proxy:
    """The batch of which these are the rows: the very one that `rows_of` was asked about, with all that it derived."""
    known = next((shape for shape, packed in _rows.values() if packed is rows), None)
    return kind.unpack(rows) if known is None else known


def _packed(shape: Proxy) -> Array:
    rows = shape.pack()
    rows.flags.writeable = False
    return rows


def _content(rows: Array) -> bytes:
    """Hash of an array; of one that nobody can change it is kept."""
    if rows.flags.writeable or rows.base is not None:
        return _hashed(rows)
    return _kept_of(_contents, rows, _hashed)


def _hashed(rows: Array) -> bytes:
    return sha1(np.ascontiguousarray(rows).data, usedforsecurity=False).digest()


def _kept_of(store: OrderedDict[int, tuple[K, V]], one: K, make: Callable[[K], V]) -> V:
    """What was made of this very object, which is kept too, so that no other one gets its id."""
    if id(one) not in store:
        store[id(one)] = one, make(one)
        if len(store) > MOST_BATCHES:
            store.popitem(last=False)
    store.move_to_end(id(one))
    return store[id(one)][1]


def kept_by_rows(make: Callable[Concatenate[Array, P], T]) -> Callable[Concatenate[Array, P], T]:
    """Make of the same rows (and other arguments) the very same, if it is one of the last that were asked for."""
    made: OrderedDict[tuple[object, ...], T] = OrderedDict()

    @wraps(make)
    def found(rows: Array, /, *others: P.args, **named: P.kwargs) -> T:
        key = (_content(rows), rows.shape, *others, *named.items())
        if key not in made:
            made[key] = make(rows, *others, **named)
            if len(made) > MOST_BATCHES:
                made.popitem(last=False)
        made.move_to_end(key)
        return made[key]

    return found
