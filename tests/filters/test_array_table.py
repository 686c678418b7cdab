"""The filters write the arrays of the table, all of them and no others."""

from __future__ import annotations

import importlib.util
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from mesh_fixtures import mixed, rectilinear, structured
from pipelines import ball, connect, control_points, update
from vtk_fixtures import FAST, add_array, make_image

from vtk_mls import Plane
from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.filters.derived_arrays import CAN_HIDE_CELLS
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

_PATH = Path(__file__).parents[2] / "docs/array_table.py"
_SPECIFICATION = importlib.util.spec_from_file_location("array_table", _PATH)
table = importlib.util.module_from_spec(_SPECIFICATION)
_SPECIFICATION.loader.exec_module(table)
IMAGE, MESH, MAP = table.IMAGE, table.MESH, table.MAP
CONTROL_POINTS, ARROWS = table.CONTROL_POINTS, table.ARROWS
CUT = Plane((4.2, 4.1, 3.3), (1, 0, 0))
KINDS = {
    table.POINTS: "GetPointData",
    table.CELLS: "GetCellData",
    table.FIELD: "GetFieldData",
}
SWITCHES = "GenerateOverlap", "GenerateJacobian", "GenerateJacobianDeterminant"
DEFORM_SWITCHES = (*SWITCHES, "GenerateCellQuality", "GenerateLargestBlend")


def names(dataset):
    """(kind of data, name, values as of the table) of the arrays of a dataset."""
    data = {kind: getattr(dataset, get)() for kind, get in KINDS.items()}
    return {
        (kind, array.GetName(), values(array))
        for kind, each in data.items()
        for array in map(each.GetAbstractArray, range(each.GetNumberOfArrays()))
    }


def values(array):
    """Type and number of values; flags are bytes."""
    if array.IsA("vtkStringArray"):
        return "text"
    dtype = arrays.to_numpy(array).dtype
    return "bytes" if dtype == np.uint8 else f"{array.GetNumberOfComponents()} {dtype}"


def told_values(each):
    """The same of a line of the table."""
    is_flag = each.values in ("0 or 1", "flags of VTK")
    return "bytes" if is_flag else each.values.partition(",")[0]


def written(algorithm, dataset, cut, **properties):
    """The arrays that a filter adds."""
    connect(algorithm, dataset, control_points())
    if cut:
        algorithm.AddCut(CUT)
    configured(algorithm, Device=FAST, **properties)
    return names(update(algorithm)) - names(dataset)


def switched(names=DEFORM_SWITCHES):
    return {"Steps": 0, **dict.fromkeys(names, True)}


def image():
    image = make_image((4, 3, 3), spacing=(2.7, 3.5, 3.3))
    add_array(image.GetPointData(), "values", np.arange(image.GetNumberOfPoints()) % 17)
    return image


def small_ball():
    return ball((4, 4, 3), 2.4, 8)


def of_all(kind, datasets, switches, flag, **always):
    """The arrays that a filter adds with and without a cut, the switches and a flag."""
    ways = product(datasets, (False, True), ({}, switches), (False, True))
    return set().union(
        *(
            written(kind(), dataset, cut, **on, **{flag: is_on}, **always)
            for dataset, cut, on, is_on in ways
        )
    )


def of_image():
    switches = {**switched(), "GradientArray": "values"}
    return of_all(MLSDeform, [image()], switches, "HideVoid")


def of_mesh():
    meshes = mixed(), rectilinear(), small_ball(), structured()
    return of_all(MLSDeform, meshes, switched(), "SplitCells")


def of_map():
    datasets, size = (image(), small_ball()), {"SampleDimensions": (4, 4, 4)}
    return of_all(MLSDisplacementField, datasets, switched(SWITCHES), "Inverse", **size)


def of_port(port, folder):
    markups = folder / "points.fcsv"
    markups.write_text("# CoordinateSystem = LPS\n# columns = id,x,y,z,label\na,1,2,3,tip\n")
    listed = control_points(weights=np.ones(8))
    read = configured(MLSControlPoints(), Mode="file", FileName=str(markups))
    outputs = []
    for algorithm in (listed, read):
        update(algorithm)
        outputs.append(algorithm.GetOutputDataObject(port))
    return set().union(*map(names, outputs))


@pytest.mark.parametrize(
    "writer", [pytest.param(IMAGE, marks=pytest.mark.matrix), MESH, MAP, CONTROL_POINTS, ARROWS]
)
def test_written_files_match_the_table(writer, tmp_path):
    find = {IMAGE: of_image, MESH: of_mesh, MAP: of_map}
    find |= {CONTROL_POINTS: partial(of_port, 0, tmp_path), ARROWS: partial(of_port, 1, tmp_path)}
    told = {(row.of, row.name, told_values(row)) for row in table.TABLE if writer in row.writers}
    if writer == IMAGE and not CAN_HIDE_CELLS:
        told.remove((table.CELLS, arrays.GHOSTS, "bytes"))
    assert find[writer]() == told
