"""The checker of repro scripts: a second one, held against `refimpl.proof` on certificates true and tampered with."""

from __future__ import annotations

import ast
import builtins
import json
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from oracles.answers import take
from oracles.batch import Batch
from oracles.engine import VELOCITIES
from oracles.impact_judge import first_broken
from oracles.impact_laws import After, laws
from oracles.impact_reference import reference_of
from oracles.impact_stages import TARGETS
from oracles.motion import exact
from oracles.repro.encoding import NotWritten, claims_data, kind_of, shape_data
from oracles.repro.pieces.checking import CHECKS, KINDS, MEANING
from oracles.repro.pieces.claims import CLAIMS
from oracles.repro.pieces.exact import Refused
from oracles.repro.pieces.impacts import breaches
from oracles.repro.pieces.judging import TRIALS
from oracles.repro.selecting import ORDER, pieces, select
from oracles.scene import DISTANCE, RAYCAST, Scene
from refimpl import Ray
from refimpl.pairs import TABLE
from refimpl.proof import Certificate, InvalidCertificate, certify, check, from_json, to_json
from tests.conftest import effort

CLOSE = Fraction(1, 2**80)
"""Both enclose square roots to about 2⁻¹⁵⁰ of what they add them to, each in a way of its own."""

LARGEST = 1e12
"""Beyond what a tampered number brings into a bound."""


def scenes_of_all_pairs(seed: int, each: int) -> list[Scene]:
    """Scenes of every pair of the table, in regimes that differ from pair to pair."""
    rng, found = np.random.default_rng(seed), []
    for pair in TABLE:
        drawn = [(batch, i) for batch in Batch.draw(pair, seed, (7,), 1) for i in range(len(batch))]
        for k in rng.permutation(len(drawn))[:each]:
            batch, i = drawn[k]
            found.append(batch.scene(RAYCAST if pair[0] is Ray else DISTANCE, i))
    return found


