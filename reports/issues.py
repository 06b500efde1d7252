"""`issues/NNN-….md`: each bucket as an issue that an engine's maintainer can take as it is.

Nothing in it needs this project: the scene is in full precision, the steps are a call of the engine alone, and why
the expected answer is the right one is said in words that can be checked by hand.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import PurePosixPath

from oracles.engines import PACKAGES
from oracles.outcome import COMPARED, FINDINGS, Bucket, Finding, Kind, Run, Verdict
from oracles.repro.calls import needed_by
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP
from refimpl.shapes import Composite, Proxy
from reports import shapes, text
from reports.findings import BucketView, interval, value
from reports.markdown import escape, fenced, table_lines
from reports.tables import Column, Entry, Table, grouped, total

ASKED = {
    DISTANCE: "Distance of {} and {}",
    CONTACTS: "Contacts of {} and {}",
    BOOLEAN: "Overlap test of {} and {}",
    IMPACT: "Impact of {} and {}",
    SWEEP: "Sweep of {} and {}",
    RAYCAST: "{} cast at {}",
}

CONVENTIONS = {
    DISTANCE: "The signed distance is the gap, 0 when touching, and minus the penetration depth when overlapping. The "
    "normal points from A to B.",
    CONTACTS: "A contact's depth is the length of the shortest translation of B that separates; the normal points from "
    "A to B. Touching counts as contact.",
    BOOLEAN: "Proxies are closed solids: touching counts as overlap.",
    IMPACT: "Velocities are those of the centres of mass; the normal points from A to B. The laws are conservation of "
    "momentum and angular momentum, restitution along the normal, and Coulomb's friction.",
    SWEEP: "Both move at constant velocities from t = 0 to 1; the time is the first at which they touch, 0 where they "
    "do from the start. The normal points from A to B.",
    RAYCAST: "The time of the hit is in units of the direction's length; a ray that starts inside hits at 0.",
}
"""What the numbers mean, by query."""

ROTATION = "turned by the quaternion `rotation` (x, y, z, w) of any length"
MEANINGS = {
    "Ray": "from `origin` along `direction`",
    "Capsule": "all points at most `radius` from the segment from `p` to `q`",
    "HalfSpace": "normal · x + k ≤ 0, whatever the normal's length",
    "Box": f"`half_extents` along its axes, {ROTATION}",
    "KDOP": "lower ≤ direction · x ≤ upper for each direction",
    "Ellipsoid": f"semi-axes `radii`, {ROTATION}",
    "Cylinder": "a solid cylinder whose axis runs from `p` to `q`",
    "ConvexPolyhedron": f"the hull of the vertices, or normal · x + k ≤ 0 for all planes (normal, k); {ROTATION}",
    "Polyhedron": f"the solid bounded by the triangles, {ROTATION} and moved by `position`",
    "Composite": "the union of its parts",
}
"""What the numbers of a scene mean, where that is not plain."""

LONGEST_CALL = 8000
"""Characters of a script that stands in an issue; longer ones are to be attached."""

Tallies = dict[tuple[str, ...], Counter[Kind]]
"""Verdicts by cell, and by cell and regime."""

MOST_RELATED, MOST_REGIMES = 8, 12
SYSTEM = ("numpy", "python", "platform")


def title(bucket: Bucket) -> str:
    """What is wrong, in a line."""
    verdict = bucket.witness.verdict
    first, second = text.visible(bucket.pair).partition("–")[::2]
    asked = ASKED.get(bucket.query, "{} and {}").format(first, second)
    amount = f", by at least {text.short(verdict.amount)}" if 0 < verdict.amount < math.inf else ""
    return f"{asked}: {text.visible(bucket.symptom)}{amount}"


def issues(run: Run, views: Sequence[BucketView]) -> Iterator[str]:
    """Texts of the issues of all buckets, each with its title as the heading."""
    tallies = grouped(run, "engine", "query", "pair", "regime") | grouped(run, "engine", "query", "pair")
    for bucket, view in zip(run.buckets, views, strict=True):
        yield "\n".join(_lines(run, bucket, view, tallies)) + "\n"


def _lines(run: Run, bucket: Bucket, view: BucketView, tallies: Tallies) -> Iterator[str]:
    yield from (f"# {escape(title(bucket))}", "", escape(view.fact), "")
    yield from ("## Versions", "", *(f"- {escape(line)}" for line in _versions(run, bucket)), "")
    yield from ("## Steps to reproduce", "", *_steps(bucket, view), "")
    yield from ("## Expected", "", *_expected(bucket, view), "")
    yield from ("## Actual", "", *_actual(bucket, view), "")
    yield from ("## How often", "", *_often(run, bucket, tallies), "")
    related = list(_related(run, bucket))
    if related:
        yield from ("## Related", "", *related, "")
    names = f"bucket {bucket.id}, scene {bucket.witness.scene.id}"
    own = run.versions.get("proxyproof", "")
    yield escape(f"Found by proxyproof {own} ({names}), which generates scenes and proves which answer is right.")


def _versions(run: Run, bucket: Bucket) -> Iterator[str]:
    package = PACKAGES.get(bucket.engine, bucket.engine)
    version = run.versions.get(package) or run.engine_versions.get(bucket.engine, "")
    yield text.visible(f"{package} {version}".strip())
    yield from (text.visible(f"{name} {run.versions[name]}") for name in SYSTEM if name in run.versions)


def _steps(bucket: Bucket, view: BucketView) -> Iterator[str]:
    called = text.block(bucket.call, LONGEST_CALL)
    if 0 < len(bucket.call) <= LONGEST_CALL:
        adapter = any(name == "oracles" for name, _ in needed_by(bucket.call))
        what = "the engine, proxyproof, and its adapter in the current folder" if adapter else "the engine and numpy"
        yield from (f"This needs nothing but {what}:", "", *fenced(called, "python"), "")
    if bucket.repro:
        script = escape(PurePosixPath(view.file).name)
        yield f"The attached script {script} asks the engine, checks the proof below with Python's standard library,"
        yield "and ends with status 1 while the answer is wrong, with 0 once it is right."
    scene = bucket.witness.scene
    whole = shapes.is_whole(scene.a) and shapes.is_whole(scene.b)
    told = "in full precision" if whole else "of which the script has every number"
    yield from ("", f"The scene, {told}:", "", *_scene(view.scene, bucket))
    types = dict.fromkeys(name for shape in (scene.a, scene.b) for name in _types(shape) if name in MEANINGS)
    yield from ("", *(f"- {name}: {MEANINGS[name]}" for name in types))


def _types(shape: Proxy) -> Iterator[str]:
    """Names of a shape's type, and of those of its parts."""
    yield type(shape).__name__
    if isinstance(shape, Composite):
        for part in shape.parts:
            yield from _types(part)


