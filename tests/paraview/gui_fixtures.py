"""Running GUIs of ParaView as fixtures, and what is run inside. Tests import them."""

from __future__ import annotations

import os
import shutil
from functools import partial

import pytest
from gui import LISTENER, running
from paraviews import NOISE, PICTURES, PROJECT, display, paraview  # noqa: F401  fixtures
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from vtk_mls.commands import demo

# Of this process, for files that several tests read: others can run beside it.
OWN = PICTURES / os.environ.get("PYTEST_XDIST_WORKER", "alone")

HANDLE = (10, 10, 0)  # the middle of an edge of the wavelet
PULL = (60, 50)  # pixels
ASIDE = (120, 40)

SETUP = """
import numpy as np
from paraview import smtrace
smtrace.start_trace()
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings
from vtkmodules.util.numpy_support import vtk_to_numpy
simple.LoadPlugin("paraview_plugin/vtk_mls_plugin.py", ns=vars(simple))
settings = vtkPVGeneralSettings.GetInstance()

def rtdata(proxy):
    data = proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0)
    filled = data and data.GetPointData().GetNumberOfArrays()
    return vtk_to_numpy(data.GetPointData().GetArray(0)) if filled else np.empty(0)

def is_bent():
    return len(rtdata(deform)) == len(volume) and not is_straight()

def is_straight():
    return np.array_equal(rtdata(deform), volume)

def dragged(pending=False):
    rest = np.reshape(deform.RestPoints, (-1, 3))
    moved = deform.SMProxy.GetProperty("DeformedPoints")
    count = moved.GetNumberOfUncheckedElements()
    pulled = [moved.GetUncheckedElement(i) for i in range(count)]
    moved = np.reshape(pulled if pending else deform.DeformedPoints, (-1, 3))
    return [int(i) for i in np.flatnonzero((moved != rest).any(axis=1))]

wavelet = simple.Wavelet()
wavelet.UpdatePipeline()
simple.Show(wavelet, view)
view.ResetCamera()
simple.Render(view)
simple.SetActiveSource(wavelet)
volume = rtdata(wavelet).copy()
"""

HAS_QT = """
try:
    import gui_places
    answer = True
except ModuleNotFoundError:
    answer = False
"""

BRAIN = """
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
file = simple.GetActiveSource()

def output(proxy):
    data = proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0)
    return data if data and data.GetPointData().GetNumberOfArrays() else None

def values(proxy, name):
    return vtk_to_numpy(output(proxy).GetPointData().GetArray(name))

def pending(name):
    changed = deform.SMProxy.GetProperty(name)
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

def dragged():  # numbers of the handles that are not where they rest, pending edits included
    rest, moved = (np.reshape(pending(n), (-1, 3)) for n in ("RestPoints", "DeformedPoints"))
    return [int(i) for i in np.flatnonzero((moved != rest).any(axis=1))]

def rest_of(number):
    return pending("RestPoints")[3 * number:3 * number + 3]

def counts():
    return [len(pending(n)) for n in ("RestPoints", "DeformedPoints", "Weights")]

def on_screen(places):
    from vtkmodules.vtkRenderingCore import vtkCoordinate
    coordinate = vtkCoordinate()
    coordinate.SetCoordinateSystemToWorld()
    seen = []
    for place in places:
        coordinate.SetValue(*place)
        seen.append(coordinate.GetComputedDisplayValue(view.GetRenderer()))
    return np.array(seen)

def in_sight():  # numbers and places of handles with no other before or behind
    places = np.reshape(pending("DeformedPoints"), (-1, 3))
    seen = on_screen(places)
    near = np.linalg.norm(seen[:, None] - seen, axis=2) < 20
    return [(n, list(p)) for n, p in enumerate(places) if near[n].sum() == 1]

def free(places):  # the one that is farthest, as it is seen, from every handle
    handles = np.reshape(pending("DeformedPoints"), (-1, 3))
    apart = np.linalg.norm(on_screen(places)[:, None] - on_screen(handles), axis=2)
    return places[int(apart.min(axis=1).argmax())]

def void_begins():  # at what x
    void = np.flatnonzero(values(deform, "Void"))
    return min(output(deform).GetPoint(int(each))[0] for each in void)

def is_bent():
    return not np.array_equal(values(deform, "T1"), values(file, "T1"))

def is_cut():
    return output(deform).GetPointData().HasArray("Void") and bool(values(deform, "Void").any())
"""


def unavailable(what):
    reason = f"{what}: tests/paraview/install.sh says why"
    (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(reason)


@pytest.fixture
def start(paraview, display, request):
    """A context manager for a running GUI."""
    missing = [tool for tool in ("Xvfb", "xdotool", "import") if not shutil.which(tool)]
    if missing:
        unavailable(f"no {', '.join(missing)} on this system")
    name = request.node.originalname.removeprefix("test_")
    folder = PICTURES / request.node.callspec.id / name
    return partial(running, paraview, PROJECT, folder, display)


@pytest.fixture
def gui(start):
    """A running GUI with a wavelet, which must not print an error or a warning."""
    with start() as gui:
        gui.run(SETUP)
        yield gui
        assert noise(gui) == []


@pytest.fixture(scope="module")
def brain():
    """File of a volume, relative to the project."""
    return write_brain(OWN / "brain.vti", every=2)


def write_brain(file, every):
    """Write a brain, some of its voxels; the file, which is relative to the project."""
    reader = vtkNIFTIImageReader()
    reader.SetFileName(str(demo.brain_file()))
    smaller = vtkImageShrink3D()
    smaller.SetInputConnection(reader.GetOutputPort())
    smaller.SetShrinkFactors(every, every, every)
    smaller.Update()
    smaller.GetOutput().GetPointData().GetScalars().SetName("T1")
    writer = vtkXMLImageDataWriter()
    writer.SetInputConnection(smaller.GetOutputPort())
    (PROJECT / file).parent.mkdir(parents=True, exist_ok=True)
    writer.SetFileName(str(PROJECT / file))
    assert writer.Write()
    return file


def noise(gui):
    """The errors and warnings that it has printed."""
    return [line for line in gui.printed.splitlines() if NOISE.search(line)]


def by_vtk_mls(file):
    """How `vtk-mls paraview FILE` starts a ParaView."""
    options = ("--dr", f"--script={LISTENER}")
    command = ("python3", "-m", "vtk_mls", "paraview", str(file))
    return (*command, *(f"--option={each}" for each in options))
