"""How a pair of types is answered: a row of a pair table, and the words for how exact it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from refimpl.linear import Array, Bools
from refimpl.proxy import Proxy
from refimpl.results import Separation

CLOSED = "closed form"
FINITE = "finite"
ITERATIVE = "iterative"


@dataclass(frozen=True)
class Rule:
    """How one pair of types is answered.

    Attributes
    ----------
    function
        Signed distance with witnesses (solids and points), or time and normal of entry (rays); takes both
        proxies in the row's order, with exactly one batch axis.
    exactness
        "closed form"; "finite" for a bounded number of features or axes; "iterative" for a search that ends when
        its proven gap has closed to rounding.
    algorithm
        What is computed, in the field's words.
    meets
        A cheaper test for `intersect`, where there is one.
    bounds
        The signed distance, and a length below which no translation separates; where that is not the depth itself.
    symmetric
        Of two proxies of one type: whether the function itself answers both orders alike, to the last bit.
    whole
        Whether the function takes a whole batch as it is, and scales each pair itself so that nothing overflows.
    """

    function: Callable[[Any, Any], Any]
    exactness: str
    algorithm: str
    meets: Callable[[Any, Any], Bools] | None = None
    bounds: Callable[[Any, Any], tuple[Separation, Array]] | None = None
    symmetric: bool = False
    whole: bool = False


def require_rows(
    rows: dict[tuple[type[Proxy], type[Proxy]], Rule], pairs: Sequence[tuple[type[Proxy], type[Proxy]]]
) -> None:
    """Raise LookupError for a missing row of a table, or for one that none of the pairs needs."""
    missing = [pair for pair in pairs if pair not in rows]
    surplus = [pair for pair in rows if pair not in pairs]
    if missing or surplus:
        names = ", ".join(f"({a.__name__}, {b.__name__})" for a, b in missing or surplus)
        raise LookupError(f"the pair table {'lacks' if missing else 'has no use for'} {names}")
