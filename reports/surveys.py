"""Surveys in a report: what engines were asked that is no question about a pair, and what they answered."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from oracles.outcome import Run
from oracles.surveys import load_survey
from oracles.surveys.judging import Shown, SurveyCount
from reports import ledger, text
from reports.tables import Column, Entry, Table

WHAT = (
    "Other libraries and this one, asked about things that are no pair of proxies; each answer is judged by a proof or "
    "by the exact truth. A fault that the ledger explains is counted apart, as known, and does not fail the run."
)
COLUMNS: tuple[tuple[str, str], ...] = (
    ("asked", "asked"),
    ("right", "right"),
    ("undecided", "undecided"),
    ("known", "known"),
    ("wrong", "wrong"),
    ("lost", "lost"),
)
LONGEST = 2000
"""Characters of a case that a report shows; `report.json` has it whole."""


@dataclass(frozen=True)
class Section:
    """One subject: its heading, what it is about, and its tables."""

    name: str
    title: str
    about: str
    tables: tuple[Table, ...]


def shown(run: Run) -> tuple[Section, ...]:
    """A section for each subject that was asked about."""
    return tuple(_section(run, name) for name in dict.fromkeys(count.survey for count in run.surveys))


def failures(run: Run) -> list[str]:
    """Sentences on where an engine is not as it promises."""
    counts: dict[tuple[str, str, str], Counter[str]] = {}
    for one in run.surveys:
        counts.setdefault((one.survey, one.engine, one.question), Counter()).update(
            {name: getattr(one, name) for name in ("wrong", "lost", "asked")}
        )
    return [
        f"survey {survey}, {engine}, {question}: {n['wrong']} wrong and {n['lost']} lost of {n['asked']}"
        for (survey, engine, question), n in counts.items()
        if n["wrong"] or n["lost"]
    ]


def _section(run: Run, name: str) -> Section:
    survey, counts = load_survey(name), [count for count in run.surveys if count.survey == name]
    found = _witnesses(run, counts)
    tables = (_matrix(counts), *([found] if found.rows else []), _counted(counts), _explained(counts))
    return Section(name, survey.title, survey.about, tables)


def _matrix(counts: Sequence[SurveyCount]) -> Table:
    """Questions and regimes by engines."""
    survey = load_survey(counts[0].survey)
    engines = list(dict.fromkeys(count.engine for count in counts))
    found = {(count.question, count.regime, count.engine): count for count in counts}
    rows = []
    asked = dict.fromkeys((c.question, c.regime) for c in counts if not c.absent)
    order = list(survey.questions)
    for question, regime in sorted(asked, key=lambda pair: order.index(pair[0]) if pair[0] in order else len(order)):
        states = (_state(found.get((question, regime, engine))) for engine in engines)
        first = Entry(text.visible(question), title=survey.questions.get(question, ""))
        rows.append((first, Entry(text.visible(regime), title=survey.regimes.get(regime, "")), *states))
    columns = (Column("question"), Column("regime"), *(Column(text.visible(engine)) for engine in engines))
    return Table(f"{survey.title}: answers by question, regime and engine", columns, tuple(rows))


def _state(count: SurveyCount | None) -> Entry:
    if count is None:
        return Entry("not asked", state="none")
    asked, worst = text.count(count.asked), f"off by {text.short(count.worst)} at most" if count.worst else ""
    known = f"{text.count(count.known)} by a known fault" if count.known else ""
    if count.lost:
        said = f"✗ {text.count(count.lost)} of {asked} lost"
        return Entry(said, "; ".join(map(text.visible, count.errors)), "crashed")
    if count.wrong:
        return Entry(f"✗ {text.count(count.wrong)} of {asked} wrong", "; ".join(filter(None, (worst, known))), "wrong")
    if count.known:
        return Entry(f"≈ {asked}", known, "convention", title="; ".join(map(text.visible, count.explained)))
    if count.undecided:
        return Entry(f"? {text.count(count.undecided)} of {asked} undecided", worst, "undecided")
    return Entry(f"✓ {asked}", worst, "ok")


def _counted(counts: Sequence[SurveyCount]) -> Table:
    """Everything that was counted: a row for each engine and question."""
    rows = []
    for engine, question in dict.fromkeys((count.engine, count.question) for count in counts if not count.absent):
        mine = [count for count in counts if (count.engine, count.question) == (engine, question)]
        sums = [(name, sum(getattr(count, name) for count in mine)) for _, name in COLUMNS]
        entries = [Entry(text.count(n), state="wrong" if n and name in ("wrong", "lost") else "") for name, n in sums]
        amounts = [Entry(text.short(max(getattr(count, name) for count in mine))) for name in ("worst", "tolerance")]
        rows.append((Entry(f"{text.visible(engine)} · {text.visible(question)}"), *entries, *amounts))
    numbers = (*(title for title, _ in COLUMNS), "off by at most", "allowed at most")
    columns = (Column("engine · question"), *(Column(title, True) for title in numbers))
    return Table(f"{load_survey(counts[0].survey).title}: everything that was counted", columns, tuple(rows))


def _explained(counts: Sequence[SurveyCount]) -> Table:
    """What the questions and regimes are, and by what each engine is asked and what it is held to."""
    survey = load_survey(counts[0].survey)
    asked = dict.fromkeys(count.regime for count in counts if not count.absent)
    words = [*survey.questions.items(), *((name, survey.regimes[name]) for name in asked if name in survey.regimes)]
    words += {count.engine: count.absent or f"{count.calls}: {count.promise}" for count in counts}.items()
    rows = tuple((Entry(text.visible(name)), Entry(text.visible(said, 1000))) for name, said in words)
    columns = (Column("question, regime, engine"), Column("what is asked, of what, by what, and what is promised"))
    return Table(f"{survey.title}: what is asked, and what engines are held to", columns, rows)


def _witnesses(run: Run, counts: Sequence[SurveyCount]) -> Table:
    """Of each engine, question, symptom and cause a case that shows it, of what is new the simplest that was found."""
    survey = load_survey(counts[0].survey)
    rows = []
    for count in counts:
        for found in count.witnesses:
            which = Entry(f"{text.visible(count.engine)} · {text.visible(count.question)}")
            known = "convention" if found.entry else ""
            kind = Entry(found.kind, state=known or {"wrong": "wrong", "lost": "crashed"}[found.kind])
            case = Entry(text.visible(survey.written(found.case), LONGEST))
            proven = Entry(text.visible("; ".join(said(found)), LONGEST))
            rows.append((which, kind, ledger.told(run, count.engine, found.entry), proven, case))
    columns = (Column("engine · question"), Column("what"), Column("ledger"), Column("proven"), Column("case"))
    return Table(f"{survey.title}: what is wrong, each by a case that shows it", columns, tuple(rows))


def said(found: Shown) -> Iterator[str]:
    """What the engine said of a witness, and what is proven of that."""
    if found.judgement is None:
        yield found.said.lost
    else:
        yield f"the answer {text.full(found.said.answer, 300)}"
        yield found.judgement.words
        if found.tolerance:
            yield f"off by {text.short(found.judgement.amount)} at least, allowed are {text.short(found.tolerance)}"
