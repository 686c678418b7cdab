"""A ParaView of this machine: its folder, its Python, and the variables to start it with."""

import glob
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from vtk_mls.base.resources import resource

_TIMEOUT = 600  # seconds for the start of ParaView's Python; it takes some three
SCENE = Path(__file__).with_name("scene.py")
# Searched after PATH; in each, the newest version comes first.
_USUAL_FOLDERS = (
    "/Applications/ParaView*.app/Contents/MacOS",
    "C:/Program Files/ParaView*/bin",
    "/opt/ParaView*/bin",
    "~/ParaView*/bin",
)
# Run by ParaView's own Python with the plugin's path: prints its contents as a line of JSON. The
# driver is not checked before ParaView uses it.
_PROBE = """
import importlib.util, json, os, sys
found = {"python": "%d.%d.%d" % sys.version_info[:3]}
from vtkmodules.vtkCommonCore import vtkVersion
found["vtk"] = vtkVersion.GetVTKVersion()
import numpy
found["numpy"] = numpy.__version__
try:
    from paraview import simple
    simple.LoadPlugin(sys.argv[1], ns=globals())
    found["plugin"] = "MLSDeform" in globals()
    from vtk_mls import DeviceError
    from vtk_mls.engine import dispatch
    try:
        found["device"] = str(dispatch.choose(is_checked=False))
        if importlib.util.find_spec("nibabel") is None:
            found["problem"] = "nibabel is missing, NIfTI files cannot be read"
    except DeviceError as error:
        found["problem"] = str(error)
except Exception as error:
    found["failure"] = "%s: %s" % (type(error).__name__, error)
# past ParaView's own stream, which is not flushed
os.write(1, ("FOUND" + json.dumps(found) + "\\n").encode())
os._exit(0)  # drivers may hang at the end
"""


@dataclass(frozen=True)
class ParaView:
    """An installation, by the `folder` of its programs."""

    folder: Path
    version: tuple[int, ...]

    @property
    def program(self):
        """The program with the window."""
        return _program(self.folder, "paraview")

    def environment(self):
        """Environment variables with which it finds and loads the plugin.

        ValueError if PYTHONPATH would replace its own VTK or numpy.
        """
        variables = dict(os.environ)
        variables.pop("PYTHONHOME", None)
        paths = [path for path in variables.get("PYTHONPATH", "").split(os.pathsep) if path]
        for path in paths:
            _refuse_mixing("PYTHONPATH has", Path(path))
        plugin = resource("paraview_plugin")
        if self.version < (5, 12):
            paths.insert(0, str(plugin / "debian12"))
        variables["PYTHONPATH"] = os.pathsep.join(paths)
        plugins = [str(plugin), variables.get("PV_PLUGIN_PATH")]
        variables["PV_PLUGIN_PATH"] = os.pathsep.join(filter(None, plugins))
        # Qt reads the last folder last: the user's own settings come first
        defaults = [variables.get("XDG_CONFIG_DIRS") or "/etc/xdg", str(plugin / "settings")]
        variables["XDG_CONFIG_DIRS"] = os.pathsep.join(defaults)
        return variables

    def contents(self, venv=None):
        """The contents of its Python, with a virtual environment or without: a dict of str.

        Versions "python", "vtk", "numpy"; "plugin", true; the OpenCL "device" that is checked and
        used first; a "problem", if there is no device or a package is missing. ValueError if it
        does not run or does not load the plugin.
        """
        pvpython = _program(self.folder, "pvpython")
        variables = self.environment()
        del variables["PV_PLUGIN_PATH"]  # the probe reports errors of loading
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "probe.py"
            script.write_text(_PROBE)
            plugin = resource("paraview_plugin") / "vtk_mls_plugin.py"
            options = [] if venv is None else [f"--venv={venv}"]
            output = _output_of([pvpython, *options, script, plugin], variables)
        lines = [line for line in output.splitlines() if line.startswith("FOUND")]
        if not lines:
            raise ValueError(f"{pvpython} does not run: {output.strip()[-500:] or 'no output'}")
        found = json.loads(lines[-1][len("FOUND") :])
        if not found.get("plugin"):
            raise ValueError(
                f"the plugin does not load in {self}, whose Python is {found['python']}: "
                f"{found.get('failure', output.strip()[-500:])}"
            )
        return found

    def check_venv(self, folder, python):
        """Raise a ValueError if `--venv` cannot use the virtual environment in a folder.

        `python` is the version of ParaView's own Python.
        """
        if self.version < (5, 13):
            raise ValueError(f"`--venv` needs ParaView 5.13 or later, this is {self}")
        try:
            settings = (Path(folder) / "pyvenv.cfg").read_text()
        except OSError:
            raise ValueError(f"`--venv` {folder} is not a virtual environment") from None
        version = re.search(r"^version(?:_info)?\s*=\s*(\d+\.\d+)", settings, re.MULTILINE)
        required = ".".join(python.split(".")[:2])
        if version is None or version[1] != required:
            raise ValueError(
                f"`--venv` {folder} has Python {version[1] if version else 'of unknown version'}, "
                f"and {self} has {required}: make it with python{required}"
            )
        for packages in Path(folder).glob("[Ll]ib/**/site-packages"):
            _refuse_mixing("`--venv` has", packages, names=("vtkmodules",))

    def __str__(self):
        return f"ParaView {'.'.join(map(str, self.version))} ({self.folder})"


