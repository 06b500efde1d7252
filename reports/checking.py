"""``proxyproof check``: what a file's certificates prove, by exact arithmetic; the file may be anybody's.

It reads a report (its folder or `report.json`), a finding alone (an object of `buckets`, or a witness of the ledger),
or any object of JSON with a ``scene`` and a ``certificate``. Nothing of it is executed, and nothing is believed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports import options, text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rich.console import Console

    from oracles.outcome import Verdict
    from oracles.scene import Scene
    from reports.proofs import Proof

HOLD, DO_NOT = 0, 1
MOST_TOLD = 20
"""Refused certificates of a report that are named."""


@dataclass(frozen=True)
class Checked:
    """What has become of one finding: what its certificate proves, or why it does not."""

    name: str
    scene: Scene | None = None
    proof: Proof | None = None
    fault: str = ""
    claim: str = ""
    """What the file says about it."""


def check(
    file: Annotated[
        Path,
        typer.Argument(
            parser=options.place("FILE", "file"), metavar="FILE", help="A report or its folder, or a finding as JSON."
        ),
    ],
) -> int:
    """Say what the certificates in a file prove.

    They are checked in exact arithmetic; nothing in the file is believed or executed.

    Exit status: 0 when all hold and there is one, 1 when one does not prove what the file says, 2 when the file cannot
    be read.
    """
    from reports.console import console  # noqa: PLC0415
    from reports.reading import read_json, read_report, report_file  # noqa: PLC0415

    with options.reading():
        path = report_file(file)
        data = read_json(path)
        if "buckets" in data:
            return _tell_all(read_report(path)["buckets"], console())
        return _tell_one(checked(_finding(data, path)), console())


def _finding(data: dict[str, Any], path: Path) -> dict[str, Any]:
    """The object that has a scene and a certificate: a finding, a bucket, or what a witness of the ledger holds."""
    from reports.reading import NoReport  # noqa: PLC0415

    inner = data.get("finding", data)
    if not isinstance(inner, dict) or not inner.keys() >= {"scene", "certificate"}:
        raise NoReport(f"{path} has no scene with a certificate, and is no report")
    return inner


def checked(data: dict[str, Any]) -> Checked:
    """Check one finding's certificate against its scene, and against the bounds that the finding claims."""
    from oracles.outcome import Kind, Verdict  # noqa: PLC0415
    from oracles.records import certificate_from_json, unproven  # noqa: PLC0415
    from oracles.scene import Scene  # noqa: PLC0415
    from reports.reading import DAMAGE, in_words, name_of  # noqa: PLC0415

    name = text.visible(name_of(data))
    try:
        scene = Scene.from_json(data["scene"])
        about = data.get("proof_scene")
        shown = scene if about is None else Scene.from_json(about)
        if data["certificate"] is None:
            wrong = data.get("kind") == Kind.WRONG and math.isfinite(float(data.get("amount", 0)))
            return Checked(name, scene, fault="no certificate proves it wrong" if wrong else "")
        certificate = certificate_from_json(data["certificate"], shown)
        lower, upper = (float(data.get(bound, end)) for bound, end in (("lower", -math.inf), ("upper", math.inf)))
        verdict = Verdict(
            Kind.WRONG,
            str(data.get("symptom", "")),
            lower=-math.inf if math.isnan(lower) else lower,
            upper=math.inf if math.isnan(upper) else upper,
            certificate=certificate,
            proof_scene=shown,
        )
        fault = unproven(verdict, scene)
        proof = None if fault else _proven(verdict, shown)
        return Checked(name, shown, proof, fault, str(data.get("claim", "")))
    except DAMAGE as error:
        return Checked(name, fault=f"it is damaged: {in_words(error)}")


def _proven(verdict: Verdict, scene: Scene) -> Proof:
    """What the certificate proves, in words; its own bounds, where they are tighter than those of the finding."""
    from oracles.records import proven_interval  # noqa: PLC0415
    from oracles.world import is_flat  # noqa: PLC0415
    from refimpl.proof.certify import round_down, round_up  # noqa: PLC0415
    from reports.findings import interval  # noqa: PLC0415
    from reports.proofs import proof_view  # noqa: PLC0415

    assert verdict.certificate is not None
    lower, upper = proven_interval(verdict.certificate, scene, verdict.symptom)
    said = interval(scene, round_down(lower), round_up(upper))
    return proof_view(verdict.certificate, said, flat=is_flat(scene.b))


def _tell_one(found: Checked, shown: Console) -> int:
    from rich.text import Text  # noqa: PLC0415

    from reports.console import facts, lines, section  # noqa: PLC0415
    from reports.findings import proxies  # noqa: PLC0415

    if found.scene is not None:
        section(shown, "The two that the certificate is about", facts(proxies(found.scene)))
    if found.proof is None:
        shown.print(Text.assemble("\n", ("not proven", "bold red"), f": {found.fault or 'there is no certificate'}"))
        return DO_NOT
    if found.claim:
        section(shown, "What the file says", Text(text.visible(found.claim, limit=1000)))
    section(shown, "What its certificate claims, and was checked in exact arithmetic", lines(found.proof.claims))
    shown.print(Text.assemble("\n", ("proven", "bold green"), f": {found.proof.interval}"))
    return HOLD


def _tell_all(buckets: Iterable[dict[str, Any]], shown: Console) -> int:
    from rich.text import Text  # noqa: PLC0415

    every = [checked(item) for item in buckets]
    refused = [found for found in every if found.fault]
    proven = sum(found.proof is not None for found in every)
    for found in refused[:MOST_TOLD]:
        shown.print(Text.assemble(("not proven", "red"), f": {found.name}: {found.fault}"))
    if len(refused) > MOST_TOLD:
        shown.print(f"and {text.count(len(refused) - MOST_TOLD)} more")
    without = len(every) - proven - len(refused)
    told = [f"{text.plural(len(every), 'finding')}: {text.plural(proven, 'certificate')} proven in exact arithmetic"]
    told += [f"{text.count(without)} without, as no answer came"] * bool(without)
    told += [f"{text.count(len(refused))} not proven"] * bool(refused)
    shown.print(Text("; ".join(told), "bold"))
    return DO_NOT if refused or not proven else HOLD
