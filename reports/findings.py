"""What a report says of a run and of each bucket, in words: written once for every format."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath

from oracles.course import Course
from oracles.motion import Motion
from oracles.outcome import COMPARED, Bucket, Finding, Kind, Run, Verdict
from oracles.scene import Scene
from oracles.world import is_flat, world_of
from refimpl import Ray
from refimpl.proof.claims import Bound
from refimpl.proof.impacts import ImpactCertificate
from reports import broad_phase, ledger, shapes, surveys, text
from reports.ledger import History, history
from reports.proofs import Proof, proof_view
from reports.relations import related_facts
from reports.story import fact, story
from reports.tables import CellKey, Column, Entry, Table, engines, grouped, total

NAME_LENGTH = 80
MOST_WARNINGS = 12
KINDER = "On the shapes that "
"""With this begins what the judge adds on the shapes that an engine effectively uses."""


@dataclass(frozen=True)
class BucketView:
    """A bucket as people read it; texts are harmless to read, but not yet escaped for any format.

    Attributes
    ----------
    about
        The two proxies that the certificate speaks of, where the answer is refuted on others than the scene's own:
        a witness against its shape, a proxy moved along the engine's normal.
    id
        The same in every run that has the bucket.
    fact, story
        A sentence, and two: what the engine says and what is true; how often, and whether it is known.
    amount
        Proven error of the scene shown, 0 where it is not one of a size.
    history
        What the ledger knows of it; None when it is new.
    file
        Path of the repro script within the report's folder.
    repro
        The script's text as the file holds it; formats show it through `text.block`.
    """

    number: int
    id: str
    cell: CellKey
    title: str
    fact: str
    story: str
    severity: str
    amount: float
    count: int
    state: str
    history: History | None
    facts: tuple[tuple[str, str], ...]
    scene: tuple[tuple[str, str], ...]
    answers: Table
    error: str
    about: tuple[tuple[str, str], ...]
    proof: Proof | None
    file: str
    repro: str

    @property
    def anchor(self) -> str:
        """Anchor of the bucket within the report."""
        return f"b-{self.id}"

    @property
    def amount_text(self) -> str:
        """The proven error in short, or a dash."""
        return f"≥ {text.short(self.amount)}" if self.amount else "–"

    @property
    def issue(self) -> str:
        """Path of the issue's text within the report's folder."""
        return f"issues/{PurePosixPath(self.file).stem}.md"

    @property
    def picture(self) -> str:
        """Path of the picture within the report's folder."""
        return f"pictures/{PurePosixPath(self.file).stem}.svg"


def bucket_views(run: Run) -> list[BucketView]:
    """All buckets in the order of the run, numbered from 1."""
    notes = {(note.engine, note.name): history(note) for note in run.ledger}
    return [
        _view(number, bucket, notes.get((bucket.engine, bucket.entry or "")))
        for number, bucket in enumerate(run.buckets, 1)
    ]


def by_cell(views: list[BucketView]) -> dict[CellKey, list[BucketView]]:
    """Buckets per cell; the cell with the worst bucket comes first."""
    cells: dict[CellKey, list[BucketView]] = {}
    for view in views:
        cells.setdefault(view.cell, []).append(view)
    return cells


def repro_file(number: int, bucket: Bucket) -> str:
    """Path of a bucket's script: letters and digits only, whatever the names hold."""
    words = re.findall(r"[A-Za-z0-9]+", " ".join((bucket.engine, bucket.query, bucket.pair, bucket.symptom)))
    return f"repro/{number:03d}-{'-'.join(words)[:NAME_LENGTH].strip('-') or 'bucket'}.py"


def _view(number: int, bucket: Bucket, known: History | None) -> BucketView:
    finding, verdict = bucket.witness, bucket.witness.verdict
    return BucketView(
        number=number,
        id=bucket.id,
        cell=(bucket.engine, bucket.query, bucket.pair),
        title=text.visible(bucket.key),
        fact=fact(finding),
        story=story(bucket),
        severity=text.visible(verdict.severity.value if verdict.severity else verdict.kind.value),
        amount=verdict.amount if _has_amount(verdict) else 0.0,
        count=bucket.count,
        state=bucket.state.value,
        history=known,
        facts=tuple(_facts(bucket)),
        scene=(*proxies(finding.scene), *related_facts(finding)),
        answers=_answers(finding),
        error=text.block(finding.text) if finding.text else "",
        about=proxies(_proven_on(finding)) if _proven_on(finding) is not finding.scene else (),
        proof=_proof(finding),
        file=repro_file(number, bucket),
        repro=_script(bucket),
    )


