"""Writes the script of a finding: the engine's call, the scene with its proofs, the checker, the verdict."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from oracles.answers import said
from oracles.engine import COLUMNS, VELOCITIES, Engine
from oracles.impact_reference import reference_of
from oracles.outcome import Finding, Kind, Verdict
from oracles.relation import RELATIONS
from oracles.repro.calls import OWN, call_of, function_of, needed_by
from oracles.repro.encoding import motion_data
from oracles.repro.facts import GIVEN, Sides, facts_of
from oracles.repro.literals import UNPACKED, WIDTH, Name, Numbers, shortened
from oracles.repro.selecting import select
from oracles.repro.templates import (
    AGAIN,
    ASK,
    ASK_BOTH,
    ASK_TIMED,
    CHECK,
    CHECK_LAWS,
    END,
    HEAD,
    JUDGE,
    JUDGE_CONTRADICTION,
    JUDGE_IMPACT,
    MAIN,
    NEAR,
    PARTS,
)
from oracles.scene import BOOLEAN, SWEEP, Scene
from oracles.words import TRUTHS, TRUTHS_OF_SWEEPS

LIMIT = 10
"""Seconds that a script gives the engine."""
LONGEST = 1000
"""Characters of a text that scripts take over."""
IN_TIME = re.compile(r"no answer within ([0-9.]+) s")
TABLES = ("MEANING", "CLAIMS", "CHECKS", "KINDS", "TRIALS")


@dataclass
class Case:
    """One answer that a script judges: constants by their names, and the rows of tables that it needs."""

    constants: dict[str, Any] = field(default_factory=dict)
    rows: dict[str, set[str]] = field(default_factory=lambda: {name: set() for name in TABLES})
    judge: str = JUDGE


def script_of(engine: Engine, finding: Finding) -> str:
    """Write the script that shows a finding: it needs the engine, numpy and nothing of this project."""
    calls = [call_of(engine, finding.scene)]
    if finding.related is None:
        case = _case(engine, finding.scene, finding.answer, finding.verdict)
    else:
        calls.append(call_of(engine, finding.related.scene))
        case = _case(engine, finding.related.scene, finding.related.answer, None)
        _add_first(case, engine, finding)
    if case.judge != JUDGE:
        case.constants["SYMPTOM"] = finding.verdict.symptom
    limit = IN_TIME.search(finding.text)
    if finding.verdict.kind is Kind.TIMED_OUT and limit and "HELD" in case.constants:
        case.constants["HELD"]["seconds"] = float(limit[1])
        case.rows["TRIALS"].add("seconds")
    needed = [one for call in calls for one in needed_by(call)]
    case.constants["NEEDED"] = [one for i, one in enumerate(needed) if one not in needed[:i]]
    names = [name for name in COLUMNS if (name in VELOCITIES) == (finding.scene.impact is not None)]
    case.constants["NAMES"] = [*names, "seconds"] if "seconds" in case.constants.get("HELD", {}) else names
    return _composed(engine, finding, calls, case)


def _case(engine: Engine, scene: Scene, answer: Mapping[str, object], verdict: Verdict | None) -> Case:
    return _of_impact(engine, scene, answer) if scene.impact is not None else _at_rest(engine, scene, answer, verdict)


def _at_rest(engine: Engine, scene: Scene, answer: Mapping[str, object], verdict: Verdict | None) -> Case:
    facts = facts_of(engine, scene, answer, verdict)
    case, shapes = Case(), dict[str, Any]()
    for side in facts.sides:
        for name, shape in (("A", side.a), ("B", side.b)):
            if side.whose == GIVEN:
                shapes[name] = shape
            elif shape not in shapes.values():
                shapes[f"{name}_USED"] = shape
    case.constants |= shapes
    case.constants |= {"ANSWER": dict(answer), "HELD": facts.held}
    case.constants["SIDES"] = [_side(side, shapes, case, sweep=scene.query == SWEEP) for side in facts.sides]
    if scene.query == BOOLEAN:
        case.rows["TRIALS"] |= {"value"}
    elif scene.query != SWEEP:
        case.rows["TRIALS"] |= {"time"} if "t" in facts.held else {"value", "points"}
    promised = {f"{name} {facts.held[name]!r}" for name in ("hit", "distance", "t", "witness") if name in facts.held}
    case.constants["ALLOWED"] = f"{engine.name} is allowed an error of {', '.join(sorted(promised))}"
    return case


def _side(side: Sides, shapes: Mapping[str, Any], case: Case, *, sweep: bool) -> dict[str, Any]:
    proofs: dict[str, Any] = {"truth": None, "claim": None}
    whose = "" if side.whose == GIVEN else f", of {side.whose}"
    if side.truth is not None:
        what = "the time of the hit" if side.truth["kind"] == "rays" else "the signed distance of A and B"
        proofs["truth"] = {"about": f"{what}{whose} is {{}}"} | side.truth
    if side.claim is not None:
        known = TRUTHS | TRUTHS_OF_SWEEPS if sweep else TRUTHS
        words = known.get(side.claim["symptom"], "the signed distance is proven to be {}").replace("proven to be ", "")
        proofs["claim"] = {"about": f"{words}{whose}"} | side.claim
    for proof in filter(None, proofs.values()):
        for name in "xy":
            _count_types(proof[name], case.rows)
            proof[name] = next((Name(known) for known, shape in shapes.items() if shape == proof[name]), proof[name])
        case.rows["KINDS"].add(proof["kind"])
        for claim in proof["claims"]:
            case.rows["CHECKS"].add(claim["kind"])
            if claim["kind"] == "part":
                case.rows["CLAIMS"].add(claim["claim"]["kind"])
    case.rows["TRIALS"] |= {name for name, needed in (("numbers", True), ("claim", side.claim)) if needed}
    return {"symptom": side.symptom, "margins": list(side.margins), **proofs}


def _count_types(shape: Mapping[str, Any], rows: dict[str, set[str]]) -> None:
    if shape["type"] == "Composite":
        for part in shape["parts"]:
            _count_types(part, rows)
    else:
        rows["MEANING"].add(shape["type"])


def _of_impact(engine: Engine, scene: Scene, answer: Mapping[str, object]) -> Case:
    assert scene.impact is not None
    cell, motion = scene.cell, scene.impact[None]
    used = engine.effective_motion(cell.type_a, cell.type_b, motion, (scene.a[None].pack(), scene.b[None].pack()))
    motions = [motion_data(scene.impact)]
    if not np.array_equal(used.pack(), motion.pack()):
        motions.append(motion_data(used[0]))
    allowed = float(engine.tolerance(cell.query, cell.type_a, cell.type_b).value.at(motion.speed)[0])
    case = Case(judge=JUDGE_IMPACT)
    right = said(reference_of(motion), 0)
    case.constants |= {"ANSWER": dict(answer), "RIGHT": right, "MOTIONS": motions, "MOST": allowed}
    case.constants["ALLOWED"] = f"{engine.name} is allowed an error of {allowed!r}"
    return case


def _add_first(case: Case, engine: Engine, finding: Finding) -> None:
    """The first of two answers that contradict each other."""
    assert finding.related is not None
    changing = RELATIONS[finding.related.relation].changing if finding.related.relation in RELATIONS else "a change"
    case.constants |= {"FIRST": dict(finding.answer), "CHANGE": f"after {changing}, {engine.name}"}
    if finding.verdict.certificate is None and finding.scene.impact is None:
        case.constants["AMOUNT"] = float(finding.verdict.amount)
        case.judge = JUDGE_CONTRADICTION


def _composed(engine: Engine, finding: Finding, calls: list[str], case: Case) -> str:
    """Put the parts of a script together; where numbers are packed, what needs them comes last."""
    numbers, both = Numbers(), len(calls) > 1
    names = ("ask", "ask_again")[: len(calls)]
    functions = [function_of(name, shortened(call, numbers)) for name, call in zip(names, calls, strict=True)]
    asking = (ASK_BOTH if both else ASK).format(engine=_plain(engine.name), limit=LIMIT)
    check = CHECK if "SIDES" in case.constants else CHECK_LAWS
    timed = "seconds" in case.constants.get("HELD", {})
    ask = ASK_TIMED if timed else "ask()"
    near = NEAR if OWN in dict(case.constants["NEEDED"]).values() else ""
    again = AGAIN if both else ""
    main = MAIN.format(near=near, ask=ask, again=again, check=check, asking=asking, judge=case.judge)
    imports, checker, rest = select(main, {name: frozenset(rows) for name, rows in case.rows.items()})
    data = "\n".join(f"{name} = {numbers.text(value, before=len(name) + 3)}" for name, value in case.constants.items())
    call, scene, judge = (PARTS[0], "\n\n".join(functions)), (PARTS[1], data), (PARTS[3], f"{rest}\n\n{main}")
    parts = [call, scene, (PARTS[2], checker), judge]
    if timed:
        imports = "\n".join([imports, "import time", "from importlib import import_module"])
    if numbers:
        parts = [call, (PARTS[2], checker), judge, (PARTS[4], f"{UNPACKED}\n\n{numbers.definition()}"), scene]
        imports = "\n".join([imports, "import base64", "import json", "import zlib"])
    body = "\n\n".join(f"{ruled(title)}\n\n{text.strip()}\n" for title, text in parts)
    return f"{_head(engine, finding)}\n{_ordered(imports)}\n\n{body}\n\n{END}"


def ruled(title: str) -> str:
    """A comment across the page."""
    return f"# ---- {title} ".ljust(WIDTH, "-")


def _ordered(imports: str) -> str:
    lines = {*imports.splitlines(), "import sys"}
    plain = sorted(line for line in lines if line.startswith("import"))
    return "\n".join([*plain, *sorted(lines - set(plain))])


def _head(engine: Engine, finding: Finding) -> str:
    scene = finding.scene
    cell = scene.cell
    title = f"{engine.name}, {cell.query} of {cell.type_a.__name__} (A) and {cell.type_b.__name__} (B): "
    story = textwrap.fill(_plain(finding.verdict.claim), 110, break_long_words=False, break_on_hyphens=False)
    return HEAD.format(
        title=_plain(title + finding.verdict.symptom + "."), story=story, engine=_plain(engine.name), limit=LIMIT
    )


def _plain(words: str) -> str:
    """Words that cannot end a docstring: printable, without quotes of three and backslashes."""
    shown = "".join(c if c.isprintable() else " " for c in words[:LONGEST])
    return shown.replace("\\", "/").replace('"', "'")
