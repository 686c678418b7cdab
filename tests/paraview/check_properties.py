"""The proxies offer the properties of their filters, with help, and defaults that do nothing."""

import numpy as np
from paraview import simple
from scene import PLUGIN, REST, array, control_points, data, wavelet

from vtk_mls.model.options import CUT_FRAME, MAP_TOLERANCE

source = wavelet()
volume = array(data(source), "RTData")

# What a user meets who adds the three and presses Apply: the identity.
handles = simple.MLSControlPoints()
deform = simple.MLSDeform(Input=source, ControlPoints=handles)
field = simple.MLSDisplacementField(Input=source, ControlPoints=handles)
assert data(handles).GetNumberOfPoints() == data(handles).GetNumberOfVerts() == 8
assert not array(data(handles), "Displacement").any()
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
assert data(deform).GetExtent() == data(source).GetExtent()
assert not array(data(field), "BackwardDisplacement").any()

defaults = {
    "Weights": [],
    "Blend": 1.0,
    "Kind": "rigid",
    "Degree": 2,
    "Alpha": 1.0,
    "DisplacementArray": ["POINTS", "Displacement"],
    "WeightArray": ["POINTS", "Weight"],
    "Device": "",
    "Nu": 2.0,
    "CutType": "none",
    "CutNormal": [1.0, 0.0, 0.0],
    "CutInward": [0.0, 0.0, 1.0],
    "CutFrame": CUT_FRAME.default,
    "GenerateOverlap": 0,
    "GenerateJacobian": 0,
    "GenerateJacobianDeterminant": 0,
    "MapTolerance": MAP_TOLERANCE.interactive_default,
}
of_deform = {
    "Interpolation": "linear",
    "LabelArrays": [],
    "Background": 0.0,
    "OutputGrid": "input",
    "OutputDimensions": [64, 64, 64],
    "OutputSpacing": [1.0, 1.0, 1.0],
    "OutputOrigin": [0.0, 0.0, 0.0],
    "HideVoid": 1,
    "SplitCells": 1,
    "PushForwardArrays": [],
    "VoidValues": "background",
    "GradientArray": "none",
    "GradientVectorArrays": [],
    "NormalizeGradient": 0,
}
of_handles = {
    "Mode": "points",
    "FileName": "",
    "DeformedFileName": "",
    "Space": "lps",
    "DeformedPoints": [],
    "Weights": [],
    "LatticeDimensions": [3, 3, 3],
    "Bounds": [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
}
# What the panel alone knows, and what is taken from the bounds of the input.
of_every_panel = {"Drag": "deformed", "NumberHandles": 0}
panel = {**of_every_panel, "LatticeDimensions": [3, 3, 3]}
of_deform_panel = {**panel, "Live": 1}
of_bounds = {"RestPoints", "DeformedPoints", "CutOrigin"}
for proxy, expected, others in (
    (
        deform,
        {**defaults, **of_deform, **of_deform_panel},
        {"Input", "ControlPoints", "Cuts", *of_bounds},
    ),
    (
        field,
        {**defaults, "Inverse": 0, "SampleDimensions": [32, 32, 32], **panel},
        {"Input", "ControlPoints", "Cuts", *of_bounds},
    ),
    (handles, {**of_handles, **of_every_panel}, {"RestPoints"}),
):
    for name, default in expected.items():
        value = getattr(proxy, name)
        value = list(value) if isinstance(default, list) else value
        assert value == default, (name, value)
    assert set(proxy.ListProperties()) == {*expected, *others}
    for name in {*expected, *others}:
        assert proxy.GetProperty(name).GetDocumentation().GetDescription().strip(), name
    assert proxy.SMProxy.GetDocumentation().GetDescription().strip()
    # The proxy's default is the filter's own, so that a script without ParaView behaves the same
    # (within MapTolerance, which is ParaView's); and it is what the filter has.
    arrays = {"DisplacementArray", "WeightArray", "LabelArrays", "GradientVectorArrays"}
    arrays |= {"PushForwardArrays"}
    for name in (
        set(expected) - arrays - set(of_deform_panel if proxy is not handles else of_every_panel)
    ):
        own = getattr(proxy.GetClientSideObject(), f"Get{name}")()
        own = list(own) if isinstance(expected[name], list) else own or expected[name]
        assert own == expected[name], (name, own)

# Drop-down lists.
for proxy, name, options in (
    (deform, "Kind", ["affine", "rigid", "similarity", "polynomial"]),
    (field, "Kind", ["affine", "rigid", "similarity", "polynomial"]),
    (deform, "Interpolation", ["nearest", "linear", "cubic"]),
    (deform, "OutputGrid", ["input", "fitted", "given"]),
    (deform, "VoidValues", ["background", "continued"]),
    (deform, "CutType", ["none", "plane", "half-plane"]),
    (field, "CutType", ["none", "plane", "half-plane"]),
    (deform, "CutFrame", ["rest", "deformed"]),
    (field, "CutFrame", ["rest", "deformed"]),
    (handles, "Mode", ["points", "lattice", "file"]),
):
    assert list(proxy.GetProperty(name).Available) == options

# The arrays that can be chosen are those of the right input.
weighted = control_points(Weights=[1.0] * len(REST))
weighted.UpdatePipeline()
other = simple.MLSDeform(Input=source, ControlPoints=weighted)


def offered(proxy, name):
    domain = proxy.GetProperty(name).FindDomain("vtkSMArrayListDomain")
    return [domain.GetString(i) for i in range(domain.GetNumberOfStrings())]


assert offered(other, "DisplacementArray") == ["Displacement"]
assert offered(other, "WeightArray") == ["Weight"]
assert offered(deform, "WeightArray") == []
assert offered(other, "LabelArrays") == ["RTData"]
assert offered(other, "GradientArray") == ["RTData", "none"]
assert offered(other, "GradientVectorArrays") == []

# A lattice fills its box, x fastest, and follows changes.
handles.Mode, handles.LatticeDimensions, handles.Bounds = "lattice", [2, 3, 4], [0, 1, 0, 4, -3, 3]
points = data(handles)
assert points.GetNumberOfPoints() == 24
assert points.GetBounds() == (0, 1, 0, 4, -3, 3)
assert points.GetPoint(1) == (1, 0, -3)

# Loading the plugin again leaves a working pipeline.
reloaded = simple.MLSDeform(Input=source, ControlPoints=handles, Kind="affine")
simple.LoadPlugin(str(PLUGIN), ns=vars(simple))
reloaded.SMProxy.RecreateVTKObjects()
np.testing.assert_array_equal(array(data(reloaded), "RTData"), volume)
assert reloaded.GetClientSideObject().GetKind() == "affine"
