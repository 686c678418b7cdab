"""Handles with a shape, written and read again."""

import json

import numpy as np
import pytest
from handle_surfaces import ball, displaced, positions
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkIOLegacy import vtkPolyDataReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

from vtk_mls import Ball, CurveHandle, RegionHandle, Solid, io
from vtk_mls.files import metadata
from vtk_mls.vtk.cells import connectivity_of
from vtk_mls.vtk.control_point_polydata import fill_polydata, path_of
from vtk_mls.vtk.objects import output_of

TURN = np.array([[0, -1, 0, 3], [1, 0, 0, 0], [0, 0, 1, -2], [0, 0, 0, 1]], float)


def solid(center):
    surface = ball(center)
    return Solid(positions(surface), connectivity_of(surface.GetPolys())[0].reshape(-1, 3))


@pytest.mark.parametrize("name", ["handles.vtp", "handles.vtk"])
def test_all_shapes_come_back(tmp_path, rng, name):
    rest, deformed = rng.normal(size=(2, 5, 3))
    weights = rng.uniform(1, 2, 5)
    curves = [CurveHandle(*rng.normal(size=(2, count, 3))) for count in (2, 6)]
    regions = [RegionHandle(solid((0, 0, 0)), TURN), RegionHandle(solid((5, 0, 0)), np.eye(4))]
    io.write_handles(tmp_path / name, rest, deformed, weights, [*curves, *regions])
    p, q, factors, handles = io.read_handles(tmp_path / name)
    np.testing.assert_array_equal(p, rest)
    np.testing.assert_allclose(q, deformed, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(factors, weights)
    assert [type(handle) for handle in handles] == [CurveHandle] * 2 + [RegionHandle] * 2
    for curve, found in zip(curves, handles):
        np.testing.assert_array_equal(found.rest, curve.rest)
        np.testing.assert_allclose(found.deformed, curve.deformed, rtol=0, atol=1e-15)
    for region, found in zip(regions, handles[2:]):
        np.testing.assert_array_equal(found.shape.points, region.shape.points)
        np.testing.assert_array_equal(found.shape.triangles, region.shape.triangles)
        np.testing.assert_allclose(found.motion, region.motion, atol=1e-13)


@pytest.mark.parametrize("ending", [".vtp", ".vtk"])
@pytest.mark.parametrize("space", ["", "LPS", "RAS"])
def test_a_path_comes_back(tmp_path, rng, ending, space):
    rest, deformed, *path = rng.normal(size=(5, 5, 3))
    curve = CurveHandle(*rng.normal(size=(2, 4, 3)))
    name = tmp_path / f"handles{ending}"
    io.write_handles(name, rest, deformed, handles=[curve], between=path)
    polydata = io.read_dataset(name)
    if space:
        metadata.store(polydata, metadata.FILE_SPACE, [space])
        io.write_dataset(polydata, name)
    reader = vtkXMLPolyDataReader() if ending == ".vtp" else vtkPolyDataReader()
    raw = output_of(reader, FileName=str(name))
    array = vtk_to_numpy(raw.GetPointData().GetArray("Path"))
    signs = np.tile([-1, -1, 1], 3) if space == "RAS" else 1
    np.testing.assert_allclose(array[:5], np.hstack(path - rest) * signs, atol=1e-14)
    np.testing.assert_array_equal(array[5:], 0)
    found = path_of(io.read_control_points(name))
    np.testing.assert_allclose(found[:, :5], path, atol=1e-14)


def test_a_path_in_the_frame_of_the_caller(tmp_path, rng):
    rest, deformed, *path = rng.normal(size=(5, 5, 3))
    polydata = vtkPolyData()
    fill_polydata(polydata, rest, deformed, None, path=path)
    io.write_dataset(polydata, tmp_path / "handles.vtp")
    found = path_of(io.read_control_points(tmp_path / "handles.vtp", space="RAS"))
    np.testing.assert_allclose(found, path * np.array([-1, -1, 1]), atol=1e-14)


def test_points_alone(tmp_path, rng):
    rest, deformed = rng.normal(size=(2, 5, 3))
    io.write_handles(tmp_path / "handles.vtp", rest, deformed)
    p, q, factors, handles = io.read_handles(tmp_path / "handles.vtp", space="RAS")  # it says LPS
    np.testing.assert_array_equal(p, rest)
    np.testing.assert_allclose(q, deformed, rtol=0, atol=1e-15)
    assert (factors, handles) == (None, [])


def test_markups_of_several_kinds(tmp_path):
    """Points that are not placed are left out of their curve."""
    places = [[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 0, 0]]

    def markups(kind, nodes, **more):
        points = [{"label": f"{kind}{i}", "position": node} for i, node in enumerate(nodes)]
        points[1] |= more
        return {"type": kind, "coordinateSystem": "RAS", "controlPoints": points}

    lists = [
        markups("Curve", places, positionStatus="undefined"),
        markups("Fiducial", places[:2]),
        markups("Line", places[1:3]),
    ]
    path = tmp_path / "all.mrk.json"
    path.write_text(json.dumps({"markups": lists}))
    rest, _, _, (curve,) = io.read_handles(path)
    ras = np.array([-1, -1, 1])
    np.testing.assert_array_equal(curve.rest, np.array(places)[[0, 2, 3]] * ras)
    np.testing.assert_array_equal(rest, np.array(places)[[0, 1, 1, 2]] * ras)


def test_bad_files(tmp_path):
    path = tmp_path / "handles.vtp"
    with pytest.raises(ValueError, match="`handles` must be curves and regions with the shape Sol"):
        io.write_handles(path, handles=[RegionHandle(Ball((0, 0, 0), 1), TURN)])
    with pytest.raises(ValueError, match="same number of points, got 1 and 2"):
        io.write_handles(path, np.zeros((1, 3)), np.zeros((2, 3)))
    with pytest.raises(ValueError, match="`between` must be finite numbers of shape"):
        io.write_handles(path, np.zeros((1, 3)), np.zeros((1, 3)), between=np.zeros((2, 3)))
    with pytest.raises(TypeError, match="`handles` must be CurveHandle or RegionHandle, got 3"):
        io.write_handles(path, handles=[3])
    for name in ("handles.stl", "handles.vti"):
        with pytest.raises(ValueError, match=f"cannot write handles to .*{name}.*: its name must"):
            io.write_handles(tmp_path / name, np.zeros((1, 3)), np.zeros((1, 3)))
    assert not [*tmp_path.iterdir()]
    surface = ball((0, 0, 0))
    io.write_dataset(displaced(surface, positions(surface)), path)
    with pytest.raises(ValueError, match="handles.vtp.*surface 0, is no rigid region"):
        io.read_handles(path)
