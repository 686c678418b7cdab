"""Meshes: tetrahedra of all of ParaView's making move with the volume, and are cut open."""

import numpy as np
from paraview import simple
from scene import DEFORMED, REST, array, control_points, data, vtk_mls, wavelet
from vtkmodules.util.numpy_support import vtk_to_numpy

source = wavelet()
tetrahedra = simple.Tetrahedralize(Input=source)


def places(dataset):
    return vtk_to_numpy(dataset.GetPoints().GetData())


# Just added, it is the identity.
deform = simple.MLSDeform(Input=tetrahedra)
before = data(tetrahedra)
assert data(deform).GetClassName() == "vtkUnstructuredGrid"
np.testing.assert_array_equal(places(data(deform)), places(before))

# Dragged handles move it as they move the volume.
handles = control_points()
deform.ControlPoints = handles
moved = data(deform)
expected = vtk_mls.Deformation(REST, DEFORMED).forward(places(before))
np.testing.assert_allclose(places(moved), expected, atol=1e-4)
np.testing.assert_array_equal(array(moved, "RTData"), array(before, "RTData"))

# Kept whole, the cells that a cut tears are hidden.
pulled = DEFORMED + np.where(REST[:, :1] > 0, [[3.0, 0, 0]], [[-3.0, 0, 0]])
handles.DeformedPoints = list(np.ravel(np.where(REST[:, 2:] > 0, pulled, REST)))
deform.CutType = "half-plane"
deform.CutOrigin = [0.2, 0.0, -1.0]
deform.CutNormal = [1.0, 0.0, 0.0]
deform.CutInward = [0.0, 0.0, 1.0]
assert data(deform).GetNumberOfCells() > before.GetNumberOfCells()
deform.SplitCells = 0
torn = data(deform)
assert torn.GetNumberOfCells() == before.GetNumberOfCells()
void = vtk_to_numpy(torn.GetCellData().GetArray("Void"))
assert 0 < void.sum() < 0.2 * len(void)
simple.ExtractSurface(Input=deform).UpdatePipeline()

# Blocks.
group = simple.MLSDeform(
    Input=simple.GroupDatasets(Input=[source, tetrahedra]), ControlPoints=handles
)
group.UpdatePipeline()
assert group.GetDataInformation().GetNumberOfDataSets() == 2
