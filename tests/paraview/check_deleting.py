"""ParaView survives new filters after others were deleted."""

from scene import simple

source = simple.Wavelet()
filters = [simple.MLSDeform(Input=source, ControlPoints=simple.MLSControlPoints()) for _ in "12"]
for proxy in filters:
    proxy.UpdatePipeline()
    simple.Delete(proxy)
del filters, proxy
for _ in range(5):
    simple.MLSImageReader()
