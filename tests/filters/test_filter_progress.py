"""What the filters report to VTK only grows, and an abort at any time leaves nothing."""

import numpy as np
import pytest
from mesh_fixtures import CUTS, cells, deforming
from pipelines import assert_same, content, control_points, update
from vtk_fixtures import add_array, make_image
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkMultiBlockDataSet

from vtk_mls import Deformation
from vtk_mls.base.messages import inform
from vtk_mls.filters import MLSDisplacementField

JACOBIAN = {"GenerateJacobian": True, "GenerateJacobianDeterminant": True}


def with_directions(data):
    """Scalars, vectors of both sorts and labels on points and cells."""
    for attributes, count in (
        (data.GetPointData(), data.GetNumberOfPoints()),
        (data.GetCellData(), data.GetNumberOfCells()),
    ):
        rng = np.random.default_rng(3)
        add_array(attributes, "values", rng.normal(size=count))
        add_array(attributes, "labels", rng.integers(0, 9, count))
        for name in ("slope", "flow"):
            add_array(attributes, name, rng.normal(size=(count, 3)), VTK_FLOAT)
    return data


def all_of(data, cut):
    """MLSDeform with all that takes time."""
    filter_ = deforming(
        with_directions(data),
        cut=cut,
        GradientArray="values",
        **JACOBIAN,
    )
    filter_.AddLabelArray("labels")
    filter_.AddGradientVectorArray("slope")
    filter_.AddPushForwardArray("flow")
    return filter_


FILTERS = {
    "image": lambda: all_of(make_image(), None),
    "cut image": lambda: all_of(make_image(), CUTS["half-plane"]),
    "mesh": lambda: all_of(cells(VTK_TETRA, 3), None),
    "cut mesh": lambda: all_of(cells(VTK_TETRA, 3), CUTS["half-plane"]),
    "field": lambda: deforming(make_image(), kind=MLSDisplacementField, **JACOBIAN),
    "inverse field": lambda: deforming(
        make_image(), kind=MLSDisplacementField, Inverse=True, **JACOBIAN
    ),
    "control points": control_points,
}


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch):
    monkeypatch.setattr("vtk_mls.queries.fields.MAX_SLAB_POINTS", 150)
    monkeypatch.setattr("vtk_mls.filters.displacement_field._CHUNK", 200)
    monkeypatch.setattr("vtk_mls.filters.warping._CHUNK", 30)


class Observer:
    """Notes what a filter reports in an execution, and aborts at the report of a number."""

    def __init__(self, filter_, last=None):
        self.last, self.told = last, []
        self.tag = filter_.AddObserver("ProgressEvent", self._hear)

    def _hear(self, filter_, _):
        self.told.append(filter_.GetProgress())
        if len(self.told) == self.last:
            filter_.SetAbortExecute(1)


@pytest.mark.parametrize("name", FILTERS)
def test_every_filter(name):
    update(FILTERS[name]())  # kernels are built, and the filter says so
    filter_ = FILTERS[name]()
    seen = Observer(filter_)
    expected = content(update(filter_))
    filter_.RemoveObserver(seen.tag)
    assert seen.told == sorted(seen.told)
    assert seen.told[0] == 0
    assert seen.told.index(1) == len(seen.told) - 1
    if name == "control points":  # made at once
        return
    assert len(set(seen.told)) >= 4
    for last in range(2, len(seen.told)):  # VTK itself says that it begins, and has done
        filter_ = FILTERS[name]()
        stopping = Observer(filter_, last)
        filter_.Update()
        assert stopping.told[:last] == seen.told[:last]
        assert set(stopping.told[last:]) <= {1}  # by VTK
        assert filter_.GetOutputDataObject(0).GetNumberOfPoints() == 0
        filter_.RemoveObserver(stopping.tag)
        filter_.SetAbortExecute(0)
    filter_.Modified()
    assert_same(update(filter_), expected)


@pytest.fixture
def in_blocks():
    """A filter on three images far from each other."""
    blocks = vtkMultiBlockDataSet()
    for number in range(3):
        blocks.SetBlock(number, make_image((4, 5, 6 + number), origin=(50 * number, 0, 0)))
    return deforming(blocks, GenerateJacobian=True)


def test_blocks_share_the_progress(in_blocks):
    update(in_blocks)
    in_blocks.Modified()
    seen = Observer(in_blocks)
    update(in_blocks)
    assert seen.told == sorted(seen.told)
    assert len(set(seen.told)) > 6
    assert seen.told[-1] == 1  # VTK says so, of the last block and of all


def test_a_sentence_does_not_change_the_progress(in_blocks, monkeypatch):
    asked = Deformation.jacobian_field

    def jacobian_field(*arguments):
        inform("Building kernels ...")
        return asked(*arguments)

    monkeypatch.setattr(Deformation, "jacobian_field", jacobian_field)
    seen = Observer(in_blocks)
    update(in_blocks)
    assert seen.told == sorted(seen.told)
    assert seen.told[-1] == 1
