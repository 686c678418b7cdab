"""Nothing that is done to many points wakes the threads of BLAS, which go on waiting busily."""

import subprocess
import sys

import pytest

CODE = """
import os, sys, time

before = set(os.listdir("/proc/self/task"))
import numpy as np

threads = set(os.listdir("/proc/self/task")) - before


def ticks():
    # of the processor's time: the fields after the name, which may have blanks
    rows = [open(f"/proc/self/task/{thread}/stat").read().rpartition(")")[2] for thread in threads]
    return sum(int(field) for row in rows for field in row.split()[11:13])


def woken(work):
    start = ticks()
    for _ in range(3):
        work()
        time.sleep(0.1)
    return ticks() - start


if woken(lambda: np.ones((300_000, 3)) @ np.ones((3, 3)).T) < 2:
    sys.exit("its BLAS does not wait")

import vtk_mls

grid = vtk_mls.Grid((70, 70, 70), spacing=(1, 2, 3))
points = grid.points()
square = vtk_mls.Surface.polygon([(0, 0, 9), (50, 0, 9), (50, 90, 9), (0, 90, 9)])
cuts = [
    vtk_mls.Plane((30, 30, 90), (0.1, 0.2, 1)),
    vtk_mls.HalfPlane((30, 60, 90), (0.1, 0.2, 1), (1, 0, 0)),
    square,
]
work = {"points": grid.points, "index": lambda: grid.index_of(points)}
for cut in cuts:
    work[type(cut).__name__] = lambda cut=cut: cut.void_distance(points, points + 1)
print(*[name for name, each in work.items() if woken(each) > 1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc for the time of threads")
def test_no_product_with_many_points_is_left_to_blas():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False)
    if "does not wait" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []
