"""Bad input: one sentence, an empty output, 0 from Update; mended, the same object works."""

import numpy as np
import pytest
from mesh_fixtures import deforming, explicit_structured
from pipelines import Executions, assert_fails, connect, control_points, update
from vtk_fixtures import DEFORMED, REST, add_array, polydata_of
from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING, vtkObject
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPolyData,
)
from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.vtk.objects import configured

POINTS = vtkDataObject.FIELD_ASSOCIATION_POINTS


class Scene:
    """A filter with an image source and control points, all of them good."""

    def __init__(self, kind):
        self.source, self.handles = vtkRTAnalyticSource(), control_points()
        self.source.SetWholeExtent(0, 5, 0, 4, 0, 3)
        self.deforming = configured(kind(), Device="reference")
        connect(self.deforming, self.source, self.handles)

    def feed(self, **point_arrays):
        """Give control points as data."""
        polydata = polydata_of(REST)
        for name, values in point_arrays.items():
            add_array(polydata.GetPointData(), name, values)
        self.deforming.SetInputDataObject(1, polydata)

    def cut(self, surface):
        self.deforming.SetInputDataObject(2, surface)

    def use(self, index, name):
        self.deforming.SetInputArrayToProcess(index, 1, 0, POINTS, name)


SLIVER = polydata_of([(0, 0, 0), (1, 0, 0), (2, 0, 0)], Polys=[(0, 1, 2)])
MOVE = DEFORMED - REST
NAN = np.where(np.arange(24).reshape(8, 3) == 4, np.nan, MOVE)
INF = np.where(np.arange(8) == 3, np.inf, 1.0)


def sets(of="deforming", **properties):
    """A function that sets properties of the filter or of the source of a scene."""
    return lambda scene: configured(getattr(scene, of), **properties)


