"""The report of `vtk-mls doctor`: versions, checked OpenCL devices, and problems."""

import importlib
import os
import platform

import numpy as np

from vtk_mls import DeviceError, __version__
from vtk_mls.base.resources import resource
from vtk_mls.commands.paraview import find_venv
from vtk_mls.engine import dispatch
from vtk_mls.engine.device import device_check, drivers
from vtk_mls.engine.device import devices as device
from vtk_mls.paraview import installation


def report(retest=False):
    """Lines about versions and devices, which are checked again with `retest`, and problems."""
    problems = []
    lines = [
        f"vtk_mls    {__version__}",
        f"Python     {platform.python_version()}",
        f"numpy      {np.__version__}",
        f"VTK        {_version('vtkmodules.vtkCommonCore', problems)}",
        f"pyopencl   {_version('pyopencl', problems)}",
        f"ParaView   {_paraview(problems)}",
        f"plugin     {_plugin(problems)}",
        *_devices(problems, retest),
    ]
    return lines, problems


def _version(module, problems):
    package = module.partition(".")[0]
    is_vtk = module.startswith("vtk")
    try:
        imported = importlib.import_module(module)
    except ImportError as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name in (module, package)
        if missing and is_vtk:  # right for an environment of ParaView
            return (
                "not installed: ParaView brings its own, the filters in Python and `vtk-mls "
                "deform` need it (pip install vtk)"
            )
        state = "not installed" if missing else f"cannot be imported: {error}"
        name, remedy = ("VTK", "pip install vtk") if is_vtk else ("pyopencl", drivers.advice())
        problems.append(f"{name} is {state}: {remedy}")
        return state
    return imported.vtkVersion.GetVTKVersion() if is_vtk else imported.__version__


def _paraview(problems):
    try:
        paraview = installation.find()
    except ValueError:
        return "not found"
    try:
        contents, _ = find_venv(paraview)
    except ValueError as error:
        problems.append(str(error))
        return paraview
    if "problem" in contents:
        problems.append(f"{paraview}: {contents['problem']}")
    versions = "Python {python}, VTK {vtk}, numpy {numpy}".format_map(contents)
    return f"{paraview}: {versions}; the plugin loads, {contents.get('device', 'no OpenCL device')}"


def _plugin(problems):
    try:
        return resource("paraview_plugin") / "vtk_mls_plugin.py"
    except FileNotFoundError as error:
        problems.append(str(error))
        return "missing"


def _devices(problems, retest):
    """The result for each device; an arrow marks the device that would be used."""
    requested = os.environ.get("VTK_MLS_DEVICE") or None
    lines, devices, used_device = [], [], None
    try:
        devices = device.list_devices()
        results = device_check.results(devices, recheck=retest)
        if requested != "reference":
            used_device = dispatch.choose(requested)
    except DeviceError as error:
        problems.append(str(error))
    lines.append("OpenCL devices" if devices else "OpenCL devices: none")
    for candidate, result in zip(devices, results if devices else ()):
        is_used = used_device is not None and candidate.key == used_device.key
        mark = "->" if is_used else "  "
        lines.append(f"  {mark} {candidate}, {candidate.version}, driver {candidate.driver}")
        lines += [f"       {line}" for line in _result(candidate, result)]
    if not any(drivers.is_fastest(candidate.platform) for candidate in devices):
        lines.append(f"faster on this processor: {drivers.advice()}")
    if requested is not None:
        lines.append(f"VTK_MLS_DEVICE is {requested}")
    return lines


def _result(device, result):
    if result.failure:
        yield f"is not used: {result.failure}"
    else:
        how = "computes right" if result.is_checked else "not checked, no process could check it"
        yield f"{how} with {device.lanes} points per work item"
    path = device_check.result_path(device)
    yield f"result kept in {path}" if path and path.exists() else "result not kept"
