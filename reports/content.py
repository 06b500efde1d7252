"""The parts of a written report in their order, shared by its HTML and its Markdown."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from oracles.outcome import COMPARED, FINDINGS, Kind, Run
from reports import broad_phase, findings, ledger, matrix, surveys, tables, text
from reports.findings import BucketView
from reports.relations import relation_table
from reports.tables import Table

TITLE = "proxyproof: discrepancy report"

MOST_MODEL_LINES = 12
"""Lines on models that a report shows."""

WORDS = (
    ("signed distance σ", "the gap when positive, 0 when touching, minus the penetration depth when negative"),
    ("depth of unions", "of a Composite or Polyhedron: the length of the shortest translation of B that separates"),
    ("part", "a convex part or a triangle of a union, counted from 0, triangles last; a convex proxy is its part 0"),
    ("sha256", "the first digits of a digest of numbers that are too many to be shown: equal ones have equal digits"),
    ("normal", "unit vector from A to B: translating B along it separates"),
    ("impact", "two bodies that touch, and their velocities after it: v of the centre of mass, ω the angular velocity"),
    ("sweep", "two bodies that move from t = 0 to 1, and the first time at which they touch, if they do"),
    (
        "wrong by, of a sweep",
        "how far the two move in the time by which it is off, and no more than they are apart or in each other then",
    ),
    ("e, μ", "restitution, by which the normal velocity at the contact is reversed, and Coulomb's friction"),
    ("wrong by, of an impact", "the least change of the velocities with which the law that is broken could hold"),
    ("proven interval", "bounds on the true value, each with a certificate that exact arithmetic has checked"),
    ("agrees", "the answer fits the proven interval and its own properties, within the engine's declared tolerance"),
    ("convention", "right on the shape that the engine effectively uses, or by a documented convention"),
    ("wrong", "a certificate excludes the answer, by at least the amount named"),
    ("inconsistent", "two answers contradict each other, the second to a scene made from the first; one is wrong"),
    ("crashed, timed out", "the engine's process ended, an error was raised, or the call did not return in time"),
    ("undecided", "the proven interval allows both"),
    ("skipped", "not asked: the engine had run out of time on too many scenes of the cell and regime"),
    ("bucket", "findings with one cause, as far as can be told; its scene is the simplest found"),
    ("crowd", "many bodies together, of which a broad phase names the pairs that may touch"),
    ("survey", "a subject that is no pair of proxies, with questions, regimes and the libraries that answer them"),
    ("ledger", "the list of known faults with their causes, and of witnesses, which each run asks again first"),
    ("NEW", "a bucket that no entry of the ledger explains"),
    ("expected", "a bucket that an entry explains; an entry whose witnesses fail as before, or that explains findings"),
    ("CHANGED", "an entry of which a witness fails otherwise than it says, or all pass though other findings fit it"),
    ("STALE", "an entry whose witnesses all pass now: it is to be taken out"),
    ("UNMATCHED", "an entry of which this run saw nothing, for the reason named"),
    (
        "touching, parallel, tiny ... in a bucket's name",
        "what is special about its scene's geometry; generic, where nothing is",
    ),
    (
        "1e-3 in a bucket's name",
        "the decade of the error, relative to the scene's largest coordinate, extent or velocity",
    ),
)
"""What the reports' words mean."""


@dataclass(frozen=True)
class Group:
    """The buckets of one cell of the matrix."""

    anchor: str
    heading: str
    support: str
    buckets: tuple[BucketView, ...]


@dataclass(frozen=True)
class Content:
    """Everything that a written report says."""

    headline: str
    warnings: tuple[str, ...]
    ran: tuple[tuple[str, str], ...]
    summary: Table
    overviews: tuple[Table, ...]
    matrices: tuple[Table, ...]
    index: Table
    ledger: Table
    buckets: tuple[BucketView, ...]
    groups: tuple[Group, ...]
    regimes: Table
    coverage: tuple[Table, ...]
    relations: Table
    broad_phase: tuple[Table, ...]
    surveys: tuple[surveys.Section, ...]
    support: Table
    timing: Table


def content(run: Run) -> Content:
    """Put together what a report says of a run."""
    views = findings.bucket_views(run)
    groups = tuple(
        Group(f"cell-{number}", " · ".join(map(text.visible, cell)), _support(run, cell), tuple(found))
        for number, (cell, found) in enumerate(findings.by_cell(views).items(), 1)
    )
    links = {group.buckets[0].cell: group.anchor for group in groups}
    return Content(
        headline=findings.headline(run),
        warnings=tuple(findings.warnings(run)),
        ran=tuple(what_ran(run)),
        summary=tables.summary(run),
        overviews=matrix.overviews(run),
        matrices=matrix.matrices(run, links),
        index=findings.index(views),
        ledger=ledger.table(run),
        buckets=tuple(views),
        groups=groups,
        regimes=tables.regime_table(run),
        coverage=tables.coverage(run),
        relations=relation_table(run),
        broad_phase=broad_phase.shown(run),
        surveys=surveys.shown(run),
        support=matrix.support_notes(run),
        timing=tables.timing(run),
    )


def _support(run: Run, cell: tables.CellKey) -> str:
    note = run.support.get(cell)
    return text.visible(f"{note.kind}: {note.reason}") if note and note.reason else ""


def _models(run: Run) -> str:
    """Where real geometry came from, and the first files that could not be used."""
    said = [text.visible(line) for line in run.models[:MOST_MODEL_LINES]]
    more = len(run.models) - len(said)
    return "; ".join([*said, f"and {text.count(more)} more: report.json has them all"] if more > 0 else said) or "none"


def _asked(run: Run) -> str:
    """How much work was asked for."""
    if run.passes is None:
        return f"of a budget of {text.seconds(run.budget)}"
    return f"for {text.plural(run.passes, 'pass', 'passes')} over all cells"


def what_ran(run: Run) -> list[tuple[str, str]]:
    """Seed, budget, versions and counts, as labels and texts."""
    verdicts, audited = tables.grouped(run).get((), Counter()), tables.audit(run)
    versions = ", ".join(f"{text.visible(name)} {text.visible(version)}" for name, version in run.versions.items())
    asked, own, bad = tables.supported(run), audited.total(), audited[Kind.REFERENCE_WRONG]
    unsupported = len(run.support) - len(asked)
    cells = text.plural(len(asked), "cell") + (
        f" answered, {text.count(unsupported)} unsupported" if unsupported else ""
    )
    return [
        ("engines", ", ".join(map(text.visible, tables.engines(run)))),
        ("versions", versions),
        ("models", _models(run)),
        ("started", text.visible(run.started)),
        ("time", f"{text.seconds(run.seconds)} {_asked(run)}"),
        ("seed", str(run.seed)),
        ("digest of every answer", run.digest or "none"),
        *([("from an earlier record", text.plural(run.recalled, "task"))] if run.recalled else []),
        ("cells", f"{cells}; {text.plural(len(tables.regimes(run)), 'regime')}"),
        ("scenes asked", text.count(tables.total(verdicts, COMPARED))),
        ("scenes by hunter", ", ".join(f"{name} {text.count(n)}" for name, n in run.hunters.items()) or "none"),
        (
            "findings",
            f"{text.count(tables.total(verdicts, FINDINGS))} in {text.plural(len(run.buckets), 'bucket')}; "
            f"{text.count(sum(bucket.proven for bucket in run.buckets))} proven one by one, the others "
            "by the reference in floats, beyond what it may err by",
        ),
        (
            "reference audited",
            f"{text.plural(own, 'answer')} of its own, {text.count(bad) if bad else 'none'} proven wrong",
        ),
    ]