def _script(bucket: Bucket) -> str:
    """The repro script, headed by the bucket that it is of; a first line for the shell stays the first."""
    first, newline, rest = bucket.repro.partition("\n")
    line = f"# {text.visible(bucket.key, limit=1000)}\n"
    if first.startswith("#!"):
        return f"{first}{newline}{line}{rest}"
    return line + bucket.repro if bucket.repro else ""


def _facts(bucket: Bucket) -> Iterator[tuple[str, str]]:
    finding, verdict, scene = bucket.witness, bucket.witness.verdict, bucket.witness.scene
    yield "severity", text.visible(verdict.severity.value if verdict.severity else verdict.kind.value)
    if _has_amount(verdict):
        yield "proven wrong by at least", text.number(verdict.amount)
    _, kinder, more = verdict.claim.partition(KINDER)
    if kinder:
        yield "at its best", text.visible(f"{kinder}{more}", limit=1000)
    about = _proven_on(finding)
    named = (
        ""
        if about is scene
        else f", for the {type(about.a).__name__} and the {type(about.b).__name__} of the certificate"
    )
    yield "proven interval", interval(about, verdict.lower, verdict.upper) + named
    proven = f", {text.count(bucket.proven)} proven one by one" if bucket.proven else ""
    yield "seen", text.plural(bucket.count, "time") + proven
    if verdict.amount < bucket.worst < math.inf:
        yield "worst of them", f"wrong by {text.number(bucket.worst)}"
    yield "regimes", ", ".join(f"{text.visible(name)} {text.count(n)}" for name, n in bucket.regimes.most_common())
    yield "ledger", _listed(bucket)
    for name, shape in (("A", scene.a), ("B", scene.b)):
        if not shapes.is_whole(shape):
            yield f"numbers of {name}", f"{text.count(shape.pack().size)}: report.json has them all"
    yield "scene", " · ".join(filter(None, (scene.id, text.visible(scene.regime), text.visible(scene.source))))


def _listed(bucket: Bucket) -> str:
    """State of a bucket, and the entry of the ledger that explains it."""
    known = f"{text.visible(bucket.entry)}" if bucket.entry is not None else "no entry explains it"
    return f"{bucket.state.value}: {known}"


def _has_amount(verdict: Verdict) -> bool:
    return verdict.kind in (Kind.WRONG, Kind.INCONSISTENT) and 0 < verdict.amount < math.inf


def _proven_on(finding: Finding) -> Scene:
    """Return the scene that the verdict's interval and certificate speak of: the finding's own, or another."""
    scene, other = finding.scene, finding.verdict.proof_scene
    if other is None or other.id == scene.id:
        return scene
    return other


def interval(scene: Scene, lower: Bound, upper: Bound) -> str:
    """Proven interval of the signed distance, or of a ray's time, in full precision."""
    symbol, name = ("t", "time of the hit") if isinstance(scene.a, Ray) else ("σ", "signed distance")
    if scene.course is not None:
        symbol, name = "t", "first time at which the two touch"
    if scene.impact is not None:
        symbol, name = "δ", "least change of the velocities that could fulfil the law"
    if any(isinstance(bound, float) and math.isnan(bound) for bound in (lower, upper)):
        return "none"
    if lower == upper:
        if lower == math.inf:
            return f"{symbol} = ∞: {'the ray misses' if scene.course is None else 'the two do not touch'}"
        end = "−∞: the overlap has no end" if lower == -math.inf else f"{text.number(lower)} ({name}, exactly)"
        return f"{symbol} = {end}"
    return f"{text.number(lower)} ≤ {symbol} ≤ {text.number(upper)} ({name}; width {text.short(upper - lower)})"


