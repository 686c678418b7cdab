"""`vtk-mls paraview`: ParaView with the plugin."""

import os
import subprocess

from vtk_mls.base import display
from vtk_mls.commands import paraview_venv
from vtk_mls.files.paths import existing_file
from vtk_mls.paraview import installation


def add(commands, text=None):
    paraview = commands.add_parser(
        "paraview",
        help=text,
        description="Start ParaView with the plugin loaded, and with a volume to deform.",
    )
    paraview.add_argument("file", nargs="?", help="file to open instead of a sample")
    add = paraview.add_argument
    add(
        "--paraview",
        metavar="DIR",
        help="folder of ParaView, if it is not on PATH or in a usual place",
    )
    add("--venv", metavar="DIR", help="virtual environment for ParaView 5.13 and later")
    add(
        "--setup",
        action="store_true",
        help="make the virtual environment that a downloaded ParaView needs, instead of starting "
        "ParaView: in DIR of --venv, or where it is found from then on",
    )
    add("--option", metavar="TEXT", action="append", default=[], help="option passed to ParaView")
    paraview.set_defaults(run=run)


def run(options):
    paraview = installation.find(options.paraview)
    if options.setup:
        return _set_up(paraview, options)
    if options.file is not None:
        existing_file(options.file)
    if not os.environ.get("QT_QPA_PLATFORM"):
        display.check()
    return _start(paraview, options)


def _set_up(paraview, options):
    contents = paraview.contents()
    if "problem" not in contents:
        print(f"{paraview} needs nothing, it has {contents['device']}")
        return 0
    folder = paraview_venv.make(paraview, contents, options.venv)
    contents = paraview.contents(folder)
    if "problem" in contents:
        raise ValueError(f"{folder} is made, and yet in {paraview}: {contents['problem']}")
    option = f" --venv {options.venv}" if options.venv else ""
    print(f"{paraview} has {contents['device']} now: start it with vtk-mls paraview{option}")
    return 0


def _start(paraview, options):
    if options.venv is None:
        contents, venv = paraview_venv.find(paraview)
    else:
        paraview.check_venv(options.venv, paraview.contents()["python"])
        contents, venv = paraview.contents(options.venv), options.venv
    command = [str(paraview.program), *options.option]
    if venv is not None:
        command.append(f"--venv={venv}")
    if "problem" in contents:
        print(f"vtk-mls: in ParaView's Python {contents['python']}: {contents['problem']}")
    if not any(option.startswith("--script") for option in options.option):
        command.append(f"--script={installation.SCENE}")
    variables = paraview.environment()
    if options.file is not None:
        variables["VTK_MLS_OPEN"] = os.path.abspath(options.file)
    print(f"{paraview}, {contents.get('device', 'no OpenCL device')}", flush=True)
    return subprocess.run(command, env=variables, check=False).returncode
