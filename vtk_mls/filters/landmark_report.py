"""The report on pairs of landmarks, as tables."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkTable
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from vtk_mls.base.errors import InputError
from vtk_mls.filters import property_tables
from vtk_mls.filters.algorithm import Algorithm, inputs
from vtk_mls.filters.map_inputs import control_point_arrays
from vtk_mls.filters.properties import with_properties
from vtk_mls.landmarks import report, text
from vtk_mls.landmarks.left_out import BASELINE
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import LABEL

_NAMES = {
    ("rest", "deformed"): "`Input`",
    "rest": "p of `Input`",
    "deformed": "q of `Input`",
    "ControlPoints": "`Input`",
}


@with_properties(property_tables.LANDMARK_REPORT)
class MLSLandmarkReport(Algorithm):
    """Predicts each pair of landmarks from the others, as `vtk_mls.landmarks.report`.

    Input port 0 takes control points, as port 1 of MLSDeform: points p with the point vectors
    "Displacement", q - p, and perhaps "Weight" and "Label". SetInputArrayToProcess names other
    arrays in the same way. Port 1 (optional) takes the same points, moved, which are q then.

    Output port 0 is a vtkTable with a row for each pair: "Name", "Rest" and "Deformed" (p and q),
    "Moved" (the distance from p to q), "Error" (when left out), "Outlier" (0 or 1) and
    "SwappedWith" (the name of another pair, or ""). Its field data have "Recommended", the options
    of the settings to take, "SmallestDeterminant" of the map with these, and "Summary", sentences.

    Output port 1 is a vtkTable with a row for each setting that was tried, the best first: "Kind",
    "Degree" and "Order" (0 for kinds without), "Alpha", "Smoothing", "Softening", "Median" (the
    median error), "Options" and "Recommended" (0 or 1). The last two are one rigid and one affine
    map for all.
    """

    def __init__(self):
        super().__init__(
            nInputPorts=2, inputType="vtkPointSet", nOutputPorts=2, outputType="vtkTable"
        )

    def FillInputPortInformation(self, port, info):
        for name in ("vtkPointSet", "vtkCompositeDataSet"):  # the second is refused
            info.Append(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), name)
        if port == 1:
            info.Set(vtkAlgorithm.INPUT_IS_OPTIONAL(), 1)
        return 1

    def SetInputData(self, *port_and_data):
        """`(data)` for port 0 or `(port, data)`: input that no algorithm makes."""
        self.SetInputDataObject(*port_and_data)

    def DisconnectDeformedControlPoints(self):
        """Remove the input from port 1: positions q are those of displacements again."""
        self.RemoveAllInputConnections(1)

    def RequestData(self, request, inInfo, outInfo):
        (points,), moved = inputs(inInfo, 0), inputs(inInfo, 1)
        for data in (points, *moved):
            if isinstance(data, vtkCompositeDataSet):
                raise ValueError(
                    f"`Input` must be one point set, got a {data.GetClassName()}; merge its blocks "
                    "first (in ParaView Merge Blocks)"
                )

        def fill(progress):
            try:
                chosen = control_point_arrays(self, points)
                p, q, weights = arrays.control_points(points, *chosen, *moved)
                labels = arrays.texts(points.GetPointData(), LABEL)
                names = [label or str(i + 1) for i, label in enumerate(labels)] or None
                device = self.GetDevice() or None
                result = report(p, q, names, weights=weights, device=device, progress=progress)
            except InputError as error:
                raise error.renamed(_NAMES) from error
            fill_pairs(vtkTable.GetData(outInfo, 0), result)
            fill_settings(vtkTable.GetData(outInfo, 1), result)

        self._run([fill])
        return 1


def fill_pairs(table, result):
    """Fill a vtkTable with the pairs of a Report."""
    rows, field = table.GetRowData(), table.GetFieldData()
    swapped = ["" if i < 0 else result.names[i] for i in result.swapped_with]
    arrays.add_texts(rows, "Name", result.names)
    for name in ("Rest", "Deformed", "Moved", "Error", "Outlier"):
        arrays.add(rows, name, getattr(result, name.lower()))
    arrays.add_texts(rows, "SwappedWith", swapped)
    arrays.add_texts(field, "Recommended", [result.recommended.flags])
    arrays.add(field, "SmallestDeterminant", result.smallest_determinant)
    arrays.add_texts(field, "Summary", text.heading(result))


def fill_settings(table, result):
    """Fill a vtkTable with the settings that a Report has tried, the best first."""
    rows = table.GetRowData()
    medians = {**result.tried, **{BASELINE[name]: value for name, value in result.baseline.items()}}
    settings = [*medians]
    arrays.add_texts(rows, "Kind", [s.kind for s in settings])
    for name in ("Degree", "Order"):
        values = [getattr(s, name.lower()) or 0 for s in settings]
        arrays.add(rows, name, np.array(values, np.int64))
    for name in ("Alpha", "Smoothing", "Softening"):
        arrays.add(rows, name, np.array([getattr(s, name.lower()) for s in settings], float))
    arrays.add(rows, "Median", np.array([medians[s] for s in settings], float))
    arrays.add_texts(rows, "Options", [s.flags for s in settings])
    arrays.add(rows, "Recommended", np.array([s == result.recommended for s in settings]))
