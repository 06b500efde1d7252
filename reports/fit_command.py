"""``proxyproof fit``: the proxies of a model, with a scorecard, a page, and files that other programs load."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

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
    ("faces, more than", "simplify, or hull"),
    ("crowded:", "simplify, or hull"),
    ("in too many pieces", "keep_largest, or hull"),
    ("holds points", "hull"),
)
"""What may help against each defect that a mesh is refused for."""
HINTS = (
    ("meshes are read from", "also read are robots from urdf, and points from xyz, txt, csv, npy files"),
    ("lies outside of the folder", "name the folder that holds all of the robot with --root"),
    ("is not there", "name the folder in which packages and meshes are with --root"),
    ("links with shapes", "name one of them with --link"),
    ("is a proxy already", "--shapes visual may have a mesh in its place"),
    ("the mesh has no faces", "nothing is left of it, or its hull is flat"),
)
"""What else may help."""


def fit(
    model: Annotated[
        Path,
        typer.Argument(
            parser=options.place("MODEL", "mesh file"),
            metavar="MODEL",
            help="Mesh (OBJ, OFF, PLY, STL), robot (URDF), or points for --repair hull (XYZ, TXT, CSV, NPY).",
        ),
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
    link: Annotated[str, typer.Option("--link", metavar="NAME", help="Of a URDF: the link to build proxies for.")] = "",
    shapes: Annotated[
        str,
        typer.Option(
            "--shapes",
            parser=one_of_shapes,
            metavar="SORT",
            help="Of a URDF: the link's collision or visual elements. Default: collision, if there are any.",
        ),
    ] = "",
    root: Annotated[
        Path | None,
        typer.Option(
            "--root",
            parser=options.place("--root"),
            metavar="DIR",
            help="Of a URDF: the folder that holds its meshes. Default: its package, or the folder above its own.",
        ),
    ] = None,
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
    from reports.folder import FolderError, require_writable  # noqa: PLC0415

    kinds = chosen_kinds(proxy or ())
    robot = Robot(link, shapes, root)
    name, solid = read(model, repair or (), scale, robot)
    if repair:
        name = f"{name} after {', '.join(repair)}"
    stem = "-".join([model.stem, *re.findall(r"[\w.]+", link)])
    folder = Path(f"{stem}-proxies") if out is None else out
    try:  # nothing is made before there is something to write
        require_writable(next(place for place in (folder, *folder.parents) if place.exists()))
    except FolderError as error:
        raise options.BadInput(str(error)) from None
    shown = console()
    with shown.status("building proxies") as status:
        try:
            card = scorecard(
                solid, kinds, name=name, each=lambda score: status.update(f"building proxies: {score.title} done")
            )
        except ShapeError as error:
            raise options.BadInput(f"{model}: {error}; see --scale") from None
    made = scorecards.table(card)
    shown.print(scorecards.caption(card))
    shown.print(fitted(made, shown.width))
    shown.print(facts(scorecards.MEANING))
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


class Robot(NamedTuple):
    """Which part of a URDF is meant: link, sort of its elements, and folder of its meshes; empty by default."""

    link: str = ""
    sort: str = ""
    root: Path | None = None


def one_of_shapes(said: str) -> str:
    """Parse --shapes."""
    if said not in ("", "collision", "visual"):
        raise options.BadInput(f"--shapes must be collision or visual, got {said!r}")
    return said


def read(model: Path, repairs: list[str] | tuple[str, ...], scale: float, robot: Robot) -> tuple[str, Polyhedron]:
    """Name and solid of a file, after the repairs asked for; bad input says what is wrong, and the way out."""
    from oracles.links import solid_of_link  # noqa: PLC0415
    from oracles.meshfiles import ModelError  # noqa: PLC0415
    from refimpl.loading import LoadError, load_polyhedron  # noqa: PLC0415
    from refimpl.repairs import REPAIRS  # noqa: PLC0415

    names = [name.strip().casefold().replace("-", "_") for name in repairs]
    for given, name in zip(repairs, names, strict=True):
        if name not in REPAIRS:
            raise options.BadInput(f"--repair {given!r} is no repair; there are {', '.join(REPAIRS)}")
    of_robot = model.suffix.lower() == ".urdf"
    if any(robot) and not of_robot:
        raise options.BadInput(f"--link, --shapes and --root are for URDF files, and {model} is none")
    try:
        if not of_robot:
            return model.name, load_polyhedron(model, scale=scale, repairs=names)
        link, solid = solid_of_link(model, robot.link, sort=robot.sort, root=robot.root, repairs=names, scale=scale)
    except (LoadError, ModelError) as error:
        said = str(error) if isinstance(error, LoadError) else f"{model} {error}"
        raise options.BadInput(said + _way_out(said)) from None
    return f"{model.name}, link {link}", solid


def _way_out(said: str) -> str:
    """What may help against what is said, if anything is known to."""
    ways = [f"; --repair may help: {way}" for sign, way in WAYS_OUT if sign in said]
    return next(iter([*ways, *(f"; {way}" for sign, way in HINTS if sign in said)]), "")


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
