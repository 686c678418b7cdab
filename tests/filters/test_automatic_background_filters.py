"""AutomaticBackground of MLSDeform: arrays, pieces and times."""

import numpy as np
import pytest
from mesh_fixtures import array_of, deforming
from pipelines import Source, control_points, update, values_of
from vtk_fixtures import add_array, make_image
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkFiltersCore import vtkPointDataToCellData
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import output_of

FAR = control_points([(0, 0, 0)], [(1000, 0, 0)])


def lower_median(values):
    """By numpy, of values (nz, ny, nx[, components]) at the corners."""
    corners = values[:: len(values) - 1, :: values.shape[1] - 1, :: values.shape[2] - 1]
    return np.nanpercentile(corners.reshape(8, *values.shape[3:]), 50, axis=0, method="lower")


@pytest.fixture
def image(rng):
    image = make_image()
    points, cells = image.GetPointData(), image.GetCellData()
    add_array(points, "ct", rng.integers(-1024, 3000, 504).astype(np.int16))
    add_array(points, "float", np.where(np.arange(504) == 0, np.nan, rng.uniform(1, 9, 504)))
    add_array(points, "rgb", rng.integers(0, 256, (504, 3)), VTK_UNSIGNED_CHAR)
    add_array(points, "labels", rng.integers(1, 9, 504))
    add_array(points, arrays.GHOSTS, np.zeros(504), VTK_UNSIGNED_CHAR)
    add_array(cells, "of cells", rng.integers(1, 99, 336))
    return image


def test_each_array_has_the_median_of_its_corners(image):
    deform = deforming(image, FAR, "reference")
    deform.AddLabelArray("labels")
    deform.SetBackground(7)
    names = "ct", "float", "rgb", "labels", arrays.GHOSTS
    assert [values_of(update(deform), name).flat[0] for name in names] == [7, 7, 7, 7, 0]
    output = output_of(deform, AutomaticBackground=1)
    for name in names[:3]:
        expected = lower_median(values_of(image, name))
        assert (values_of(output, name) == expected).all(), name
    assert not values_of(output, "labels").any()
    assert not values_of(output, arrays.GHOSTS).any()
    cells = arrays.to_numpy(image.GetCellData().GetArray("of cells")).reshape(6, 7, 8)
    moved = arrays.to_numpy(output.GetCellData().GetArray("of cells"))
    assert (moved == lower_median(cells)).all()
    assert deform.used_backgrounds >= {("ct", lower_median(values_of(image, "ct")))}
    assert (values_of(output_of(deform, AutomaticBackground=0), "ct") == 7).all()


def test_pieces_have_the_background_of_the_whole():
    source, cells = vtkRTAnalyticSource(), vtkPointDataToCellData()
    source.SetWholeExtent(-6, 6, -5, 5, -4, 4)
    cells.SetInputConnection(source.GetOutputPort())
    cells.PassPointDataOn()
    handles = control_points([(0, 0, 0), (5, 5, 4)], [(4, 0, 0), (9, 5, 4)])
    deform = deforming(cells, handles, "reference", AutomaticBackground=1)
    whole = values_of(update(deform), "RTData").copy()
    of_cells = array_of(deform.GetOutput(), "RTData", "Cell").reshape(8, 10, 12)
    assert whole[0, 0, 0] == lower_median(values_of(cells.GetOutput(), "RTData"))
    source.Modified()
    assert deform.UpdateExtent((-6, -2, -1, 3, -4, 0))
    assert source.GetOutput().GetNumberOfPoints() < whole.size / 4
    part = deform.GetOutput()
    np.testing.assert_array_equal(values_of(part, "RTData"), whole[:5, 4:9, :5])
    part = array_of(part, "RTData", "Cell").reshape(4, 4, 4)
    np.testing.assert_array_equal(part, of_cells[:4, 4:8, :4])


def test_all_times_have_the_background_of_the_first():
    def fill(output, time):
        output.ShallowCopy(make_image())
        add_array(output.GetPointData(), "values", np.full(504, 100 * time))

    source = Source(fill, (1.0, 2.0, 3.0), output_type="vtkImageData")
    handles = control_points([(0, 0, 0)], [(6.0, 0, 0)])
    deform = deforming(source, handles, "reference", AutomaticBackground=1)
    for time in (3.0, 1.0, 2.0):
        deform.UpdateTimeStep(time)
        assert {*values_of(deform.GetOutput(), "values").flat} == {100, 100 * time}
