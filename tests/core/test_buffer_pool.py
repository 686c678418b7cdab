"""Memory of results that nobody has any more, for the next ones."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from vtk_mls import Deformation, Grid, HalfPlane
from vtk_mls.base import buffer_pool

SIZE = 3 << 20


@pytest.fixture(autouse=True)
def nothing_kept():
    buffer_pool._kept.clear()
    yield
    buffer_pool._kept.clear()


def address(array):
    return array.__array_interface__["data"][0]


def kept():
    return sum(each.array.nbytes for each in buffer_pool._kept)


def test_memory_is_used_again_for_arrays_of_its_size():
    first = buffer_pool.empty((3, 1 << 18), np.float32)
    assert first.flags.writeable
    assert first.flags.c_contiguous
    at = address(first)
    del first
    assert kept() == SIZE
    assert address(buffer_pool.empty(SIZE, np.uint8)) == at
    assert buffer_pool.empty((1 << 17, 3), np.float64).shape == (1 << 17, 3)
    assert kept() == SIZE


def test_a_view_holds_it():
    whole = buffer_pool.empty(SIZE, np.uint8)
    whole[:] = 7
    view = whole.reshape(3, -1)[1, 5:9].view(np.uint16)
    del whole
    assert kept() == 0
    buffer_pool.empty(SIZE, np.uint8)[:] = 9
    assert (view == 7 + 7 * 256).all()
    del view
    assert kept() == 2 * SIZE


def test_small_arrays_are_numpy_s():
    small = buffer_pool.empty(1000, np.int64)
    assert small.shape == (1000,)
    assert small.dtype == np.int64
    assert small.base is None
    assert buffer_pool.empty((0, 3), np.float32).shape == (0, 3)


def test_it_is_bounded(monkeypatch):
    monkeypatch.setattr(buffer_pool, "_MOST", 5 * SIZE)
    many = [buffer_pool.empty(SIZE, np.uint8) for _ in range(9)]
    large = buffer_pool.empty(6 * SIZE, np.uint8)
    last = address(many[-1])
    del large
    while many:
        del many[0]
    assert kept() == 5 * SIZE
    assert last in [address(each.array) for each in buffer_pool._kept]


def test_what_is_not_wanted_any_more_goes():
    other = buffer_pool.empty(2 * SIZE, np.uint8)
    del other
    for _ in range(buffer_pool._PATIENCE):
        assert kept() >= 2 * SIZE
        buffer_pool.empty(SIZE, np.uint8)
    assert kept() == SIZE


def test_threads_have_arrays_of_their_own():
    wrong = []

    def work(number):
        rng = np.random.default_rng(number)
        held = []
        for _ in range(150):
            array = buffer_pool.empty(int(rng.choice([1 << 20, 2 << 20])), np.uint8)
            value = int(rng.integers(256))
            array[:] = value
            held.append((array, value))
            if len(held) > 3:
                array, value = held.pop(int(rng.integers(4)))
                wrong.extend(np.flatnonzero(array != value)[:1])

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert not wrong


def maps(count, rng):
    rest = rng.uniform(0, 70, (6, 3))
    cut = HalfPlane((35, 35, 35), (0, 0, 1), (1, 0, 0))
    return [Deformation(rest, rest + rng.normal(size=(6, 3)), cuts=[cut]) for _ in range(count)]


def test_fields_that_are_held_stay_as_they_are(rng):
    grid = Grid((70, 70, 70))
    held = []
    for each in maps(4, rng):
        field = each.displacement_field(grid)
        held.append((field.displacement[::7], field.displacement[::7].copy()))
        if len(held) == 3:
            del held[1]
    for view, copy in held:
        np.testing.assert_array_equal(view, copy)


def test_a_program_may_end_with_an_array():
    code = (
        "import numpy as np; from vtk_mls.base import buffer_pool;"
        "a = buffer_pool.empty(1 << 22, 'u1');"
        "b = buffer_pool.empty(1 << 22, 'u1'); a[:] = 1; c = a[::3]"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
