"""After the last task: a script for each bucket, and what makes the run incomplete."""

from __future__ import annotations

from collections.abc import Collection

from oracles.bench import Workshop
from oracles.engine import Engine
from oracles.outcome import ANSWERED, Finding, Kind, Run
from oracles.recipes import is_for
from oracles.regimes import THRESHOLDS_OF, is_drawn
from oracles.repro import script_of
from oracles.repro.calls import call_of
from oracles.scene import TYPES
from oracles.sweep_regimes import TURNING
from oracles.world import is_flat


def write_scripts(run: Run, shop: Workshop) -> None:
    """Give each bucket the script that asks its engine alone for its witness."""
    engines = {bench.name: bench.engine for bench in shop.benches}
    for bucket in run.buckets:
        if bucket.engine in engines:
            engine = engines[bucket.engine]
            bucket.call = _calls(engine, bucket.witness)
            bucket.repro = _script(engine, bucket.witness)


def _calls(engine: Engine, finding: Finding) -> str:
    """The call of the engine alone, followed by that on the scene whose answer contradicts it."""
    first = call_of(engine, finding.scene)
    if finding.related is None:
        return first
    second = f"# The same engine on the related scene ({finding.related.relation}):"
    return f"{first.rstrip()}\n\n{second}\n{call_of(engine, finding.related.scene)}"


def _script(engine: Engine, finding: Finding) -> str:
    try:
        return script_of(engine, finding)
    except Exception as error:  # an adapter's mistake must not cost the report
        why = f"{type(error).__name__}: {str(error)[:500]!r}"
        return f"# No proof could be put into this script: {why}\n{_calls(engine, finding)}"


def silent_cells(run: Run) -> list[str]:
    """Supported cells and regimes in which nothing was compared: silence would look like agreement.

    An engine that supports none of the cells is no gap, unless there is no other one.
    """
    able = {engine for (engine, _, _), note in run.support.items() if note.kind != "unsupported"}
    silent = [
        f"{engine}: no answer was compared at all"
        for engine in run.engines
        if (engine in able or not able) and not run.total(engine=engine, kinds=ANSWERED)
    ]
    compared = {
        key[:4] for key, count in run.counts.items() if count and key[4] not in (Kind.UNSUPPORTED, Kind.SKIPPED)
    }
    answered = {(engine, pair) for (engine, _, pair), note in run.support.items() if note.kind != "unsupported"}
    for cell, note in run.support.items():
        engine, query, pair = cell
        refused = {key[3] for key, n in run.counts.items() if n and key[:3] == cell and key[4] is Kind.UNSUPPORTED}
        wanted = [name for name in run.regimes if is_for(name, query) and not (name in TURNING and name in refused)]
        wanted = [name for name in wanted if has_scenes(name, pair, answered)]
        lacking = [regime for regime in wanted if (*cell, regime) not in compared]
        if note.kind != "unsupported" and lacking:
            regimes = f"{len(lacking)} of {len(wanted)} regimes: {', '.join(lacking)}"
            where = "any regime" if len(lacking) == len(wanted) else regimes
            silent.append(f"{engine}: nothing compared in {query} {pair} in {where}")
    return silent


def has_scenes(regime: str, pair: str, answered: Collection[tuple[str, str]]) -> bool:
    """Whether a regime has scenes of a pair: models are of space, and thresholds of the engine's own world.

    Parameters
    ----------
    answered
        Engines and pairs that they answer.
    """
    kinds = [TYPES[name] for name in pair.split("–") if name in TYPES]
    flat = any(map(is_flat, kinds))
    owner = regime.removeprefix(THRESHOLDS_OF)
    if owner == regime:
        return is_drawn(regime, kinds)
    firsts = (TYPES.get(name.split("–")[0]) for engine, name in answered if engine == owner)
    return any(kind is not None and is_flat(kind) == flat for kind in firsts)
