"""A run as a campaign would leave it, with every kind of verdict, for the tests of what people read."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from html.parser import HTMLParser

import numpy as np

from oracles.degeneracy import degeneracy
from oracles.impact_judge import certificate_of
from oracles.impact_laws import ANGULAR
from oracles.outcome import Bucket, EntryNote, Finding, Kind, Run, Severity, State, SupportNote, Verdict
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP, Scene, cells
from oracles.world import is_flat
from refimpl import Box, Capsule, Composite, ConvexPolyhedron, HalfSpace, Point, Polyhedron, Ray, Sphere
from refimpl.proof import Certificate, certify, check
from refimpl.proof.certify import round_down, round_up
from reports.tables import regimes_for
from tests.sample_impact import FLAT, answered

REGIMES = {
    "generic": "random sizes and poses: the bulk of all scenes, where the least is found",
    "aligned": "axis-aligned with round numbers: ties between features decide",
    "touching": "signed distance 0, up to rounding",
    "nearly_touching": "gaps and depths from 10^-1 to 10^-15 of the size",
    "deep": "one proxy well inside the other: the shortest way out changes",
    "concentric": "coinciding centres: no direction is preferred",
    "parallel_edges": "cross products of edges vanish",
    "face_on_face": "witness points are not unique",
    "sliver": "extents that differ by six decades",
    "huge": "sizes of 1e9",
    "tiny": "sizes of 1e-9",
    "size_ratio": "sizes that differ by up to 1e9",
    "far_away": "coordinates of 1e6 with sizes of 1e-3",
    "models": "meshes of robots, tools and toys: many faces, no two alike",
    "head_on": "along the normal through the middle, without spin or friction",
    "slow": "below thresholds from which on engines let bodies bounce",
}

SCRIPT = '''"""Ask the engine alone."""

import math

print("distance =", repr(math.sqrt(2.0)))
'''

TURNED = (0.18257418583505536, 0.3651483716701107, 0.5477225575051661, 0.7302967433402214)
A_BOX = Box([0.1, -0.30000000000000004, 2.0], [1.0, 0.5, 0.25], TURNED)
B_BOX = Box([1.7, 0.0, 2.0], [0.5, 0.5, 0.5], [0.0, 0.0, 0.0, 1.0])
ROOM = HalfSpace([0.0, 0.0, 2.0], -1.0)
ROD = Capsule([0.0, 0.0, 0.0], [0.0, 0.0, 3.0], 0.25)
BALL = Sphere([0.5, 0.0, 1.0], 1.0)
_TURN = 2.4 * np.arange(120.0)
STONE = ConvexPolyhedron.from_vertices(np.stack([np.cos(_TURN), np.sin(_TURN), np.linspace(-1.0, 1.0, 120)], -1))
"""A hull of as many numbers as a real model has."""
WEDGE = Polyhedron(
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    position=[2.0, -0.5, 0.0],
)


IN_SPACE = [cell for cell in cells() if not is_flat(cell.type_a)]
"""What engines of space are asked."""


def sample_run() -> Run:
    """Two engines, every cell of the pair table, sixteen regimes, ten buckets."""
    run = Run(
        seed=20240229,
        budget=60.0,
        started="2026-03-04T05:06:07Z",
        seconds=59.84,
        versions={
            "proxyproof": "0.1.0",
            "python-fcl": "0.7.0.11",
            "pybullet": "3.2.7",
            "numpy": "2.4.6",
            "Python": "3.11.2",
        },
        engines=["fcl", "bullet"],
        regimes=dict(REGIMES),
        models=["pybullet_data 3.2.7: 2298 models", "duck.obj: no solid: 4 edges are open"],
        timing={
            "scenes": 3.2,
            "fcl": 21.7,
            "bullet": 9.4,
            "reference": 8.8,
            "judge": 5.1,
            "proofs": 9.9,
            "shrinking": 1.7,
        },
    )
    _support(run)
    run.buckets = _buckets()
    run.ledger = LEDGER
    _counts(run)
    return run


def spread(run: Run, count: int) -> list[Bucket]:
    """So many new buckets, no two with the same key."""
    its = [bucket for bucket in run.buckets if bucket.state is State.NEW]
    return [dataclasses.replace(its[number % len(its)], degeneracy=f"variant {number}") for number in range(count)]


def _support(run: Run) -> None:
    for cell in IN_SPACE:
        for engine in run.engines:
            note = SupportNote("native", "")
            if cell.query == IMPACT and (engine == "fcl" or cell.pair != "HalfSpace–Box"):
                note = SupportNote("unsupported", "no impacts")
            elif cell.query == SWEEP:
                note = SupportNote("unsupported", "no sweeps")
            elif engine == "fcl" and cell.query == RAYCAST:
                note = SupportNote("unsupported", "FCL casts no rays")
            elif engine == "fcl" and cell.query == DISTANCE and "HalfSpace" in cell.pair:
                note = SupportNote("unsupported", "distance of a Halfspace ends the process")
            elif "HalfSpace–HalfSpace" in cell.pair:
                note = SupportNote("unsupported", "two static planes have no contacts")
            elif "Point" in cell.pair:
                note = SupportNote("emulated", "the point is a sphere of radius 1e-12")
            run.support[engine, cell.query, cell.pair] = note


def _counts(run: Run) -> None:
    """Agreement everywhere, with the findings of the buckets and what else can be said of an answer in between."""
    rng = np.random.default_rng(1)
    for (engine, query, pair), note in run.support.items():
        if note.kind == "unsupported":
            continue
        for regime in regimes_for(query, run.regimes):
            run.counts[engine, query, pair, regime, Kind.AGREES] += int(rng.integers(40, 900))
            if engine == "bullet" and "Box" in pair and query not in (RAYCAST, IMPACT):
                run.counts[engine, query, pair, regime, Kind.CONVENTION] += int(rng.integers(1, 90))
    for bucket in run.buckets:
        for regime, n in bucket.regimes.items():
            run.counts[bucket.engine, bucket.query, bucket.pair, regime, bucket.witness.verdict.kind] += n
    for cell in IN_SPACE:
        if cell.query in (DISTANCE, RAYCAST):
            run.counts["refimpl", cell.query, cell.pair, "generic", Kind.AGREES] += 3
    run.counts["fcl", BOOLEAN, "Box–Box", "touching", Kind.UNDECIDED] += 17
    run.counts["fcl", CONTACTS, "AABB–Box", "concentric", Kind.SKIPPED] += 240


def bucket(engine: str, scene: Scene, verdict: Verdict, regimes: dict[str, int], **more: object) -> Bucket:
    """File one finding as a bucket; `more` are further fields of bucket and finding."""
    fields = {name: more.pop(name) for name in ("answer", "reference", "text") if name in more}
    finding = Finding(engine, scene, **{"answer": {}, "reference": {}, **fields}, verdict=verdict)
    decade = math.floor(math.log10(verdict.amount)) if 0 < verdict.amount < math.inf else None
    count = sum(regimes.values())
    own = {
        "count": count,
        "proven": min(3, count),
        "worst": verdict.amount,
        "regimes": Counter(regimes),
        "call": SCRIPT,
        "repro": SCRIPT,
    }
    return Bucket(
        engine, scene.query, scene.cell.pair, verdict.symptom, degeneracy(scene), decade, finding, **{**own, **more}
    )


def proven(scene: Scene) -> tuple[float, float, Certificate]:
    """Interval of a scene's true value, with its certificate."""
    certificate = certify(scene.a, scene.b)
    lower, upper = check(certificate, scene.a, scene.b)
    return round_down(lower), round_up(upper), certificate


