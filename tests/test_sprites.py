"""Sprites: held against plain arrays of booleans on one canvas, and against pygame's masks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from oracles.surveys.sprites_engines import pygame_mask as from_image
from refimpl.flat import bitmask, scanning
from refimpl.flat.sprites import (
    FARTHEST,
    Sprite,
    collide,
    common_pixel,
    gradient,
    intersect,
    overlap_area,
    overlap_areas,
)
from refimpl.kernels import masks as kernels
from refimpl.shapes import ShapeError

pygame = pytest.importorskip("pygame")


@pytest.fixture(params=["numpy", "compiled"])
def how(request: pytest.FixtureRequest) -> Iterator[str]:
    """Both ways of scanning, whichever was used before."""
    before = [getattr(scanning.COMPILED, name) for name in scanning.Compiled.__slots__]
    scanning.COMPILED.forget()
    if request.param == "compiled":
        pytest.importorskip("numba")
        assert scanning.compile_scans()
    yield request.param
    for name, kernel in zip(scanning.Compiled.__slots__, before, strict=True):
        setattr(scanning.COMPILED, name, kernel)


SIDES = st.sampled_from([1, 2, 7, 8, 9, 63, 64, 65, 130])
"""Around the sides of tiles and words."""


@st.composite
def masks(draw: st.DrawFn) -> np.ndarray[Any, Any]:
    """Noise of any density, with full and empty rows and columns; most of it is no larger than a word."""
    shape = draw(SIDES), draw(SIDES)
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    mask = rng.uniform(size=shape) < draw(st.sampled_from([0.0, 0.001, 0.02, 0.5, 0.98, 1.0]))
    for axis in (0, 1):
        line = draw(st.integers(0, shape[axis] - 1))
        value = draw(st.sampled_from([None, False, True]))
        if value is not None:
            mask[(slice(None),) * axis + (line,)] = value
    return mask


def on_canvas(a: Sprite, b: Sprite) -> tuple[np.ndarray[Any, Any], tuple[int, int]]:
    """Both on one large canvas: where both are solid, and the canvas's first pixel."""
    corners = np.array([a.position, b.position])
    ends = corners + np.array([a.shape[::-1], b.shape[::-1]])
    first, last = corners.min(axis=0), ends.max(axis=0)
    both = np.ones(tuple((last - first)[::-1]), dtype=bool)
    for sprite, (x, y) in zip((a, b), (corners - first).tolist(), strict=True):
        canvas = np.zeros_like(both)
        canvas[y : y + sprite.shape[0], x : x + sprite.shape[1]] = sprite.mask
        both &= canvas
    return both, (int(first[0]), int(first[1]))


def pygame_mask(mask: np.ndarray[Any, Any]) -> Any:
    """The same for pygame, pixel by pixel."""
    made = pygame.mask.Mask(mask.shape[::-1])
    for y, x in np.argwhere(mask).tolist():
        made.set_at((x, y))
    return made


def assert_as_on_canvas(a: Sprite, b: Sprite) -> None:
    both, (x, y) = on_canvas(a, b)
    places = np.argwhere(both)
    assert overlap_area(a, b) == len(places)
    assert intersect(a, b) == (len(places) > 0)
    first = (int(places[0, 1]) + x, int(places[0, 0]) + y) if len(places) else None
    assert common_pixel(a, b) == first
    if first is not None:
        assert first in a
        assert first in b


