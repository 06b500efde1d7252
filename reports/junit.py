"""`junit.xml`: the run as continuous integration counts it, a case for each cell and for each entry of the ledger.

A failure is what makes `proxyproof run` end with status 1: a finding that the ledger does not explain, or an entry
that is STALE or CHANGED. Known faults pass and say so, unsupported cells and UNMATCHED entries are skipped, and what
is incomplete is an error. The form is that of Jenkins's xUnit plugin, which GitLab and most readers share.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from oracles.outcome import COMPARED, FINDINGS, Bucket, EntryNote, Kind, Run, State
from reports import broad_phase, text
from reports.findings import BucketView
from reports.surveys import said
from reports.tables import UNSUPPORTED, CellKey, grouped, state_of, time_split, total

LONGEST = 20_000
"""Characters of the text below one case."""

FAILURE, ERROR, SKIPPED = "failure", "error", "skipped"


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes
    ----------
    outcome
        "failure", "error" or "skipped"; empty when it passes.
    kind, message, details
        What happened: in a word, in a line, and at length.
    """

    group: str
    name: str
    outcome: str = ""
    kind: str = ""
    message: str = ""
    details: str = ""


def render(run: Run, views: Sequence[BucketView]) -> str:
    """Return the run as JUnit XML."""
    suites = [("proxyproof", [_whole(run)])]
    suites += [(engine, list(_cells(run, views, engine))) for engine in run.engines]
    suites += [(f"survey.{name}", list(_survey(run, name))) for name in dict.fromkeys(c.survey for c in run.surveys)]
    suites += [("broad phase", list(_broad_phases(run)))]
    listed = dict.fromkeys(note.engine for note in run.ledger)
    suites += [
        (f"{engine}.ledger", [_entry(note) for note in run.ledger if note.engine == engine]) for engine in listed
    ]
    every = _counts([case for _, cases in suites for case in cases])
    root = ElementTree.Element("testsuites", {"name": "proxyproof", "time": f"{run.seconds:.3f}", **every})
    for name, cases in suites:
        if cases:
            _add_suite(root, run, name, cases)
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_suite(root: ElementTree.Element, run: Run, name: str, cases: list[Case]) -> None:
    named = {"name": _words(name), "timestamp": _words(run.started)[:19]}
    suite = ElementTree.SubElement(root, "testsuite", {**named, **_counts(cases), SKIPPED: _count(cases, SKIPPED)})
    properties = ElementTree.SubElement(suite, "properties")
    for label, value in (("seed", str(run.seed)), ("digest", run.digest), *run.versions.items()):
        ElementTree.SubElement(properties, "property", name=_words(label), value=_words(value))
    for case in cases:
        made = ElementTree.SubElement(suite, "testcase", classname=_words(case.group), name=_words(case.name))
        if case.outcome:
            found = ElementTree.SubElement(made, case.outcome, type=_words(case.kind), message=_words(case.message))
        elif case.details:
            found = ElementTree.SubElement(made, "system-out")
        else:
            continue
        found.text = text.block(case.details, LONGEST)


def _words(words: str) -> str:
    return text.visible(words, limit=1000)


def _counts(cases: list[Case]) -> dict[str, str]:
    return {"tests": str(len(cases)), "failures": _count(cases, FAILURE), "errors": _count(cases, ERROR)}


def _count(cases: Iterable[Case], outcome: str) -> str:
    return str(sum(case.outcome == outcome for case in cases))


# -- cases ---------------------------------------------------------------------------------------------------


def _whole(run: Run) -> Case:
    """Whether the run is whole."""
    lines = ["the run was interrupted"] * run.interrupted + run.problems
    if not lines:
        return Case("proxyproof", "run is complete", details=time_split(run))
    return Case("proxyproof", "run is complete", ERROR, "incomplete", lines[0], "\n".join([*lines, time_split(run)]))


def _cells(run: Run, views: Sequence[BucketView], engine: str) -> Iterable[Case]:
    """A case for each cell of an engine."""
    counts = grouped(run, *("engine", "query", "pair"))
    told: dict[CellKey, list[tuple[Bucket, str]]] = {}
    for bucket, view in zip(run.buckets, views, strict=True):
        line = f"{view.number}. [{view.state}] {view.title}\n   {view.fact}\n   {view.facts[0][1]}; {view.file}"
        told.setdefault(view.cell, []).append((bucket, line))
    for key, note in run.support.items():
        if key[0] == engine:
            group, pair = f"{key[0]}.{key[1]}", key[2]
            if note.kind == UNSUPPORTED:
                yield Case(group, pair, SKIPPED, UNSUPPORTED, note.reason)
            else:
                yield _cell(group, pair, counts.get(key, Counter()), told.get(key, []))


def _cell(group: str, pair: str, verdicts: Counter[Kind], told: list[tuple[Bucket, str]]) -> Case:
    """What became of a supported cell: a failure where the ledger does not explain all that was found."""
    details = "\n".join(line for _, line in told)
    new = [bucket for bucket, _ in told if bucket.state is State.NEW]
    if any(bucket.against_reference for bucket in new):
        return Case(group, pair, ERROR, Kind.REFERENCE_WRONG.value, "the reference itself was proven wrong", details)
    if new:
        message = f"{text.plural(len(new), 'new finding')}: {new[0].witness.verdict.claim or new[0].symptom}"
        return Case(group, pair, FAILURE, new[0].symptom, message, details)
    found = total(verdicts, FINDINGS)
    if found and not told:
        return Case(group, pair, FAILURE, "wrong", f"{text.plural(found, 'wrong answer')} that no bucket holds")
    if not total(verdicts, COMPARED):
        return Case(group, pair, ERROR, "nothing compared", "the cell is supported, and nothing was compared")
    _, worst, rest = state_of(verdicts)
    return Case(group, pair, details="\n".join(filter(None, ["; ".join([worst, *rest]), details])))


def _survey(run: Run, name: str) -> Iterable[Case]:
    """A case for each engine and question of a survey."""
    mine = [count for count in run.surveys if count.survey == name]
    for engine, question in dict.fromkeys((count.engine, count.question) for count in mine):
        counts = [count for count in mine if (count.engine, count.question) == (engine, question)]
        group, case = f"survey.{name}.{engine}", question or "asked"
        failed, absent = [count for count in counts if count.failed], counts[0].absent
        details = "\n".join(line for count in counts for found in count.witnesses for line in said(found))
        if failed:
            message = "; ".join(f"{c.regime}: {c.wrong} wrong and {c.lost} lost of {c.asked}" for c in failed)
            against = any(count.against_reference for count in failed)
            yield Case(group, case, ERROR if against else FAILURE, "wrong", message, details)
        elif absent:
            yield Case(group, case, SKIPPED, "not installed", absent)
        else:
            yield Case(group, case, details=details)


def _broad_phases(run: Run) -> Iterable[Case]:
    """A case for each engine that was asked about crowds."""
    told = broad_phase.failures(run)
    for engine in dict.fromkeys(count.engine for count in run.crowds):
        broken = told.get(engine, "")
        yield Case("broad phase", engine, FAILURE if broken else "", "wrong" if broken else "", broken)


def _entry(note: EntryNote) -> Case:
    """What became of an entry of the ledger."""
    details = "\n".join([note.cause, *note.upstream])
    outcomes = {State.STALE: FAILURE, State.CHANGED: FAILURE, State.UNMATCHED: SKIPPED}
    outcome = outcomes.get(note.state, "")
    return Case(f"{note.engine}.ledger", note.name, outcome, note.state.value, note.why or note.state.value, details)
