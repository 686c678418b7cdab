"""`vtk-mls paraview`: ParaView with the plugin."""

from __future__ import annotations

import os

from vtk_mls.base import display
from vtk_mls.files.existing import existing_file


def add(commands):
    """Add the command to its parent's parsers."""
    paraview = commands.add_parser(
        "paraview",
        help="start ParaView with the plugin loaded",
        description="Start ParaView with the plugin loaded, and with a volume to deform.",
    )
    paraview.add_argument("file", nargs="?", help="what to open, instead of a sample")
    add = paraview.add_argument
    add("--paraview", metavar="DIR", help="where ParaView is, if not on PATH or in a usual place")
    add("--venv", metavar="DIR", help="virtual environment that ParaView is to use (from 5.13 on)")
    add(
        "--setup",
        action="store_true",
        help="instead of starting it, make the virtual environment that a downloaded ParaView "
        "needs, in DIR of --venv or where it is found from then on",
    )
    add("--option", metavar="TEXT", action="append", default=[], help="handed on to ParaView")
    paraview.set_defaults(run=run)


def run(options):
    """Run the command."""
    from vtk_mls.paraview import installation

    found = installation.find(options.paraview)
    if not options.setup:
        _check_can_start(options)
    return (_set_up if options.setup else _start)(found, options)


def _check_can_start(options):
    """Raise OSError if there is no such file, or nothing to show it on."""
    if options.file is not None:
        existing_file(options.file)
    if not os.environ.get("QT_QPA_PLATFORM"):
        display.check()


def _set_up(found, options):
    """Make what a ParaView lacks."""
    from vtk_mls.commands import companion

    contents = found.contents()
    if "device" in contents:
        print(f"{found} needs nothing, it has {contents['device']}")
        return 0
    folder = companion.make(found, contents, options.venv)
    contents = found.contents(folder)
    if "device" not in contents:
        raise ValueError(f"{folder} is made, and yet in {found}: {contents['problem']}")
    option = f" --venv {options.venv}" if options.venv else ""
    print(f"{found} has {contents['device']} now: start it with vtk-mls paraview{option}")
    return 0


def _start(found, options):
    """Start a ParaView."""
    import subprocess

    from vtk_mls.commands import companion
    from vtk_mls.paraview import installation

    if options.venv is None:
        contents, venv = companion.look(found)
    else:
        found.check_venv(options.venv, found.contents()["python"])
        contents, venv = found.contents(options.venv), options.venv
    command = [str(found.program), *options.option]
    if venv is not None:
        command.append(f"--venv={venv}")
    if "problem" in contents:
        print(f"vtk-mls: in ParaView's Python {contents['python']}: {contents['problem']}")
    if not any(option.startswith("--script") for option in options.option):
        command.append(f"--script={installation.SCENE}")
    variables = found.environment()
    if options.file is not None:
        variables["VTK_MLS_OPEN"] = os.path.abspath(options.file)
    print(f"{found}, {contents.get('device', 'no OpenCL device')}", flush=True)
    return subprocess.run(command, env=variables, check=False).returncode
