"""What must be measured in a process of its own: how it starts, and how much memory it needs.

python alone.py start                 # JSON to standard output: milliseconds
python alone.py memory 512 0.02       # MB, of a volume of 512^3 within a map tolerance
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
_STATUS = Path("/proc/self/status")
_MB = 1 << 20


def starts():
    """Milliseconds of a program's first steps: where no cache has anything, and the next time."""
    with tempfile.TemporaryDirectory() as folder:
        caches = {"XDG_CACHE_HOME": folder, "POCL_CACHE_DIR": f"{folder}/pocl"}
        caches["CUDA_CACHE_PATH"] = f"{folder}/cuda"
        return {name: _asked(["start"], caches) for name in ("cold", "warm")}


def memory(n, tolerance):
    """MB of an update of `MLSDeform`: its input, its output, what else there is at the peak.

    None where the system does not tell.
    """
    if not _STATUS.exists():
        return None
    asked = ["memory", str(n), str(tolerance)]
    _asked(asked)  # builds all kernels: a compiler in the second process would count as memory
    return _asked(asked)


def _asked(arguments, environment=None):
    command = [sys.executable, __file__, *arguments]
    paths = [str(PROJECT), *filter(None, [os.environ.get("PYTHONPATH")])]
    settings = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(environment or {})}
    ended = subprocess.run(command, env=settings, capture_output=True, text=True)
    if ended.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} has failed: {ended.stderr}")
    return json.loads(ended.stdout.splitlines()[-1])


def _start():
    began = time.perf_counter()
    steps = {}

    def step(name):
        nonlocal began
        now = time.perf_counter()
        steps[name], began = 1000 * (now - began), now

    import vtk_mls
    from vtk_mls.engine.dispatch import engine_for

    step("import")
    engine_for()
    step("device")
    rest = [(10.0, 10, 10), (50, 12, 14), (30, 50, 40), (20, 30, 60)]
    for name in ("first map", "second map"):
        moved = [(x + len(steps), y, z) for x, y, z in rest]
        vtk_mls.Deformation(rest, moved).displacement_field((64, 64, 64))
        step(name)
    return steps


def _memory(n, tolerance):
    _prepared(64, tolerance)[0].Update()  # kernels are loaded, threads started
    deform, image = _prepared(n, tolerance)
    before = _told("VmRSS")
    deform.Update()
    peak, arrays = _told("VmHWM"), deform.GetOutput().GetPointData()
    sizes = [arrays.GetArray(i).GetDataSize() for i in range(arrays.GetNumberOfArrays())]
    output = sum(sizes) / _MB
    return {
        "input": sum(array.nbytes for array in image) / _MB,
        "output": output,
        "beside": max(peak - before - output, 0),
    }


def _prepared(n, tolerance):
    """A filter on a volume with labels and a scalar, and their arrays: nothing else is kept."""
    import numpy as np
    from operations import handles
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData

    from vtk_mls.filters import MLSDeform
    from vtk_mls.vtk.objects import configured

    volume, arrays, along = vtkImageData(), [], np.arange(n, dtype=np.uint8)
    volume.SetDimensions(n, n, n)
    for name, shift in (("labels", 5), ("scalars", 0)):
        values = np.empty((n, n, n), np.uint8)
        np.bitwise_xor((along[:, None] ^ along)[:, :, None], along, out=values)
        np.right_shift(values, shift, out=values)
        array = numpy_to_vtk(values.ravel())
        array.SetName(name)
        volume.GetPointData().AddArray(array)
        arrays.append(values)
    deform, (rest, deformed) = configured(MLSDeform(), InputData=volume), handles(n)
    configured(deform, RestPoints=rest, DeformedPoints=deformed, MapTolerance=tolerance)
    deform.AddLabelArray("labels")
    return deform, arrays


def _told(what):
    """MB that the system tells of this process."""
    (line,) = (line for line in _STATUS.read_text().splitlines() if line.startswith(what))
    return int(line.split()[1]) / 1024


if __name__ == "__main__":
    if sys.argv[1] == "start":
        print(json.dumps(_start()))
    else:
        print(json.dumps(_memory(int(sys.argv[2]), float(sys.argv[3]))))
