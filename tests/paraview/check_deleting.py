"""Filters that are deleted leave nothing behind that ends ParaView when others are made."""

from scene import simple

source = simple.Wavelet()
filters = [simple.MLSDeform(Input=source, ControlPoints=simple.MLSControlPoints()) for _ in "12"]
for each in filters:
    each.UpdatePipeline()
    simple.Delete(each)
del filters, each
for _ in range(5):
    simple.MLSImageReader()
