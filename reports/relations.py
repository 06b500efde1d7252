"""The table of relations: how an engine's answers to related scenes fared, and what a finding says of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from oracles.outcome import Finding, Kind, Run
from oracles.relations import RELATIONS
from oracles.scene import Scene
from reports import shapes, text
from reports.tables import Column, Entry, Table

COLUMNS: tuple[tuple[str, tuple[Kind, ...]], ...] = (
    ("agree", (Kind.AGREES,)),
    ("contradict", (Kind.INCONSISTENT,)),
    ("one wrong", (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT, Kind.REFERENCE_WRONG)),
    ("undecided", (Kind.UNDECIDED,)),
    ("convention", (Kind.CONVENTION,)),
    ("not comparable", (Kind.SKIPPED,)),
    ("unsupported", (Kind.UNSUPPORTED,)),
)
"""What becomes of pairs of answers: the reference convicts one of them, or both contradict each other, or neither."""


def relation_table(run: Run) -> Table:
    """Pairs of scenes that were asked per relation and engine, and how their answers fared."""
    sums: dict[tuple[str, str], Counter[Kind]] = {}
    for (engine, name, _, kind), n in run.relations.items():
        sums.setdefault((name, engine), Counter())[kind] += n
    rows = []
    for name, relation in RELATIONS.items():
        for engine in run.engines:
            kinds = sums.get((name, engine))
            if kinds is None:
                continue
            counts = [sum(kinds[kind] for kind in group) for _, group in COLUMNS]
            entries = [_entry(title, count) for (title, _), count in zip(COLUMNS, counts, strict=True)]
            rows.append((Entry(relation.changing), Entry(text.visible(engine)), Entry(relation.reason), *entries))
    columns = (Column("relation"), Column("engine"), Column("why"), *(Column(title, True) for title, _ in COLUMNS))
    return Table("Relations: pairs of scenes of which one was made from the other", columns, tuple(rows))


def _entry(title: str, count: int) -> Entry:
    return Entry(text.count(count), state="wrong" if count and title in ("contradict", "one wrong") else "")


def related_facts(finding: Finding) -> Iterator[tuple[str, str]]:
    """The scene whose answer contradicts that of a finding, and the answer."""
    related = finding.related
    if related is None:
        return
    relation = RELATIONS.get(related.relation)
    yield "related by", relation.changing if relation else text.visible(related.relation)
    yield from _sides(related.scene)
    said = ", ".join(f"{text.visible(name)} = {text.full(value)}" for name, value in related.answer.items())
    yield "related answer", said or "none"


def _sides(scene: Scene) -> Iterator[tuple[str, str]]:
    yield "related query", text.visible(scene.query)
    yield "related A", shapes.in_words(scene.a)
    yield "related B", shapes.in_words(scene.b)
