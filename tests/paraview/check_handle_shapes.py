"""Lines and closed surfaces as handles, a moved surface as its motion, masks and faces."""

import os
import tempfile
from types import SimpleNamespace

import numpy as np
from paraview import simple
from scene import array, data, grid, output_messages, vtk_mls, wavelet
from vtkmodules.util.numpy_support import vtk_to_numpy

BALL, PLANE = [0.0, 0.0, 0.0, 6.0, 2.0], [0.0, 0.0, -6.0, 0.0, 0.0, 1.0, 3.0]
FIRST, SECOND = [-3.0, 0.0, 0.0], [3.5, 0.0, 0.0]  # centers of two bones
CURVE = [-2.0, 5.0, 0.0, 0.0, 5.0, 1.0, 2.0, 5.0, 0.0]
LIFT = [0.0, 0.5, 0.5]


def motion(transform):
    """The matrix (4, 4) of a Transform."""
    matrix = transform.Transform.GetClientSideObject().GetMatrix()
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])


def turned(proxy, angle, shift):
    """A Transform of a source: turned about z and shifted."""
    result = simple.Transform(Input=proxy)
    result.Transform.Rotate, result.Transform.Translate = [0.0, 0.0, angle], shift
    return result


def places(dataset):
    return vtk_to_numpy(dataset.GetPoints().GetData()).astype(float)


def solid(proxy):
    """The Solid of a surface of triangles."""
    surface = data(proxy)
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_mls.Solid(places(surface), triangles)


def build():
    """Two bones and a curve at rest and moved, and filters that deform an image and a mesh."""
    source = wavelet()
    tetrahedra = simple.Tetrahedralize(Input=source)
    bones = [simple.Sphere(Center=center, Radius=2.0) for center in (FIRST, SECOND)]
    moved = [turned(bones[0], 20.0, [0.0, 0.5, 0.0]), turned(bones[1], -15.0, [0.0, 0.0, 1.0])]
    line = simple.PolyLineSource(Points=CURVE)
    lifted = simple.Transform(Input=line)
    lifted.Transform.Translate = LIFT
    parts, moved_parts = [*bones, line], [*moved, lifted]
    rest, deformed = simple.AppendGeometry(Input=parts), simple.AppendGeometry(Input=moved_parts)
    inputs = {"ControlPoints": rest, "DeformedControlPoints": deformed}
    settings = {**inputs, "HandleShapes": "cells", "MapTolerance": 0.0}
    filters = [simple.MLSDeform(Input=data, **settings) for data in (source, tetrahedra)]
    return SimpleNamespace(
        source=source,
        tetrahedra=tetrahedra,
        moved=moved,
        solids=[solid(bone) for bone in bones],
        parts=parts,
        moved_parts=moved_parts,
        rest=rest,
        deformed=deformed,
        deform=filters[0],
        mesh=filters[1],
    )


def expected(scene, **limits):
    """The Deformation of the scene by Transforms alone."""
    nodes = np.reshape(CURVE, (-1, 3))
    handles = [vtk_mls.CurveHandle(nodes, nodes + LIFT)]
    for shape, moved in zip(scene.solids, scene.moved):
        handles.append(vtk_mls.RegionHandle(shape, motion(moved)))
    return vtk_mls.Deformation(handles=handles, **limits)


def check(scene, value):
    """Both filters against a Deformation."""
    image = data(scene.deform)
    sampling = vtk_mls.Sampling(grid(image), background="auto")
    (values,) = value.resample([array(data(scene.source), "RTData")], sampling)
    np.testing.assert_allclose(array(image, "RTData"), values, atol=0.02)
    before, after = places(data(scene.tetrahedra)), places(data(scene.mesh))
    np.testing.assert_allclose(after, value.forward(before), atol=1e-4)
    assert np.abs(after - before).max() > 0.5


def check_limits(scene):
    """A mask ball and a fixed plane; the result."""
    for proxy in (scene.deform, scene.mesh):
        proxy.MaskBall, proxy.FixedPlanes = BALL, PLANE
    face = vtk_mls.FixedFace(vtk_mls.Plane(PLANE[:3], PLANE[3:6]), PLANE[6])
    mask = vtk_mls.BallMask(BALL[:3], BALL[3], BALL[4])
    check(scene, expected(scene, mask=mask, constraints=[face]))
    image, values = data(scene.source), array(data(scene.deform), "RTData")
    outside = np.linalg.norm(grid(image).points(), axis=1).reshape(values.shape) > 8
    np.testing.assert_array_equal(values[outside], array(image, "RTData")[outside])
    return values.copy()


def check_errors(deform, values):
    """Open surfaces, and data that do not pair, are one sentence; mended, it is as before."""
    closed, moved = deform.ControlPoints, deform.DeformedControlPoints
    half = simple.Clip(Input=simple.Sphere(Radius=3.0))
    opened = simple.ExtractSurface(Input=half)
    for inputs, sentence in (
        ((opened, opened), "`Control Points`, surface 0, is no rigid region"),
        ((closed, opened), "`DeformedControlPoints` must have a point for each of the"),
        ((None, moved), "`DeformedControlPoints` is what `ControlPoints` is, moved"),
    ):
        deform.ControlPoints, deform.DeformedControlPoints = inputs
        with output_messages() as text:
            deform.UpdatePipeline()
        assert text[0].count("ERROR") == text[0].count(sentence) == 1, text[0]
        assert deform.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints() == 0
        deform.ControlPoints, deform.DeformedControlPoints = closed, moved
        np.testing.assert_array_equal(array(data(deform), "RTData"), values)


scene = build()
check(scene, expected(scene))
before = array(data(scene.deform), "RTData").copy()
scene.moved[0].Transform.Rotate = [0.0, 0.0, 35.0]
check(scene, expected(scene))
assert not np.array_equal(array(data(scene.deform), "RTData"), before)
values = check_limits(scene)

# A state keeps it all.
simple.RenameSource("bones", scene.deform)
with tempfile.TemporaryDirectory() as folder:
    state = os.path.join(folder, "state.pvsm")
    simple.SaveState(state)
    del scene
    simple.ResetSession()
    assert simple.FindSource("bones") is None
    simple.LoadState(state)
loaded = simple.FindSource("bones")
assert loaded.HandleShapes == "cells"
assert (list(loaded.MaskBall), list(loaded.FixedPlanes)) == (BALL, PLANE)
np.testing.assert_array_equal(array(data(loaded), "RTData"), values)
check_errors(loaded, values)

# Equal bones whose copies are appended in another order.
scene = build()
scene.deformed.Input = [scene.moved[1], scene.moved[0], scene.moved_parts[2]]
with output_messages() as text:
    data(scene.deform)
assert text[0].count("MLSDeform: rigid regions 0 and 1 have the same shape, and are moved") == 1
