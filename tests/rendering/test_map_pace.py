"""The time of the last map determines the number of nodes of the next one."""

import pytest

from vtk_mls.rendering.pace import MapPace


class Clock:
    """A clock that advances by the time of each map: `seconds` for 64^3 nodes."""

    def __init__(self, monkeypatch):
        self.now, self.seconds, self.nodes = 0.0, [], []
        monkeypatch.setattr("time.perf_counter", lambda: self.now)

    def make_map(self, nodes):
        seconds = self.seconds.pop(0) if len(self.seconds) > 1 else self.seconds[0]
        self.now += seconds * (nodes / 64) ** 3
        self.nodes.append(nodes)


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


@pytest.mark.parametrize(
    ("seconds", "moving", "resting"),
    [(0.008, 64, 128), (0.06, 64, 128), (0.48, 32, 72), (60, 24, 64)],
)
def test_nodes_follow_from_the_time_of_the_last_map(clock, seconds, moving, resting):
    pace, clock.seconds = MapPace(max_nodes=128), [seconds]
    for is_moving in (True, True, False, False):
        pace.make(clock.make_map, is_moving)
    assert clock.nodes == [64, moving, resting, resting]


def test_the_first_map_has_the_most_nodes(clock):
    clock.seconds = [0.01]
    for is_moving in (True, False):
        MapPace(max_nodes=128).make(clock.make_map, is_moving)
    assert clock.nodes == [64, 128]


def test_a_map_at_rest_is_computed_again_after_a_slow_one(clock):
    pace, clock.seconds = MapPace(max_nodes=128), [0.4, 0.01]
    pace.make(clock.make_map, True)
    pace.make(clock.make_map, False)
    assert clock.nodes == [64, 77, 128]
    assert pace.nodes == 128
    assert pace.map_seconds == pytest.approx(0.08)
