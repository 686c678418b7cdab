"""The memory of large results is reused."""

import threading

import numpy as np
import pytest

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
