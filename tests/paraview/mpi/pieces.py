"""The pieces of all processes together equal the result of one process.

For `mpirun -np N pvbatch --symmetric`.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
from scene import DEFORMED, REST, array, output_messages
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import (
    vtkAlgorithm,
    vtkStreamingDemandDrivenPipeline,
    vtkTrivialProducer,
)
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
from vtkmodules.vtkParallelCore import vtkMultiProcessController

import vtk_mls
from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.filters.algorithm import Algorithm
from vtk_mls.filters.map_inputs import surfaces
from vtk_mls.filters.parallel import all_gather
from vtk_mls.vtk.objects import configured, output_of

controller = vtkMultiProcessController.GetGlobalController()
RANK, SIZE = controller.GetLocalProcessId(), controller.GetNumberOfProcesses()
ARRAYS = ("RTData", "Void", "VoidDistance", "Gradient", "Jacobian", "BackwardDisplacement")


def source(extent=(-9, 8, -8, 8, -7, 9)):
    wavelet = vtkRTAnalyticSource()
    wavelet.SetWholeExtent(*extent)
    return wavelet


def tetrahedra():
    image, cells = source(), vtkDataSetTriangleFilter()
    cells.SetInputConnection(image.GetOutputPort())
    return cells


class Corners(Algorithm):
    """The moving corners of `source()`, shared among all processes but the last, which may fail."""

    fails = False

    def __init__(self):
        super().__init__(nInputPorts=0, outputType="vtkPolyData")

    def RequestInformation(self, request, inInfo, outInfo):
        info, keys = outInfo.GetInformationObject(0), vtkStreamingDemandDrivenPipeline
        info.Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        info.Set(keys.TIME_STEPS(), [0.0, 1.0], 2)
        info.Set(keys.TIME_RANGE(), [0.0, 1.0], 2)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        key = vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
        time = info.Get(key) if info.Has(key) else 0.0
        corners = np.stack(np.meshgrid((-9, 8), (-8, 8), (-7, 9)), axis=-1).reshape(-1, 3) + time
        share = [*np.array_split(corners, max(SIZE - 1, 1)), corners[:0]][RANK]
        vtkPolyData.GetData(outInfo).ShallowCopy(polydata(share, share))
        if self.fails and RANK == SIZE - 1:
            raise ValueError("no corners")
        return 1


def sampled(time=0):
    """The expected field on the grid over `Corners`."""
    origin = time - 9, time - 8, time - 7
    box = configured(vtkImageData(), Dimensions=(18, 17, 17), Origin=origin)
    producer = configured(vtkTrivialProducer(), Output=box)
    return whole(MLSDisplacementField, producer, polydata())


def polydata(rest=REST, deformed=DEFORMED, name="Displacement"):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.array(rest, float).reshape(-1, 3), deep=True))
    moved = numpy_to_vtk(np.reshape(np.subtract(deformed, rest), (-1, 3)), deep=True)
    moved.SetName(name)
    result = vtkPolyData()
    result.SetPoints(points)
    result.GetPointData().AddArray(moved)
    return result


def scalpel():
    """A cut that ends inside."""
    plane = configured(vtkPlaneSource(), Origin=(-4, 0.3, -20), Point1=(20, 0.3, -20))
    return output_of(plane, Point2=(-4, 0.3, 20))


def pipeline(kind, image, handles, cut=None, **settings):
    """A filter of a source, with the `handles` and the `cut` of this process."""
    deform = kind()
    deform.SetInputConnection(0, image.GetOutputPort())
    deform.SetInputDataObject(1, handles)
    if cut is not None:
        deform.SetInputDataObject(2, cut)
    return configured(deform, **settings)


def update(deform, ghosts=0):
    """Compute the piece of this process; returns whether this succeeded."""
    deform.UpdateInformation()
    return deform.GetExecutive().Update(0) if SIZE == 1 else deform.UpdatePiece(RANK, SIZE, ghosts)


def pieces(deform, ghosts=0):
    """Extent, point arrays and cell arrays of the pieces of all processes."""
    update(deform, ghosts)
    output = deform.GetOutputDataObject(0)
    names = [name for name in ARRAYS if output.GetPointData().HasArray(name)]
    points = {name: array(output, name).copy() for name in names}
    cells = {}
    if output.GetNumberOfCells() and output.GetCellData().HasArray("Void"):
        cells = {"Void": np.asarray(output.GetCellData().GetArray("Void")).copy()}
    return all_gather((output.GetExtent(), points, cells))


def check(deform, alone, ghosts=0):
    """Compare the pieces of `deform` with the whole image `alone`."""
    extent = alone.GetExtent()
    covered = np.zeros(alone.GetDimensions()[::-1], bool)
    compared = 0
    for part, points, cells in pieces(deform, ghosts):
        if any(first > last for first, last in zip(part[::2], part[1::2])):
            continue
        block = tuple(
            slice(first - start, last - start + 1)
            for first, last, start in list(zip(part[::2], part[1::2], extent[::2]))[::-1]
        )
        covered[block] = True
        for name, values in points.items():
            expected = array(alone, name)[block]
            np.testing.assert_array_equal(values, expected, err_msg=f"{name} in {part}")
            compared += 1
        for name, values in cells.items():
            whole = np.asarray(alone.GetCellData().GetArray(name))
            whole = whole.reshape([max(n - 1, 1) for n in alone.GetDimensions()[::-1]])
            inner = tuple(slice(s.start, max(s.stop - 1, s.start + 1)) for s in block)
            np.testing.assert_array_equal(values, whole[inner].ravel())
    assert covered.all()
    assert compared


def whole(kind, image, handles, cut=None, **settings):
    """The result of one process; each process computes it."""
    deform = pipeline(kind, image, handles, cut, **settings)
    deform.Update()
    return deform.GetOutputDataObject(0)


def volume(mesh):
    volumes = output_of(vtkCellSizeFilter(), InputData=mesh).GetCellData().GetArray("Volume")
    return float(vtk_to_numpy(volumes).sum()) if mesh.GetNumberOfCells() else 0.0


def only_on(rank, data):
    """`data` on one process, nothing on the others."""
    return data if rank % SIZE == RANK else vtkPolyData()


EVERYTHING = {"GenerateJacobian": True, "Interpolation": "cubic", "GradientArray": "RTData"}

# Control points on all processes, on one, or distributed; the results are equal to the bit.
everywhere = whole(MLSDeform, source(), polydata(), **EVERYTHING)
field = whole(MLSDisplacementField, source(), polydata())
parts = np.array_split(np.arange(len(REST)), SIZE)[RANK]
for handles in (
    polydata(),
    only_on(0, polydata()),
    only_on(-1, polydata()),
    polydata(REST[parts], DEFORMED[parts]) if len(parts) else vtkPolyData(),
):
    check(pipeline(MLSDeform, source(), handles, **EVERYTHING), everywhere)
    check(pipeline(MLSDisplacementField, source(), handles), field)

# After a change every process computes again, also with ghosts.
image, handles = source(), MLSControlPoints()
handles.SetRestPoints(REST)
deform = MLSDeform()
deform.SetInputConnection(0, image.GetOutputPort())
deform.SetInputConnection(1, handles.GetOutputPort())
update(deform)
handles.SetDeformedPoints(DEFORMED)
alone = whole(MLSDeform, source(), polydata())
check(deform, alone)
check(deform, alone, ghosts=1)
check(deform, alone)
deform.SetKind("affine")
check(deform, whole(MLSDeform, source(), polydata(), Kind="affine"))

# Cuts, on one process or several.
opened = {"GradientArray": "RTData", "GenerateJacobian": True}
for opened["CutFrame"] in vtk_mls.CUT_FRAMES:
    alone = whole(MLSDeform, source(), polydata(), scalpel(), **opened)
    assert array(alone, "Void").any() or opened["CutFrame"] == "rest"  # both sides move alike
    for cut in (scalpel(), only_on(-1, scalpel())):
        check(pipeline(MLSDeform, source(), only_on(0, polydata()), cut, **opened), alone)

# Meshes in pieces with ghost cells, without and with a cut.
for cut in (None, scalpel()):
    handles, cells = only_on(0, polydata()), tetrahedra()
    deform = pipeline(MLSDeform, cells, handles, cut and only_on(-1, cut))
    update(deform, ghosts=1)
    piece = deform.GetOutput()
    cuts = surfaces(cut) if cut else ()
    value = vtk_mls.Deformation(REST, DEFORMED, cuts=cuts)
    if piece.GetNumberOfPoints() and not cut:
        places = vtk_to_numpy(cells.GetOutput().GetPoints().GetData())
        moved = vtk_to_numpy(piece.GetPoints().GetData())
        np.testing.assert_allclose(moved, value.forward(places), rtol=0, atol=1e-4)
    deform = pipeline(MLSDeform, tetrahedra(), handles, cut and only_on(-1, cut))
    update(deform)
    alone = pipeline(MLSDeform, tetrahedra(), polydata(), cut)
    measured = sum(all_gather(volume(deform.GetOutput())))
    alone.Update()
    # the division of voxels into tetrahedra depends on the extent
    np.testing.assert_allclose(measured, volume(alone.GetOutput()), rtol=1e-3)

# The field over a mesh in pieces: one grid over the bounds of all pieces.
alone, size = sampled(), {"SampleDimensions": (18, 17, 17)}
cells, corners = tetrahedra(), Corners()
check(pipeline(MLSDisplacementField, cells, only_on(0, polydata()), **size), alone)
assert sum(all_gather(cells.GetOutput().GetNumberOfCells())) == 5 * 17 * 16 * 16
field = pipeline(MLSDisplacementField, corners, only_on(0, polydata()), **size)
check(field, alone)
assert field.UpdateTimeStep(1.0, RANK, SIZE, 0)
alone = sampled(time=1)
check(field, alone)
corners.fails = True
corners.Modified()
with output_messages() as text:
    done = update(field)
assert not done
expected = "no corners" if RANK == SIZE - 1 else f"on process {SIZE - 1} of {SIZE}"
assert expected in text[0], text[0]
corners.fails = False
corners.Modified()
check(field, alone)
with output_messages() as text:
    field.SetInputDataObject(0, vtkPolyData())
    done = update(field)
assert not done
assert "`Input` is empty" in text[0], text[0]

# Blocks; each process has another number, the last has none.
blocks, wavelet, handles = vtkMultiBlockDataSet(), source(), MLSControlPoints()
wavelet.Update()
for number in range(SIZE - 1 - RANK):
    blocks.SetBlock(number, wavelet.GetOutput())
deform = MLSDeform()
deform.SetInputDataObject(0, blocks)
deform.SetInputConnection(1, handles.GetOutputPort())
handles.SetRestPoints(REST)
for step in range(3):
    handles.SetDeformedPoints(DEFORMED + step)
    update(deform, ghosts=step % 2)
    result = deform.GetOutputDataObject(0)
    expected = array(whole(MLSDeform, source(), polydata(REST, DEFORMED + step)), "RTData")
    assert result.GetNumberOfBlocks() == blocks.GetNumberOfBlocks()
    for number in range(result.GetNumberOfBlocks()):
        np.testing.assert_array_equal(array(result.GetBlock(number), "RTData"), expected)

# More processes than slices.
thin = (0, 5, -3, 4, 2, 3)
check(
    pipeline(MLSDeform, source(thin), only_on(0, polydata())),
    whole(MLSDeform, source(thin), polydata()),
)

# A wrong value on one process is an error on all, until it is corrected.
for bad, words in (
    (polydata(name="Velocity"), "Displacement"),
    (polydata(DEFORMED, np.full_like(REST, np.nan)), "nan"),
    (vtkPolyData(), "ControlPoints"),
):
    deform = pipeline(MLSDeform, source(), only_on(-1, bad))
    with output_messages() as text:
        done = update(deform)
    assert not done
    assert words in text[0], text[0]
    assert deform.GetOutputDataObject(0).GetNumberOfPoints() == 0
    deform.SetInputDataObject(1, polydata())
    check(deform, whole(MLSDeform, source(), polydata()))

controller.Barrier()
print(f"done {RANK} of {SIZE}")
