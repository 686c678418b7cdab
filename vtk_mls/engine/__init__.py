"""The map on OpenCL devices, and which device computes it."""
