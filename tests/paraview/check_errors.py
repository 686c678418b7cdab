"""Bad input is reported in one readable sentence, leaves no data, and is over once it is mended."""

import numpy as np
from paraview import simple
from scene import DEFORMED, array, control_points, data, output_messages, wavelet

source = wavelet()
volume = array(data(source), "RTData")
handles = control_points()
deform = simple.MLSDeform(Input=source, ControlPoints=handles)
field = simple.MLSDisplacementField(Input=source, ControlPoints=handles)
moved = array(data(deform), "RTData").copy()
assert not np.array_equal(moved, volume)


def check(proxy, name, bad, *words, filters=(deform, field)):
    """Set a bad value, read the message, set the good value again."""
    good = getattr(proxy, name)
    good = list(good) if hasattr(good, "__len__") and not isinstance(good, str) else good
    with output_messages() as text:
        setattr(proxy, name, bad)
        for each in filters:
            each.UpdatePipeline()
    assert all(word in text[0] for word in words), (name, bad, text[0])
    assert "Traceback" not in text[0], text[0]
    for each in filters:
        assert each.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints() == 0
    setattr(proxy, name, good)
    np.testing.assert_array_equal(array(data(deform), "RTData"), moved)
    assert array(data(field), "BackwardDisplacement").any()


check(handles, "DeformedPoints", list(DEFORMED[:3].ravel()), "DeformedPoints", "8", "3")
check(handles, "Weights", [1.0, 2.0], "Weights", "8", "2")
check(handles, "Weights", [1.0] * 7 + [-1.0], "weights", "positive")
check(handles, "DeformedPoints", [np.nan, *DEFORMED.ravel()[1:]], "nan")
for proxy in (deform, field):
    check(proxy, "Alpha", -1.0, "`alpha`", "-1", filters=[proxy])
    check(proxy, "Degree", 0, "`degree`", "0", filters=[proxy])
    check(proxy, "Kind", "elastic", "`kind`", "elastic", "similarity", filters=[proxy])
    check(proxy, "Device", "9:9", "9:9", filters=[proxy])
    check(
        proxy,
        "DisplacementArray",
        ["POINTS", "Velocity"],
        "Velocity",
        "Displacement",
        filters=[proxy],
    )
check(deform, "Interpolation", "sharp", "`Interpolation`", "sharp", filters=[deform])
