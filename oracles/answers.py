"""Handling of engine answers: picking rows, saying what was said, and the reference's own answers in that form."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from oracles.engine import COLUMNS, WIDTH, Answers, Status
from oracles.impact_reference import reference_of
from oracles.scene import BOOLEAN, RAYCAST, Cell, Scene
from oracles.sweep_reference import sweep_answers
from oracles.world import VECTORS, world_of
from refimpl import Proxy, distance, raycast


def take(answers: Answers, rows: Any) -> Answers:
    """Answers of the given rows, in their order, or of those that are True."""
    rows = np.asarray(rows)
    rows = np.flatnonzero(rows) if rows.dtype == bool else rows
    columns = {name: getattr(answers, name)[rows] for name in COLUMNS}
    errors = {new: answers.errors[int(old)] for new, old in enumerate(rows) if int(old) in answers.errors}
    return Answers(status=answers.status[rows], **columns, errors=errors)


def said(answers: Answers, row: int) -> dict[str, object]:
    """Only what the engine said about one scene, by name, in full precision."""
    if answers.status[row] != Status.ANSWERED:
        return {}
    found = {name: getattr(answers, name)[row].tolist() for name in COLUMNS}
    return {name: value for name, value in found.items() if not np.isnan(value).all()}


def reference_for(scene: Scene) -> Answers:
    """Answer one scene as the reference does."""
    if scene.course is not None:
        return sweep_answers(scene.a[None], scene.b[None], scene.course[None])
    if scene.impact is not None:
        return reference_of(scene.impact[None])
    return reference_answers(scene.query, scene.a[None], scene.b[None])


def reference_answers(query: str, a: Proxy, b: Proxy) -> Answers:
    """Answer as the reference does, for shapes with one batch axis."""
    table, world = np.full((len(a), WIDTH), np.nan), world_of(b)
    if query == RAYCAST:
        found = raycast(a, b)  # type: ignore[arg-type]
        columns = {"hit": found.hit, "t": found.t, "normal": found.normal, "point": found.point}
    else:
        sep = distance(a, b)
        columns = {"hit": sep.distance <= 0}
        if query != BOOLEAN:
            columns |= {"distance": sep.distance, "on_a": sep.on_a, "on_b": sep.on_b, "normal": sep.normal}
    for name, values in columns.items():
        table[:, COLUMNS[name]] = world.fill(values) if name in VECTORS else values[:, None]
    return Answers.from_table(np.zeros(len(a), dtype=np.int8), table, {})


def add_to_digest(digest: hashlib._Hash, engine: str, cell: Cell, answers: Answers) -> None:
    """Feed a digest with every bit of some answers; what is no number counts as one and the same."""
    digest.update(f"{engine} {cell.query} {cell.pair} {len(answers)}\n".encode())
    digest.update(np.ascontiguousarray(answers.status, dtype=np.int8).tobytes())
    for name in COLUMNS:
        column = np.ascontiguousarray(getattr(answers, name), dtype="<f8")
        digest.update(np.where(np.isnan(column), np.nan, column).tobytes())