SHARED = settings(max_examples=75, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
"""A fixture that tells how things are scanned is not changed by what is scanned."""


@SHARED
@given(masks(), masks(), st.tuples(st.integers(-140, 140), st.integers(-140, 140)), st.integers(-9, 9))
def test_sprites_are_as_on_one_canvas_and_as_pygame_has_them(
    how: str, a: np.ndarray[Any, Any], b: np.ndarray[Any, Any], offset: tuple[int, int], shift: int
) -> None:
    first, second = Sprite(a, (shift, 2 * shift)), Sprite(b, (shift + offset[0], 2 * shift + offset[1]))
    assert_as_on_canvas(first, second)
    assert_as_on_canvas(second, first)
    theirs, other = pygame_mask(a), pygame_mask(b)
    assert np.array_equal([made.count() for made in (theirs, other)], [a.sum(), b.sum()])
    assert theirs.overlap_area(from_image(a), (0, 0)) == a.sum()  # the survey's masks are the same
    assert overlap_area(first, second) == theirs.overlap_area(other, offset)
    pixel = theirs.overlap(other, offset)
    assert intersect(first, second) == (pixel is not None)
    if pixel is not None:
        place = pixel[0] + shift, pixel[1] + 2 * shift
        assert place in first
        assert place in second


@settings(SHARED, max_examples=30)
@given(masks(), masks(), st.tuples(st.integers(-70, 70), st.integers(-70, 70)))
def test_the_normal_is_where_the_area_falls(
    how: str, a: np.ndarray[Any, Any], b: np.ndarray[Any, Any], offset: tuple[int, int]
) -> None:
    first, second = Sprite(a), Sprite(b, offset)
    found = collide(first, second)
    areas = {
        move: int(np.count_nonzero(on_canvas(first, second.translated(move))[0]))
        for move in ((1, 0), (-1, 0), (0, 1), (0, -1))
    }
    slope = areas[1, 0] - areas[-1, 0], areas[0, 1] - areas[0, -1]
    assert gradient(first, second) == slope
    if not found.hit:
        assert (found.area, found.pixel, found.normal.tolist()) == (0, None, [0.0, 0.0])
        return
    assert np.hypot(*found.normal) == pytest.approx(1.0, abs=1e-15)
    if any(slope):
        assert found.normal @ slope == pytest.approx(-np.hypot(*slope))
    else:
        assert sorted(np.abs(found.normal)) == [0.0, 1.0]


def test_the_normal_pushes_discs_apart() -> None:
    y, x = np.mgrid[:81, :81]
    disc = (x - 40) ** 2 + (y - 40) ** 2 <= 40**2
    for offset in ((30, 0), (0, -30), (20, 20), (-35, 14)):
        normal = collide(Sprite(disc), Sprite(disc, offset)).normal
        assert normal @ offset / np.hypot(*offset) > 0.995  # a raster's edge is no circle's


def test_in_the_middle_of_a_block_the_nearest_way_out_is_the_normal() -> None:
    block = Sprite(np.ones((20, 30), dtype=bool))
    for corner, way in (((3, 9), [-1, 0]), ((23, 9), [1, 0]), ((13, 2), [0, -1]), ((13, 15), [0, 1])):
        assert collide(block, Sprite(np.ones((2, 2), dtype=bool), corner)).normal.tolist() == way


@pytest.mark.usefixtures("how")
def test_what_is_empty_meets_nothing_and_edges_do_not_touch() -> None:
    full = Sprite(np.ones((64, 64), dtype=bool))
    for empty in (Sprite([]), Sprite(np.zeros((0, 5), dtype=bool)), Sprite(np.zeros((9, 9), dtype=bool), (3, 3))):
        for pair in ((full, empty), (empty, full), (empty, empty)):
            assert not intersect(*pair)
            assert (overlap_area(*pair), common_pixel(*pair), gradient(*pair)) == (0, None, (0, 0))
        assert (empty.area, empty.box) == (0, None)
    assert not intersect(full, full.moved_to((64, 0)))
    assert overlap_area(full, full.moved_to((63, -63))) == 1
    assert common_pixel(full, full.moved_to((63, -63))) == (63, 0)


@pytest.mark.usefixtures("how")
def test_huge_positions_are_exact() -> None:
    full = Sprite(np.ones((64, 64), dtype=bool))
    for far in (FARTHEST, -FARTHEST):
        there = full.moved_to((far, far))
        assert not intersect(full, there)
        assert overlap_area(there, full.moved_to((far, far))) == 64 * 64
        assert collide(there, there).pixel == (far, far)
        assert overlap_area(there, full.moved_to((far - np.sign(far) * 63, far))) == 64
    with pytest.raises(ShapeError, match=r"2\*\*62"):
        full.moved_to((FARTHEST + 1, 0))


@pytest.mark.parametrize("mask", [[[1, 0]], [True], [[[True]]], [[True], [True, False]], [[0.5]], ["x"]])
def test_what_is_no_mask_is_refused(mask: Any) -> None:
    with pytest.raises(ShapeError, match=r"Sprite\.mask"):
        Sprite(mask)


@pytest.mark.parametrize("position", [(0.5, 0), (1,), (1, 2, 3), None, (True, "x"), (float("nan"), 0)])
def test_what_is_no_position_is_refused(position: Any) -> None:
    with pytest.raises(ShapeError, match=r"Sprite\.position"):
        Sprite([[True]], position)
    with pytest.raises(ShapeError, match=r"Sprite\.pixel"):
        assert position in Sprite([[True]])


def test_a_mask_is_its_own_copy() -> None:
    given_mask = np.ones((3, 3), dtype=bool)
    sprite = Sprite(given_mask)
    given_mask[:] = False
    assert sprite.area == 9
    assert np.array_equal(sprite.mask, np.ones((3, 3)))
    with pytest.raises(ValueError, match="read-only"):
        sprite._bits.solid[0, 0] = False


def test_large_masks_keep_few_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bitmask, "KEEPING", 10)
    rng = np.random.default_rng(0)
    a, b = (Sprite(rng.uniform(size=(40, 140)) < 0.1) for _ in range(2))
    for x in range(70):
        assert_as_on_canvas(a, b.moved_to((x, 1)))
    assert len(b._bits._strips) <= 2


