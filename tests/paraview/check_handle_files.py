"""Control points are read from files that ParaView saved and from text files."""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import DEFORMED, REST, array, control_points, data

from vtk_mls.files import control_point_files

handles = control_points(Weights=list(np.arange(1.0, 9.0)))
handles.UpdatePipeline()
expected = array(data(handles), "Displacement")
files = simple.MLSControlPoints(Mode="file")
with tempfile.TemporaryDirectory() as folder:
    files.FileName = os.path.join(folder, "table.csv")
    simple.SaveData(files.FileName, proxy=handles, Precision=17)
    loaded = data(files)
    np.testing.assert_allclose(array(loaded, "Displacement"), expected, atol=1e-12)
    np.testing.assert_array_equal(array(loaded, "Weight"), np.arange(1.0, 9.0))
    for number, place in enumerate(REST):
        np.testing.assert_allclose(loaded.GetPoint(number), place)

    polydata = os.path.join(folder, "handles.vtp")
    simple.SaveData(polydata, proxy=handles)
    reader = simple.XMLPolyDataReader(FileName=[polydata])
    np.testing.assert_array_equal(array(data(reader), "Displacement"), expected)

    for name, places in (("rest.mrk.json", REST), ("deformed.fcsv", DEFORMED)):
        control_point_files.write(os.path.join(folder, name), places, places)
    files.FileName = os.path.join(folder, "rest.mrk.json")
    assert not array(data(files), "Displacement").any()
    files.DeformedFileName = os.path.join(folder, "deformed.fcsv")
    np.testing.assert_allclose(array(data(files), "Displacement"), expected, atol=1e-12)

# The second output shows where the handles were dragged.
arrows = simple.ExtractSurface(Input=simple.OutputPort(files, 1))
arrows.UpdatePipeline()
bounds = np.reshape(data(arrows).GetBounds(), (3, 2))
assert data(arrows).GetNumberOfCells() > 0
assert (bounds[:, 1] > DEFORMED.max(axis=0) - 0.1).all()
