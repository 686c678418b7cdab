"""A saved state restores filters with all their properties, inputs and results."""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import DEFORMED, REST, array, control_points, data, wavelet

IMAGE = {
    "Kind": "polynomial",
    "Degree": 1,
    "Alpha": 1.25,
    "MapTolerance": 0.0,
    "Interpolation": "cubic",
    "OutputGrid": "given",
    "OutputDimensions": [12, 13, 14],
    "OutputOrigin": [-6.0, -6.0, -6.0],
    "Background": 3.0,
    "LabelArrays": ["RTData"],
}
CUT = {
    "CutType": "half-plane",
    "CutOrigin": [1.0, 0.0, -2.0],
    "CutNormal": [2.0, 0.0, 0.0],
    "CutInward": [0.0, 0.0, 1.0],
    "Nu": 3.0,
    "GradientArray": "RTData",
    "NormalizeGradient": 1,
    "GenerateJacobian": 1,
}
OWN_HANDLES = {
    "Kind": "spline",
    "Order": 2,
    "Smoothing": 0.5,
    "RestPoints": [*REST.ravel()],
    "DeformedPoints": [*DEFORMED.ravel()],
}
BONES = {
    "HandleShapes": "cells",
    "MapTolerance": 0.0,
    "MaskBall": [0.0, 0.0, 0.0, 6.0, 2.0],
    "FixedPlanes": [0.0, 0.0, -6.0, 0.0, 0.0, 1.0, 3.0],
}
SETTINGS = {"image": IMAGE, "cut": CUT, "own handles": OWN_HANDLES, "bones": BONES, "reference": {}}


def turned(proxy, angle, shift):
    """A Transform of a source: turned about z and shifted."""
    result = simple.Transform(Input=proxy)
    result.Transform.Rotate, result.Transform.Translate = [0.0, 0.0, angle], shift
    return result


source, handles = wavelet(), control_points(Weights=[1.0, 2.0] * 4)
polygon = simple.Plane(Origin=[-90, 1.3, 1], Point1=[90, 1.3, 1], Point2=[-90, 1.3, 90])
filters = {
    "image": simple.MLSDeform(Input=source, ControlPoints=handles, **IMAGE),
    "cut": simple.MLSDeform(Input=source, ControlPoints=handles, Cuts=polygon),
    "own handles": simple.MLSDeform(Input=source, **OWN_HANDLES),
    "reference": simple.MLSDeform(Input=source, ControlPoints=handles),
}
filters["reference"].Reference = simple.Wavelet(WholeExtent=[0, 5, 0, 6, 0, 7])
for name, value in CUT.items():
    setattr(filters["cut"], name, value)


def arrays(proxy):
    result = data(proxy)
    names = [
        name for name in ("RTData", "Void", "Gradient") if result.GetPointData().HasArray(name)
    ]
    return {name: array(result, name).copy() for name in names}


# Two bones and a curve, at rest and moved; `test_gui_panel` compares the values inside of a bone.
parts = [simple.Sphere(Center=[x, 0.0, 0.0], Radius=2.0) for x in (-3.0, 3.5)]
parts.append(simple.PolyLineSource(Points=[-2.0, 5.0, 0.0, 0.0, 5.0, 1.0, 2.0, 5.0, 0.0]))
motions = (20.0, [0.0, 0.5, 0.0]), (-15.0, [0.0, 0.0, 1.0]), (0.0, [0.0, 0.5, 0.5])
moved = [turned(part, *motion) for part, motion in zip(parts, motions)]
rest, deformed = (simple.AppendGeometry(Input=inputs) for inputs in (parts, moved))
filters["bones"] = simple.MLSDeform(
    Input=source, ControlPoints=rest, DeformedControlPoints=deformed, **BONES
)
before = arrays(filters["bones"])["RTData"]
moved[0].Transform.Rotate = [0.0, 0.0, 35.0]
assert not np.array_equal(arrays(filters["bones"])["RTData"], before)

expected = {name: arrays(proxy) for name, proxy in filters.items()}
assert [len(found) for found in expected.values()] == [1, 3, 1, 1, 1]
for name, proxy in filters.items():
    simple.RenameSource(name, proxy)
with tempfile.TemporaryDirectory() as folder:
    state = os.path.join(folder, "state.pvsm")
    simple.SaveState(state)
    del source, handles, polygon, filters, proxy, parts, moved, rest, deformed
    simple.ResetSession()
    assert simple.FindSource("image") is None
    simple.LoadState(state)
for name, settings in SETTINGS.items():
    loaded = simple.FindSource(name)
    for key, value in settings.items():
        current = getattr(loaded, key)
        assert (list(current) if isinstance(value, list) else current) == value, key
    found = arrays(loaded)
    assert found.keys() == expected[name].keys()
    for key, values in found.items():
        np.testing.assert_array_equal(values, expected[name][key])
assert len(simple.FindSource("cut").Cuts) == 1
