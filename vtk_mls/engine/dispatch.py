"""Chooses the engine: an OpenCL device that computes right, or the numpy reference."""

from __future__ import annotations

import dataclasses
import os

from vtk_mls.base.messages import warn
from vtk_mls.engine.device import device_check, devices, drivers
from vtk_mls.engine.device.devices import DeviceError
from vtk_mls.reference import engine as reference


def engine_for(name=None):
    """The engine for the device `name`, as `device` of `Deformation` describes it.

    Without a name, and where there are devices but none that computes right, it is the
    specification.

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
    from vtk_mls.engine import engine  # only now is OpenCL needed

    return engine.on(chosen)


def choose(name: str | None = None) -> devices.Device | None:
    """The device meant by `name`, with as many points per work item as it computes right.

    Parameters
    ----------
    name : {"gpu", "cpu", "platform:device"}, optional
        The first GPU, else the fastest CPU driver, if not given. MPI processes share out the GPUs
        of their node: the first takes the first GPU, the second the second, and so on round.

    Returns
    -------
    Device or None
        None without a name, if there are devices and none of them computes right.

    Raises
    ------
    DeviceError
        If there is none as named, or none at all; it lists what there is.
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
    if name in ("cpu", None) and (working := _working(cpus)):
        return working[0]
    install = f"install your GPU's driver, or one for the CPU: {drivers.advice()}"
    wanted = "no OpenCL device found" if name is None else f"no OpenCL device `{name}`"
    if not found:
        raise DeviceError(f"{wanted}: {problem}; {install}")
    listed = "found " + "; ".join(map(_with_failure, found))
    if name is None:
        warn(f"No OpenCL device computes right, numpy does it, slowly; {listed}; {install}")
        return None
    works = " that works" if any(name in (device.key, device.kind) for device in found) else ""
    raise DeviceError(f'{wanted}{works}; {listed}; use another of these, or "reference"; {install}')


def _working(found):
    """Devices that compute right, the fastest first."""
    working = [pair for pair in zip(device_check.results(found), found) if pair[0].lanes]
    working.sort(key=lambda pair: -pair[0].speed)
    return [dataclasses.replace(device, width=result.lanes) for result, device in working]


def _with_failure(device):
    result = device_check.cached_result(device)
    fails = result is not None and not result.lanes
    return f"{device}" + (f", which fails: {result.failures[-1]}" if fails else "")
