"""Closed surfaces and a line with their Transforms, a mask and a plane: states and errors.

`test_gui_regions` compares the values inside of a surface.
"""

import os
import tempfile
from types import SimpleNamespace

import numpy as np
from paraview import simple
from scene import array, data, output_messages, wavelet

BALL, PLANE = [0.0, 0.0, 0.0, 6.0, 2.0], [0.0, 0.0, -6.0, 0.0, 0.0, 1.0, 3.0]
FIRST, SECOND = [-3.0, 0.0, 0.0], [3.5, 0.0, 0.0]  # centers of two bones
CURVE = [-2.0, 5.0, 0.0, 0.0, 5.0, 1.0, 2.0, 5.0, 0.0]
LIFT = [0.0, 0.5, 0.5]


def turned(proxy, angle, shift):
    """A Transform of a source: turned about z and shifted."""
    result = simple.Transform(Input=proxy)
    result.Transform.Rotate, result.Transform.Translate = [0.0, 0.0, angle], shift
    return result


def build():
    """A filter with two bones and a curve, at rest and moved."""
    bones = [simple.Sphere(Center=center, Radius=2.0) for center in (FIRST, SECOND)]
    line = simple.PolyLineSource(Points=CURVE)
    moved = [
        turned(bones[0], 20.0, [0.0, 0.5, 0.0]),
        turned(bones[1], -15.0, [0.0, 0.0, 1.0]),
        turned(line, 0.0, LIFT),
    ]
    rest, deformed = (simple.AppendGeometry(Input=parts) for parts in ([*bones, line], moved))
    inputs = {"ControlPoints": rest, "DeformedControlPoints": deformed}
    deform = simple.MLSDeform(Input=wavelet(), HandleShapes="cells", MapTolerance=0.0, **inputs)
    return SimpleNamespace(moved=moved, deformed=deformed, deform=deform)


def values_of(deform):
    return array(data(deform), "RTData").copy()


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
        np.testing.assert_array_equal(values_of(deform), values)


scene = build()
before = values_of(scene.deform)
scene.moved[0].Transform.Rotate = [0.0, 0.0, 35.0]
assert not np.array_equal(values_of(scene.deform), before)
scene.deform.MaskBall, scene.deform.FixedPlanes = BALL, PLANE
values = values_of(scene.deform)

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
np.testing.assert_array_equal(values_of(loaded), values)
check_errors(loaded, values)

# Equal bones whose copies are appended in another order.
scene = build()
scene.deformed.Input = [scene.moved[i] for i in (1, 0, 2)]
with output_messages() as text:
    data(scene.deform)
assert text[0].count("MLSDeform: rigid regions 0 and 1 have the same shape, and are moved") == 1
