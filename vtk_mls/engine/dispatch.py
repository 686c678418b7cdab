"""Choice of the engine: an OpenCL device that passed its check, or the numpy reference."""

from __future__ import annotations

import dataclasses
import os

from vtk_mls.base.messages import warn
from vtk_mls.engine.device import device_check, devices, drivers
from vtk_mls.engine.device.devices import DeviceError
from vtk_mls.reference import engine as reference


def engine_for(name=None):
    """The engine for `name`, the `device` of a `Deformation`.

    Without a name it is the numpy reference if devices exist and all fail their check.

    Raises
    ------
    DeviceError
    """
    name = name or os.environ.get("VTK_MLS_DEVICE") or None
    if name == "reference":
        return reference
    chosen = choose(name)
    if chosen is None:
        return reference
    from vtk_mls.engine import engine  # needs OpenCL

    return engine.on(chosen)


def choose(name: str | None = None) -> devices.Device | None:
    """The device for `name`, with the number of points per work item that passed the check.

    Parameters
    ----------
    name : {"gpu", "cpu", "platform:device"}, optional
        The default is the first GPU, else the fastest CPU driver. MPI processes take the GPUs of
        their node in turn.

    Returns
    -------
    Device or None
        None without a name, if devices exist and all fail the check.

    Raises
    ------
    DeviceError
        If the device or any device is missing; it lists the devices found.
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
    install = f"install your GPU's driver, or one for the CPU: {drivers.advice()}"
    missing = "no OpenCL device found" if name is None else f"no OpenCL device `{name}`"
    if not found:
        raise DeviceError(f"{missing}: {problem}; {install}")
    listed = "found " + "; ".join(map(_with_failure, found))
    if name is None:
        warn(f"No OpenCL device computes right; numpy is used, slowly; {listed}; {install}")
        return None
    works = " that works" if any(name in (device.key, device.kind) for device in found) else ""
    raise DeviceError(
        f'{missing}{works}; {listed}; use another of these, or "reference"; {install}'
    )


def _working(found):
    """Devices that pass the check, the fastest first."""
    working = [pair for pair in zip(device_check.results(found), found) if pair[0].lanes]
    working.sort(key=lambda pair: -pair[0].speed)
    return [dataclasses.replace(device, width=result.lanes) for result, device in working]


def _with_failure(device):
    result = device_check.cached_result(device)
    fails = result is not None and not result.lanes
    return f"{device}" + (f", which fails: {result.failures[-1]}" if fails else "")
