"""Which engine answers: a device, or the numpy specification."""

from __future__ import annotations

import os

from vtk_mls import device, reference


def engine_for(name=None):
    """The engine for the device `name`, as `device` of `Deformation` describes it.

    Raises
    ------
    DeviceError
    """
    name = name or os.environ.get("VTK_MLS_DEVICE") or None
    if name == "reference":
        return reference
    chosen = device.choose(name)
    from vtk_mls import engine  # only now is OpenCL needed

    return engine.on(chosen)
