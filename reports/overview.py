"""The report's first screen: what each engine did, what asks for a decision, and where the time went."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from oracles.outcome import COMPARED, FINDINGS, EntryNote, Kind, Run, State
from reports import text
from reports.tables import engines, grouped, total

PARTS = (
    ("ok", "agree", (Kind.AGREES,)),
    ("convention", "right by convention", (Kind.CONVENTION,)),
    ("undecided", "undecided", (Kind.UNDECIDED,)),
    ("wrong", "wrong", (Kind.WRONG, Kind.INCONSISTENT, Kind.REFERENCE_WRONG)),
    ("crashed", "no answer", (Kind.CRASHED, Kind.TIMED_OUT)),
)
"""State, words and verdicts of the parts of which an engine's answers consist."""

LEAST_SHARE = 0.4
"""No part that is there is drawn narrower than this, in per cent."""


@dataclass(frozen=True)
class Part:
    """Answers of one kind: how many, in words, and where they lie in a bar of 100."""

    state: str
    words: str
    count: str
    start: float
    share: float


@dataclass(frozen=True)
class Card:
    """What one engine did."""

    engine: str
    version: str
    verdict: str
    parts: tuple[Part, ...]
    buckets: str


@dataclass(frozen=True)
class Spent:
    """Time spent on one thing, and its share in per cent."""

    name: str
    time: str
    share: float
    share_text: str


def cards(run: Run) -> tuple[Card, ...]:
    """Return a card for each engine, in the run's order."""
    counts = grouped(run, "engine")
    return tuple(_card(run, engine, counts.get((engine,), Counter())) for engine in engines(run))


def _card(run: Run, engine: str, verdicts: Counter[Kind]) -> Card:
    compared, bad = total(verdicts, COMPARED), total(verdicts, FINDINGS)
    its = [bucket for bucket in run.buckets if bucket.engine == engine]
    new = sum(bucket.state is State.NEW for bucket in its)
    share = f"{text.THIN}({text.short(100 * bad / compared)}{text.THIN}%)" if bad else ""
    return Card(
        engine=text.visible(engine),
        version=text.visible(run.engine_versions.get(engine, "")),
        verdict=f"{text.count(bad) if bad else 'none'} of {text.plural(compared, 'answer')} wrong or lost{share}",
        parts=tuple(_parts(verdicts, compared)),
        buckets=f"{text.plural(len(its), 'bucket')}, {f'{text.count(new)} new' if new else 'none new'}",
    )


def _parts(verdicts: Counter[Kind], compared: int) -> list[Part]:
    amounts = [(state, words, total(verdicts, kinds)) for state, words, kinds in PARTS]
    shares = [max(LEAST_SHARE, 100 * n / compared) if n else 0.0 for _, _, n in amounts]
    whole, start, found = sum(shares), 0.0, []
    for (state, words, n), share in zip(amounts, shares, strict=True):
        if n:
            width = 100 * share / whole
            found.append(Part(state, words, text.count(n), round(start, 2), round(width, 2)))
            start += width
    return found


def unsettled_entries(run: Run) -> list[EntryNote]:
    """Entries of the ledger that ask for something to be done."""
    return [note for note in run.ledger if note.state in (State.STALE, State.CHANGED)]


def spent(run: Run) -> tuple[Spent, ...]:
    """Where the time went, the most first."""
    whole = sum(run.timing.values())
    return tuple(
        Spent(
            text.visible(name),
            text.seconds(time),
            round(100 * time / whole, 2) if whole else 0.0,
            text.share(time, whole),
        )
        for name, time in sorted(run.timing.items(), key=lambda item: -item[1])
    )
