"""A scene for each engine that is wrong on purpose, kept as JSON.

``python -m tests.planted_scenes`` looks for them anew.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from oracles.answers import take
from oracles.batch import Batch
from oracles.clumsiness import odd_numbers
from oracles.engine import WIDTH, Answers, Engine, Status, faults
from oracles.judges import Judges
from oracles.outcome import FINDINGS
from oracles.planted.mutant import Mutant
from oracles.planted.mutants import MUTANTS
from oracles.scene import IMPACT, Cell, Scene, cells

FILE = Path(__file__).with_name("planted_scenes.json")


def cell_of(query: str, pair: str) -> Cell:
    """The cell of these names."""
    return next(cell for cell in cells() if (cell.query, cell.pair) == (query, pair))


def batches(cell: Cell, seed: int, each: int) -> list[Batch]:
    """Scenes of every regime for a cell."""
    pair = cell.type_a, cell.type_b
    if cell.query == IMPACT:
        return [long_normals(batch) for batch in Batch.draw_impacts(pair, seed, (0, 0), each)]
    return Batch.draw(pair, seed, (0, 0), each)


def long_normals(batch: Batch) -> Batch:
    """The same impacts, with normals of length 2 in every second scene: any length is right."""
    assert batch.motion is not None
    length = np.where(np.arange(len(batch)) % 2, 2.0, 1.0)
    return replace(batch, motion=replace(batch.motion, normal=batch.motion.normal * length[:, None]))


def answered(engine: Engine, cell: Cell, batch: Batch) -> Answers:
    """What an engine answers in this process, one scene after another."""
    solve, rows = engine.solver(cell.query, cell.type_a, cell.type_b), batch.rows
    table, status, errors = np.full((len(batch), WIDTH), np.nan), np.zeros(len(batch), np.int8), dict[int, str]()
    for i, (a, b) in enumerate(zip(*(row.tolist() for row in rows), strict=True)):
        try:
            table[i] = solve(a, b)
        except Exception as error:
            errors[i] = f"{type(error).__name__}: {error}"
    errors = faults(cell.query, engine.says(cell.query, cell.type_a, cell.type_b), table) | errors
    status[list(errors)] = Status.ERROR
    return Answers.from_table(status, table, errors)


def convictions(mutant: Mutant, seed: int, each: int) -> Iterator[Scene]:
    """Scenes of bulk batches on which a wrong engine is convicted of its fault."""
    engine, cell = mutant.engine(), cell_of(mutant.query, mutant.pair)
    judges = Judges(engine)
    for batch in batches(cell, seed, each):
        answers = answered(engine, cell, batch)
        screening = judges.screen(cell, batch.a, batch.b, batch.motion, answers)
        wrong = [i for i, symptom in enumerate(screening.symptom) if symptom == mutant.symptoms[0]]
        for i in sorted(wrong, key=lambda i: odd_numbers(batch.scene(cell.query, i)))[:3]:
            verdict = judges.convict(batch.scene(cell.query, i), take(answers, [i]))
            if verdict.kind in FINDINGS and verdict.symptom == mutant.symptoms[0]:
                yield batch.scene(cell.query, i)


def main() -> None:
    """Write the file."""
    kept = {}
    for name, mutant in MUTANTS.items():
        if mutant.comes_back and not mutant.engine.remembers:
            found = [scene for seed in range(3) for scene in convictions(mutant, seed, 20)]
            if found:
                kept[name] = min(found, key=odd_numbers).to_json()
            print(name, len(found))
    lines = (f"{json.dumps(name)}: {json.dumps(scene)}" for name, scene in kept.items())
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")


if __name__ == "__main__":
    main()
