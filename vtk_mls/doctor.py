"""What `vtk-mls doctor` says: versions, what each device has proven, and what is wrong."""

from __future__ import annotations

import importlib
import os
import platform

import numpy as np

from vtk_mls import DeviceError, __version__
from vtk_mls.commands import companion
from vtk_mls.engine import device, dispatch, drivers, proof
from vtk_mls.paraview import installation
from vtk_mls.resources import resource


def report(retest=False):
    """What is installed and found.

    Parameters
    ----------
    retest : bool, optional
        Test the devices although there are verdicts on them.

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
        *_devices(problems, retest),
    ]
    return lines, problems


def _version(module, problems):
    package = module.partition(".")[0]
    is_vtk = module.startswith("vtk")
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name in (module, package)
        if missing and is_vtk:  # as it should be in an environment for ParaView
            return (
                "not installed: ParaView brings its own, the filters in Python and `vtk-mls "
                "deform` need it (pip install vtk)"
            )
        state = "not installed" if missing else f"cannot be imported: {error}"
        name, cure = ("VTK", "pip install vtk") if is_vtk else ("pyopencl", drivers.advice())
        problems.append(f"{name} is {state}: {cure}")
        return state
    return found.vtkVersion.GetVTKVersion() if is_vtk else found.__version__


def _paraview(problems):
    try:
        found = installation.find()
    except ValueError:
        return "not found"
    try:
        contents, _ = companion.look(found)
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


def _devices(problems, retest):
    """What each device has proven, the one that would be used with an arrow."""
    wanted = os.environ.get("VTK_MLS_DEVICE") or None
    lines, found, chosen = [], [], None
    try:
        found = device.list_devices()
        verdicts = proof.verdicts(found, retest)
        if wanted != "reference":
            chosen = dispatch.choose(wanted)
            if chosen is None:
                problems.append(
                    f"no OpenCL device computes right, numpy does it, slowly: {drivers.advice()}"
                )
    except DeviceError as error:
        problems.append(str(error))
    lines.append("OpenCL devices" if found else "OpenCL devices: none")
    for each, verdict in zip(found, verdicts if found else ()):
        mark = "->" if chosen is not None and each.key == chosen.key else "  "
        lines.append(f"  {mark} {each}, {each.version}, driver {each.driver}")
        lines += [f"       {line}" for line in _verdict(each, verdict)]
    if not any(drivers.is_fastest(each.platform) for each in found):
        lines.append(f"faster on this processor: {drivers.advice()}")
    if wanted is not None:
        lines.append(f"VTK_MLS_DEVICE is {wanted}")
    return lines


def _verdict(each, verdict):
    if verdict.lanes:
        how = "computes right" if verdict.proven else "not tested, for no Python could be started"
        speed = f", {verdict.speed / 1e6:.0f} million points/s" if verdict.speed else ""
        yield f"{how} with {verdict.lanes} points per work item{speed}"
    else:
        yield "is not used"
    yield from verdict.failures
    kept = proof.record_path(each)
    yield f"verdict kept in {kept}" if kept and kept.exists() else "verdict not kept"
