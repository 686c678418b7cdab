"""Scenes of the tests in ParaView's GUI, and their files."""

from __future__ import annotations

import os

from gui import LISTENER
from paraviews import NOISE, PICTURES, PROJECT, unavailable
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from vtk_mls.commands import demo
from vtk_mls.vtk.objects import configured, output_of

# Of this process, for files that several tests read: others can run beside it.
OWN = PICTURES / os.environ.get("PYTEST_XDIST_WORKER", "alone")

HANDLE = (10, 10, 0)  # the middle of an edge of the wavelet
PULL = (60, 50)  # pixels
ASIDE = (120, 40)

LOAD = """
from paraview import smtrace
smtrace.start_trace()
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings
simple.LoadPlugin("paraview_plugin/vtk_mls_plugin.py", ns=vars(simple))
settings = vtkPVGeneralSettings.GetInstance()
"""


def _shown(name, source):
    return f"""
{name} = {source}
{name}.UpdatePipeline()
simple.Show({name}, view)
view.ResetCamera()
simple.Render(view)
simple.SetActiveSource({name})
"""


WAVELET = _shown("wavelet", "simple.Wavelet()")
VALUES = "volume = values(wavelet).copy()\n"
SETUP = LOAD + WAVELET + VALUES
AS_VOLUME = """
simple.ColorBy(simple.GetDisplayProperties(wavelet, view), ("POINTS", "RTData"))
simple.GetDisplayProperties(wavelet, view).SetRepresentationType("Volume")
simple.Render(view)
"""
LIVE = f"""{AS_VOLUME}
from vtk_mls.rendering import DeformedVolume
record_updates(DeformedVolume)
"""
_SPHERE = "simple.Sphere(Radius=10, ThetaResolution=90, PhiResolution=90)"
BALL = f"simple.Delete(wavelet){_shown('ball', _SPHERE)}"
HAS_QT = """
try:
    import gui_places
    answer = True
except ModuleNotFoundError:
    answer = False
"""
BRAIN = "file = simple.GetActiveSource(); volume = values(file).copy()\n"


def write_brain(file, step):
    """Write every n-th voxel of a brain along each axis; the file, relative to the project."""
    brain = output_of(vtkNIFTIImageReader(), FileName=str(demo.brain_file()))
    smaller = output_of(vtkImageShrink3D(), InputData=brain, ShrinkFactors=[step] * 3)
    smaller.GetPointData().GetScalars().SetName("T1")
    (PROJECT / file).parent.mkdir(parents=True, exist_ok=True)
    writer = configured(vtkXMLImageDataWriter(), InputData=smaller, FileName=str(PROJECT / file))
    assert writer.Write()
    return file


def noise(gui):
    """The errors and warnings that it has printed."""
    return [line for line in gui.printed.splitlines() if NOISE.search(line)]


def require_qt(gui):
    if not gui.run(HAS_QT):
        unavailable("no Qt for Python with this ParaView: tests/paraview/install.sh says why")


def vtk_mls_command(file):
    """The command `vtk-mls paraview FILE` with the listener."""
    options = ("--dr", f"--script={LISTENER}")
    command = ("python3", "-m", "vtk_mls", "paraview", str(file))
    return (*command, *(f"--option={option}" for option in options))