def _scene(scene: Iterable[tuple[str, str]], bucket: Bucket) -> list[str]:
    language = "python" if bucket.witness.scene.motion is None else ""
    return fenced("\n".join(f"{label} = {words}" for label, words in scene), language)


def _expected(bucket: Bucket, view: BucketView) -> Iterator[str]:
    finding = bucket.witness
    yield escape(_true(bucket, view))
    if bucket.query in CONVENTIONS:
        yield from ("", CONVENTIONS[bucket.query])
    if view.about:
        yield from ("", "The two that the answer leads to:", "", *_scene(view.about, bucket))
    if view.proof:
        yield from ("", "Why this is so:", "", *(f"- {escape(claim)}" for claim in view.proof.claims), "")
        yield "Each of these was checked in exact rational arithmetic: a double is a fraction, so nothing is rounded."
    if finding.related is not None:
        yield from ("", "The two scenes above must have answers that fit each other, whatever the answers are.")


def _true(bucket: Bucket, view: BucketView) -> str:
    """What is true of the scene, in a sentence."""
    verdict, about = bucket.witness.verdict, bucket.witness.verdict.proof_scene
    if bucket.witness.scene.impact is not None:
        least = f" of at least {text.number(verdict.amount)}" if 0 < verdict.amount < math.inf else ""
        return f"Velocities that fulfil the laws of impacts. To fulfil them, those answered need a change{least}."
    if view.about and about is not None:
        return f"An answer whose own claims hold. Of this one they do not: {text.visible(verdict.claim, limit=1000)}"
    if math.isnan(verdict.lower) or math.isnan(verdict.upper):
        return "An answer."
    said = interval(bucket.witness.scene, verdict.lower, verdict.upper)
    return f"{_relation(bucket.query, verdict)}: {said}."


