"""Many impacts in a row: the reference keeps energy and momentum, and what is told and drawn is what was measured."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from oracles import longruns
from oracles.longruns import Cradle, Series, ball_in_box, ball_in_box_of_bullet, cradle, cradle_of_bullet
from reports import cli
from reports import longruns as told

BOXES = [
    Series("refimpl", np.ones(1000)),
    Series("PyBullet by default", np.array([0.75, 0.5, 0.0])),
    Series("PyBullet without damping", np.linspace(1.0, 0.5, 12)),
]
CRADLES = [cradle(), Cradle("PyBullet by default", np.array([-0.5, 0.25, 0.25, 0.5, 0.5]))]


def test_the_reference_keeps_the_energy_of_a_ball_in_a_box() -> None:
    found = ball_in_box(300)
    assert len(found.energy) == 300
    assert np.abs(found.energy - 1).max() < 1e-13


def test_the_last_ball_of_a_cradle_leaves_as_the_first_came() -> None:
    found = cradle()
    np.testing.assert_array_equal(found.velocities, [0, 0, 0, 0, 1])
    assert (found.momentum, found.energy) == (1.0, 1.0)


def test_by_default_pybullet_loses_the_energy_within_some_bounces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(longruns, "MOST_STEPS", 4000)
    damped, free = (ball_in_box_of_bullet(30, damped=damped) for damped in (True, False))
    assert (len(damped.energy) < 30, damped.energy[-1] < 0.1) == (True, True)
    assert 0.9 > free.energy[9] > damped.energy[9]
    assert (np.diff(damped.energy) < 0.01).all()


def test_a_cradle_of_pybullet_keeps_its_momentum_but_not_the_formula() -> None:
    free = cradle_of_bullet(damped=False)
    assert free.momentum == pytest.approx(1.0, abs=1e-9)
    assert free.velocities[0] < -0.5
    assert free.velocities[4] < 0.5


def test_the_tables_say_what_was_measured() -> None:
    lines = told.as_markdown(BOXES, CRADLES).splitlines()
    rows = {line.split("|")[1].strip(): [c.strip() for c in line.split("|")[2:-1]] for line in lines if "|" in line}
    assert rows["energy after bounces"] == [str(mark) for mark in told.MARKS]
    assert rows["PyBullet without damping"] == ["1", "0.909", "0.591", "–", "–", "–", "–"]
    first = [line for line in lines if line.startswith("| PyBullet by default")]
    assert [c.strip() for c in first[0].split("|")[2:-1]] == ["0.75", "0", "–", "–", "–", "–", "–"]
    assert [c.strip() for c in first[1].split("|")[2:-1]] == ["−0.5", "0.25", "0.25", "0.5", "0.5", "1", "0.875"]


def test_the_drawing_is_one_curve_for_each() -> None:
    root = ElementTree.fromstring(told.as_svg(BOXES))
    space = "{http://www.w3.org/2000/svg}"
    curves = [line for line in root.iter(f"{space}polyline") if line.get("stroke-width") == "2"]
    assert len(curves) == 2 * len(BOXES)  # each with a sample of it beside its name
    said = [element.text for element in root.iter(f"{space}text")]
    assert all(box.name in said for box in BOXES)
    last = [float(y.split(",")[1]) for y in curves[2].get("points", "").split()]
    assert last == pytest.approx([104.0, 160.0, 272.0])


def test_the_command_prints_and_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(told, "measured", lambda: (BOXES, CRADLES))
    assert cli.main(["longruns", "--plot", str(tmp_path / "plot.svg")]) == 0
    assert (tmp_path / "plot.svg").read_text("utf-8") == told.as_svg(BOXES)
    assert capsys.readouterr().out == told.as_markdown(BOXES, CRADLES)
    assert cli.main(["longruns", "--plot", str(tmp_path)]) == cli.BAD_INPUT
    assert "--plot" in capsys.readouterr().err
