"""What `vtk-mls info` says: versions, devices, and what is wrong."""

from __future__ import annotations

import importlib
import os
import platform

import numpy as np

from vtk_mls import DeviceError, __version__, device, installation
from vtk_mls.resources import resource


def report():
    """What is installed and found.

    Returns
    -------
    lines : list of str
    problems : list of str
        What keeps something from working, with what to do.
    """
    problems = []
    lines = [
        f"vtk_mls    {__version__}",
        f"Python     {platform.python_version()}",
        f"numpy      {np.__version__}",
        f"VTK        {_version('vtkmodules.vtkCommonCore', problems)}",
        f"pyopencl   {_version('pyopencl', problems)}",
        f"ParaView   {_paraview(problems)}",
        f"plugin     {_plugin(problems)}",
        *_devices(problems),
    ]
    return lines, problems


def _version(module, problems):
    package = module.partition(".")[0]
    extra = "vtk" if module.startswith("vtk") else "pocl"
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name in (module, package)
        state = "not installed" if missing else f"cannot be imported: {error}"
        need = "the filters and `vtk-mls deform` need it" if extra == "vtk" else "OpenCL needs it"
        name = "VTK" if extra == "vtk" else "pyopencl"
        problems.append(f"{name} is {state}; {need}: pip install 'vtk-mls[{extra}]'")
        return state
    return found.vtkVersion.GetVTKVersion() if extra == "vtk" else found.VERSION_TEXT


def _paraview(problems):
    try:
        found = installation.find()
    except ValueError:
        return "not found"
    try:
        contents = found.contents()
    except ValueError as error:
        problems.append(str(error))
        return found
    if "problem" in contents:
        problems.append(f"{found}: {contents['problem']}")
    versions = ", ".join(
        f"{name} {contents[key]}"
        for name, key in (("Python", "python"), ("VTK", "vtk"), ("numpy", "numpy"))
    )
    return f"{found}: {versions}; the plugin loads, {contents.get('device', 'no OpenCL device')}"


def _plugin(problems):
    try:
        return resource("paraview_plugin") / "vtk_mls_plugin.py"
    except FileNotFoundError as error:
        problems.append(str(error))
        return "missing"


def _devices(problems):
    """A line for each device, the one that would be used with an arrow."""
    wanted = os.environ.get("VTK_MLS_DEVICE") or None
    chosen = None
    if wanted != "reference":
        try:
            chosen = device.choose(wanted)
        except DeviceError as error:
            problems.append(str(error))
    found = device.list_devices()
    lines = ["OpenCL devices" if found else "OpenCL devices: none"]
    for each in found:
        mark = "->" if each == chosen else "  "
        lines.append(f"  {mark} {each}, {each.version}")
        defect = device.defect(each)
        if defect:
            lines.append(f"       does not work: {defect}")
    if wanted is not None:
        lines.append(f"VTK_MLS_DEVICE is {wanted}")
    return lines
