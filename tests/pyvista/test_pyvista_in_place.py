"""Changes of arrays in place are in the next result, also on devices that cache images."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
from control_point_sets import DEVICES

from vtk_mls import Deformation, Grid, Plane
from vtk_mls.vtk import arrays

pyvista = pytest.importorskip("pyvista", "0.48", reason="PyVista is not installed")
importlib.import_module("vtk_mls.pyvista")  # registers `mesh.mls`

pytestmark = [
    pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right"),
    pytest.mark.usefixtures("device_memory"),
]
REST = np.array([(0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)], float)
DEFORMED = REST + 0.3 * np.eye(4, 3)
CHANGES = {
    "add": lambda values: np.add(values, 100, out=values),
    "assign": lambda values: values.__setitem__(slice(None), 7),
    "fill": lambda values: values.fill(7),
    "view": lambda values: np.asarray(values).__setitem__(slice(5, None), 7),
}


def image():
    result = pyvista.ImageData(dimensions=(10, 10, 10))
    result["values"] = np.arange(1000.0)
    result.cell_data["cells"] = np.arange(729.0)
    return result


def deformed(data, **options):
    return data.mls.deform(REST, DEFORMED, device=DEVICES[0], **options)


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", ["values", "cells"])
@pytest.mark.parametrize("is_block", [False, True])
def test_values_of_images(change, name, is_block):
    data = image()
    dataset = pyvista.MultiBlock([data]) if is_block else data
    deformed(dataset, gradient_array="values")
    CHANGES[change](data[name])
    found = deformed(dataset, gradient_array="values")
    expected = deformed(data.copy(deep=True), gradient_array="values")
    for array in (name, "Gradient"):
        np.testing.assert_array_equal((found[0] if is_block else found)[array], expected[array])


def test_no_image_stays_on_the_device(device_memory):
    deformed(image())
    assert not device_memory._resident


@pytest.mark.parametrize("cuts", [(), Plane((0.1, 0, 0), (1, 0, 0))], ids=["whole", "cut"])
def test_points_and_cells_of_meshes(cuts):
    mesh = pyvista.Sphere(radius=5).cast_to_unstructured_grid()
    before = deformed(mesh, cuts=cuts)
    np.add(mesh.points, 1, out=np.asarray(mesh.points))
    connectivity = arrays.to_numpy(mesh.GetCells().GetConnectivityArray())
    connectivity[:3] = connectivity[30:33]
    found = deformed(mesh, cuts=cuts)
    assert found == deformed(mesh.copy(deep=True), cuts=cuts)
    assert found != before


def test_control_points_and_cuts():
    data, handles = image(), pyvista.PolyData(REST)
    handles["Displacement"] = DEFORMED - REST
    cut = pyvista.Plane(center=(4.2, 4, 4), direction=(1, 0, 0), i_size=30, j_size=30)

    def result_of(points, surface):
        return data.mls.deform(points, cuts=surface, device=DEVICES[0])

    before = result_of(handles, cut)
    np.multiply(handles["Displacement"], 2, out=np.asarray(handles["Displacement"]))
    np.add(cut.points, 1, out=np.asarray(cut.points))
    found = result_of(handles, cut)
    assert found == result_of(handles.copy(deep=True), cut.copy(deep=True))
    assert not np.array_equal(found["values"], before["values"])


def test_arrays_without_a_version_are_read_each_time():
    values, deformation = np.arange(1000.0).reshape(10, 10, 10), Deformation(REST, DEFORMED)
    grid = Grid((10, 10, 10))
    deformation.resample([values], grid)
    values += 100
    (found,) = deformation.resample([values], grid)
    (expected,) = deformation.resample([values.copy()], grid)
    np.testing.assert_array_equal(found, expected)


def test_an_editor_saves_values_as_they_are(tmp_path, opengl):
    data, plotter = image(), pyvista.Plotter(off_screen=True, window_size=(200, 200))
    edit = plotter.mls.edit(data, REST, DEFORMED, device=DEVICES[0])
    saved = []
    for folder in ("before", "after"):
        edit.save(tmp_path / folder)
        saved.append(pyvista.read(tmp_path / folder / "data-1-deformed.vti")["values"])
        data["values"].fill(7)
    plotter.close()
    assert not np.array_equal(*saved)
    assert set(np.unique(saved[1].round(3))) <= {0, 7}
