"""Make the studies again: ``python -m reports.studies [FOLDER]`` writes README.md and its plots there."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

from rich.progress import track

from oracles.engine import EngineUnavailable
from reports.studies import bounces, cradle, defaults, particles, tunnelling
from reports.studies.plots import StudyUnavailable

HERE = Path(__file__).parent

TEXTS: dict[ModuleType, tuple[str, str]] = {
    particles: (
        "Particles instead of a rigid body",
        "A body of particles with distance constraints (`refimpl.impacts.constraints`) drops a corner on a plane, "
        "without friction and with e = 0.5. Nothing in the solver knows of rotations; what turns the body are the "
        "repaired distances. The angular velocity after one time step comes to that of the rigid formula by a factor "
        "an iteration, until only the bend of the step is left, which is in proportion to the time step. A cube "
        "takes longer than a tetrahedron, for its repairs undo each other; a beam longer still.",
    ),
    defaults: (
        "A bounce by PyBullet's defaults",
        "With other settings PyBullet bounces a ball by the formula, to 1e-13; this is how it bounces one as it comes. "
        "Approaches below 0.2 do not bounce, velocities are clamped at 100, and a plane that is reached late in a time "
        "step takes the bounce away. Lines are medians over the moments within a step, bands all of them, dots the "
        "formula.",
    ),
    bounces: (
        "A thousand bounces in a box",
        "A ball with e = 1 between six walls, without gravity. By the formula each bounce turns one part of the "
        "momentum round; what a thousand bounces add up is rounding. PyBullet does so too, once its friction, damping, "
        "thresholds and penetration repair are off; with its defaults the ball stops.",
    ),
    cradle: (
        "Newton's cradle",
        "Five equal balls in a row between two walls, e = 1; the first is thrown at the others. Impact after impact, "
        "pair by pair, as in the lecture, the last ball leaves alone, whether the balls touch or not. PyBullet solves "
        "all contacts of a time step together: when the balls touch, the first one bounces back and the other four "
        "go on as one. Both keep momentum and energy: the impact of several bodies at once has no single answer "
        "without a model of what happens within it (a convention, not an error). With PyBullet's defaults and small "
        "gaps the balls first gain energy, for its repair of penetration pushes them apart, and then lose all of it.",
    ),
    tunnelling: (
        "Through the wall",
        "A ball flies at a thin wall. Static detection looks at the end of each time step and sees nothing in "
        "between: with x the way of a step over the way on which ball and wall overlap (thickness and diameter), a "
        "share 1 − 1/x of all arrivals tunnels once x > 1. Dynamic detection, `refimpl.sweep`, sees every one. "
        "PyBullet by default, but without its damping, lets 1 − 1/(2x) through, from x = 1/2 on: a ball that it first "
        "sees with its centre past the middle of the wall is pushed out behind it. `ccdSweptSphereRadius` changes "
        "nothing of that, to the last number, unless the ball is created with `useMaximalCoordinates`; then nothing "
        "tunnels. FCL's `continuousCollide`, asked for each step: the naive solver looks at 10 times, 9 ways apart, "
        "and tunnels from x = 9 on, by design; conservative advancement does not, but for `CCDM_SCREW`, which moves a "
        "body that does not turn by the square of its way: shorter steps are not gone to the end, longer ones too far "
        "(a wrong time, which this table does not show). `CCDM_LINEAR` is left out, for its answers differ from "
        "process to process.",
    ),
}


def page(folder: Path) -> str:
    """Run every study, write its plot, and give the page that shows them."""
    parts = ["# Studies\n", "Made by `python -m reports.studies`.\n"]
    for study, (title, text) in track(TEXTS.items(), description="studies", transient=True):
        name = study.__name__.rpartition(".")[2]
        found = study.courses()
        study.draw(found, folder / f"{name}.svg")
        parts.append(f"## {title}\n\n{text}\n\n![{title}]({name}.svg)\n\n{study.told(found)}\n")
    return "\n".join(parts)


def main(arguments: list[str]) -> None:
    """Write the page and its plots."""
    folder = Path(arguments[0]) if arguments else HERE
    folder.mkdir(parents=True, exist_ok=True)
    try:
        text = page(folder)
    except (StudyUnavailable, EngineUnavailable) as error:
        sys.exit(str(error))
    (folder / "README.md").write_text(text, encoding="utf-8")
    print(folder / "README.md")


if __name__ == "__main__":
    main(sys.argv[1:])
