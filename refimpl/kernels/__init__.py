"""Scalar kernels: the searches of the pair table, one pair at a time, in plain floats.

Broadcasting numpy is fast where every pair of a batch takes the same steps. A search does not: its pairs end at
different steps. So the searches are written for one pair, as functions of floats and flat sequences of floats, and
run in either of two ways with the same bits: as they are, by Python, or compiled by numba, which
`refimpl.compiling` does for large batches when numba is installed.

What both ways understand is a small language: floats, ints, booleans, tuples of them, flat buffers that are lists
in one and arrays in the other (indexed by single ints, never sliced), ``math.sqrt``, and other kernels. Modules
of this package import each other relatively, for they are loaded a second time to be compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Mark a function of this package as one that numba can compile."""
    return _compiled(function, "never")


def inlined(function: F) -> F:
    """Mark a kernel that numba compiles as a part of those that call it.

    Compiling a function goes through all that it calls once more. Of the ways of a long search, which are called in
    one or two places and call everything, that would take minutes.
    """
    return _compiled(function, "always")


def brief(function: F) -> F:
    """Mark a kernel that is called for one pair and ends so soon that to let other threads in would take longer."""
    return _compiled(function, "never", nogil=False)


def _compiled(function: F, inline: Literal["never", "always"], nogil: bool = True) -> F:
    if __name__ == "refimpl.kernels":
        return function
    import numba  # noqa: PLC0415  only the second, compiled copy of this package needs it

    njit: Any = numba.njit
    # nothing here keeps or makes arrays: without counting references, calls take a third of the time
    return cast(F, njit(cache=True, error_model="numpy", nogil=nogil, inline=inline, _nrt=False)(function))
