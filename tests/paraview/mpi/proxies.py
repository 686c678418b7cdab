"""The proxies in several processes: the client fetches the result of one process.

For `mpirun -np N pvbatch`; or, with the number of a pvserver's port, for a client in pvpython.
"""

import dataclasses
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
sys.path.append(str(Path(__file__).resolve().parents[3]))
from paraview import servermanager, simple

if len(sys.argv) > 1 and sys.argv[1].isdigit():
    simple.Connect("localhost", int(sys.argv[1]))

from scene import DEFORMED, REST, array, control_points, grid, wavelet
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
from vtkmodules.vtkIOXML import vtkXMLPImageDataReader

import vtk_mls

SIZE = servermanager.ActiveConnection.GetNumberOfDataPartitions()
folder = tempfile.TemporaryDirectory()
value = vtk_mls.Deformation(REST, DEFORMED)
source = wavelet()
alone = vtkRTAnalyticSource()
alone.SetWholeExtent(*source.WholeExtent)
alone.Update()
volume = array(alone.GetOutput(), "RTData")
lattice = grid(alone.GetOutput())


def data(proxy):
    """An image, put together from the files of all processes."""
    file = str(Path(folder.name) / "whole.pvti")
    simple.SaveData(file, proxy)
    reader = vtkXMLPImageDataReader()
    reader.SetFileName(file)
    reader.Update()
    return reader.GetOutput()


def check(deform, field, value=value):
    """Both filters against the value outside of the pipeline."""
    (expected,) = value.resample([volume], vtk_mls.Sampling(lattice, background="auto"))
    result = data(deform)
    assert result.GetDimensions() == lattice.dimensions
    np.testing.assert_allclose(array(result, "RTData"), expected, rtol=1e-6)
    expected = value.displacement_field(lattice)
    np.testing.assert_array_equal(array(data(field), "BackwardDisplacement"), expected.displacement)
    if value.cuts:
        np.testing.assert_array_equal(array(result, "Void") > 0, expected.void)
        assert expected.void.any() or value.in_rest_frame  # all that the cut parts moves alike


# Control points on every process, and from a table that one process reads.
deform = simple.MLSDeform(Input=source, ControlPoints=control_points())
field = simple.MLSDisplacementField(Input=source, ControlPoints=deform.ControlPoints)
deform.MapTolerance = field.MapTolerance = 0
check(deform, field)
table = Path(folder.name) / "handles.csv"
rows = np.hstack([REST, DEFORMED - REST])
np.savetxt(table, rows, delimiter=",", fmt="%.17g", header="px,py,pz,dx,dy,dz", comments="")
points = simple.TableToPoints(
    Input=simple.CSVReader(FileName=[str(table)]), XColumn="px", YColumn="py", ZColumn="pz"
)
handles = simple.Calculator(
    Input=points, Function="dx*iHat + dy*jHat + dz*kHat", ResultArrayName="Displacement"
)
deform.ControlPoints = field.ControlPoints = handles
check(deform, field)

# A cut from a source, and one of the filter's own.
plane = simple.Plane(Origin=[-4, 0.3, -20], Point1=[20, 0.3, -20], Point2=[-4, 0.3, 20])
deform.Cuts = field.Cuts = plane
corners = [[-4, 0.3, -20], [20, 0.3, -20], [20, 0.3, 20], [-4, 0.3, 20]]
cuts = [vtk_mls.Surface.polygon(corners)]
for frame in vtk_mls.CUT_FRAMES:
    deform.CutFrame = field.CutFrame = frame
    check(deform, field, vtk_mls.Deformation(REST, DEFORMED, cuts=cuts, cut_frame=frame))
deform.Cuts = field.Cuts = None

# A mesh.
mesh = simple.Tetrahedralize(Input=source)
moved = simple.MLSDeform(Input=mesh, ControlPoints=handles)
moved.UpdatePipeline()
bounds = moved.GetDataInformation().GetBounds()
expected = value.forward(lattice.points())
low, high = expected.min(axis=0), expected.max(axis=0)
np.testing.assert_allclose(bounds, np.stack([low, high], axis=1).ravel(), atol=1e-4)

# The field over a mesh: the pieces of its image fit together, over the bounds of the whole mesh.
field = simple.MLSDisplacementField(
    Input=mesh, ControlPoints=handles, SampleDimensions=lattice.dimensions, MapTolerance=0
)
image = data(field)
assert image.GetDimensions() == lattice.dimensions
assert image.GetBounds() == alone.GetOutput().GetBounds()
expected = value.displacement_field(lattice).displacement
np.testing.assert_array_equal(array(image, "BackwardDisplacement"), expected)

# Within the tolerance that ParaView begins with pieces fit together, too.
large = simple.Wavelet(WholeExtent=[-24, 23, -20, 21, -22, 22])
field = simple.MLSDisplacementField(Input=large, ControlPoints=handles)
image = data(field)
exact = value.displacement_field(grid(image)).displacement
coarse_value = dataclasses.replace(value, map_tolerance=field.MapTolerance)
expected = coarse_value.displacement_field(grid(image)).displacement
np.testing.assert_array_equal(array(image, "BackwardDisplacement"), expected)
assert not np.array_equal(expected, exact)

folder.cleanup()
print(f"done with {SIZE}")
