"""Maps are as fine as the mouse allows."""

import pytest

from vtk_mls.rendering.pace import MapPace


class Clock:
    """A time that passes only where maps are made, by so much for each node of 64^3 of them."""

    def __init__(self, monkeypatch):
        self.now, self.seconds, self.made = 0.0, [], []
        monkeypatch.setattr("time.perf_counter", lambda: self.now)

    def make_map(self, nodes):
        seconds = self.seconds.pop(0) if len(self.seconds) > 1 else self.seconds[0]
        self.now += seconds * (nodes / 64) ** 3
        self.made.append(nodes)


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


@pytest.mark.parametrize(
    ("seconds", "moving", "resting"),
    [(0.008, 64, 128), (0.06, 64, 128), (0.48, 32, 72), (60, 24, 64)],
)
def test_nodes_follow_what_the_last_map_took(clock, seconds, moving, resting):
    pace, clock.seconds = MapPace(max_nodes=128), [seconds]
    for is_moving in (True, True, False, False):
        pace.make(clock.make_map, is_moving)
    assert clock.made == [64, moving, resting, resting]


def test_before_the_first_map_they_are_as_many_as_may_be(clock):
    clock.seconds = [0.01]
    for is_moving in (True, False):
        MapPace(max_nodes=128).make(clock.make_map, is_moving)
    assert clock.made == [64, 128]


def test_a_map_that_stays_is_as_fine_as_can_be_though_the_one_before_was_slow(clock):
    pace, clock.seconds = MapPace(max_nodes=128), [0.4, 0.01]
    pace.make(clock.make_map, True)
    pace.make(clock.make_map, False)
    assert clock.made == [64, 77, 128]
    assert pace.nodes == 128
    assert pace.map_seconds == pytest.approx(0.08)
