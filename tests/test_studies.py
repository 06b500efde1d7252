"""The studies' page says what they measure now, and their plots are whole."""

from __future__ import annotations

import math
import re
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import reports.studies
from oracles import tunnelling
from refimpl import Point, Polyhedron, distance, load_polyhedron, support
from refimpl.construct.kinds import KINDS
from reports import scorecards as cards
from reports.studies import bounces, cradle, particles, plots, rejects, scorecards
from reports.studies.__main__ import main
from tests.solids import box

pytest.importorskip("matplotlib")
pytest.importorskip("pybullet")
pytest.importorskip("fcl")

NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]\d+)?")
HERE = Path(reports.studies.__file__).parent


def alike(old: str, new: str) -> bool:
    """Whether two numbers agree but for what rounding does on another machine."""
    x, y = float(old), float(new)
    return math.isclose(x, y, rel_tol=0.5, abs_tol=1e-13)


def test_the_page_is_fresh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main([str(tmp_path)])
    assert str(tmp_path) in capsys.readouterr().out
    old, new = ((folder / "README.md").read_text(encoding="utf-8") for folder in (HERE, tmp_path))
    again = "stale: run python -m reports.studies"
    assert NUMBER.sub("#", old) == NUMBER.sub("#", new), again
    for x, y in zip(NUMBER.findall(old), NUMBER.findall(new), strict=True):
        assert alike(x, y), f"{again}: {x} is now {y}"
    for picture in re.findall(r"\((\w+\.svg)\)", new):
        assert ElementTree.parse(tmp_path / picture).getroot().tag.endswith("svg")
        assert (HERE / picture).is_file()


def test_numbers_that_differ_are_told_apart() -> None:
    assert alike("7e-15", "2e-15")
    assert alike("0.0922", "0.08")
    assert not alike("2", "0.8")
    assert not alike("1e-04", "1e-03")


def test_the_formula_keeps_energy_and_momentum_over_a_thousand_bounces() -> None:
    course = bounces.by_formula()
    assert len(course.energy) == bounces.BOUNCES
    assert np.ptp(course.energy) < 1e-13 * course.energy[0]
    parts = np.abs(bounces.AXES @ bounces.VELOCITY)
    assert np.max(np.abs(np.array(course.momenta) - parts)) < 1e-13 * np.max(parts)


@pytest.mark.parametrize("gap", cradle.GAPS)
def test_the_cradle_passes_one_ball_on_by_the_formula(gap: float) -> None:
    course = cradle.by_formula(gap)
    energies = np.sum(course.velocities**2, axis=1) / 2
    assert np.all(energies == cradle.SPEED**2 / 2)
    assert np.all(np.sum(course.velocities != 0, axis=1) == 1)  # one ball moves at a time
    assert np.any(course.velocities[:, -1] == cradle.SPEED)


def test_more_iterations_are_better_until_the_step_bends() -> None:
    for course in particles.courses():
        floor = 2 * course.errors[-1]
        errors = [e for e in course.errors if e > floor]
        assert errors == sorted(errors, reverse=True)
        assert course.errors[-1] < 2 * course.time_step


def test_steps_tunnel_as_often_as_none_falls_into_the_overlap_and_sweeps_never() -> None:
    found = [tunnelling.Flight(*numbers) for numbers in product((1 / 60, 1 / 10), (0.01, 0.1), (3.0, 30.0))]
    for flight in found:
        assert abs(tunnelling.by_stepping(flight) - tunnelling.expected(flight)) < 1 / tunnelling.MOMENTS
        assert tunnelling.by_sweep(flight) == 0
    shares = [tunnelling.expected(flight) for flight in found]
    assert min(shares) == 0
    assert max(shares) > 0.9


def test_bullet_sweeps_only_bodies_in_maximal_coordinates() -> None:
    flight = tunnelling.Flight(1 / 60, 0.01, 30.0)
    shares = []
    for swept, maximal in ((False, False), (True, False), (True, True)):
        with tunnelling.bullet(swept, maximal) as watch:
            shares.append(watch(flight))
    assert shares[0] == shares[1] == pytest.approx(tunnelling.pushed_through(flight), abs=1 / tunnelling.MOMENTS)
    assert shares[2] == 0


