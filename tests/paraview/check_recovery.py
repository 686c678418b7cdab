"""A wrong value of a property gives one error; the old value restores the view."""

import tempfile
from pathlib import Path

import numpy as np
from paraview import simple
from scene import control_points, output_messages
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

view = simple.GetActiveViewOrCreate("RenderView")
view.ViewSize, view.OrientationAxesVisibility = [160, 120], 0
simple._DisableFirstRenderCameraReset()


def picture():
    simple.Render(view)
    grab = vtkWindowToImageFilter()
    grab.SetInput(view.GetRenderWindow())
    grab.ReadFrontBufferOff()
    grab.Update()
    return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).astype(int)


def count(proxy):
    return proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints()


def drag(proxy):
    """Move a handle, so that pictures differ from those of the input."""
    proxy.UpdatePipeline()
    moved = list(proxy.DeformedPoints)
    moved[-3] += 0.2 * (max(moved[::3]) - min(moved[::3]))
    proxy.DeformedPoints = moved


def check(visible, changed, name, bad, word, meanwhile=()):
    """Set a wrong value of a property, then the old one, and render each."""
    for context, value in meanwhile:
        setattr(changed, context, value)
    before, points = picture(), count(visible)
    assert points > 0
    good = getattr(changed, name)
    good = list(good) if hasattr(good, "__len__") and not isinstance(good, str) else good
    with output_messages() as text:
        setattr(changed, name, bad)
        empty = picture()
    where = visible.GetXMLName(), changed.GetXMLName(), name, bad
    assert text[0].count("ERROR") == text[0].count(word) == 1, (where, text[0])
    assert "Traceback" not in text[0], (where, text[0])
    assert count(visible) == 0, where
    assert (empty != before).any(), where
    with output_messages() as text:
        setattr(changed, name, good)
        after = picture()
    assert text[0] == "", (where, text[0])
    assert count(visible) == points, where
    assert np.abs(after - before).max() <= 1, where


MAP = [  # of both filters
    ("Kind", "elastic", "`Kind`"),
    ("Alpha", -3.0, "`Locality (alpha)`"),
    (
        "Steps",
        -3,
        "`Steps (0 prevents folds)` must be an integer from 1 to 256, or 0 for automatic",
    ),
    ("Device", "9:9", "`9:9`"),
    ("DeformedPoints", [1.0, 2.0, 3.0], "`Deformed Points`"),
    ("CutType", "cube", "`Cut Type`"),
    ("CutNormal", [0.0, 0.0, 0.0], "`Cut Normal`", [("CutType", "plane")]),
]
OF_IMAGES = [
    ("Interpolation", "sharp", "`Interpolation`"),
    ("LabelArrays", ["Bone"], "`Bone`"),
    ("GradientArray", "Density", "`Density`"),
    ("OutputDimensions", [3, 0, 3], "`Output Dimensions`", [("OutputGrid", "given")]),
]

sphere = simple.Sphere()
wavelet = simple.Wavelet(WholeExtent=[-5, 4, -5, 5, -4, 5])
scenes = []
for source, representations in ((sphere, ["Surface"]), (wavelet, ["Surface", "Volume"])):
    source.UpdatePipeline()
    for representation in representations:
        deform = simple.MLSDeform(Input=source)
        drag(deform)
        display = simple.Show(deform, view)
        if source is wavelet:
            simple.ColorBy(display, ("POINTS", "RTData"))
        display.SetRepresentationType(representation)
        simple.ResetCamera(view)
        cases = MAP + (OF_IMAGES if source is wavelet else [])
        for name, bad, word, *meanwhile in cases:
            check(deform, deform, name, bad, word, *meanwhile)
        simple.Delete(deform)

for source in (sphere, wavelet):
    field = simple.MLSDisplacementField(Input=source, SampleDimensions=[6, 6, 6])
    drag(field)
    display = simple.Show(field, view)
    display.SetRepresentationType("Surface")
    simple.ColorBy(display, ("POINTS", "BackwardDisplacement"))
    simple.ResetCamera(view)
    own = [("SampleDimensions", [0, 1, 2], "`Sample Dimensions`")] if source is sphere else []
    for name, bad, word, *meanwhile in [*MAP, *own]:
        check(field, field, name, bad, word, *meanwhile)
    simple.Delete(field)

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "pairs.csv")
    file.write_text("px,py,pz,qx,qy,qz\n0,0,0,1,0,0\n5,0,0,5,0,0\n0,5,0,0,5,1\n0,0,5,0,0,5\n")
    handles = control_points()
    display = simple.Show(handles, view)
    display.SetRepresentationType("Points")
    display.PointSize = 6.0
    simple.ResetCamera(view)
    OWN = [
        ("Mode", "random", "`Mode`"),
        ("DeformedPoints", [1.0, 2.0, 3.0], "`Deformed Points`"),
        ("Weights", [1.0, 2.0], "`Weights`"),
    ]
    for name, bad, word in OWN:
        check(handles, handles, name, bad, word)
    # Filters downstream report nothing.
    deform = simple.MLSDeform(Input=wavelet, ControlPoints=handles)
    simple.Hide(handles, view)
    simple.Show(deform, view).SetRepresentationType("Surface")
    for name, bad, word in [*OWN, ("DeformedPoints", [np.nan] * 24, "`Control Points`")]:
        check(deform, handles, name, bad, word)
    below = simple.MLSDeform(Input=deform)
    drag(below)
    simple.Hide(deform, view)
    simple.Show(below, view).SetRepresentationType("Surface")
    check(below, deform, "Alpha", -3.0, "`Locality (alpha)`")
    check(below, handles, "Mode", "random", "`Mode`")
    for proxy in (below, deform):
        simple.Delete(proxy)
    simple.Show(handles, view)
    handles.DeformedPoints = []
    lattice = [("Mode", "lattice")]
    check(handles, handles, "LatticeDimensions", [2, 0, 1], "`Lattice Dimensions`", lattice)
    check(handles, handles, "Bounds", [1, -1, 0, 1, 0, 1], "`Bounds`", lattice)
    handles.FileName = str(file)
    missing = str(file.with_name("none.csv"))
    check(handles, handles, "FileName", missing, "`FileName`", [("Mode", "file")])
    check(handles, handles, "Space", "moon", "`Space`")
    simple.Delete(handles)

# A missing array of control points.
handles = control_points()
for kind in (simple.MLSDeform, simple.MLSDisplacementField):
    deform = kind(Input=wavelet, ControlPoints=handles)
    simple.Show(deform, view).SetRepresentationType("Surface")
    simple.ResetCamera(view)
    for name in ("DisplacementArray", "WeightArray"):
        check(deform, deform, name, ["POINTS", "Velocity"], "`Velocity`")
    simple.Delete(deform)
