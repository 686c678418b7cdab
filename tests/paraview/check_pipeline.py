"""The proxies compute what `vtk_mls.Deformation` does, and follow every change."""

import numpy as np
from paraview import simple
from scene import DEFORMED, REST, array, control_points, data, grid, wavelet

import vtk_mls
from vtk_mls.model.options import ALPHA

source = wavelet()
handles = control_points()
deform = simple.MLSDeform(Input=source, ControlPoints=handles)
field = simple.MLSDisplacementField(Input=source, ControlPoints=handles)
deform.MapTolerance = field.MapTolerance = 0
volume = array(data(source), "RTData")
lattice = grid(data(source))


def check(deformed=DEFORMED, interpolation="linear", **settings):
    """Both filters against the value outside of the pipeline."""
    value = vtk_mls.Deformation(REST, deformed, **settings)
    background = 0 if interpolation == "nearest" else "auto"  # of labels, and of others
    sampling = vtk_mls.Sampling(lattice, interpolation=interpolation, background=background)
    (expected,) = value.resample([volume], sampling)
    result = array(data(deform), "RTData")
    assert result.dtype == volume.dtype
    np.testing.assert_array_equal(result, expected)
    displacement = array(data(field), "BackwardDisplacement")
    expected = value.displacement_field(lattice.dimensions, lattice.origin, lattice.spacing)
    np.testing.assert_array_equal(displacement, expected.displacement)
    assert np.abs(displacement).max() > 1
    return result


# Properties of the map.
results = []
for settings in (
    {"kind": "rigid"},
    {"kind": "polynomial", "degree": 1},
    {"kind": "rigid", "alpha": 1.5},
):
    for proxy in (deform, field):
        proxy.Kind = settings["kind"]
        proxy.Degree = settings.get("degree", 2)
        proxy.Alpha = settings.get("alpha", ALPHA.default)
    results.append(check(**settings))
assert not np.array_equal(results[0], results[-1])
for proxy in (deform, field):
    proxy.Alpha = ALPHA.default

# Interpolation, and labels, which are not interpolated.
deform.Interpolation = "cubic"
check(interpolation="cubic")
deform.LabelArrays = ["RTData"]
assert np.isin(check(interpolation="nearest"), [*volume.ravel(), 0]).all()
deform.LabelArrays = []
deform.Interpolation = "linear"


# Nothing is computed again without a change; a dragged handle changes the result.
def times():
    return [p.GetClientSideObject().GetOutputDataObject(0).GetMTime() for p in (deform, field)]


check()
before = times()
check()
assert times() == before
dragged = DEFORMED + np.array([0.5, 0, -1])
handles.DeformedPoints = list(dragged.ravel())
assert not np.array_equal(check(deformed=dragged), results[0])

# Another displacement array, by name.
halved = simple.Calculator(Input=handles, Function="Displacement / 2", ResultArrayName="Half")
deform.ControlPoints = field.ControlPoints = halved
deform.DisplacementArray = field.DisplacementArray = ["POINTS", "Half"]
check(deformed=(REST + dragged) / 2)
deform.ControlPoints = field.ControlPoints = handles
deform.DisplacementArray = field.DisplacementArray = ["POINTS", "Displacement"]
check(deformed=dragged)
