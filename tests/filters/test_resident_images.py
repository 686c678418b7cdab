"""On devices with a memory of their own images stay there from update to update."""

import numpy as np
import pytest
from control_point_sets import DEVICES
from mesh_fixtures import deforming
from pipelines import control_points, update, values_of
from vtk_fixtures import add_array, make_image
from vtkmodules.vtkCommonCore import VTK_FLOAT, VTK_SHORT

from vtk_mls import Deformation, Grid, Sampling

pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
GRID = Grid((9, 8, 7))
HANDLES = [(1, 2, 3), (7, 6, 5)], [(1.5, 2, 3), (7, 5.5, 5)]


@pytest.fixture
def uploads(device_memory, monkeypatch):
    """Sizes of the arrays of images that went to the device."""
    sizes = []

    def noted(method):
        def note(array, *options):
            if array.ndim >= 3:
                sizes.append(array.nbytes)
            return method(array, *options)

        return note

    for name in ("input_buffer", "argument", "constant"):
        monkeypatch.setattr(device_memory, name, noted(getattr(device_memory, name)))
    return sizes


def smooth_image():
    image = make_image()
    values = np.sin(np.arange(GRID.size) / 9)
    add_array(image.GetPointData(), "values", values, VTK_FLOAT)
    add_array(image.GetPointData(), "labels", np.round(9 * values), VTK_SHORT)
    return image


def dragged(image):
    handles = control_points(*HANDLES)
    return handles, deforming(image, handles, DEVICES[0])


def drag(handles, x):
    handles.SetDeformedPoints([(x, 2, 3), HANDLES[1][1]])


def test_a_drag_uploads_an_image_once(uploads):
    image = smooth_image()
    handles, deform = dragged(image)
    expected = []
    for x in (1.5, 1.7, 2.0):
        drag(handles, x)
        expected.append(values_of(update(deform), "values").copy())
    assert uploads == [4 * GRID.size, 2 * GRID.size]
    assert not np.array_equal(expected[0], expected[1])
    other_handles, other = dragged(image)
    drag(other_handles, 2.0)
    np.testing.assert_array_equal(values_of(update(other), "values"), expected[2])
    assert len(uploads) == 2


@pytest.mark.parametrize("who_tells", ["the array", "the image"])
def test_what_is_written_into_an_array_is_uploaded(who_tells, uploads):
    image = smooth_image()
    _, deform = dragged(image)
    before, count = values_of(update(deform), "values").copy(), len(uploads)
    values_of(image, "values")[...] += 1
    (image.GetPointData().GetArray("values") if who_tells == "the array" else image).Modified()
    assert not np.array_equal(values_of(update(deform), "values"), before)
    assert len(uploads) > count


def test_arrays_that_are_not_used_make_room(device_memory, monkeypatch, rng):
    deformation = Deformation(*HANDLES, device=DEVICES[0])
    images = [rng.normal(size=GRID.shape).astype(np.float32) for _ in range(4)]
    monkeypatch.setattr(device_memory, "limit", 2 * 2.5 * images[0].nbytes)
    expected = [deformation.resample([image], GRID)[0] for image in images]
    assert not device_memory._resident
    for _ in range(2):
        for version, image in enumerate(images):
            (found,) = deformation.resample([image], Sampling(GRID, versions=[version]))
            np.testing.assert_array_equal(found, expected[version])
            assert len(device_memory._resident) <= 2
    assert {version for version, *_ in device_memory._resident} == {2, 3}