def wrong(scene: Scene, symptom: str, severity: Severity, amount: float, about: Scene | None = None) -> Verdict:
    """Verdict with a true interval and certificate; the amount is made up."""
    lower, upper, certificate = proven(about or scene)
    claim = f"{symptom}; the true value is proven to lie between {lower!r} and {upper!r}"
    return Verdict(Kind.WRONG, symptom, severity, amount, lower, upper, claim, certificate, about)


def lost(scene: Scene, kind: Kind, symptom: str, claim: str, amount: float = 0.0) -> Verdict:
    """Verdict on an answer that never came, or that is none."""
    lower, upper, _ = proven(scene)
    return Verdict(kind, symptom, Severity.LOST, amount, lower, upper, claim)


def _buckets() -> list[Bucket]:
    deep = Scene(BOOLEAN, BALL, ROD, "touching", "20240229/touching/3:17")
    stuck = Scene(CONTACTS, A_BOX, B_BOX, "concentric", "20240229/concentric/0:4")
    ray = Scene(RAYCAST, Ray([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]), BALL, "generic", "hypothesis")
    boxes = Scene(DISTANCE, A_BOX, B_BOX, "aligned", "20240229/aligned/0:12")
    thin = Scene(DISTANCE, A_BOX, B_BOX, "sliver", "20240229/sliver/1:7")
    floor = Scene(CONTACTS, ROD, ROOM, "huge", "20240229/huge/0:1")
    small = Scene(DISTANCE, BALL, B_BOX, "tiny", "20240229/tiny/0:1")
    far = Scene(DISTANCE, BALL, ROD, "far_away", "20240229/far_away/0:1")
    witness = Scene(DISTANCE, Point([1.0, 0.0, 2.0]), A_BOX, "sliver")
    model = Scene(DISTANCE, STONE, Composite([WEDGE, ROD.translated([4.0, 0.0, 0.0])]), "models", "bulk 1/2/3 of a.stl")
    said = {"distance": 0.21235, "on_a": [1.0, 0.0, 2.0], "on_b": [1.2, 0.0, 2.0]}
    true = {"distance": 0.2, "on_a": np.array([1.0, 0.0, 2.0]), "on_b": np.array([1.2000000000000002, 0.0, 2.0])}
    tipped = {"velocity_b": [0.5, 0.0, 0.25], "angular_b": [0.0, 0.5, 0.0]}
    return [
        bucket(
            "fcl",
            deep,
            wrong(deep, "missed contact", Severity.BOOLEAN, 0.75),
            {"touching": 12, "deep": 1},
            answer={"hit": False},
            reference={"hit": True, "distance": -0.75},
        ),
        bucket(
            "fcl",
            stuck,
            lost(stuck, Kind.TIMED_OUT, "no answer in time", "the engine did not answer within the limit"),
            {"concentric": 2},
            text="no answer within 1 s",
            reference={"hit": True, "distance": -0.5},
            proven=0,
        ),
        bucket(
            "bullet",
            ray,
            wrong(ray, "ray hits behind the surface", Severity.GROSS, 0.3333333333333333),
            {"generic": 1234},
            answer={"hit": True, "t": 3.25, "normal": (0.0, 0.0, 1.0)},
            reference={"hit": True, "t": 1.75},
            worst=2.25,
        ),
        bucket(
            "fcl",
            boxes,
            wrong(boxes, "distance too large", Severity.LARGE, 0.0123456789),
            {"aligned": 310, "face_on_face": 45},
            answer=said,
            reference=true,
        ),
        bucket(
            "fcl",
            thin,
            wrong(thin, "witness off its shape", Severity.SMALL, 1.25e-7, witness),
            {"sliver": 3},
            answer=said,
            reference=true,
        ),
        bucket(
            "bullet",
            floor,
            lost(floor, Kind.WRONG, "not a number", "bullet answers a signed distance of nan", math.inf),
            {"huge": 9},
            answer={"distance": math.nan, "normal": (math.nan, math.nan, math.nan)},
            reference={"distance": -0.75, "normal": (0.0, 0.0, -1.0)},
            proven=9,
        ),
        bucket(
            "bullet",
            small,
            lost(small, Kind.CRASHED, "error raised", "the engine raised an error instead of answering"),
            {"tiny": 4},
            text="ValueError: nothing came back\n  in a worker",
            reference={"distance": 0.125},
            proven=0,
        ),
        bucket(
            "fcl",
            far,
            wrong(far, "distance too small", Severity.SMALL, 1e-5),
            {"far_away": 700},
            answer={"distance": 0.09999},
            reference={"distance": 0.1},
            entry="tolerance",
            state=State.EXPECTED,
            cause=TOLERANCE,
        ),
        bucket(
            "bullet",
            FLAT,
            Verdict(
                Kind.WRONG,
                ANGULAR,
                Severity.LARGE,
                LEAST,
                LEAST,
                math.nextafter(LEAST, 1),
                f"bullet tips the box: {ANGULAR}",
                certificate_of(FLAT, answered(FLAT, **tipped)),
            ),
            {"head_on": 5},
            answer={"velocity_a": [0.0] * 3, "angular_a": [0.0] * 3, **tipped},
            reference={"velocity_b": [0.5, 0.0, 1.0], "angular_b": [0.0, 0.0, 0.0]},
        ),
        bucket(
            "bullet",
            model,
            wrong(model, "distance too large", Severity.SMALL, 1e-6),
            {"models": 2},
            answer={"distance": 1.0002686679224458},
            reference={"distance": 1.0002676679224458},
        ),
    ]


