"""Closed surfaces and a line with their Transforms, a mask and a plane, in a state.

`test_gui_regions` compares the values inside of a surface.
"""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import array, data, wavelet

BALL, PLANE = [0.0, 0.0, 0.0, 6.0, 2.0], [0.0, 0.0, -6.0, 0.0, 0.0, 1.0, 3.0]
FIRST, SECOND = [-3.0, 0.0, 0.0], [3.5, 0.0, 0.0]  # centers of two bones
CURVE = [-2.0, 5.0, 0.0, 0.0, 5.0, 1.0, 2.0, 5.0, 0.0]
LIFT = [0.0, 0.5, 0.5]


def turned(proxy, angle, shift):
    """A Transform of a source: turned about z and shifted."""
    result = simple.Transform(Input=proxy)
    result.Transform.Rotate, result.Transform.Translate = [0.0, 0.0, angle], shift
    return result


def values_of(deform):
    return array(data(deform), "RTData").copy()


# Two bones and a curve, at rest and moved.
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
before = values_of(deform)
moved[0].Transform.Rotate = [0.0, 0.0, 35.0]
assert not np.array_equal(values_of(deform), before)
deform.MaskBall, deform.FixedPlanes = BALL, PLANE
values = values_of(deform)

# A state keeps it all.
simple.RenameSource("bones", deform)
with tempfile.TemporaryDirectory() as folder:
    state = os.path.join(folder, "state.pvsm")
    simple.SaveState(state)
    del bones, line, moved, rest, deformed, inputs, deform
    simple.ResetSession()
    assert simple.FindSource("bones") is None
    simple.LoadState(state)
loaded = simple.FindSource("bones")
assert loaded.HandleShapes == "cells"
assert (list(loaded.MaskBall), list(loaded.FixedPlanes)) == (BALL, PLANE)
np.testing.assert_array_equal(values_of(loaded), values)
