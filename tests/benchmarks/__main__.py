"""Print µs a pair, beside the engines: ``python -m tests.benchmarks [--write] [types or pairs]``.

Batches of 10 000 by the reference, and one by one by python-fcl and PyBullet, each in one thread. Ratios count how many
times the engine's rate the reference has; the asked ones are 10 for closed forms and finite searches, else 1. The
columns "shared" are of the same batch as a caller gets it by default, shared by a thread for each processor, by the
clock on the wall.
"""

from __future__ import annotations

import sys
import time

from rich.console import Console
from rich.progress import track
from rich.table import Table

import refimpl
from oracles.engine import Engine, EngineUnavailable
from oracles.engines.bullet_engine import BulletEngine
from oracles.engines.fcl_engine import FclEngine
from refimpl.pairs import ITERATIVE, TABLE
from tests.accuracy import merge
from tests.benchmarks import rates, scenes


def engines() -> dict[str, Engine]:
    """The engines that are installed."""
    found: dict[str, Engine] = {}
    for name, make in (("fcl", FclEngine), ("bullet", BulletEngine)):
        engine: Engine = make()
        try:
            engine.warm()
        except EngineUnavailable as error:
            print(error)
            continue
        found[name] = engine
    return found


def measured(pair: tuple[type, type], against: dict[str, Engine]) -> dict[str, float | None]:
    """Times of a pair in µs, and rates as multiples of the engines'."""
    a, b = scenes.batch_of(pair)
    with rates.threads(1):
        ours, alone = rates.in_batch(a, b), rates.alone(a, b)
    with rates.threads(None):
        shared = rates.in_batch(a, b, time.perf_counter)
    row: dict[str, float | None] = {"alone_us": alone, "batch_us": ours, "shared_us": shared}
    for name, engine in against.items():
        theirs = rates.engine_loop(engine, a, b)
        row[f"{name}_us"] = theirs
        row[name] = None if theirs is None else theirs / ours
        row[f"{name}_shared"] = None if theirs is None else theirs / shared
    return row


def shown(value: float | None, form: str = "{:.1f}") -> str:
    return "–" if value is None else form.format(value)


def pairs_table(words: list[str], write: bool) -> None:
    """Measure and print the pairs that a word names, and keep each at once if asked to."""
    against = engines()
    titles = ("pair", "class", "alone µs", "batch µs", "shared µs", "FCL µs", "Bullet µs", "× FCL", "× Bullet")
    table = Table(*titles, "× FCL shared", "× Bullet shared", "asked")
    chosen = [p for p in TABLE if not words or {p[0].__name__, p[1].__name__, _name(p, "-")} & set(words)]
    for pair in track(chosen, description="measuring", transient=True):
        row, exactness = measured(pair, against), TABLE[pair].exactness
        asked, most_alone = (1.0, 5000.0) if exactness == ITERATIVE else (10.0, 1000.0)
        ratios = [row[name] for name in against if row[name] is not None]
        missed = [f"{ratio:.1f} < {asked:.0f}" for ratio in ratios if ratio is not None and ratio < asked]
        missed += ["alone"] if (row["alone_us"] or 0.0) > most_alone else []
        table.add_row(
            _name(pair, "–"),
            exactness,
            shown(row["alone_us"], "{:.0f}"),
            shown(row["batch_us"], "{:.2f}"),
            shown(row["shared_us"], "{:.2f}"),
            *(shown(row.get(key)) for key in ("fcl_us", "bullet_us", "fcl", "bullet", "fcl_shared", "bullet_shared")),
            "; ".join(missed) or "✓",
        )
        if write:
            merge({_name(pair, "–"): {key: row.get(key) for key in ("alone_us", "batch_us", "fcl", "bullet")}})
    Console(width=150).print(table)


def _name(pair: tuple[type, type], sign: str) -> str:
    return f"{pair[0].__name__}{sign}{pair[1].__name__}"


def meshes() -> None:
    """Print the large hull and the large mesh."""
    began = time.perf_counter()
    a, b = scenes.large_hulls(1000)
    faces = a.hull.planes.shape[-2]
    print(f"hull of {faces} faces derived in {time.perf_counter() - began:.2f} s")
    with rates.threads(1):
        ours = rates.in_batch(a, b)
    lines = [f"hull against the same: {ours:.1f} µs in a batch, {rates.alone(a, b):.0f} µs alone"]
    for name, engine in engines().items():
        theirs = rates.engine_loop(engine, a, b)
        lines.append(f"{name} {shown(theirs)} µs, ratio {shown(theirs / ours if theirs else None)}")
    print("; ".join(lines))
    began = time.perf_counter()
    mesh, balls = scenes.large_mesh(), scenes.spheres(300)
    refimpl.distance(balls[0], mesh)
    prepared = time.perf_counter() - began
    print(
        f"mesh of {len(mesh.triangles)} faces prepared in {prepared:.1f} s; against a sphere "
        f"{rates.alone(balls, mesh.broadcast_to((300,))):.0f} µs alone (asked: 1000), "
        f"{rates.in_batch(balls, mesh.broadcast_to((300,))):.0f} µs in a batch"
    )


def main(arguments: list[str]) -> None:
    """Measure everything, or what is named."""
    words = [word for word in arguments if not word.startswith("-")]
    if words != ["meshes"]:
        pairs_table([word for word in words if word != "meshes"], "--write" in arguments)
    if not words or "meshes" in words:
        meshes()
        print(f"import refimpl: {rates.import_seconds():.3f} s (asked: 0.3)")


if __name__ == "__main__":
    main(sys.argv[1:])
