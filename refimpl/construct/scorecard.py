"""The scorecard of a model: what each type of proxy costs, how well it fits, and what can be done with it.

Five things speak for or against a proxy: the time to build it, the numbers it is stored in, how tightly it fits (its
volume by the model's, and how far their surfaces are from each other), the transformations that it survives, and the
time of a test against another of its kind (Ericson, Real-Time Collision Detection, 4.1).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from refimpl.bounds import aabb
from refimpl.construct.kinds import KINDS, MODEL
from refimpl.construct.overlap import proxy_volume
from refimpl.construct.surface_distance import surface_distance
from refimpl.construct.surfaces import surface_samples
from refimpl.construct.survival import survives
from refimpl.linear import Array, norm
from refimpl.mass import mass_properties
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.queries import intersect
from refimpl.shapes import Composite, Polyhedron
from refimpl.threads import products_in_one_thread

SEED = 8
FEWEST_PAIRS, MOST_PAIRS = 16, 4096
ENOUGH = 0.02
"""Seconds of tests that tell the time of one."""
MOST_FACES_TESTED = 1000
"""Faces of a model beyond which it is not tested against itself: where two overlap, that may take minutes."""
PLACES = 256
"""Points of a surface that pairs are moved by."""
SMALLEST, LARGEST = 1e-50, 1e50
POINTS = 2048
"""Points on each surface between which distances are measured."""


@dataclass(frozen=True)
class Score:
    """One row of a scorecard.

    Attributes
    ----------
    kind
        How it was built: a name out of `KINDS`.
    proxy
        What was built; None where it could not be, and `fault` says why.
    build : seconds of processor time
    volume_ratio
        Volume of the proxy by that of the model; at least 1 for what contains it.
    out, back : length
        Mean distance of the proxy's surface from the model's, and of the model's from the proxy's.
    survives
        What keeps it from each transformation, empty where it survives it.
    test : seconds of processor time
        Of an `intersect` with another of its kind, in a batch of such pairs, of which half meet.
    """

    kind: str
    proxy: Proxy | None = None
    fault: str = ""
    build: float = math.nan
    volume_ratio: float = math.nan
    out: float = math.nan
    back: float = math.nan
    survives: Mapping[str, str] = field(default_factory=dict)
    test: float = math.nan

    @property
    def title(self) -> str:
        """What its kind is called."""
        return KINDS[self.kind].title

    @property
    def numbers(self) -> int:
        """How many numbers it is stored in, each a double."""
        return 0 if self.proxy is None else self.proxy.storage

    @property
    def type(self) -> str:
        """Type of the proxy; of a composite also how many parts it has."""
        if isinstance(self.proxy, Composite):
            kinds = dict.fromkeys(type(part).__name__ for part in self.proxy.parts)
            return f"Composite of {len(self.proxy.parts)} {' and '.join(kinds)}"
        return "" if self.proxy is None else type(self.proxy).__name__


@dataclass(frozen=True)
class Scorecard:
    """The scores of a model's proxies, and what they are measured against.

    Attributes
    ----------
    volume : length³
    diagonal : length
        Of the model's box; surface distances are best told as shares of it.
    """

    name: str
    model: Polyhedron
    volume: float
    diagonal: float
    scores: tuple[Score, ...]

    @property
    def proxies(self) -> dict[str, Proxy]:
        """What could be built, by kind; not the model itself."""
        return {score.kind: score.proxy for score in self.scores if score.proxy is not None and score.kind != MODEL}


def scorecard(
    model: Polyhedron,
    kinds: Iterable[str] = tuple(KINDS),
    *,
    name: str = "",
    each: Callable[[Score], None] | None = None,
) -> Scorecard:
    """Build and measure proxies of a solid.

    Parameters
    ----------
    model : a single polyhedron
    kinds
        Names out of `KINDS`; by default all.
    name
        Of the model, for those who read the card.
    each
        Is told of each score as soon as it is there, since some take seconds.

    Raises
    ------
    ShapeError
        For a batch, a kind that there is not, and sizes whose powers no double holds.
    """
    if model.batch_shape:
        raise ShapeError(f"scorecard: expected a single Polyhedron, got a batch of shape {model.batch_shape}")
    chosen = list(dict.fromkeys(kinds))
    for kind in chosen:
        if kind not in KINDS:
            raise ShapeError(f"scorecard: there is no kind {kind!r}; there are {', '.join(KINDS)}")
    size = float(model.magnitude)
    if not SMALLEST <= size <= LARGEST:
        raise ShapeError(
            f"scorecard: sizes from {SMALLEST:g} to {LARGEST:g} are measured, this is {size:g}: scale it first"
        )
    volume, box = float(mass_properties(model).volume), aabb(model)
    scores = []
    for kind in chosen:
        with products_in_one_thread():  # threads that wait for work would be counted
            scores.append(_score(kind, model, volume))
        if each is not None:
            each(scores[-1])
    return Scorecard(name, model, volume, float(norm(box.upper - box.lower)), tuple(scores))


def _score(kind: str, model: Polyhedron, volume: float) -> Score:
    start = time.process_time()
    try:
        proxy = KINDS[kind].make(model)
    except (ShapeError, UnsupportedOperation) as error:
        return Score(kind, fault=str(error))
    built = Score(kind, proxy, build=time.process_time() - start, survives=survives(proxy))
    if kind == MODEL:
        test = time_of_test(proxy) if len(model.triangles) <= MOST_FACES_TESTED else math.nan
        return replace(built, build=math.nan, volume_ratio=1.0, out=0.0, back=0.0, test=test)
    apart = surface_distance(proxy, model, points=POINTS)
    return replace(
        built,
        volume_ratio=proxy_volume(proxy).value / volume,
        out=apart.of_proxy.mean,
        back=apart.of_mesh.mean,
        test=time_of_test(proxy),
    )


def time_of_test(proxy: Proxy) -> float:
    """Seconds of an `intersect` of a proxy with itself elsewhere: pairs in a batch, of which half meet.

    They are moved against each other and not turned, as not every type can be; more pairs are taken until the time
    can be measured. What compiles or derives something does so before.
    """
    rng, places = np.random.default_rng(SEED), surface_samples(proxy, PLACES).points
    count = FEWEST_PAIRS
    while True:
        began = time.process_time()
        others = proxy.translated(_half_meeting(proxy, places, count, rng))
        spent = math.inf
        for _ in range(2):
            start = time.process_time()
            intersect(proxy, others)
            spent = min(spent, time.process_time() - start)
        if spent >= ENOUGH or count >= MOST_PAIRS or time.process_time() - began > 10 * ENOUGH:
            return spent / others.batch_shape[0]
        count *= 4


def _half_meeting(proxy: Proxy, places: Array, count: int, rng: np.random.Generator) -> Array:
    """Translations (n, 3), `count` or somewhat fewer, half of which leave a proxy in touch with where it was.

    From one point of the surface to another, convex proxies still meet; up to twice as far, some do.
    """
    one, other = places[rng.integers(len(places), size=(2, 2 * count))]
    ways = rng.uniform(0.0, 2.0, (2 * count, 1)) * (other - one)
    met = intersect(proxy, proxy.translated(ways))
    half = min(count // 2, int(np.sum(met)), int(np.sum(~met)))
    chosen = np.sort(np.concatenate([np.flatnonzero(met)[:half], np.flatnonzero(~met)[:half]]))
    return np.asarray(ways[chosen] if half else ways[:count])
