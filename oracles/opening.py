"""Before the first task: engines that load, start and are sound, and a run that knows what will be asked."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from oracles.adapters import require_sound
from oracles.batch import PairKey
from oracles.bench import Setup, Workshop, workshop
from oracles.engine import Engine, EngineUnavailable
from oracles.outcome import Run, SupportNote
from oracles.recipes import reasons_of
from oracles.scene import cells, cells_of
from oracles.store import Store
from oracles.world import is_flat


def shop_of(setup: Setup) -> Workshop:
    """Workshop of this process, with every engine started and found sound.

    Raises
    ------
    EngineUnavailable
        When an engine cannot be loaded or started, its adapter is not sound, or two have one name.
    """
    shop = workshop(setup)
    names = [bench.name for bench in shop.benches]
    if len(set(names)) < len(names) or "refimpl" in names:
        raise EngineUnavailable(f"engines must have names of their own, none of them refimpl: {', '.join(names)}")
    for bench in shop.benches:
        require_sound(bench.engine)
    return shop


def wanted_pairs(names: Sequence[str] | None, engines: Iterable[Engine] = ()) -> list[PairKey]:
    """Pairs of these names, or all of the engines' worlds, by name."""
    worlds = {engine.flat for engine in engines} or {False, True}
    every = [cell for cell in cells() if is_flat(cell.type_a) in worlds]
    found = {(c.type_a, c.type_b) for c in (cells() if names else every) if not names or c.pair in names}
    return sorted(found, key=lambda p: (p[0].__name__, p[1].__name__))


def run_of(shop: Workshop, pairs: Sequence[PairKey], budget: float) -> Run:
    """Say what will be asked, of what, and why."""
    engines = [bench.engine for bench in shop.benches]
    started = datetime.now(UTC).isoformat(timespec="seconds")
    run = Run(shop.setup.seed, budget, started)
    run.engines = [bench.name for bench in shop.benches]
    run.versions = own_versions()
    run.engine_versions = {bench.name: next(iter(bench.engine.versions().values()), "") for bench in shop.benches}
    for bench in shop.benches:
        run.versions |= bench.engine.versions()
    for cell in (cell for pair in pairs for cell in cells_of(pair)):
        for bench in shop.benches:
            support = bench.engine.support(cell.query, cell.type_a, cell.type_b)
            run.support[bench.name, cell.query, cell.pair] = SupportNote(support.kind.value, support.reason)
    answered = {query for (_, query, _), note in run.support.items() if note.kind != "unsupported"}
    run.regimes = reasons_of(answered, engines)
    return run


def own_versions() -> dict[str, str]:
    """Versions of whatever the verdicts depend on besides the engines."""
    found = {"python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
    return found | {name: version(name) for name in ("proxyproof", "numpy", "scipy", "hypothesis")}


def store_of(
    folder: Path, shop: Workshop, run: Run, pairs: Sequence[PairKey], passes: int | None, *, resume: bool
) -> Store:
    """Record of a run, begun or gone on with; a full disk is no reason not to run.

    Raises
    ------
    RecordError
        When there is no record to go on with, or it is of another run.
    """
    manifest = {
        "versions": run.versions,
        "seed": run.seed,
        "engines": list(shop.setup.engines),
        "pairs": [f"{a.__name__}-{b.__name__}" for a, b in pairs],
        "call limit": shop.setup.call_limit,
        "models": shop.setup.models,
        "examples": shop.setup.examples,
        "database": shop.setup.database,
    }
    if resume:
        return Store.go_on(folder, manifest)
    try:
        return Store.begin(folder, manifest | {"work": {"budget": run.budget, "passes": passes}})
    except OSError as error:
        return Store(folder, [f"nothing of this run is recorded: {error.strerror or error}"], failed=True)
