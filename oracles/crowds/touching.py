"""The pipeline of `refimpl.world` and PyBullet on one crowd: which pairs touch, judged by certificates.

Both must leave out every pair that is proven to be farther apart than the margins by which Bullet's shapes differ from
the proxies, and name every pair that is proven to be deeper in each other. The reference has no margins: it must be
right about every pair whose proven interval excludes 0, but for the rounding of doubles. What differs in between is
listed, with what the reference says of the shapes that Bullet effectively uses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oracles.crowds.making import Crowd
from oracles.engine import Effective, Kind
from oracles.engines.bullet_crowd import BulletCrowd, Pair
from oracles.engines.bullet_engine import BulletEngine
from oracles.engines.bullet_shapes import MARGIN, STEPS
from oracles.scene import CONTACTS
from refimpl.bounds import aabb
from refimpl.broadphase import BroadPhase
from refimpl.linear import Array
from refimpl.pairs import TABLE
from refimpl.proof import certify
from refimpl.proxy import Proxy
from refimpl.queries import distance
from refimpl.shapes import Capsule, Composite, ConvexPolyhedron, HalfSpace, Sphere
from refimpl.volumes import is_endless
from refimpl.world import Stage, World

EXACT = (Sphere, Capsule, HalfSpace)
"""Types that Bullet holds without a margin."""
ROUNDING = 1e-14
"""Error of the reference's signed distances, relative to a scene's largest number."""
FARTHEST = 1e-2
"""Beyond any margin of a crowd: boxes that are farther apart prove more than is asked."""


@dataclass(frozen=True)
class Close:
    """A pair that is near enough to be judged.

    Attributes
    ----------
    lower, upper
        Proven interval of the signed distance.
    margin
        By so much the signed distance of what Bullet effectively holds may differ.
    rounding
        By so much the reference's own, which is computed in doubles.
    reference, engine
        Whether it touches, as the pipeline and as Bullet have it.
    effective
        The signed distance of the shapes that Bullet effectively uses, where the two differ; else not a number.
    """

    pair: Pair
    types: str
    lower: float
    upper: float
    margin: float
    rounding: float
    reference: bool
    engine: bool
    effective: float = float("nan")

    @property
    def decided(self) -> bool | None:
        """Whether it touches, beyond the margins; None in between."""
        return None if self.lower <= self.margin and self.upper >= -self.margin else self.upper < 0

    @property
    def engine_wrong(self) -> bool:
        """Whether Bullet contradicts the proof, beyond the margins."""
        return self.decided not in (None, self.engine)

    @property
    def reference_wrong(self) -> bool:
        """Whether the pipeline contradicts the proof, beyond what its collision data may be rounded by."""
        return (self.lower > self.rounding and self.reference) or (self.upper < -self.rounding and not self.reference)


@dataclass(frozen=True)
class Compared:
    """What came of one crowd.

    Attributes
    ----------
    far
        Pairs whose boxes prove them to be farther apart than any margin; `far_named` are those of them that one of
        the two says to touch.
    """

    bodies: int
    far: int
    far_named: tuple[Pair, ...]
    close: tuple[Close, ...]
    stages: dict[str, Stage]

    @property
    def wrong(self) -> list[Close]:
        """Pairs on which one of the two contradicts the proof."""
        return [one for one in self.close if one.engine_wrong or one.reference_wrong]

    @property
    def in_between(self) -> list[Close]:
        """Pairs on which the two differ and neither contradicts the proof."""
        return [one for one in self.close if one.engine != one.reference and one not in self.wrong]


def compared(crowd: Crowd, broad_phase: BroadPhase | None = None) -> Compared:
    """Ask both for the pairs that touch, and judge each by a certificate.

    Parameters
    ----------
    crowd : Crowd
    broad_phase : BroadPhase, optional
        Of the pipeline.

    Raises
    ------
    EngineUnavailable
        When PyBullet is not installed.
    """
    world = World(crowd.bodies(), broad_phase=broad_phase)
    reference = {(i, j) for i, j in world.detect().pairs.tolist()}
    with BulletCrowd(crowd.proxies, crowd.static.tolist()) as bullet:
        engine = set(bullet.touching())
    near, far = _near(crowd)
    judge = BulletEngine()
    close = tuple(_close(judge, crowd.proxies, pair, pair in reference, pair in engine) for pair in near)
    named = tuple(sorted((reference | engine) - set(near)))
    return Compared(len(crowd), far, named, close, world.stages)


def _near(crowd: Crowd) -> tuple[list[Pair], int]:
    """Pairs, not both static, whose boxes are not farther apart than `FARTHEST`; and how many others there are.

    Every pair is looked at, one after the other: this is what broad phases are held against.
    """
    lower, upper = np.full((len(crowd), 3), -np.inf), np.full((len(crowd), 3), np.inf)
    for number, proxy in enumerate(crowd.proxies):
        if not is_endless(proxy):
            box = aabb(proxy)
            lower[number], upper[number] = box.lower - FARTHEST, box.upper
    i, j = np.triu_indices(len(crowd), 1)
    possible = ~(crowd.static[i] & crowd.static[j])
    meet = np.all((lower[i] <= upper[j]) & (lower[j] <= upper[i]), axis=1)
    rows = np.flatnonzero(possible & meet)
    return list(zip(i[rows].tolist(), j[rows].tolist(), strict=True)), int(np.count_nonzero(possible & ~meet))


def _close(judge: BulletEngine, proxies: tuple[Proxy, ...], pair: Pair, reference: bool, engine: bool) -> Close:
    a, b = (proxies[number] for number in pair)
    proof = certify(a, b)
    margin = margin_of(a) + margin_of(b) + _tolerance(judge, a, b)
    effective = _effective_distance(judge, a, b) if reference != engine else float("nan")
    types = f"{type(a).__name__}–{type(b).__name__}"
    rounding = ROUNDING * _size(a, b)
    return Close(pair, types, float(proof.lower), float(proof.upper), margin, rounding, reference, engine, effective)


def margin_of(proxy: Proxy) -> float:
    """By how much Bullet may hold a proxy smaller or larger than it is: its margin, and of hulls half a grid's step."""
    if isinstance(proxy, Composite):
        return max(map(margin_of, proxy.parts))
    if isinstance(proxy, ConvexPolyhedron):
        sides = np.ptp(proxy.vertices, axis=0)
        return MARGIN + float(np.sqrt(sides @ sides)) / STEPS
    return 0.0 if isinstance(proxy, EXACT) else MARGIN


def _in_order(a: Proxy, b: Proxy) -> tuple[Proxy, Proxy]:
    return (a, b) if (type(a), type(b)) in TABLE else (b, a)


def _tolerance(judge: BulletEngine, a: Proxy, b: Proxy) -> float:
    a, b = _in_order(a, b)
    return float(judge.tolerance(CONTACTS, type(a), type(b)).value.at(_size(a, b)))


def _size(a: Proxy, b: Proxy) -> float:
    return max(float(a.magnitude), float(b.magnitude))


def _effective_distance(judge: BulletEngine, a: Proxy, b: Proxy) -> float:
    """Signed distance of what Bullet effectively uses, in doubles."""
    a, b = _in_order(a, b)
    rows: tuple[Array, Array] = (a.pack()[None], b.pack()[None])
    first, second = judge.effective(CONTACTS, type(a), rows[0], type(b), rows[1])
    found = distance(_made(first), _made(second)).distance[0]
    return float(found - first.margin[0] - second.margin[0])


def _made(side: Effective) -> Proxy:
    kind: Kind = side.kind
    return kind.unpack(side.rows) if side.made is None else side.made
