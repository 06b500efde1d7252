"""What a run is said to lack, and what it has no need of."""

from __future__ import annotations

from oracles.closing import has_scenes, silent_cells
from oracles.outcome import Kind, Run, SupportNote
from oracles.scene import DISTANCE

SPACE, PLANE = "Sphere–Box", "Disc–Rectangle"
NATIVE, NONE = SupportNote("native", ""), SupportNote("unsupported", "not written")


def run(support: dict[str, SupportNote]) -> Run:
    found = Run(0, 1.0, "", engines=list(support))
    found.regimes = {"generic": "why"}
    found.support = {(engine, DISTANCE, SPACE): note for engine, note in support.items()}
    return found


def test_an_engine_that_supports_nothing_that_is_asked_is_no_gap_beside_one_that_does() -> None:
    found = run({"able": NATIVE, "other": NONE})
    found.counts["able", DISTANCE, SPACE, "generic", Kind.AGREES] = 1
    assert silent_cells(found) == []
    assert silent_cells(run({"other": NONE})) == ["other: no answer was compared at all"]
    assert silent_cells(run({"able": NATIVE, "other": NONE})) == [
        "able: no answer was compared at all",
        f"able: nothing compared in {DISTANCE} {SPACE} in any regime",
    ]


def test_regimes_have_scenes_in_their_own_world() -> None:
    answered = {("of_space", SPACE), ("of_the_plane", PLANE)}
    assert has_scenes("models", SPACE, answered)
    assert not has_scenes("models", PLANE, answered)
    assert has_scenes("generic", PLANE, answered)
    for owner, own, other in (("of_space", SPACE, PLANE), ("of_the_plane", PLANE, SPACE)):
        assert has_scenes(f"thresholds_of_{owner}", own, answered)
        assert not has_scenes(f"thresholds_of_{owner}", other, answered)
