"""The command `vtk-mls`."""

from __future__ import annotations

import sys

from vtk_mls import __version__
from vtk_mls.commands.supervision import IS_POSSIBLE, supervise


def main(arguments=None):
    """Run a command.

    Parameters
    ----------
    arguments : list of str, optional
        Instead of those of the process; all is done in this process then, and what makes VTK
        crash ends it.

    Returns
    -------
    int
        Exit status: 0, 1 after one sentence on stderr, or 130 after Ctrl-C.
    """
    try:
        # ParaView is a process of its own, and Ctrl-C is for it too
        if arguments is None and IS_POSSIBLE and sys.argv[1:2] != ["paraview"]:
            return supervise(lambda: _run(None))
        return _run(arguments)
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return 130


def _run(arguments):
    import warnings

    from vtk_mls import Aborted, DeviceError

    arguments = sys.argv[1:] if arguments is None else arguments
    options = _parser().parse_args(_with_values(arguments))
    try:
        with warnings.catch_warnings():
            # numpy's remarks about values that are not finite, in files or for want of digits
            warnings.simplefilter("ignore", RuntimeWarning)
            return options.run(options)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("vtkmodules", "vtk"):
            raise
        message = "VTK is not installed: pip install vtk"
    except (Aborted, DeviceError, OSError, ValueError) as error:
        message = str(error)
    except MemoryError:
        message = "there is not enough memory"
    print(f"vtk-mls: {' '.join(message.split())}", file=sys.stderr)
    return 1


def _with_values(arguments):
    """Options joined with their values, `--cut-plane=-1,...`, where these begin with a minus.

    argparse takes such lists of numbers for options.
    """
    joined = []
    for each in arguments:
        before = joined[-1] if joined else ""
        is_value = before[:2] == "--" != before and "=" not in before
        if is_value and each[:1] == "-" and each[1:2] in [*"0123456789."]:
            joined[-1] += f"={each}"
        else:
            joined.append(each)
    return joined


def _parser():
    import argparse

    from vtk_mls.commands import deform, demo, field, paraview, points, view

    parser = argparse.ArgumentParser(
        prog="vtk-mls", description="Moving-least-squares deformation of volumes by control points."
    )
    parser.add_argument("--version", action="version", version=f"vtk-mls {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    deform.add(commands)
    field.add(commands)
    points.add(commands)
    view.add(commands)
    info = commands.add_parser(
        "doctor",
        aliases=["info"],
        help="show versions, checked OpenCL devices, and problems",
        description="Show versions, checked OpenCL devices, and problems. "
        "Exit status 1 if something is.",
    )
    info.add_argument("--retest", action="store_true", help="test the devices again")
    info.set_defaults(run=_info)
    paraview.add(commands)
    path = commands.add_parser(
        "plugin-path",
        help="print the folder of the ParaView plugin",
        description="Print the folder of the ParaView plugin, for ParaView to load it by itself: "
        'export PV_PLUGIN_PATH="$(vtk-mls plugin-path)"',
    )
    path.set_defaults(run=_plugin_path)
    demo.add(commands)
    return parser


def _info(options):
    from vtk_mls.doctor import report

    lines, problems = report(options.retest)
    print("\n".join(lines))
    for problem in problems:
        print(f"wrong: {problem}")
    return 1 if problems else 0


def _plugin_path(options):
    from vtk_mls.base.resources import resource

    print(resource("paraview_plugin"))
    return 0