def proxies(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Both proxies of a scene, and how they move, where they do."""
    found = ("A", shapes.in_words(scene.a)), ("B", shapes.in_words(scene.b))
    axes = world_of(scene.b).axes
    if scene.course is not None:
        return (*found, *course_in_words(scene.course, axes))
    return found if scene.impact is None else (*found, *motion_in_words(scene.impact, axes))


def course_in_words(course: Course, axes: int = 3) -> Iterator[tuple[str, str]]:
    """How the two move from t = 0 to 1, in full precision; in the plane by two numbers."""
    for name, side in (("A", course.a), ("B", course.b)):
        moves = [f"by {text.full(side.linear[:axes])}"] if side.linear.any() else []
        if side.angular.any():
            axis, center = text.full(side.angular), text.full(side.center)
            moves.append(f"turning by {axis} (an axis times radians) about {center}, which moves along")
        yield f"{name} moves", ", ".join(moves) or "rests"


def motion_in_words(motion: Motion, axes: int = 3) -> Iterator[tuple[str, str]]:
    """How the two move and where they meet, in full precision; in the plane spins and inertias are single numbers."""
    turning = slice(None) if axes == 3 else -1
    for name, body in (("A", motion.a), ("B", motion.b)):
        moves = f"v = {text.full(body.velocity[:axes])}, ω = {text.full(body.angular_velocity[turning])}"
        if body.inverse_mass > 0:
            mass, inertia = text.full(body.inverse_mass), text.full(body.inertia[turning, turning])
            moves = f"1/m = {mass}, centre {text.full(body.position[:axes])}, {moves}, inertia {inertia}"
        yield f"{name} moves", moves if body.inverse_mass > 0 else f"immovable, {moves}"
    contact = f"at {text.full(motion.point[:axes])}, normal {text.full(motion.normal[:axes])}"
    yield "contact", f"{contact}, e = {text.full(motion.restitution)}, μ = {text.full(motion.friction)}"


def _answers(finding: Finding) -> Table:
    """Both answers side by side, in full precision."""
    names = dict.fromkeys([*finding.reference, *finding.answer])
    rows = []
    for name in names:
        said = [value(name, a[name]) if name in a else "not said" for a in (finding.answer, finding.reference)]
        rows.append((Entry(text.visible(name)), *map(Entry, said)))
    columns = (Column("answer"), Column(text.visible(finding.engine)), Column("refimpl"))
    return Table("Both answers", columns, tuple(rows))


def value(name: str, said: object) -> str:
    """Engines answer a hit with 1 or 0, as a bool or a double; anything else is shown as it is."""
    if name == "hit" and isinstance(said, int | float) and said in (0, 1):
        return "yes" if said else "no"
    return text.full(said)


def _proof(finding: Finding) -> Proof | None:
    certificate = finding.verdict.certificate
    if certificate is None:
        return None
    verdict = finding.verdict
    about = verdict if isinstance(certificate, ImpactCertificate) else certificate
    scene = _proven_on(finding)
    return proof_view(certificate, interval(scene, about.lower, about.upper), flat=is_flat(scene.b))


def index(views: list[BucketView]) -> Table:
    """One row per bucket: what is new first, then the worst."""
    rows = []
    for view in views:
        number = Entry(str(view.number), link=view.anchor)
        rest = (view.title, view.severity, view.amount_text, text.count(view.count), view.state)
        rows.append((number, *map(Entry, rest)))
    names = (
        ("#", True),
        ("engine · query · pair · symptom", False),
        ("severity", False),
        ("wrong by", True),
        ("seen", True),
    )
    columns = (*(Column(title, numeric) for title, numeric in names), Column("ledger"))
    return Table("Findings, what is new first, then the worst", columns, tuple(rows))


def headline(run: Run) -> str:
    """One sentence: what the run found."""
    if run.reference_wrong:
        return "The reference itself was proven wrong, so the run stopped: believe nothing here before that is settled."
    counts = grouped(run, "engine")
    clauses = [_clause(text.visible(engine), counts.get((engine,), Counter())) for engine in engines(run)]
    states = ledger.in_words(run)
    buckets = f"; {text.plural(len(run.buckets), 'bucket')}{f' ({states})' if states else ''}"
    return f"{'; '.join(clauses) or 'No engine was asked'}{buckets if states else ''}."


def _clause(engine: str, verdicts: Counter[Kind]) -> str:
    compared, wrong = total(verdicts, COMPARED), verdicts[Kind.WRONG]
    words = [f"{engine} is wrong in {text.count(wrong) if wrong else 'none'} of {text.plural(compared, 'scene')}"]
    ends = (("crashed on", Kind.CRASHED), ("did not return on", Kind.TIMED_OUT))
    words += [f"{ending} {text.plural(verdicts[kind], 'scene')}" for ending, kind in ends if verdicts[kind]]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def warnings(run: Run) -> list[str]:
    """Sentences that a reader must see before anything else."""
    found = ["The run was interrupted: this is what it had until then."] if run.interrupted else []
    told = [*run.problems, *broad_phase.failures(run).values(), *surveys.failures(run)]
    told += [f"{what} ({text.plural(n, 'time')})" for what, n in run.incidents.most_common()]
    found += [text.visible(problem, limit=1000) for problem in told[:MOST_WARNINGS]]
    more = len(told) - MOST_WARNINGS
    return [*found, f"… and {text.count(more)} more such problems: report.json has them all."] if more > 0 else found
