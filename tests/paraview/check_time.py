"""Control points of time series deform a static input, also in a view."""

import tempfile
from pathlib import Path

import numpy as np
from paraview import servermanager, simple
from scene import array, output_messages

from vtk_mls import io
from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk.objects import configured, output_of

TIMES = 0.0, 1.0, 3.0
folder = Path(tempfile.mkdtemp())


def write_series(name, sources):
    """A .pvd file of polydata at TIMES."""
    rows = []
    for time, source in zip(TIMES, sources):
        path = folder / f"{name}-{time:g}.vtp"
        io.write_dataset(output_of(source), path)
        rows.append(f'<DataSet timestep="{time}" file="{path.name}"/>')
    series = folder / f"{name}.pvd"
    series.write_text(
        f'<VTKFile type="Collection"><Collection>{"".join(rows)}</Collection></VTKFile>'
    )
    return simple.PVDReader(FileName=str(series))


def handles(time):
    """A control point that moves by `time` along x."""
    return configured(MLSControlPoints(), RestPoints=[(0, 0, 0)], DeformedPoints=[(time, 0, 0)])


def shift(dataset):
    """How far a dataset is moved along x."""
    return array(dataset, "ForwardDisplacement")[..., 0].mean()


moving = write_series("handles", map(handles, TIMES))
sphere = simple.Sphere()
deform = simple.MLSDeform(Input=sphere, ControlPoints=moving)
for time in (0.0, 3.0, 1.0):
    deform.UpdatePipeline(time)
    np.testing.assert_allclose(shift(servermanager.Fetch(deform)), time, atol=1e-5)

# An animation.
view = simple.GetActiveViewOrCreate("RenderView")
simple.Show(deform, view)
animation = simple.GetAnimationScene()
animation.UpdateAnimationUsingDataTimeSteps()
assert list(animation.TimeKeeper.TimestepValues) == list(TIMES)
for time in (3.0, 0.0, 1.0):
    animation.AnimationTime = time
    simple.Render(view)
    output = deform.GetClientSideObject().GetOutputDataObject(0)
    np.testing.assert_allclose(shift(output), time, atol=1e-5)

# A table of control points with times, and an image with a time axis.
table = folder / "moving.csv"
rows = [f"{time},0,0,0,{time},0,0" for time in TIMES]
table.write_text("\n".join(["time,px,py,pz,qx,qy,qz", *rows]))
points = simple.MLSControlPoints(Mode="file", FileName=str(table))
points.UpdatePipelineInformation()
assert list(points.TimestepValues) == list(TIMES), points.TimestepValues
deform = simple.MLSDeform(Input=sphere, ControlPoints=points)
for time, expected in ((3.0, 3), (0.5, 0), (1.0, 1)):
    deform.UpdatePipeline(time)
    np.testing.assert_allclose(shift(servermanager.Fetch(deform)), expected, atol=1e-5)
values = np.arange(3 * 4 * 5 * 6, dtype="<f4").reshape(3, 4, 5, 6)
(folder / "beats.mha").write_bytes(
    b"NDims = 4\nDimSize = 6 5 4 3\nOffset = 0 0 0 0.5\nElementSpacing = 1 1 1 0.25\n"
    b"ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" + values.tobytes()
)
beats = simple.MLSImageReader(FileName=str(folder / "beats.mha"))
beats.UpdatePipelineInformation()
assert list(beats.TimestepValues) == [0.5, 0.75, 1.0], beats.TimestepValues
for time, index in ((1.0, 2), (0.0, 0), (0.8, 1)):
    beats.UpdatePipeline(time)
    found = array(servermanager.Fetch(beats), "MetaImage")
    np.testing.assert_array_equal(found.ravel(), values[index].ravel())

# Images that are opened together are time steps, if they have one each.
group = [str(folder / f"scan{index}.nii") for index in range(3)]
for name, time in zip(group, beats.TimestepValues):
    beats.UpdatePipeline(time)
    io.write_dataset(servermanager.Fetch(beats), name)
series = simple.OpenDataFile(group)
assert list(series.TimestepValues) == [0, 1, 2], series.TimestepValues
for time in (2.0, 0.0):
    series.UpdatePipeline(time)
    found = array(servermanager.Fetch(series), "NIFTI")
    np.testing.assert_array_equal(np.sort(found.ravel()), values[int(time)].ravel())
with output_messages() as text:
    series.FileName = [group[0], str(folder / "beats.mha")]
    series.UpdatePipeline()
assert text[0].count("`FileName`: files that are opened together are the steps") == 1, text[0]