# What is broken, and what the sentence says. Tests of the core have all wrong options.
BOTH = {
    "unknown kind": (sets(Kind="elastic"), "`kind`.*rigid.*elastic"),
    "alpha 0": (sets(Alpha=0), "`alpha` must be .*positive.* 0"),
    "no device": (sets(Device="77:0"), "no OpenCL device `77:0`"),
    "no handles": (lambda s: s.deforming.SetInputDataObject(1, vtkPolyData()), "has no points"),
    "no array": (lambda s: s.feed(Weight=INF), "no numeric point array `Displacement`.*`Weight`"),
    "array named wrongly": (lambda s: s.use(0, "Moved"), "array `Moved`; it has `Displacement`"),
    "no such weight": (lambda s: s.use(1, "Mass"), "array `Mass`; it has `Displacement`"),
    "flat vectors": (lambda s: s.feed(Displacement=MOVE[:, :2]), "must have 3 components, got 2"),
    "few vectors": (lambda s: s.feed(Displacement=MOVE[:5]), "one tuple per point, got 5 for 8"),
    "NaN": (lambda s: s.feed(Displacement=NAN), "`deformed` must be finite.*nan.* row 1"),
    "weight 0": (lambda s: s.feed(Displacement=MOVE, Weight=np.arange(8)), "positive, got 0"),
    "weight vectors": (
        lambda s: s.feed(Displacement=MOVE, Weight=MOVE),
        "must have 1 component, got 3",
    ),
    "empty image": (lambda s: s.deforming.SetInputDataObject(0, vtkImageData()), "empty image"),
    "uneven handles": (lambda s: s.handles.SetDeformedPoints(REST[:3]), "8 rest points, got 3"),
    "uneven weights": (lambda s: s.handles.SetWeights([1, 2]), "`Weights` .*8 rest.*got 2"),
    "ragged points": (lambda s: s.handles.SetRestPoints([(1, 2)]), "`RestPoints` must be rows of"),
    "unknown mode": (lambda s: s.handles.SetMode("random"), "`Mode` must be .*random"),
    "empty lattice": (
        sets("handles", Mode="lattice", LatticeDimensions=(2, 0, 1)),
        r"`LatticeDimensions` .*\(2, 0, 1\)",
    ),
    "lattice inside out": (
        sets("handles", Mode="lattice", Bounds=(1, -1, 0, 1, 0, 1)),
        "`Bounds` must be",
    ),
    "nu 1": (sets(Nu=1), "`nu` must be a number above 1, got 1"),
    "zero normal": (sets(CutType="plane", CutNormal=(0, 0, 0)), "`CutNormal` must not be zero"),
    "parallel": (sets(CutType="half-plane", CutInward=(2, 0, 0)), "`CutInward`.*not be parallel"),
    "not a frame": (sets(CutFrame="x"), "`CutFrame` must be one of.* got 'x'"),
    "not a type": (sets(CutType="disk"), "`CutType` .* none, plane.*'disk'"),
    "no cut": (lambda s: s.deforming.AddCut("x"), "`cuts` must be Plane, HalfPlane or Surface"),
    "no face": (lambda s: s.deforming.AddConstraint("x"), "`constraints` must be"),
    "no surface": (lambda s: s.cut(vtkPolyData()), "`Cuts` has no surface"),
    "sliver": (lambda s: s.cut(SLIVER), "`Cuts` has no usable surface.*area"),
    "no shapes": (sets(HandleShapes="lines"), "`HandleShapes` must be .* points, cells, .*'lines'"),
    **{
        f"blend {blend}": (sets(Blend=blend), f"`Blend` must be a (finite )?number, got {blend!r}")
        for blend in (np.nan, np.inf, "half", None)
    },
    "steps": (sets(Steps=1000), "`steps` must be an integer from 1 to 256"),
    "no file": (sets(InitialTransform="no.nrrd"), "`InitialTransform`: there is no file `no.nrrd`"),
    "no transform": (
        sets(InitialTransform=3),
        "`InitialTransform` must be the path of a file, or an Affine, .* got 3",
    ),
}
DEFORM = {
    "unknown void": (sets(VoidValues="full"), "`VoidValues`.*'full'"),
    "unknown interpolation": (sets(Interpolation="sharp"), "linear.*sharp"),
    "unknown grid": (sets(OutputGrid="own"), "`OutputGrid` .*fitted.*own"),
    "background of text": (sets(Background="air"), "`background` .*air"),
    "no background": (sets(Background=None), "`background` must be a number, got None"),
    "no scalars": (sets(GradientArray="x"), "`GradientArray`.*`x`.*`RTData`"),
    "no vectors": (lambda s: s.deforming.AddGradientVectorArray("x"), "VectorArrays` names `x`"),
    "flat": (lambda s: s.deforming.AddGradientVectorArray("RTData"), "`RTData`.*3 comp.*got 1"),
    "no such label": (lambda s: s.deforming.AddLabelArray("Bone"), "`Bone`.*it has `RTData`"),
    "no dimensions": (
        sets(OutputGrid="given", OutputDimensions=(3, 0, 3)),
        r"`OutputDimensions` must be three positive integers .*\(3, 0, 3\)",
    ),
    "no spacing": (sets(OutputGrid="given", OutputSpacing=(1, 0, 1)), "`OutputSpacing` must not"),
    "no fit": (sets(OutputGrid="fitted", Alpha=-2), "`alpha` must be .*-2"),
    "nothing to fit": (
        lambda s: (s.deforming.SetOutputGrid("fitted"), s.handles.SetDeformedPoints(REST[:3])),
        "8 rest points, got 3",
    ),
    "no device to fit": (sets(OutputGrid="fitted", Device="77:0"), "no OpenCL device `77:0`"),
    "a file as reference": (
        sets(Reference="a.nii"),
        "`Reference` must be a vtkImageData or a `vtk_mls.Grid`, got 'a.nii'",
    ),
    "an empty reference": (sets(Reference=vtkImageData()), "`Reference` is an empty image"),
}
FIELD = {
    "empty mesh": (lambda s: s.deforming.SetInputDataObject(0, vtkPolyData()), "`Input` is empty"),
    "no samples": (
        lambda s: (
            s.deforming.SetInputDataObject(0, update(vtkSphereSource())),
            s.deforming.SetSampleDimensions(0, 1, 2),
        ),
        r"`SampleDimensions` must be .*\(0, 1, 2\)",
    ),
}
CASES = [
    pytest.param(kind, *case, id=f"{kind.__name__}-{name}")
    for kind, cases in ((MLSDeform, {**BOTH, **DEFORM}), (MLSDisplacementField, {**BOTH, **FIELD}))
    for name, case in cases.items()
]


def mend(scene):
    """Set every property and input to what is good, on the same filter."""
    for algorithm in (scene.handles, scene.deforming):
        for prop in algorithm.PROPERTIES:
            prop.assign(algorithm, prop.default)
    configured(scene.handles, RestPoints=REST, DeformedPoints=DEFORMED)
    configured(scene.deforming, Device="reference").DisconnectCuts()
    scene.source.Modified()
    connect(scene.deforming, scene.source, scene.handles)
    scene.use(0, "Displacement")
    scene.use(1, "Weight")


