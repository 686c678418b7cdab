"""OpenCL devices: discovery, drivers and the check before the first use."""
