"""The table of engines that are wrong on purpose: found or not, when, in which buckets, by which witness."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import partial

from oracles.clumsiness import odd_numbers
from oracles.executors import Crew
from oracles.outcome import FINDINGS
from oracles.planted.hunting import MOST_ODD, Hunted, hunted, questioned
from oracles.planted.mutant import Mutant
from oracles.planted.mutants import MUTANTS
from oracles.scene import Scene
from reports.text import visible

HEADINGS = ("mutant", "cell", "found after", "buckets", "numbers", "what the hunter says", "witness")
WIDTHS = (28, 28, 11, 7, 7, 44, 0)
LONGEST_WITNESS = 400


def names() -> list[str]:
    """Names of all wrong engines."""
    return list(MUTANTS)


def chosen(names: Sequence[str]) -> list[Mutant]:
    """Wrong engines of these names, or all.

    Raises
    ------
    KeyError
        With the first name that there is not.
    """
    return [MUTANTS[name] for name in names] if names else list(MUTANTS.values())


def hunts(mutants: Sequence[Mutant], *, budget: float, settle: float, seed: int, jobs: int) -> Iterator[Hunted]:
    """Hunt for each of them, some at a time, and tell in their order."""
    hunt = partial(_hunted, budget=budget, settle=settle, seed=seed)
    wanted = [mutant.name for mutant in mutants]
    if jobs == 1:
        yield from map(hunt, wanted)
        return
    with Crew(jobs) as crew:  # its processes end with this one, however that ends
        yield from crew.map(hunt, wanted)


def _hunted(name: str, *, budget: float, settle: float, seed: int) -> Hunted:
    """Hunt for one, by its name, in any process."""
    return hunted(MUTANTS[name], budget=budget, settle=settle, seed=seed)


def show(mutants: Sequence[Mutant], *, budget: float, settle: float, seed: int, jobs: int, markdown: bool) -> int:
    """Print the table line by line, and return 1 when anything is not as it should be, else 0."""
    print(*heading(markdown=markdown), sep="\n", flush=True)
    done = []
    for found in hunts(mutants, budget=budget, settle=settle, seed=seed, jobs=jobs):
        print(line(found, markdown=markdown), flush=True)
        done.append(found)
    print("", *summary(done), sep="\n")
    return int(any(found.faults for found in done))


def show_right(scenes: int, seed: int) -> int:
    """Question the engine that is right, and print what is found: 0 when that is nothing, else 1."""
    begin = time.monotonic()
    run = questioned(scenes=scenes, seed=seed)
    for bucket in run.buckets:
        print(bucket.key, bucket.witness.verdict.claim, sep="\n")
    wrong, total, spent = run.total(kinds=FINDINGS), run.hunters.total(), time.monotonic() - begin
    print(f"{wrong} findings in {total} scenes of {len(run.support)} cells, by bulk and Hypothesis, in {spent:.0f} s")
    return int(wrong > 0 or total < scenes)


def heading(*, markdown: bool) -> list[str]:
    """First lines of the table."""
    if markdown:
        return [_row(HEADINGS, markdown=True), "| " + " | ".join("---" for _ in HEADINGS) + " |"]
    return [_row(HEADINGS, markdown=False)]


def line(found: Hunted, *, markdown: bool) -> str:
    """One line of the table."""
    mutant = found.mutant
    when = "never" if found.seconds is None else f"{found.seconds:.1f} s"
    symptoms = "; ".join(dict.fromkeys(bucket.symptom for bucket in found.buckets))
    problems = [] if found.found else [visible(problem, limit=LONGEST_WITNESS) for problem in found.problems]
    said = "; ".join([*(f"FAULT: {fault}" for fault in (*found.faults, *problems)), symptoms])
    shapes = "; ".join(visible(_scene(scene), limit=LONGEST_WITNESS) for scene in found.witnesses[:1])
    odd = ", ".join(str(odd_numbers(scene)) for scene in found.witnesses)
    cells = (mutant.name, f"{mutant.query} {mutant.pair}", when, str(len(found.buckets)), odd, said, shapes)
    return _row(cells, markdown=markdown)


def _scene(scene: Scene) -> str:
    moving = "" if scene.motion is None else f", moving: {scene.motion.to_json()}"
    return f"{scene.a} against {scene.b}{moving}"


def _row(cells: Sequence[str], *, markdown: bool) -> str:
    if markdown:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    return "  ".join(cell.ljust(width) for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()


def summary(all_found: Sequence[Hunted]) -> list[str]:
    """Last lines: how many were found, named and gathered as they should be, and how small the witnesses are."""
    total = len(all_found)
    late = max((found.seconds for found in all_found if found.seconds is not None), default=0.0)
    small, witnesses = (sum(many) for many in zip(*((f.small, len(f.witnesses)) for f in all_found), strict=True))
    return [
        f"{sum(f.found for f in all_found)} of {total} found, the last after {late:.1f} s",
        f"{sum(f.named for f in all_found)} of {total} named rightly: cell and symptom",
        f"{sum(f.found and f.gathered for f in all_found)} of {total} in at most two buckets",
        f"{small} of {witnesses} witnesses with at most {MOST_ODD} numbers that are not 0, 1, -1, 0.5 or 2",
    ]
