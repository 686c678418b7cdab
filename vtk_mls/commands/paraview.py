"""`vtk-mls paraview`: ParaView with the plugin.

A ParaView from paraview.org needs a virtual environment with pyopencl, nibabel and an OpenCL
driver. It must have the version of ParaView's Python and of its numpy, and no VTK.
"""

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from vtk_mls.base import display
from vtk_mls.engine.device import caches
from vtk_mls.files.paths import existing_file
from vtk_mls.paraview import installation

_FIRST_VERSION = 5, 13  # of ParaView that has `--venv`


def add(paraview):
    paraview.description = "Start ParaView with the plugin loaded, and with a volume to deform."
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
    folder = make_venv(paraview, contents, options.venv)
    contents = paraview.contents(folder)
    if "problem" in contents:
        raise ValueError(f"{folder} is made, and yet in {paraview}: {contents['problem']}")
    option = f" --venv {options.venv}" if options.venv else ""
    print(f"{paraview} has {contents['device']} now: start it with vtk-mls paraview{option}")
    return 0


def _start(paraview, options):
    if options.venv is None:
        contents, venv = find_venv(paraview)
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


def _usual_folder(python):
    """The default folder for a version of Python; None without a cache folder."""
    cache = caches.folder()
    return cache and cache / "vtk_mls" / f"paraview-python{_minor(python)}"


def find_venv(paraview):
    """The contents of a ParaView, and the folder of the virtual environment if it needs one.

    As of `ParaView.contents`; a "problem" says what to do.
    """
    contents = paraview.contents()
    if "problem" not in contents or paraview.version < _FIRST_VERSION:
        return contents, None
    folder = _usual_folder(contents["python"])
    if folder and (folder / "pyvenv.cfg").is_file():
        contents = paraview.contents(folder)
    else:
        folder = None
    if "problem" in contents:
        contents["problem"] += "; or install it for ParaView with `vtk-mls paraview --setup`"
    return contents, folder


def make_venv(paraview, contents, folder):
    """Make the virtual environment for a ParaView; its folder.

    `contents` are those of ParaView without an environment. One in the usual folder, for None, is
    replaced. Errors have a remedy.
    """
    python = contents["python"]
    if paraview.version < _FIRST_VERSION:
        raise ValueError(
            f"{paraview} takes no virtual environment, which ParaView 5.13 and later do: install "
            "a newer one, or put pyopencl, nibabel and an OpenCL driver into its own Python"
        )
    folder = Path(folder) if folder else _usual_folder(python)
    if folder is None:
        raise ValueError("no folder for the virtual environment: name one with `--venv DIR`")
    if folder == _usual_folder(python):
        shutil.rmtree(folder, ignore_errors=True)
    elif folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"`--venv` {folder} is there already: remove it, or name another")
    # the same numpy as ParaView's, whichever it finds first
    packages = [f"numpy=={contents['numpy']}", *_requirements()]
    print(f"making {folder} with Python {_minor(python)} ...")
    try:
        _make_empty(folder, _minor(python))
        _install(packages, folder)
    except BaseException:  # Ctrl-C, too: an incomplete environment must not be found later
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def _make_empty(folder, minor):
    """Make an environment by this Python, one on PATH or uv, whichever works first."""
    makers = []
    if minor == _minor(sys.version):
        makers.append([sys.executable, "-m", "venv", folder])
    if program := shutil.which(f"python{minor}"):
        makers.append([program, "-m", "venv", folder])
    if sys.platform == "win32" and (program := shutil.which("py")):
        makers.append([program, f"-{minor}", "-m", "venv", folder])
    if program := shutil.which("uv"):
        makers.append([program, "venv", "--quiet", "--seed", "--python", minor, folder])
    problems = []
    for maker in makers:
        problem = _problem(maker)
        if not problem:
            return
        problems.append(f" ({maker[0]}: {problem})")
        shutil.rmtree(folder, ignore_errors=True)
    raise ValueError(
        f"no Python {minor} makes a virtual environment here, which is the version that ParaView "
        f"has: install one, or uv, which brings any (pip install uv){''.join(problems)}"
    )


def _install(packages, folder):
    names = dict.fromkeys(package.partition(";")[0].strip() for package in packages)
    print(f"installing {', '.join(names)} ...")
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    problem = _problem([*pip, *packages])
    if problem:
        raise ValueError(f"pip could not install into {folder}: {problem}")


def _requirements():
    """The requirements of the extras `cpu` and `medical` of this package, for pip."""
    try:
        lines = importlib.metadata.requires("vtk-mls") or ()
    except importlib.metadata.PackageNotFoundError:
        raise ValueError("vtk_mls is importable, but not installed: pip install it first") from None
    requirements = []
    for line in lines:
        name, _, marker = line.partition(";")
        if re.search(r"extra == .(cpu|medical).", marker):
            marker = re.sub(r"\s*(and)?\s*extra == .\w+.\s*", "", marker).strip()
            requirements.append(f"{name.strip()}; {marker}" if marker else name.strip())
    return requirements


def _minor(version):
    """`3.12` of a version of Python."""
    return ".".join(re.findall(r"\d+", version)[:2])


def _problem(command):
    """The last line that a failing command prints; empty on success."""
    try:
        done = subprocess.run(
            [str(word) for word in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            check=False,
        )
    except OSError as error:
        return str(error)
    lines = done.stdout.strip().splitlines() or [f"exit status {done.returncode}"]
    return lines[-1] if done.returncode else ""