TOLERANCE = "FCL's tolerance of 1e-6 is relative to the coordinates, and cannot be set through python-fcl."

LEDGER = [
    EntryNote(
        "fcl",
        "tolerance",
        TOLERANCE,
        State.EXPECTED,
        "",
        700,
        2,
        ("0123456789ab", "ba9876543210"),
        ("https://example.org/1",),
    ),
    EntryNote(
        "fcl", "mended", "A sign.", State.STALE, "1 witness passes now", 0, 1, (), cells=((DISTANCE, "Box–Box"),)
    ),
    EntryNote("bullet", "another", "A clamp.", State.CHANGED, "1 witness fails otherwise", 0, 2, ("00112233aabb",)),
    EntryNote("bullet", "elsewhere", "A case.", State.UNMATCHED, "it is about versions <3, not 3.2.7", 0, 0, ()),
]

LEAST = 0.3
"""Least change of the velocities of the tipped box that keeps its angular momentum: 3/2 · 1/2 over 3/2 / 3/2 + 3/2."""


class Page(HTMLParser):
    """The parts of a page that the tests ask for."""

    def __init__(self, source: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: Counter[str] = Counter()
        self.attributes: list[tuple[str, str | None]] = []
        self.shown: list[str] = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        self.attributes += attrs

    def handle_data(self, data: str) -> None:
        self.shown.append(data)

    def values(self, name: str) -> list[str]:
        return [value or "" for key, value in self.attributes if key == name]

    @property
    def words(self) -> str:
        return " ".join(self.shown)