def test_without_matplotlib_the_error_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(plots.StudyUnavailable, match=r"proxyproof\[studies\]"), plots.figure(tmp_path / "x.svg"):
        pass


def test_early_rejects_are_told_from_what_was_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rejects, "COUNT", 30)
    monkeypatch.setattr(rejects, "REPEATS", 1)
    plain, ball = (rejects.course("capsule", volume, broad=False) for volume in (rejects.NONE, "Sphere"))
    assert plain.asked == plain.passed == ball.asked == 30 * 29 // 2
    assert ball.hits == plain.hits < ball.passed < ball.asked / 2
    assert plain.reject == 0 < plain.miss
    assert ball._replace(reject=3.0, miss=1.0, hit=6.0).wasted == pytest.approx(0.4)
    behind = rejects.course("capsule", "AABB", broad=True)
    assert behind.passed == behind.asked < plain.asked
    assert behind.hits == plain.hits
    page = rejects.told([plain, ball, behind])
    assert f"| capsule | no | Sphere | 435 | {ball.passed} | {ball.hits} |" in page
    rejects.draw([plain, ball, behind], tmp_path / "x.svg")
    assert ElementTree.parse(tmp_path / "x.svg").getroot().tag.endswith("svg")


@pytest.mark.parametrize("collider", rejects.COLLIDERS)
def test_volumes_of_the_study_contain_their_points(collider: str) -> None:
    shape, points = rejects.COLLIDERS[collider]()
    for name, volume in rejects.volumes(shape, points).items():
        if collider != "capsule" or name != "Sphere":  # the ball is fitted to the capsule, not to the points about it
            assert np.all(distance(volume, Point(points)).distance <= 1e-8), name
    directions = np.random.default_rng(0).normal(size=(200, 3))
    assert np.all(support(shape, directions) <= np.max(points @ directions.T, axis=0) + 1e-12)


def test_the_scorecards_of_models_have_the_form_of_today() -> None:
    """Times and shares are of the day on which they were made; what is told of, and how, is of today."""
    page = (HERE / "scorecards.md").read_text(encoding="utf-8")
    again = "stale: run python -m reports.studies.scorecards"
    assert page.startswith(
        f"# Scorecards of models\n\nMade by `python -m reports.studies.scorecards`.\n\n{scorecards.TEXT}"
    )
    sections = page.split("\n## ")[1:]
    assert [section.partition("\n")[0].lower() for section in sections] == [model.name for model in scorecards.MODELS]
    for section, model in zip(sections, scorecards.MODELS, strict=True):
        assert model.text in section, again
        asked = "".join(f" --repair {name}" for name in model.repairs)
        assert f'{model.file}"{asked}\n' in section, again
        rows = [line.split(" | ") for line in section.splitlines() if line.startswith("| ")]
        assert [cell.strip("| ") for cell in rows[0]] == [column.title for column in cards.COLUMNS], again
        assert [row[0].strip("| ") for row in rows[2:]] == [kind.title for kind in KINDS.values()], again
        picture = (HERE / f"scorecard-{model.name}.png").read_bytes()
        assert picture.startswith(b"\x89PNG")
        assert 10_000 < len(picture) < 120_000


def test_models_of_the_scorecards_are_solids_after_their_repairs() -> None:
    data = Path(pytest.importorskip("pybullet_data").getDataPath())
    for model in scorecards.MODELS:
        assert len(load_polyhedron(data / model.file, repairs=model.repairs).triangles) > 300


def test_a_gallery_shows_what_could_be_built() -> None:
    cube = Polyhedron(*box())
    card = scorecards.scorecard(cube, ("model", "aabb", "sphere"), name="cube")
    page = scorecards.gallery(card)
    assert page.count('<figure class="scene"') == 2
    assert "<h3>axis-aligned box</h3>" in page
    told = scorecards.told(scorecards.MODELS[0], card)
    assert "--repair merge_near --repair fill_holes" in told
    assert "| smallest sphere" in told