@pytest.fixture(scope="module")
def proofs() -> list[tuple[Scene, Certificate]]:
    scenes = scenes_of_all_pairs(2026, max(1, effort() // 10))
    return [(scene, certify(scene.a, scene.b)) for scene in scenes]


def proves(certificate: Certificate, scene: Scene) -> tuple[Any, Any]:
    """What the checker of scripts makes of a certificate, read as from a file."""
    a, b = scene.a, scene.b
    data = json.loads(json.dumps([claims_data(certificate, a, b), shape_data(a), shape_data(b)]))
    lower, upper = KINDS[kind_of(a, b)](*data)
    return lower, upper


def differ(x: Any, y: Any, size: float) -> bool:
    if math.inf in (abs(x), abs(y)):
        return bool(x != y)
    return bool(abs(Fraction(x) - Fraction(y)) > CLOSE * Fraction(max(abs(x), abs(y), size)))


def test_it_proves_what_the_other_checker_proves(proofs: list[tuple[Scene, Certificate]]) -> None:
    kinds = set()
    for scene, certificate in proofs:
        kinds |= {claim["kind"] for claim in claims_data(certificate, scene.a, scene.b)}
        known = check(certificate, scene.a, scene.b)
        assert not any(map(differ, proves(certificate, scene), known, [scene.size] * 2)), (
            scene.cell.pair,
            scene.regime,
        )
    assert kinds >= {"separated", "near", "escape", "core", "cover", "part", "free", "hit"}
    assert len(proofs) >= len(TABLE)


def leaves(data: Any) -> Iterator[tuple[Any, Any]]:
    """Every place of a number in plain data: what holds it, and its key."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, dict | list):
            yield from leaves(value)
        elif isinstance(value, int | float) or (isinstance(value, str) and "/" in value):
            yield data, key


def tampered(certificate: Certificate, rng: np.random.Generator) -> Certificate | None:
    """The certificate with one number changed; None where that is no certificate at all."""
    data = to_json(certificate)
    places = list(leaves(data["claims"]))
    where, key = places[rng.integers(len(places))]
    old = where[key]
    new = [0, -1, 1e300, 3] if type(old) is int else [0.0, 1.5, "1/3", -1e-3, 1e9]
    if isinstance(old, float):
        new += [-old, old * (1 + 1e-9), old * 0.999]
    where[key] = new[rng.integers(len(new))]
    try:
        return from_json(data)
    except InvalidCertificate:
        return None


def test_what_is_tampered_with_is_refused_or_proves_no_falsehood(proofs: list[tuple[Scene, Certificate]]) -> None:
    rng, refused, held = np.random.default_rng(7), 0, 0
    for scene, certificate in proofs:
        lower, upper = check(certificate, scene.a, scene.b)
        for _ in range(3):
            changed = tampered(certificate, rng)
            if changed is None:
                continue
            try:
                found = proves(changed, scene)
            except (Refused, NotWritten, ArithmeticError, LookupError, TypeError, ValueError):
                refused += 1
                continue
            held += 1
            assert found[0] <= upper
            assert found[1] >= lower
            try:
                known = check(changed, scene.a, scene.b)
            except InvalidCertificate:  # it has limits that this one has not: of effort, of what is an index
                continue
            assert not any(map(differ, found, known, [LARGEST] * 2)), (scene.cell.pair, scene.regime)
    assert refused > 50
    assert held > 50


# -- impacts -------------------------------------------------------------------------------------------------


def test_the_laws_of_impacts_are_those_of_the_judge() -> None:
    rng, seen = np.random.default_rng(1), set()
    for pair in TARGETS:
        (batch,) = Batch.draw_impacts(pair, 3, (0,), 1)
        assert batch.motion is not None
        right = reference_of(batch.motion)
        for i in range(len(batch)):
            for spread in (0.0, 1e-9, 1.0):
                one, motion = take(right, [i]), batch.motion[[i]]
                noise = [spread * rng.normal(size=3) * (rng.random(3) < 0.4) for _ in VELOCITIES]
                one = replace(one, **{n: getattr(one, n) + dv for n, dv in zip(VELOCITIES, noise, strict=True)})
                after = After(*(exact(getattr(one, name)) for name in VELOCITIES))
                wanted = {law.symptom: law.amount[0] for law in laws(motion.exact(), after) if law.applies[0]}
                answer = {name: getattr(one, name)[0].tolist() for name in VELOCITIES}
                found = dict(breaches(batch.motion[i].to_json(), answer))
                assert found == wanted
                assert list(found) == list(wanted)
                broken = first_broken(motion, one, Fraction(1, 10**6))
                seen.add(broken and broken[0])
    assert len(seen) >= 5


# -- what scripts take of it ---------------------------------------------------------------------------------


def test_the_pieces_need_only_the_standard_library_and_each_other() -> None:
    for module in ORDER:
        text = (pieces.__wrapped__.__globals__["files"])("oracles.repro.pieces").joinpath(f"{module}.py").read_text()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom):
                top, _, rest = str(node.module).partition(".")
                assert top in sys.stdlib_module_names or rest.startswith("repro.pieces.")
                before = ORDER[: ORDER.index(module)]
                assert top != "oracles" or rest.rpartition(".")[2] in before, (module, rest)
            elif isinstance(node, ast.Import):
                assert {alias.name for alias in node.names} <= sys.stdlib_module_names


def unknown_names(text: str) -> set[str]:
    """Names that a module reads and neither defines, imports nor finds among the builtins."""
    tree = ast.parse(text)
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    known = {node.id for node in names if not isinstance(node.ctx, ast.Load)} | set(dir(builtins))
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            known.add(node.name)
        elif isinstance(node, ast.arg):
            known.add(node.arg)
        elif isinstance(node, ast.alias):
            known.add(node.name)
    return {node.id for node in names} - known


ROWS = {
    "MEANING": MEANING,
    "CHECKS": CHECKS,
    "CLAIMS": CLAIMS,
    "KINDS": KINDS,
    "TRIALS": TRIALS,
}


@pytest.mark.parametrize(("table", "key"), [(table, key) for table, rows in ROWS.items() for key in rows])
def test_each_row_brings_all_that_it_needs_and_no_other_row(table: str, key: str) -> None:
    tables = {name: frozenset({key} if name == table else ()) for name in ROWS}
    imports, checker, rest = select("proofs_of(1), wrong_by(2), part(3), read(4), interval_of(5)", tables)
    text = f"{checker}\n\n{rest}"
    assert unknown_names(f"{imports}\n{text}") == set()
    found = dict[str, Any]()
    exec(compile(f"from __future__ import annotations\n{imports}\n{text}", "selected", "exec"), found)
    for name in ROWS:
        assert set(found.get(name, tables[name])) == tables[name]
    assert table in found


def test_a_short_script_has_a_short_checker() -> None:
    rows = {"MEANING": {"Sphere", "Box"}, "CHECKS": {"separated", "near"}, "KINDS": {"solids"}, "CLAIMS": set[str]()}
    _, text, rest = select("proven(1)", {name: frozenset(keys) for name, keys in rows.items()})
    assert rest == ""
    assert len(text.splitlines()) < 200
    assert "Cylinder" not in text
    assert "class Union" not in text
