"""`vtk-mls paraview`: ParaView with the plugin."""

from __future__ import annotations

import os


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
    add("--option", metavar="TEXT", action="append", default=[], help="handed on to ParaView")
    paraview.set_defaults(run=run)


def run(options):
    """Run the command."""
    import subprocess

    from vtk_mls.paraview import installation

    found = installation.find(options.paraview)
    contents = found.contents()
    command = [str(found.program), *options.option]
    if options.venv is not None:
        found.check_venv(options.venv, contents["python"])
        contents = found.contents(options.venv)
        command.append(f"--venv={options.venv}")
    if "problem" in contents:
        print(f"vtk-mls: in ParaView's Python {contents['python']}: {contents['problem']}")
    if not any(option.startswith("--script") for option in options.option):
        command.append(f"--script={installation.SCENE}")
    variables = found.environment()
    if options.file is not None:
        variables["VTK_MLS_OPEN"] = os.path.abspath(options.file)
    print(f"{found}, {contents.get('device', 'no OpenCL device')}", flush=True)
    return subprocess.run(command, env=variables, check=False).returncode