@settings(max_examples=40, deadline=None)
@given(masks(), masks(), st.tuples(st.integers(-130, 130), st.integers(-130, 130)))
def test_kernels_say_the_same_by_python(
    a: np.ndarray[Any, Any], b: np.ndarray[Any, Any], offset: tuple[int, int]
) -> None:
    first, second = Sprite(a), Sprite(b, offset)
    one, two = ((placed[0].tolist(), *placed[1:]) for placed in (first._placed, second._placed))
    both, (x, y) = on_canvas(first, second)
    found = np.argwhere(both).tolist()
    pixel = (found[0][1] + x, found[0][0] + y) if found else None
    assert kernels.first_pixel(one, two) == pixel
    assert kernels.meet(one, two) == (pixel is not None)
    assert kernels.area(one, two) == len(found)


def test_where_few_of_many_tiles_meet_each_step_of_the_search_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tiles that tell, tiles that are looked at, rows, and words: how often each decides."""
    scans = []
    monkeypatch.setattr(scanning, "_scanned", lambda *pair, scan=scanning._scanned: scans.append(pair) or scan(*pair))
    monkeypatch.setattr(scanning.COMPILED, "meet", None)
    monkeypatch.setattr(scanning.COMPILED, "first_pixel", None)
    monkeypatch.setattr(scanning.COMPILED, "area", None)
    y, x = np.mgrid[:200, :200]
    even, odd = (x + y) % 2 == 0, (x + y) % 2 == 1
    odd[190] = True
    assert_as_on_canvas(Sprite(even), Sprite(odd))
    assert len(scans) == 2  # once for each question, as neither tiles nor the rows on top tell
    sparse = np.zeros((200, 200), dtype=bool)
    sparse[150, 100] = sparse[8, 9] = True
    for offset in ((0, 0), (1, 0), (91, 142), (-91, -142), (3, 77)):
        assert_as_on_canvas(Sprite(sparse), Sprite(sparse, offset))
    assert len(scans) == 2


@pytest.mark.usefixtures("how")
def test_areas_at_many_positions_are_those_at_each() -> None:
    rng = np.random.default_rng(3)
    a, b = Sprite(rng.uniform(size=(70, 90)) < 0.3, (4, 5)), Sprite(rng.uniform(size=(30, 66)) < 0.3, (-7, 1))
    positions = rng.integers(-70, 100, (2, 5, 2))
    found = overlap_areas(a, b, positions)
    assert found.shape == (2, 5)
    for place in np.ndindex(2, 5):
        both, _ = on_canvas(a, b.moved_to(positions[place].tolist()))
        assert found[place] == np.count_nonzero(both)
    assert np.count_nonzero(found) > 3
    assert overlap_areas(a, b, np.zeros((0, 2))).shape == (0,)
    assert overlap_areas(a, b, [[FARTHEST, -FARTHEST]]).tolist() == [0]
    for bad in ([0.5, 0.5], [[1, 2, 3]], 3, [[FARTHEST + 1, 0]], ["a", "b"]):
        with pytest.raises(ShapeError, match="positions"):
            overlap_areas(a, b, bad)


def test_what_was_hit_last_is_asked_first_and_changes_no_answer() -> None:
    rng = np.random.default_rng(4)
    a, b = (Sprite(rng.uniform(size=(90, 90)) < 0.02) for _ in range(2))
    offsets = rng.integers(-80, 80, (60, 2)).tolist()
    answers = [(intersect(a, b.moved_to(offset)), common_pixel(a, b.moved_to(offset))) for offset in offsets]
    for row in (0, 44, 89):
        a._bits.likely = row
        again = [(intersect(a, b.moved_to(offset)), common_pixel(a, b.moved_to(offset))) for offset in offsets[::-1]]
        assert again[::-1] == answers


@given(arrays(np.uint64, st.tuples(st.integers(1, 3), st.integers(1, 5))))
def test_both_ways_of_counting_bits_agree(words: np.ndarray[Any, Any]) -> None:
    every = sum(int(word).bit_count() for word in words.ravel())
    assert scanning.count(words) == scanning._counted_by_bytes(words) == every


# -- images --------------------------------------------------------------------------------------------------


def test_the_alpha_of_an_image_is_the_mask(tmp_path: Path) -> None:
    alpha = np.array([[0, 127, 128], [255, 1, 200]], dtype=np.uint8)
    image = Image.fromarray(np.dstack([np.full((2, 3, 3), 9, dtype=np.uint8), alpha]))
    for name in ("a.png", "a.webp", "a.tga", "a.tif"):
        image.save(tmp_path / name, **({"lossless": True, "exact": True} if name.endswith("webp") else {}))
        assert np.array_equal(Sprite.from_image(tmp_path / name).mask, alpha > 127)
    assert Sprite.from_image(tmp_path / "a.png", (5, 6), threshold=0).area == 5
    surface = pygame.image.load(tmp_path / "a.png")
    assert pygame.mask.from_surface(surface, 127).count() == Sprite.from_image(tmp_path / "a.png").area


def test_images_that_are_none_or_too_large_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "text.png").write_text("no image")
    Image.new("RGB", (2, 2)).save(tmp_path / "opaque.png")
    Image.new("RGBA", (9, 9)).save(tmp_path / "large.png")
    whole = (tmp_path / "large.png").read_bytes()
    (tmp_path / "cut.png").write_bytes(whole[: len(whole) // 2])
    Image.new("RGB", (2, 2)).save(tmp_path / "photo.jpg")
    for name, why in (
        ("text.png", "no image"),
        ("opaque.png", "no alpha"),
        ("cut.png", "read"),
        ("photo.jpg", "no image"),
        ("nowhere.png", "read"),
    ):
        with pytest.raises(ShapeError, match=why):
            Sprite.from_image(tmp_path / name)
    with pytest.raises(ShapeError, match="threshold"):
        Sprite.from_image(tmp_path / "large.png", threshold=256)
    monkeypatch.setattr("refimpl.flat.sprites.MOST_PIXELS", 80)
    with pytest.raises(ShapeError, match="at most 80 pixels"):
        Sprite.from_image(tmp_path / "large.png")
    with pytest.raises(ShapeError, match="at most 80 pixels"):
        Sprite(np.zeros((9, 9), dtype=bool))