def _relation(query: str, verdict: Verdict) -> str:
    """How the two lie, as far as it is proven."""
    if query == RAYCAST:
        return "The ray misses" if verdict.lower == math.inf else "The ray hits"
    if query == SWEEP:
        return "The two do not touch" if verdict.lower == math.inf else "The two touch on their way"
    if verdict.lower > 0:
        return "The two are apart"
    if verdict.upper < 0:
        return "The two overlap"
    return "The two touch" if verdict.lower == verdict.upper else "The two touch, or nearly so"


def _actual(bucket: Bucket, view: BucketView) -> Iterator[str]:
    finding = bucket.witness
    ended = {Kind.CRASHED: "The call does not come back with an answer.", Kind.TIMED_OUT: "The call does not return."}
    if finding.verdict.kind in ended:
        yield from (ended[finding.verdict.kind], "")
    if finding.answer:
        yield from table_lines(_answers(finding))
    if view.error:
        yield from ("", *fenced(view.error))
    if dict(view.facts).get("proven wrong by at least"):
        yield from ("", f"Wrong by at least {dict(view.facts)['proven wrong by at least']}, proven.")


def _answers(finding: Finding) -> Table:
    """What the engine said, beside a right answer: one of several, where more than one is right."""
    rows = []
    for name, said in finding.answer.items():
        right = value(name, finding.reference[name]) if name in finding.reference else "–"
        rows.append((Entry(text.visible(name)), Entry(value(name, said)), Entry(right)))
    columns = (Column(""), Column(f"{text.visible(finding.engine)} answers"), Column("a right answer"))
    return Table("", columns, tuple(rows))


def _often(run: Run, bucket: Bucket, tallies: Tallies) -> Iterator[str]:
    """Counts, of all answers on these types and by recipe."""
    cell = bucket.engine, bucket.query, bucket.pair
    whole = tallies.get(cell, Counter())
    compared = text.plural(total(whole, COMPARED), "scene")
    proven = f" ({text.count(bucket.proven)} of them proven one by one)" if bucket.proven else ""
    every = total(whole, FINDINGS)
    others = f" All faults together: {text.count(every)}." if every > bucket.count else ""
    yield f"Seen {text.plural(bucket.count, 'time')}{proven} among {compared} of these types.{others} By kind of scene:"
    yield ""
    rows = []
    for name, n in bucket.regimes.most_common(MOST_REGIMES):
        of = total(tallies.get((*cell, name), Counter()), COMPARED)
        why = text.visible(run.regimes.get(name, ""))
        rows.append((Entry(text.visible(name)), Entry(f"{text.count(n)} of {text.count(of)}"), Entry(why)))
    columns = (Column("scenes"), Column("wrong", numeric=True), Column("what they are"))
    yield from table_lines(Table("", columns, tuple(rows)))


def _related(run: Run, bucket: Bucket) -> Iterator[str]:
    """What is known of the cause, and where else the like was seen."""
    if bucket.cause:
        yield from (f"The cause, as far as it is traced: {escape(text.visible(bucket.cause, limit=4000))}", "")
    for note in run.ledger:
        if (note.engine, note.name) == (bucket.engine, bucket.entry) and note.upstream:
            yield from (f"Perhaps the same: {escape(', '.join(map(text.visible, note.upstream)))}", "")
    alike = _alike(run, bucket)
    for other in alike[:MOST_RELATED]:
        worst = other.witness.verdict.amount
        amount = f", by at least {text.short(worst)}" if 0 < worst < math.inf else ""
        yield f"- {escape(text.visible(other.key))}: {text.plural(other.count, 'time')}{amount}"
    if len(alike) > MOST_RELATED:
        yield f"- and {text.count(len(alike) - MOST_RELATED)} more"


def _alike(run: Run, bucket: Bucket) -> Sequence[Bucket]:
    """Buckets of the same entry of the ledger, or with the same symptom in the same query; the same pair first."""
    same = [
        other
        for other in run.buckets
        if other is not bucket
        and other.engine == bucket.engine
        and (
            (other.entry is not None and other.entry == bucket.entry)
            or (other.query, other.symptom) == (bucket.query, bucket.symptom)
        )
    ]
    return sorted(same, key=lambda other: (other.pair != bucket.pair, -other.count))
