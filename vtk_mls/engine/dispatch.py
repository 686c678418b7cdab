"""Choice of the engine: an OpenCL device that passed its check, or the numpy reference."""

import os

from vtk_mls.base import lazy
from vtk_mls.base.messages import warn
from vtk_mls.engine.device import device_check, devices, drivers
from vtk_mls.engine.device.device_check import BASIC, SUBJECTS
from vtk_mls.engine.device.devices import NoDevice
from vtk_mls.reference import reference_engine as reference


def engine_for(name=None, needs_float64=False, needed=()):
    """The engine for `name`, the `device` of a `Deformation`, or DeviceError.

    It is the numpy reference, with one warning, if no device works and none is named, or if the
    device has no float64 and the map needs it. The device has passed the check of what is `needed`
    besides the first of `device_check.SUBJECTS`.
    """
    name = name or os.environ.get("VTK_MLS_DEVICE") or None
    if name == "reference":
        return reference
    subjects = tuple(subject for subject in SUBJECTS if subject in {BASIC, *needed})
    try:
        chosen = _chosen(name, subjects, os.getpid())
    except NoDevice as error:
        if name is not None:
            raise
        _warn_once(f"numpy is used, slowly: {error}")
        return reference
    if needs_float64 and not chosen.has_float64:
        _warn_once(f"{chosen} has no double precision, which this spline needs: numpy is used")
        return reference
    from vtk_mls.engine import opencl_engine as engine  # needs OpenCL

    return engine.on(chosen)


_warn_once = lazy.cached(warn)


@lazy.cached
def _chosen(name, subjects, process):
    """The device for a name in a process; a fork must not use that of its parent."""
    return choose(name, subjects)


def choose(name=None, subjects=SUBJECTS, is_checked=True):
    """The device for `name`, which passed the check of subjects.

    Names are "gpu", "cpu" and "platform:device". The default is the first GPU, else the fastest CPU
    driver. MPI processes take the GPUs of their node in turn. Devices are checked in the order of
    preference, and none after the first that passes; without `is_checked` none is, and those that
    have failed are left out. NoDevice, if none is left, lists the devices found.
    """
    found, problem = devices.find()
    candidates = [device for device in found if device.key == name]
    if name in ("gpu", None):
        candidates += devices.shared_out([device for device in found if device.kind == "gpu"])
    if name in ("cpu", None):
        cpus = [device for device in found if device.kind == "cpu" and devices.is_free(device)]
        candidates += sorted(cpus, key=lambda device: drivers.rank(device.platform))
    for device in candidates:
        if is_checked:
            failure = device_check.results([device], subjects)[0].failure
        else:
            failure = device_check.failure(device)
        if not failure:
            return device
    missing = "no OpenCL device" + (f" `{name}`" if name else " that works")
    if name and any(name in (device.key, device.kind) for device in found):
        missing += " that works"
    listed = "; found " + "; ".join(map(_with_failure, found)) if found else f": {problem}"
    others = "another of these or " * bool(name and found)
    raise NoDevice(
        f"{missing}{listed}; install your GPU's driver, or one for the CPU: {drivers.advice()}; or "
        f'use {others}device="reference"'
    )


def _with_failure(device):
    failure = device_check.failure(device)
    return f"{device}" + (f", not used: {failure}" if failure else "")
