"""After the last task: a script for each bucket, and what makes the run incomplete."""

from __future__ import annotations

from oracles.bench import Workshop
from oracles.engine import Engine
from oracles.impact_regimes import is_of_impacts
from oracles.outcome import ANSWERED, Finding, Kind, Run
from oracles.scene import IMPACT, Scene


def write_scripts(run: Run, shop: Workshop) -> None:
    """Give each bucket the script that asks its engine alone for its witness."""
    engines = {bench.name: bench.engine for bench in shop.benches}
    for bucket in run.buckets:
        if bucket.engine in engines:
            bucket.repro = _scripts(engines[bucket.engine], bucket.witness)


def _scripts(engine: Engine, finding: Finding) -> str:
    """The script of a finding, followed by that of the scene whose answer contradicts it."""
    first = _script(engine, finding.scene)
    if finding.related is None:
        return first
    second = f"# The same engine on the related scene ({finding.related.relation}):"
    return f"{first.rstrip()}\n\n{second}\n{_script(engine, finding.related.scene)}"


def _script(engine: Engine, scene: Scene) -> str:
    rows = [row.tolist() for row in scene.rows]
    try:
        script = engine.repro(scene.query, scene.cell.type_a, scene.cell.type_b, *rows)
        return (
            script if isinstance(script, str) else f"# {engine.name} wrote a {type(script).__name__} for this scene\n"
        )
    except Exception as error:  # an adapter's mistake must not cost the report
        return f"# {engine.name} wrote no script for this scene: {type(error).__name__}: {str(error)[:500]!r}\n"


def silent_cells(run: Run) -> list[str]:
    """Supported cells and regimes in which nothing was compared: silence would look like agreement."""
    silent = [
        f"{engine}: no answer was compared at all"
        for engine in run.engines
        if not run.total(engine=engine, kinds=ANSWERED)
    ]
    compared = {
        key[:4] for key, count in run.counts.items() if count and key[4] not in (Kind.UNSUPPORTED, Kind.SKIPPED)
    }
    for cell, note in run.support.items():
        engine, query, pair = cell
        wanted = [name for name in run.regimes if is_of_impacts(name) == (query == IMPACT)]
        lacking = [regime for regime in wanted if (*cell, regime) not in compared]
        if note.kind != "unsupported" and lacking:
            regimes = f"{len(lacking)} of {len(wanted)} regimes: {', '.join(lacking)}"
            where = "any regime" if len(lacking) == len(wanted) else regimes
            silent.append(f"{engine}: nothing compared in {query} {pair} in {where}")
    return silent
