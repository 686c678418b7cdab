"""Which engine answers: a device that has proven itself, or the numpy specification."""

from __future__ import annotations

import dataclasses
import os

from vtk_mls import reference
from vtk_mls.announcements import warn
from vtk_mls.engine import device as devices
from vtk_mls.engine import drivers, proof
from vtk_mls.engine.device import DeviceError


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
    """The device meant by `name`, with as many points per work item as it has proven.

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
        if name == device.key and (sound := _proven([device])):
            return sound[0]
    gpus = [device for device in found if device.kind == "gpu"]
    if name in ("gpu", None):
        for device in devices.shared_out(gpus):
            if sound := _proven([device]):
                return sound[0]
    cpus = [device for device in found if device.kind == "cpu" and devices.is_free(device)]
    if name in ("cpu", None) and (sound := _proven(cpus)):
        return sound[0]
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


def _proven(found):
    """Those of the devices that have proven themselves, the fastest first."""
    sound = [pair for pair in zip(proof.verdicts(found), found) if pair[0].lanes]
    sound.sort(key=lambda pair: -pair[0].speed)
    return [dataclasses.replace(device, width=verdict.lanes) for verdict, device in sound]


def _with_failure(device):
    verdict = proof.known(device)
    fails = verdict is not None and not verdict.lanes
    return f"{device}" + (f", which fails: {verdict.failures[-1]}" if fails else "")
