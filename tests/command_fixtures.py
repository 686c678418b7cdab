"""The command `vtk-mls` in a folder of its own or a process of its own. Tests import them."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vtk_fixtures import DEFORMED, REST, add_array, add_scalars, make_image

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.vtk.arrays import ImageGeometry

PROJECT = Path(__file__).resolve().parents[1]
signal.signal(signal.SIGINT, signal.default_int_handler)  # else ignored by a job in the background
WITHOUT = """
import sys
for name in {names}:
    sys.modules[name] = None
from vtk_mls.commands.cli import main
sys.exit(main(sys.argv[1:]))
"""
# A program of the child that runs the command: code is run where it begins to import a module.
AT = """
import ctypes, importlib.abc, os, signal, sys, time

def forever():
    signal.pause()  # as C++ does: without the interpreter's eye on signals
    while True:
        ctypes.PyDLL(None).sleep(1)

def meet():
    {code}

class Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "{place}":
            meet()

sys.meta_path.insert(0, Finder())
if "{place}" == "the replacing":
    from vtk_mls.files import paths
    paths._move_over = lambda *_: meet()
# here
import runpy
runpy.run_path(sys.argv[1])
"""
# The command, whose child runs another program before its own.
PARENT = """
import sys
from vtk_mls.base import child_process
child_process.interpreter = lambda: [sys.executable, "-c", {child!r}]
from vtk_mls.commands.cli import main
sys.exit(main())
"""


@pytest.fixture(autouse=True)
def numpy_computes(monkeypatch):
    """Commands and filters use the specification, unless a test names a device."""
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, but for handles.csv, as the current one."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("handles.csv", np.hstack([REST, DEFORMED]), delimiter=",", fmt="%.17g")
    return tmp_path


@pytest.fixture
def files(folder):
    """The folder with in.vti, too."""
    image = make_image()
    x, y, z = ImageGeometry.of_image(image).grid.points().T
    add_scalars(image, "values", np.sin(x) + y * z)
    add_array(image.GetPointData(), "labels", np.arange(504) % 2 * 1000, 6)
    io.write_dataset(image, "in.vti")
    return folder


@pytest.fixture
def refused(capsys):
    """A function of the words of a command, which must end in one sentence: it returns that."""

    def sentence(*words):
        capsys.readouterr()
        assert main([*map(str, words)]) == 1
        printed = capsys.readouterr()
        assert printed.out == ""
        assert re.fullmatch("vtk-mls: [^\n]*\n", printed.err), printed.err
        return printed.err.removeprefix("vtk-mls: ").rstrip("\n")

    return sentence


@pytest.fixture
def disk():
    """Set how many bytes a file may have; a file system that is full is the same to a writer."""
    resource = pytest.importorskip("resource", reason="the size of files cannot be limited here")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def run(*arguments, code=None, child=None, **environment):
    """A process of its own: (exit status, stdout, stderr).

    It runs the command, or the program `code`; the program `child` is run in the command's child.
    """
    code = PARENT.format(child=child) if child else code
    return python(*(["-c", code] if code else ["-m", "vtk_mls"]), *arguments, **environment)


def python(*arguments, folder=None, path=PROJECT, **environment):
    """Python in a process of its own, as of `run`, in a folder, with modules of a path."""
    path = os.pathsep.join([str(path), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path, **environment},
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def write_collection(entries, name="in.pvd"):
    """The name of a collection of ParaView, of times and files."""
    lines = [f'<DataSet timestep="{time}" file="{file}"/>' for time, file in entries]
    text = f'<VTKFile type="Collection"><Collection>{"".join(lines)}</Collection></VTKFile>'
    Path(name).write_text(text)
    return name


def write_moving(name, rows):
    """The name of a table of control points in time: rows of a time, p and q."""
    header = "time,px,py,pz,qx,qy,qz"
    np.savetxt(name, rows, "%.17g", ",", header=header, comments="")
    return name
