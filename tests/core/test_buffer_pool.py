"""The memory of large results is reused."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from vtk_mls import Deformation, Grid, HalfPlane
from vtk_mls.base import buffer_pool

SIZE = 3 << 20


@pytest.fixture(autouse=True)
def empty_pool():
    buffer_pool._idle.clear()
    yield
    buffer_pool._idle.clear()


def address(array):
    return array.__array_interface__["data"][0]


def idle_bytes():
    return sum(buffer.nbytes for buffer, _ in buffer_pool._idle)


def test_memory_is_reused_for_arrays_of_the_same_size():
    first = buffer_pool.empty((3, 1 << 18), np.float32)
    assert first.flags.writeable
    assert first.flags.c_contiguous
    at = address(first)
    del first
    assert idle_bytes() == SIZE
    assert address(buffer_pool.empty(SIZE, np.uint8)) == at
    assert buffer_pool.empty((1 << 17, 3), np.float64).shape == (1 << 17, 3)
    assert idle_bytes() == SIZE


def test_a_view_keeps_its_memory():
    whole = buffer_pool.empty(SIZE, np.uint8)
    whole[:] = 7
    view = whole.reshape(3, -1)[1, 5:9].view(np.uint16)
    del whole
    assert idle_bytes() == 0
    buffer_pool.empty(SIZE, np.uint8)[:] = 9
    assert (view == 7 + 7 * 256).all()
    del view
    assert idle_bytes() == 2 * SIZE


def test_small_arrays_are_not_pooled():
    small = buffer_pool.empty(1000, np.int64)
    assert small.shape == (1000,)
    assert small.dtype == np.int64
    assert small.base is None
    assert buffer_pool.empty((0, 3), np.float32).shape == (0, 3)


def test_idle_memory_is_bounded(monkeypatch):
    monkeypatch.setattr(buffer_pool, "MAX_IDLE_BYTES", 5 * SIZE)
    many = [buffer_pool.empty(SIZE, np.uint8) for _ in range(9)]
    large = buffer_pool.empty(6 * SIZE, np.uint8)
    last = address(many[-1])
    del large
    while many:
        del many[0]
    assert idle_bytes() == 5 * SIZE
    assert last in [address(buffer) for buffer, _ in buffer_pool._idle]


def test_idle_memory_is_freed_after_some_calls():
    other = buffer_pool.empty(2 * SIZE, np.uint8)
    del other
    for _ in range(buffer_pool.MAX_IDLE_CALLS):
        assert idle_bytes() >= 2 * SIZE
        buffer_pool.empty(SIZE, np.uint8)
    assert idle_bytes() == SIZE


def test_threads_do_not_share_memory():
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
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def maps(count, rng):
    rest = rng.uniform(0, 70, (6, 3))
    cut = HalfPlane((35, 35, 35), (0, 0, 1), (1, 0, 0))
    return [Deformation(rest, rest + rng.normal(size=(6, 3)), cuts=[cut]) for _ in range(count)]


def test_fields_in_use_do_not_change(rng):
    grid = Grid((70, 70, 70))
    held = []
    for deformation in maps(4, rng):
        field = deformation.displacement_field(grid)
        held.append((field.displacement[::7], field.displacement[::7].copy()))
        if len(held) == 3:
            del held[1]
    for view, copy in held:
        np.testing.assert_array_equal(view, copy)


def test_a_program_ends_cleanly_with_arrays_in_use():
    code = (
        "import numpy as np; from vtk_mls.base import buffer_pool;"
        "a = buffer_pool.empty(1 << 22, 'u1');"
        "b = buffer_pool.empty(1 << 22, 'u1'); a[:] = 1; c = a[::3]"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_large_arrays_begin_with_a_cache_line():
    """Kernels write whole lines past the caches."""
    arrays = [buffer_pool.empty((1 << 20) + n, np.float32) for n in range(3)]
    assert [array.ctypes.data % buffer_pool.ALIGNMENT for array in arrays] == [0, 0, 0]