def find(folder=None):
    """The installation in `folder`, by default on PATH or in a usual folder; or ValueError."""
    if folder is not None:
        folder = Path(folder)
        folders = [folder, folder / "bin", folder / "Contents/MacOS"]
    else:
        on_path = shutil.which("paraview") or shutil.which("pvpython")
        folders = [Path(on_path).parent] if on_path else []
        for pattern in _USUAL_FOLDERS:
            paths = glob.glob(os.path.expanduser(pattern))
            folders += map(Path, sorted(paths, key=_version, reverse=True))
    for candidate in folders:
        pvpython = _program(candidate, "pvpython")
        if pvpython.exists():
            output = _output_of([pvpython, "--version"], dict(os.environ))
            return ParaView(candidate, _version(output.partition("version")[2]))
    if folder is not None:
        raise ValueError(f"`--paraview` {folder} has no ParaView: there is no pvpython in it")
    raise ValueError(
        "no ParaView found on PATH or in the usual places; install it (paraview.org), or give its "
        "folder with `--paraview DIR`"
    )


def _program(folder, name):
    """Path of a program; on macOS pvpython has a folder of its own."""
    name += ".exe" if sys.platform == "win32" else ""
    in_bin = folder.parent / "bin" / name
    return in_bin if folder.name == "MacOS" and not (folder / name).exists() else folder / name


def _output_of(command, variables):
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    words = [str(word) for word in command]
    options = {**streams, "env": variables, "text": True, "timeout": _TIMEOUT, "check": False}
    try:
        return subprocess.run(words, **options).stdout
    except OSError as error:
        raise ValueError(f"{words[0]} does not run: {error}") from error
    except subprocess.TimeoutExpired:
        raise ValueError(f"{words[0]} has not answered for {_TIMEOUT} s; try again") from None


def _refuse_mixing(source, folder, names=("vtkmodules", "numpy")):
    for name in names:
        if (folder / name).is_dir():
            package = {"vtkmodules": "VTK"}.get(name, name)
            raise ValueError(
                f"{source} {folder}, whose {package} would take the place of ParaView's own, and "
                f"ParaView works only with the one it was built with: leave {folder} out"
            )


def _version(text):
    """The first version number in a text; () without."""
    match = re.search(r"\d+(?:\.\d+)+", text)
    return tuple(int(number) for number in match[0].split(".")) if match else ()
