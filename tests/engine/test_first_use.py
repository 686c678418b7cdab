"""The first use of a device by several threads at once, in fresh processes."""

import multiprocessing
import subprocess
import sys
import threading
import time

import pytest
from control_point_sets import DEVICES

from vtk_mls.base import lazy

HEAD = """
import threading
import numpy as np
from vtk_mls import Deformation, Grid
rest = np.array([(a, b, c) for a in (0, 9) for b in (0, 9) for c in (0, 9)] + [(5, 5, 5)], float)
moved = rest.copy()
moved[-1] += 1
d, grid = Deformation(rest, moved), Grid((24, 24, 24), spacing=(0.4, 0.4, 0.4))
image = np.random.default_rng(0).random((24, 24, 24), np.float32)
def in_threads(work):
    values, gate = [], threading.Barrier(4)
    def run():
        gate.wait()
        values.append(work())
    threads = [threading.Thread(target=run) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(values) == 4
    return values
"""
FIELD = """
def work():
    return Deformation(rest, moved).displacement_field(grid).displacement
values = in_threads(work)
assert all((value == d.displacement_field(grid).displacement).all() for value in values)
"""
FILTERS = """
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk.arrays import ImageGeometry, to_numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtk_mls.vtk.control_point_polydata import fill_polydata
def work():
    data, handles, deform = vtkImageData(), vtkPolyData(), MLSDeform()
    data.SetDimensions(24, 24, 24)
    data.SetSpacing(0.4, 0.4, 0.4)
    data.GetPointData().SetScalars(numpy_to_vtk(image.ravel(), deep=True))
    fill_polydata(handles, rest, moved, None)
    deform.SetInputData(0, data)
    deform.SetInputData(1, handles)
    deform.Update()
    return to_numpy(deform.GetOutput().GetPointData().GetScalars()).copy()
values = in_threads(work)
alone = d.resample([image], grid)[0].ravel()
assert all(np.abs(value - alone).max() < 1e-4 for value in values)
"""
DASK = """
from vtk_mls.dask import resample
blocks = resample(image, Deformation(rest, moved), grid, chunks=8)
value = blocks.compute(scheduler="threads", num_workers=4)
assert np.abs(value - d.resample([image], grid)[0]).max() < 1e-4
"""
PROCESSES = """
import concurrent.futures, multiprocessing
def work(_):
    return d.backward([(4.0, 4, 4)]).tolist()
if __name__ == "__main__":
    context = multiprocessing.get_context("{method}")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        values = [*pool.map(work, range(4))]
    assert values == [work(0)] * 4
"""


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize(
    "work",
    [
        pytest.param(FIELD, id="plain"),
        pytest.param(FILTERS, id="filters"),
        pytest.param(DASK, id="dask"),
        *(
            pytest.param(PROCESSES.format(method=method), id=method)
            for method in multiprocessing.get_all_start_methods()
        ),
    ],
)
def test_the_first_use_by_several_threads(work, tmp_path):
    if "dask" in work:
        pytest.importorskip("dask")
    program = tmp_path / "program.py"
    program.write_text(HEAD + work)
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_shared_value_is_made_once_and_an_error_is_not_kept():
    calls = []

    @lazy.cached
    def value(key):
        calls.append(key)
        time.sleep(0.05)
        if len(calls) == 1:
            raise ValueError("not yet")
        return object()

    with pytest.raises(ValueError, match="not yet"):
        value("a")
    found = []
    threads = [threading.Thread(target=lambda: found.append(value("a"))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert calls == ["a", "a"]
    assert len(set(map(id, found))) == 1
    assert value("b") is not found[0]
