"""``proxyproof fit``: the proxies of a model, with a scorecard, a page, and files that other programs load."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports import options, text

if TYPE_CHECKING:
    from refimpl.construct.scorecard import Scorecard
    from refimpl.shapes import Polyhedron

FINISHED = 0
PROXIES = "proxies.json"

WAYS_OUT = (
    ("open:", "merge_near, then fill_holes"),
    ("flipped:", "turn_outwards"),
    ("has no area", "drop_degenerate"),
    ("twice the same face", "drop_duplicates"),
    ("self-intersecting", "drop_crossing and fill_holes, perhaps twice; or keep_largest"),
    ("nested:", "keep_largest"),
    ("not a surface", "merge_near, drop_duplicates, or drop_crossing and fill_holes"),
)
"""What may help against each defect that a mesh is refused for."""


def fit(
    model: Annotated[
        Path,
        typer.Argument(parser=options.place("MODEL", "mesh file"), metavar="MODEL", help="OBJ, OFF, PLY or STL file."),
    ],
    proxy: Annotated[
        list[str] | None,
        typer.Option("--proxy", metavar="KIND", help="Build only this kind; may be given again. Default: all kinds."),
    ] = None,
    repair: Annotated[
        list[str] | None,
        typer.Option(
            "--repair", metavar="NAME", help="Repair the mesh first; may be given again, and is done in that order."
        ),
    ] = None,
    scale: Annotated[
        float, typer.Option(parser=options.positive("--scale"), metavar="FACTOR", help="From the file's unit to yours.")
    ] = 1.0,
    mass: Annotated[
        float, typer.Option(parser=options.positive("--mass"), metavar="MASS", help="Of the body in the URDFs.")
    ] = 1.0,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", parser=options.place("--out"), metavar="DIR", help="Folder of the results. Default: MODEL-proxies."
        ),
    ] = None,
) -> int:
    """Build proxies for a model, and score them: time, storage, tightness, transformations, tests.

    Prints the scorecard; writes a page with the model and its proxies, all proxies as JSON, and each as a URDF of
    collision elements.
    """
    from refimpl.construct.scorecard import scorecard  # noqa: PLC0415
    from refimpl.proxy import ShapeError  # noqa: PLC0415
    from reports import scorecards  # noqa: PLC0415
    from reports.console import console, facts, fitted  # noqa: PLC0415

    kinds = chosen_kinds(proxy or ())
    solid = read(model, repair or (), scale)
    shown = console()
    with shown.status("building proxies") as status:
        try:
            card = scorecard(
                solid, kinds, name=model.name, each=lambda score: status.update(f"building proxies: {score.title} done")
            )
        except ShapeError as error:
            raise options.BadInput(f"{model}: {error}; see --scale") from None
    made = scorecards.table(card)
    shown.print(scorecards.caption(card))
    shown.print(fitted(made, shown.width))
    shown.print(facts(scorecards.MEANING))
    folder = Path(f"{model.stem}-proxies") if out is None else out
    save(card, folder, mass)
    shown.print(f"\n{text.visible(folder / 'index.html', limit=1000)}", soft_wrap=True)
    return FINISHED


def chosen_kinds(wanted: list[str] | tuple[str, ...]) -> list[str]:
    """Kinds of proxies: the model itself for comparison, and those asked for or all."""
    from refimpl.construct.kinds import KINDS, MODEL  # noqa: PLC0415

    names = [name.strip().casefold().replace("-", "_") for name in wanted]
    for given, name in zip(wanted, names, strict=True):
        if name not in KINDS:
            known = ", ".join(kind for kind in KINDS if kind != MODEL)
            raise options.BadInput(f"--proxy {given!r} is no kind of proxy; there are {known}")
    return list(dict.fromkeys([MODEL, *(names or KINDS)]))


def read(model: Path, repairs: list[str] | tuple[str, ...], scale: float) -> Polyhedron:
    """The solid of a mesh file, after the repairs asked for; bad input says what is wrong, and the way out."""
    from refimpl.loading import LoadError, load_polyhedron  # noqa: PLC0415
    from refimpl.repairs import REPAIRS  # noqa: PLC0415

    names = [name.strip().casefold().replace("-", "_") for name in repairs]
    for given, name in zip(repairs, names, strict=True):
        if name not in REPAIRS:
            raise options.BadInput(f"--repair {given!r} is no repair; there are {', '.join(REPAIRS)}")
    try:
        return load_polyhedron(model, scale=scale, repairs=names)
    except LoadError as error:
        said = str(error)
        way = next((f"; --repair may help: {way}" for sign, way in WAYS_OUT if sign in said), "")
        raise options.BadInput(f"{said}{way}") from None


def save(card: Scorecard, folder: Path, mass: float) -> None:
    """Write the page, the proxies as JSON, and a URDF of each that can stand in one."""
    from oracles.exporting import proxies_to_json, urdf  # noqa: PLC0415
    from refimpl.mass import mass_properties  # noqa: PLC0415
    from reports.folder import FolderError, write_files  # noqa: PLC0415
    from reports.scorecards import page  # noqa: PLC0415

    matter = mass_properties(card.model)
    robots = {kind: urdf(made, kind, matter=matter, mass=mass) for kind, made in card.proxies.items()}
    files = {kind: tuple(robot.files)[:1] for kind, robot in robots.items()}
    notes = {kind: tuple(robot.notes) for kind, robot in robots.items()}
    contents: dict[str, str | bytes] = {PROXIES: proxies_to_json(text.visible(card.name), card.proxies)}
    for robot in robots.values():
        contents |= robot.files
    try:
        write_files(folder, contents | {"index.html": page(card, files, notes)}, PROXIES)
    except FolderError as error:
        raise options.BadInput(str(error)) from None
