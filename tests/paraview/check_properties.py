"""The proxies have the properties of their filters, with help, and are the identity by default."""

import tempfile

import numpy as np
from paraview import simple
from scene import PLUGIN, REST, array, control_points, data, wavelet

from vtk_mls import Field, Grid, io
from vtk_mls.filters import properties
from vtk_mls.filters import property_tables as tables

source = wavelet()
volume = array(data(source), "RTData")

# New proxies: the identity.
handles = simple.MLSControlPoints()
deform = simple.MLSDeform(Input=source, ControlPoints=handles)
field = simple.MLSDisplacementField(Input=source, ControlPoints=handles)
assert data(handles).GetNumberOfPoints() == data(handles).GetNumberOfVerts() == 8
assert not array(data(handles), "Displacement").any()
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
assert data(deform).GetExtent() == data(source).GetExtent()
assert not array(data(field), "BackwardDisplacement").any()

# Properties of the panel alone, and those with defaults from the bounds of the input.
PANEL = {"Drag": "deformed", "NumberHandles": 0}
FILTER_PANEL = {
    **PANEL,
    "LatticeDimensions": (3, 3, 3),
    "restored": 1,
    "ConnectedCuts": "unknown",
    "DisplacementArray": ("POINTS", "Displacement"),
    "WeightArray": ("POINTS", "Weight"),
}
DEFORM_PANEL = {**FILTER_PANEL, "Live": 1, "AutomaticBackground": 1}
FROM_BOUNDS = {"RestPoints", "DeformedPoints", "CutOrigin"}
INPUTS = {"Input", "ControlPoints", "DeformedControlPoints", "Cuts", "Mask"}
INTERACTIVE = {prop.name: prop for prop in tables.INTERACTIVE_COMPUTING}


def properties_of(table):
    return [
        INTERACTIVE.get(prop.name, prop)
        for prop in table
        if not isinstance(prop, (properties.Value, properties.Values))  # only in Python
    ]


for proxy, table, panel, others in (
    (deform, tables.DEFORM, DEFORM_PANEL, INPUTS | FROM_BOUNDS | {"Reference"}),
    (field, tables.DISPLACEMENT_FIELD, FILTER_PANEL, INPUTS | FROM_BOUNDS),
    (handles, tables.CONTROL_POINTS, PANEL, {"RestPoints", "TimestepValues"}),
):
    table = properties_of(table)
    defaults = {
        prop.name: "none" if isinstance(prop, properties.ArrayName) else prop.default
        for prop in table
        if prop.name not in others
    }
    for name, default in {**defaults, **panel}.items():
        value = getattr(proxy, name)
        assert (tuple(value) if isinstance(default, tuple) else value) == default, name
    assert set(proxy.ListProperties()) == {*defaults, *panel, *others}
    for name in proxy.ListProperties():
        assert proxy.GetProperty(name).GetDocumentation().GetDescription().strip(), name
    assert proxy.SMProxy.GetDocumentation().GetDescription().strip()
    # Help, level and values are those of the filter.
    for prop in table:
        shown = proxy.SMProxy.GetProperty(prop.name)
        assert shown.GetDocumentation().GetDescription().split() == prop.help.split(), prop.name
        assert (shown.GetPanelVisibility() == "advanced") == prop.is_advanced, prop.name
        if prop.name in others or isinstance(prop, properties.ArrayNames):
            continue
        own = getattr(proxy.GetClientSideObject(), f"Get{prop.name}")()
        has_other = prop.name == "AutomaticBackground"  # on in ParaView
        default = (panel if has_other else defaults)[prop.name]
        assert (own or default) == default, (prop.name, own)
        if isinstance(prop, properties.Choice):
            assert tuple(proxy.GetProperty(prop.name).Available) == prop.choices
assert [deform.Kind, deform.Alpha, deform.Nu, deform.CutType] == ["rigid", 2, 2, "none"]
KINDS = ["affine", "rigid", "similarity", "polynomial", "spline", "auto", "tps"]
assert list(field.GetProperty("Kind").Available) == KINDS

# Array lists show the arrays of the right input.
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

# A new filter has an automatic background; another Background is used.
values = volume.reshape(data(source).GetDimensions()[::-1])
corners = values[:: len(values) - 1, :: values.shape[1] - 1, :: values.shape[2] - 1]
median = np.percentile(corners, 50, method="lower")
far = {"RestPoints": [0, 0, 0], "DeformedPoints": [900, 0, 0], "Device": "reference"}
distant = simple.MLSDeform(Input=source, **far)
assert (array(data(distant), "RTData") == median).all()
distant.Background = -5.0
assert (array(data(distant), "RTData") == -5).all()
distant.Background, distant.AutomaticBackground = 0.0, 0
assert not array(data(distant), "RTData").any()
distant.AutomaticBackground = 1
assert (array(data(distant), "RTData") == median).all()

# The file of a transform moves the material before the handles do.
with tempfile.TemporaryDirectory() as folder:
    shift, grid = np.tile([2.0, 0, 0], (3, 3, 3, 1)), Grid((3, 3, 3), (-20,) * 3, (20,) * 3)
    io.write_transform(Field(shift, grid), f"{folder}/shift.nrrd")
    with open(f"{folder}/shift.tfm", "w") as file:
        file.write("#Insight Transform File V1.0\n#Transform 0\n")
        file.write("Transform: AffineTransform_double_3_3\n")
        file.write("Parameters: 1 0 0 0 1 0 0 0 1 2 0 0\nFixedParameters: 0 0 0\n")
    for ending in ("nrrd", "tfm"):
        reloaded.InitialTransform = f"{folder}/shift.{ending}"
        shifted = array(data(reloaded), "RTData").reshape(data(source).GetDimensions()[::-1])
        np.testing.assert_array_equal(shifted[:, :, :-2], volume.reshape(shifted.shape)[:, :, 2:])
