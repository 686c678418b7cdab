"""The own handles of MLS Deform, in scripts, states and animations."""

import numpy as np
from paraview import simple
from scene import DEFORMED, REST, array, control_points, data, wavelet

source = wavelet()
source.UpdatePipeline()
volume = array(data(source), "RTData")

# A new filter has a lattice of handles over the bounds of the input, and is the identity.
deform = simple.MLSDeform(Input=source)
rest = np.reshape(deform.RestPoints, (-1, 3))
expected = {(x, y, z) for z in (-7, 1, 9) for y in (-8, 0, 8) for x in (-9, -0.5, 8)}
assert len(rest) == 27
assert {tuple(place) for place in rest} == expected
np.testing.assert_array_equal(rest, np.reshape(deform.DeformedPoints, (-1, 3)))
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
field = simple.MLSDisplacementField(Input=source)
assert list(field.RestPoints) == list(deform.RestPoints)
assert not array(data(field), "BackwardDisplacement").any()

# A dragged handle deforms; the handles stay in place when the input changes.
dragged = list(deform.DeformedPoints)
dragged[0] -= 3
deform.DeformedPoints = dragged
assert not np.array_equal(array(data(deform), "RTData"), volume)
source.WholeExtent = [-9, 8, -8, 8, -7, 5]
data(deform)
np.testing.assert_array_equal(rest, np.reshape(deform.RestPoints, (-1, 3)))
source.WholeExtent = [-9, 8, -8, 8, -7, 9]

# Own handles work as those of a source, which replace them while it is connected.
handles = control_points()
bent = array(data(simple.MLSDeform(Input=source, ControlPoints=handles)), "RTData").copy()
for proxy in (deform, field):
    proxy.RestPoints, proxy.DeformedPoints = list(np.ravel(REST)), list(np.ravel(DEFORMED))
np.testing.assert_array_equal(array(data(deform), "RTData"), bent)
deform.DeformedPoints = list(np.ravel(REST))
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
deform.ControlPoints = handles
np.testing.assert_array_equal(array(data(deform), "RTData"), bent)
deform.ControlPoints = None
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
deform.DeformedPoints = list(np.ravel(DEFORMED))
np.testing.assert_array_equal(array(data(deform), "RTData"), bent)

# An animation of the blend, and of a handle's place.
half = control_points(REST, (REST + DEFORMED) / 2)
middle = array(data(simple.MLSDeform(Input=source, ControlPoints=half)), "RTData")

# Another displacement array, by name.
halved = simple.Calculator(Input=handles, Function="Displacement / 2", ResultArrayName="Half")
named = simple.MLSDeform(Input=source, ControlPoints=halved)
named.DisplacementArray = ["POINTS", "Half"]
np.testing.assert_allclose(array(data(named), "RTData"), middle, atol=1e-2)
scene = simple.GetAnimationScene()
scene.PlayMode, scene.NumberOfFrames = "Sequence", 3
scene.StartTime, scene.EndTime = 0.0, 1.0


def animate(name, index, first, last):
    track = simple.GetAnimationTrack(name, index=index, proxy=deform)
    keys = [simple.CompositeKeyFrame(KeyTime=k, KeyValues=[v]) for k, v in ((0, first), (1, last))]
    track.KeyFrames = keys
    return track


track = animate("Blend", 0, 0.0, 1.0)
for time, expected in ((0.0, volume), (0.5, middle), (1.0, bent)):
    scene.AnimationTime = time
    np.testing.assert_allclose(array(data(deform), "RTData"), expected, atol=1e-2)
track.Enabled = 0
deform.Blend = 1.0
track = animate("DeformedPoints", 14, float(DEFORMED[4, 2]), float(DEFORMED[4, 2]) + 4)
moved = DEFORMED.copy()
for time, expected in ((0.0, 0), (1.0, 4)):
    scene.AnimationTime = time
    moved[4, 2] = DEFORMED[4, 2] + expected
    np.testing.assert_array_equal(np.reshape(deform.DeformedPoints, (-1, 3)), moved)
    alike = simple.MLSDeform(Input=source, ControlPoints=control_points(REST, moved))
    np.testing.assert_array_equal(array(data(deform), "RTData"), array(data(alike), "RTData"))
track.Enabled = 0
simple.Delete(track)
deform.DeformedPoints = list(np.ravel(DEFORMED))

# Before an update the bounds of the input are unknown; it is the identity then, too.
deform = simple.MLSDeform(Input=wavelet())
np.testing.assert_array_equal(array(data(deform), "RTData"), volume)
