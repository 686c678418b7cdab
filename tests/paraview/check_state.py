"""A saved state brings back the pipeline with all its properties, whatever defaults are by then."""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import array, control_points, data, wavelet

settings = {
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
handles = control_points(Weights=[1.0, 2.0] * 4)
deform = simple.MLSDeform(Input=wavelet(), ControlPoints=handles, **settings)
simple.RenameSource("deformed", deform)
expected = array(data(deform), "RTData").copy()

with tempfile.TemporaryDirectory() as folder:
    state = os.path.join(folder, "state.pvsm")
    simple.SaveState(state)
    for proxy in (deform, handles):
        simple.Delete(proxy)
    del deform, handles, proxy
    simple.ResetSession()
    assert simple.FindSource("deformed") is None
    simple.LoadState(state)

loaded = simple.FindSource("deformed")
for name, value in settings.items():
    current = getattr(loaded, name)
    assert (list(current) if isinstance(value, list) else current) == value, name
np.testing.assert_array_equal(array(data(loaded), "RTData"), expected)