@pytest.mark.parametrize("after_a_success", [False, True], ids=["at once", "later"])
@pytest.mark.parametrize(("kind", "spoil", "sentence"), CASES)
def test_bad_input(kind, spoil, sentence, after_a_success, messages):
    scene = Scene(kind)
    deforming = scene.deforming
    if after_a_success:
        assert update(deforming).GetNumberOfPoints() == 120
    spoil(scene)
    for _ in range(2):  # it stays an error until it is mended
        assert_fails(deforming, messages, rf"^ERROR: MLS\w+: .*{sentence}")
        assert deforming.GetOutputDataObject(0).GetPointData().GetNumberOfArrays() == 0
    mend(scene)
    assert update(deforming).GetNumberOfPoints() == 120
    runs = Executions(deforming)
    update(deforming)
    assert runs.count == 0


@pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField, MLSControlPoints])
def test_observers_hear_the_sentence_once(kind):
    heard = []

    @calldata_type(VTK_STRING)
    def hear(caller, event, text):
        heard.append(text)

    if kind is MLSControlPoints:
        algorithm = configured(kind(), Mode="random")
    else:
        algorithm = configured(Scene(kind).deforming, Kind="elastic")
    algorithm.AddObserver("ErrorEvent", hear)
    algorithm.Update()
    assert len(heard) == 1
    assert heard[0].startswith(f"{kind.__name__}: `")
    assert heard[0].count("\n") == 0


def test_the_executive_may_still_report_its_own(messages):
    scene = Scene(MLSDeform)
    scene.deforming.SetAlpha(-1)
    scene.deforming.Update()
    messages.take()
    scene.deforming.SetInputConnection(0, None)
    scene.deforming.Update()
    assert "Input port 0" in messages.take()


def test_no_output_when_vtk_is_silent(messages):
    scene = Scene(MLSDeform)
    scene.deforming.SetAlpha(-1)
    vtkObject.SetGlobalWarningDisplay(0)
    try:
        assert not scene.deforming.GetExecutive().Update()
    finally:
        vtkObject.SetGlobalWarningDisplay(1)
    assert messages.take() == ""


def test_the_environment_names_the_device(monkeypatch, messages, coarse_fits):
    monkeypatch.setenv("VTK_MLS_DEVICE", "77:0")
    for choice in ("input", "fitted"):
        deforming = configured(Scene(MLSDeform).deforming, Device="", OutputGrid=choice)
        assert_fails(deforming, messages, "no OpenCL device `77:0`")
        monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
        # nothing in the pipeline has changed, and yet it works now
        assert update(deforming).GetNumberOfPoints() >= 120
        monkeypatch.setenv("VTK_MLS_DEVICE", "77:0")


def test_blocks_of_one_execution_report_once(messages):
    scene, blocks = Scene(MLSDeform), vtkMultiBlockDataSet()
    for number, cells in enumerate((1, 2, 3)):
        source = vtkRTAnalyticSource()
        source.SetWholeExtent(0, cells, 0, 4, 0, 3)
        blocks.SetBlock(number, update(source))
    scene.deforming.SetInputDataObject(0, blocks)
    for alpha in (-1, -2, -2):  # blocks that failed are tried again
        scene.deforming.SetAlpha(alpha)
        scene.deforming.Update()
        messages.assert_one(f"^ERROR: MLSDeform: `alpha` must be .*{alpha}")
        assert scene.deforming.GetOutputDataObject(0).GetNumberOfPoints() == 0
    scene.deforming.SetAlpha(1)
    assert update(scene.deforming).GetNumberOfPoints() == 180
    messages.assert_one("what crosses a border between them is lost")


def test_downstream_sees_the_failure(messages):
    scene = Scene(MLSDeform)
    contour = vtkContourFilter()
    contour.SetInputConnection(scene.deforming.GetOutputPort())
    contour.SetValue(0, 150)
    assert update(contour).GetNumberOfPoints() > 0
    scene.deforming.SetAlpha(-1)
    assert not contour.GetExecutive().Update()
    messages.assert_one("`alpha`")
    scene.deforming.SetAlpha(1)
    assert update(contour).GetNumberOfPoints() > 0


def test_an_error_on_an_explicit_grid_leaves_no_random_extent(messages):
    """VTK does not initialize the extent of a new vtkExplicitStructuredGrid."""
    grid, extents = explicit_structured(), set()
    for _ in range(20):
        filter_ = deforming(grid, Alpha=-1.0)
        junk = [np.full(count, 77777, np.int32) for count in range(100, 300)]
        del junk
        assert_fails(filter_, messages, "`alpha`")
        extents.add(filter_.GetOutputDataObject(0).GetExtent())
    assert extents == {(0, -1, 0, -1, 0, -1)}
