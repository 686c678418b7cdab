"""The command `vtk-mls`."""

import sys

from vtk_mls import __version__
from vtk_mls.base import child_process
from vtk_mls.commands.supervision import supervise

# Commands with a module each, and what the list of commands says about them.
_COMMANDS = {
    "deform": "deform an image or a mesh file",
    "field": "write the displacement field of a deformation, a transform for other programs",
    "points": "move a file of landmarks with the material",
    "check": "find bad pairs of landmarks, and the settings that suit them",
    "view": "deform an image or a mesh by the mouse, in a browser",
    "paraview": "start ParaView with the plugin loaded",
    "demo": "cut a real brain open",
}


def main(arguments=None):
    """Run a command; its exit status: 0, 1 after one sentence on stderr, or 130 after Ctrl-C.

    A list of `arguments` is run in this process, which a crash of VTK ends; by default those of the
    process are run in a child.
    """
    try:
        # ParaView is a process of its own, and Ctrl-C is for it too
        is_supervised = arguments is None and sys.argv[1:2] != ["paraview"]
        arguments = sys.argv[1:] if arguments is None else arguments
        if is_supervised and child_process.interpreter():
            return supervise("vtk_mls.commands.cli:run", arguments)
    except OSError as error:  # no folder for temporary files, or too many processes
        return _fail(str(error))
    return run(arguments)


def run(arguments):
    """Run a command in this process; the exit status, as of `main`."""
    import warnings

    from vtk_mls import Aborted, DeviceError

    try:
        words = _with_values(arguments)
        options = _parser(words).parse_args(words)
        with warnings.catch_warnings():
            # numpy's warnings about values that are not finite
            warnings.simplefilter("ignore", RuntimeWarning)
            return options.run(options)
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return 130
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("vtkmodules", "vtk"):
            raise
        return _fail("VTK is not installed: pip install vtk")
    except (Aborted, DeviceError, OSError, ValueError) as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("there is not enough memory")


def _fail(message):
    print(f"vtk-mls: {' '.join(message.split())}", file=sys.stderr)
    return 1


def _with_values(arguments):
    """Join options with values that begin with a minus, as `--cut-plane=-1,...`.

    argparse would take such lists of numbers for options.
    """
    joined = []
    for argument in arguments:
        before = joined[-1] if joined else ""
        is_value = before[:2] == "--" != before and "=" not in before
        if is_value and argument[:1] == "-" and argument[1:2] in [*"0123456789."]:
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def _parser(words=None):
    """The parser of the command in words, or of all: the others are only listed."""
    import argparse
    from importlib import import_module

    parser = argparse.ArgumentParser(
        prog="vtk-mls", description="Moving-least-squares deformation of volumes by control points."
    )
    parser.add_argument("--version", action="version", version=f"vtk-mls {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, text in _COMMANDS.items():
        command = commands.add_parser(name, help=text)
        if words is None or name in words[:1]:
            module = import_module(f"vtk_mls.commands.{name}")
            module.add(command)
            command.set_defaults(run=module.run, parser=command)
    info = commands.add_parser(
        "doctor",
        aliases=["info"],
        help="show versions, checked OpenCL devices, and problems",
        description="Show versions, checked OpenCL devices, and problems. "
        "The exit status is 1 if there are problems.",
    )
    info.add_argument("--retest", action="store_true", help="test the devices again")
    info.set_defaults(run=_info)
    path = commands.add_parser(
        "plugin-path",
        help="print the folder of the ParaView plugin",
        description="Print the folder of the ParaView plugin. ParaView loads it at each start with "
        'export PV_PLUGIN_PATH="$(vtk-mls plugin-path)"',
    )
    path.set_defaults(run=_plugin_path)
    return parser


def _info(options):
    from vtk_mls.commands.installation import report

    lines, problems = report(options.retest)
    print("\n".join(lines))
    for problem in problems:
        print(f"wrong: {problem}")
    return 1 if problems else 0


def _plugin_path(options):
    from vtk_mls.base.resources import resource

    print(resource("paraview_plugin"))
    return 0
