"""Folds are red in the default colors of JacobianDeterminant."""

import sys
from pathlib import Path

import numpy as np
from paraview import simple
from scene import REST, array, data, output_messages, screenshot, wavelet

from vtk_mls.rendering import volume_colors

FOLDER = Path(sys.argv[1])
DRAG = np.zeros_like(REST)
DRAG[0] = 9.0, 9.0, 0.0  # past the middle

source = wavelet()
deform = simple.MLSDeform(Input=source, GenerateJacobianDeterminant=1)
deform.RestPoints, deform.DeformedPoints = list(np.ravel(REST)), list(np.ravel(REST + DRAG))
values = array(data(deform), "JacobianDeterminant")
k = int(np.argmax((values <= 0).sum(axis=(1, 2))))
is_folded = values[k] <= 0
assert 0.02 < is_folded.mean() < 0.5

view = simple.CreateView("RenderView")
view.ViewSize = [340, 320]
view.OrientationAxesVisibility = 0
display = simple.Show(deform, view)
table = simple.GetColorTransferFunction("JacobianDeterminant")
# as the GUI does; `simple.ColorBy` would fit the table to the data
display.ColorArrayName, display.LookupTable = ["POINTS", "JacobianDeterminant"], table
display.SetRepresentationType("Slice")  # of a display without colors would fit a table, too
display.SliceMode, display.Slice = "XY Plane", k
np.testing.assert_allclose(table.RGBPoints, volume_colors.table().ravel(), atol=1e-6)

view.CameraParallelProjection = 1
simple.ResetCamera(view)
picture = screenshot(view, FOLDER / "folds_slice.png") / 255
background = picture[0, 0]
is_data = np.abs(picture - background).max(axis=-1) > 0.02
is_red = np.abs(picture - volume_colors.FOLDED).max(axis=-1) < 0.03
# cells at the border of a fold are partly red
assert abs(is_red.sum() / is_data.sum() - is_folded[:-1, :-1].mean()) < 0.03

# The range stays that of the table when the data change, and when the GUI colors a display.
deform.DeformedPoints = list(np.ravel(REST + 0.5 * DRAG))
simple.Render(view)
display.RescaleTransferFunctionToDataRange(True, False)
np.testing.assert_allclose(table.RGBPoints, volume_colors.table().ravel(), atol=1e-6)

# A line says so at the first update, and that material leaves the image; none if neither is true.
FOLDS = "the map folds; set Steps to 0, or drag less"
LEAVES = "of the material leaves the image; set Output Grid (advanced) to fitted"
SHIFT = np.full_like(REST, 0) + (9.0, 0.0, 0.0)
for grid, steps, drag, lines in (
    ("fitted", 1, 0.1 * DRAG, []),
    ("fitted", 1, DRAG, [FOLDS]),
    ("fitted", 0, DRAG, []),
    ("input", 1, SHIFT, [LEAVES]),
    ("fitted", 1, SHIFT, []),
):
    deform.OutputGrid, deform.Steps = grid, steps
    with output_messages() as messages:
        for factor in (1, 1.001):
            deform.DeformedPoints = list(np.ravel(REST + factor * drag))
            deform.UpdatePipeline()
    found = [line for line in messages[0].splitlines() if "MLSDeform: " in line]
    assert len(found) == len(lines), found
    assert all(map(str.endswith, found, lines)), found
