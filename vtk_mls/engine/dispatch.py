"""Choice of the engine: an OpenCL device that passed its check, or the numpy reference."""

from __future__ import annotations

import os

from vtk_mls.base import lazy
from vtk_mls.base.messages import warn
from vtk_mls.engine.device import device_check, devices, drivers
from vtk_mls.engine.device.devices import NoDevice
from vtk_mls.reference import reference_engine as reference


def engine_for(name=None):
    """The engine for `name`, the `device` of a `Deformation`.

    Without a name it is the numpy reference if no device works, with one warning.

    Raises
    ------
    DeviceError
    """
    name = name or os.environ.get("VTK_MLS_DEVICE") or None
    if name == "reference":
        return reference
    try:
        chosen = choose(name)
    except NoDevice as error:
        if name is not None:
            raise
        _warn_once(f"numpy is used, slowly: {error}")
        return reference
    from vtk_mls.engine import opencl_engine as engine  # needs OpenCL

    return engine.on(chosen)


_warn_once = lazy.cached(warn)


def choose(name: str | None = None) -> devices.Device:
    """The device for `name`, which passed the check.

    Parameters
    ----------
    name : {"gpu", "cpu", "platform:device"}, optional
        The default is the first GPU, else the fastest CPU driver. MPI processes take the GPUs of
        their node in turn.

    Raises
    ------
    NoDevice
        If the device is missing or fails the check; it lists the devices found.
    """
    found, problem = devices.find()
    for device in found:
        if name == device.key and (working := _working([device])):
            return working[0]
    gpus = [device for device in found if device.kind == "gpu"]
    if name in ("gpu", None):
        for device in devices.shared_out(gpus):
            if working := _working([device]):
                return working[0]
    cpus = [device for device in found if device.kind == "cpu" and devices.is_free(device)]
    for is_fastest in (True, False) if name in ("cpu", None) else ():  # which saves checks
        alike = [device for device in cpus if drivers.is_fastest(device.platform) == is_fastest]
        if working := _working(alike):
            return working[0]
    missing = "no OpenCL device" + (f" `{name}`" if name else " that works")
    if name and any(name in (device.key, device.kind) for device in found):
        missing += " that works"
    listed = "; found " + "; ".join(map(_with_failure, found)) if found else f": {problem}"
    others = "another of these or " * bool(name and found)
    raise NoDevice(
        f"{missing}{listed}; install your GPU's driver, or one for the CPU: {drivers.advice()}; or "
        f'use {others}device="reference"'
    )


def _working(found):
    """Devices that pass the check, the fastest first."""
    checked = zip(device_check.results(found), found)
    working = [(result.speed, device) for result, device in checked if not result.failure]
    return [device for _, device in sorted(working, key=lambda pair: -pair[0])]


def _with_failure(device):
    result = device_check.cached_result(device)
    return f"{device}" + (f", not used: {result.failure}" if result and result.failure else "")
