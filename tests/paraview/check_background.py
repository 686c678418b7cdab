"""A new filter has an automatic background; a Background other than 0 is used as before."""

import numpy as np
from paraview import simple
from scene import array, data, wavelet

FAR = {"RestPoints": [0, 0, 0], "DeformedPoints": [900, 0, 0], "Device": "reference"}
source = wavelet()
values = array(data(source), "RTData")
corners = values[:: len(values) - 1, :: values.shape[1] - 1, :: values.shape[2] - 1]
median = np.percentile(corners, 50, method="lower")
deform = simple.MLSDeform(Input=source, **FAR)
assert deform.AutomaticBackground == 1
assert (array(data(deform), "RTData") == median).all()
deform.Background = -5.0
assert (array(data(deform), "RTData") == -5).all()
deform.Background, deform.AutomaticBackground = 0.0, 0
assert not array(data(deform), "RTData").any()
deform.AutomaticBackground = 1
assert (array(data(deform), "RTData") == median).all()
