"""What a script does when it is run: it checks the proofs, asks the engine, and prints its verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from oracles.repro.pieces.asking import Answer
from oracles.repro.pieces.checking import proven
from oracles.repro.pieces.exact import number, require
from oracles.repro.pieces.impacts import breaches
from oracles.repro.pieces.judging import TRIALS, Error


def proofs_of(sides: Any) -> list[Any]:
    """Check every certificate; the exact intervals join those that are stated."""
    found = []
    for side in sides:
        proofs = {name: side[name] for name in ("truth", "claim") if side[name] is not None}
        found.append(side | {name: proof | {"exact": proven(proof)} for name, proof in proofs.items()})
    return found


def print_answer(engine: str, answer: Answer, words: str, recorded: Any) -> None:
    """Show what the engine said."""
    print(f"{engine} answers{'' if answer else f' nothing: {words}'}")
    for name, value in answer.items():
        print(f"  {name} = {value!r}")
    if answer != recorded:
        print("  (not what it answered when this file was written)")


def print_proofs(sides: Any) -> None:
    """Show what the certificates prove."""
    print("proven, by the certificates in this file:")
    for proof in [side[name] for side in sides for name in ("truth", "claim") if side[name] is not None]:
        low, high = proof["interval"]
        print(" ", proof["about"].format(repr(low) if low == high else f"from {low!r} to {high!r}"))


def errors_of(answer: Answer, recorded: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of an answer on one pair of shapes.

    What was recorded is tried by the claim that it breaks. Any other answer is tried by what is proven of the shapes
    themselves, and by what else can be told exactly.
    """
    same = answer == recorded and side["claim"] is not None
    for name, trial in TRIALS.items():
        if name in ("numbers", "seconds") or (name == "claim") == same:
            yield from trial(answer, side, held)


def wrong_by(answer: Answer, recorded: Any, sides: Any, held: Any) -> tuple[str, Any] | None:
    """What is wrong with an answer on every pair of shapes, and the least amount; None if it is right on one."""
    worst: list[tuple[str, Any]] = []
    for side in sides:
        found = [(name, by) for name, by, allowed in errors_of(answer, recorded, side, held) if by > allowed]
        if not found and (side["truth"] is not None or answer == recorded):
            return None
        worst += sorted(found, key=lambda error: error[0] != side["symptom"])[:1]
    return (worst[0][0], min(by for _, by in worst)) if worst else None


def laws_of(motion: Any, right: Any, allowed: float) -> Any:
    """By how much velocities break the laws of an impact: these must keep them better than the engine has to."""
    broken = max(0, *(by for _, by in breaches(motion, right)))
    require(broken <= allowed, "the velocities said to be right break a law")
    return broken


def print_laws(motion: Any, right: Any) -> None:
    """Show velocities that keep the laws of an impact, and how well they do."""
    print("velocities that keep every law of the impact, checked exactly:")
    for name, value in right.items():
        print(f"  {name} = {value!r}")
    print(f"  broken by no more than {float(laws_of(motion, right, math.inf))!r}")


def verdict(answer: Answer, wrong: tuple[str, Any] | None, allowed: str) -> int:
    """Say whether the answer is right; gives the exit status."""
    if not answer:
        print("verdict: WRONG: there is no answer")
        return 1
    if wrong is None:
        print(f"verdict: right, as far as this file can tell ({allowed})")
        return 0
    symptom, amount = wrong
    size = f", by at least {float(amount)!r}" if amount < math.inf else ""
    print(f"verdict: WRONG: {symptom}{size} ({allowed})")
    return 1


def at_most(amount: Any) -> float:
    """Largest double that is not above an exact number."""
    found = float(amount)
    return found if found <= amount else math.nextafter(found, -math.inf)


def of_impact(answer: Answer, motions: Sequence[Any], allowed: float, symptom: str) -> tuple[str, Any] | None:
    """The law that velocities break for every one of some motions, and by how much."""
    if not answer or set(answer) != {"velocity_a", "angular_a", "velocity_b", "angular_b"}:
        return "a velocity is missing", math.inf
    worst = []
    for motion in motions:
        found = [(name, by) for name, by in breaches(motion, answer) if by > number(allowed)]
        if not found:
            return None
        worst.append((sorted(found, key=lambda law: law[0] != symptom)[0], max(by for _, by in found)))
    return worst[0][0][0], at_most(min(worst[0][0][1], *(most for _, most in worst[1:]), math.inf))
