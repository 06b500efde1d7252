"""Large batches in threads: the same bits, as many threads as are allowed, one in processes that share the work."""

import multiprocessing
import threading

import numpy as np
import pytest

from refimpl import Box, Cylinder, Polyhedron, Sphere, collide, distance, intersect, threads
from tests.solids import L_SHAPE, prism

ROWS = 2 * threads.SHARE + 7


def boxes(seed):
    rng = np.random.default_rng(seed)
    return Box(rng.normal(size=(ROWS, 3)), rng.uniform(0.2, 1.0, (ROWS, 3)), rng.normal(size=(ROWS, 4)))


@pytest.fixture
def started(monkeypatch):
    """Threads in which parts were answered."""
    names = set()
    shared = threads.in_threads

    def watched(work, parts):
        return shared(lambda part: names.add(threading.get_ident()) or work(part), parts)

    monkeypatch.setattr("refimpl.queries.in_threads", watched)
    return names


def others():
    rng = np.random.default_rng(2)
    mesh = Polyhedron(*prism(L_SHAPE), rng.normal(size=(ROWS, 3)), rng.normal(size=(ROWS, 4)))
    return {"Box": boxes(1), "Polyhedron": mesh, "Cylinder": Cylinder(rng.normal(size=(ROWS, 3)), [0, 0, 3], 0.5)}


@pytest.mark.parametrize("kind", ["Box", "Polyhedron", "Cylinder"])
def test_the_number_of_threads_changes_no_bit(kind, monkeypatch, started):
    a, b = boxes(0), others()[kind]
    monkeypatch.setenv(threads.SETTING, "1")
    one = distance(a, b), intersect(a, b), collide(a, b)
    assert len(started) == 1
    for count in ("2", "3", "64"):
        started.clear()
        monkeypatch.setenv(threads.SETTING, count)
        many = distance(a, b), intersect(a, b), collide(a, b)
        assert len(started) > 1
        assert np.array_equal(one[1], many[1])
        for before, after in ((one[0], many[0]), (one[2], many[2])):
            for name, value in vars(before).items():
                assert np.array_equal(value, getattr(after, name), equal_nan=True), name


def test_small_batches_and_closed_forms_stay_in_one_thread(monkeypatch, started):
    monkeypatch.setenv(threads.SETTING, "4")
    distance(boxes(0)[: 2 * threads.SHARE - 1], boxes(1)[: 2 * threads.SHARE - 1])
    distance(Sphere(np.zeros((ROWS, 3)), 1.0), boxes(1))
    assert started == {threading.get_ident()}


def test_parts_cover_each_row_once(monkeypatch):
    for count in range(1, 9):
        monkeypatch.setenv(threads.SETTING, str(count))
        for rows in (0, 1, threads.SHARE, 2 * threads.SHARE, 10_000, 100_003):
            parts = list(threads.shares(rows))
            assert np.array_equal(np.concatenate([np.arange(rows)[part] for part in parts]), np.arange(rows))
            assert len(parts) <= count + 1


def test_parts_are_not_shared_again(monkeypatch):
    monkeypatch.setenv(threads.SETTING, "4")
    found = threads.in_threads(lambda part: len(list(threads.shares(100_000))), range(3))
    assert found == [5, 1, 1]


def test_an_error_in_a_thread_is_raised(monkeypatch):
    def fail(part):
        if part:
            raise ArithmeticError(part)

    with pytest.raises(ArithmeticError, match="2"):
        threads.in_threads(fail, [0, 2])


@pytest.mark.parametrize("wrong", ["0", "-1", "two", "1.5", "²"])
def test_a_wrong_setting_is_refused(wrong, monkeypatch):
    monkeypatch.setenv(threads.SETTING, wrong)
    with pytest.raises(ValueError, match=threads.SETTING):
        threads.allowed_threads()


def _told(pipe):
    pipe.send(threads.allowed_threads())


def test_processes_that_share_the_work_have_one_thread(monkeypatch):
    monkeypatch.delenv(threads.SETTING, raising=False)
    assert threads.allowed_threads() >= 1
    here, there = multiprocessing.get_context("spawn").Pipe(duplex=False)
    child = multiprocessing.get_context("spawn").Process(target=_told, args=(there,))
    child.start()
    there.close()
    assert here.recv() == 1
    child.join()


def test_products_are_not_shared_within_the_block() -> None:
    import threadpoolctl  # noqa: PLC0415  scans what is loaded

    def allowed() -> list[int]:
        return [found["num_threads"] for found in threadpoolctl.threadpool_info() if found["user_api"] == "blas"]

    before = allowed()
    with threads.products_in_one_thread():
        assert set(allowed()) == {1}
    assert allowed() == before
