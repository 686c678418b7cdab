"""The virtual environment that a downloaded ParaView needs: one with pyopencl and an OpenCL driver.

ParaView from paraview.org has neither. It takes them from a virtual environment of its own Python's
version, which must not have another VTK, nor another numpy.
"""

from __future__ import annotations

import importlib.metadata
import re
import shutil
import subprocess
import sys
from pathlib import Path

from vtk_mls.engine.device import caches

_FIRST_VERSION = 5, 13  # of ParaView that has `--venv`


def usual_folder(python):
    """Where the one for a version of Python is if nothing else is said; None without a place."""
    cache = caches.folder()
    return cache and cache / "vtk_mls" / f"paraview-python{_minor(python)}"


def look(paraview):
    """What a ParaView has, with the virtual environment that `make` made if it needs that.

    Parameters
    ----------
    paraview : installation.ParaView

    Returns
    -------
    contents : dict
        As of `ParaView.contents`; a "problem" says what to do.
    folder : Path or None
        The virtual environment, if it has a part in that.

    Raises
    ------
    ValueError
        As `ParaView.contents`.
    """
    contents = paraview.contents()
    if "device" in contents or paraview.version < _FIRST_VERSION:
        return contents, None
    folder = usual_folder(contents["python"])
    if folder and _is_environment(folder):
        return paraview.contents(folder), folder
    if "problem" in contents:
        contents["problem"] += "; or let `vtk-mls paraview --setup` bring one for ParaView"
    return contents, None


def make(paraview, contents, folder=None, note=print):
    """Make the virtual environment for a ParaView; the one in the usual folder is made anew.

    Parameters
    ----------
    paraview : installation.ParaView
    contents : dict
        What its Python has by itself.
    folder : path, optional
        Where to.
    note : callable, optional
        Told what is begun.

    Returns
    -------
    folder : Path

    Raises
    ------
    ValueError
        With what to do.
    """
    python = contents["python"]
    if paraview.version < _FIRST_VERSION:
        raise ValueError(
            f"{paraview} takes no virtual environment, which ParaView 5.13 and later do: install "
            "a newer one, or put pyopencl and an OpenCL driver into its own Python"
        )
    folder = Path(folder) if folder else usual_folder(python)
    if folder is None:
        raise ValueError("there is no folder to keep it in: say with `--venv DIR` where it may be")
    if folder == usual_folder(python):
        shutil.rmtree(folder, ignore_errors=True)
    elif folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"`--venv` {folder} is there already: remove it, or name another")
    # whichever ParaView finds first, its own numpy or this one, they are the same
    packages = [f"numpy=={contents['numpy']}", *_requirements()]
    note(f"making {folder} with Python {_minor(python)} ...")
    try:
        _make_empty(folder, _minor(python))
        _install(packages, folder, note)
    except BaseException:  # Ctrl-C, too: half of one would be taken for a whole one
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def _make_empty(folder, minor):
    """Make an environment with the first that can: this Python, one on PATH, or uv."""
    makers = []
    if minor == _minor(sys.version):
        makers.append([sys.executable, "-m", "venv", folder])
    if found := shutil.which(f"python{minor}"):
        makers.append([found, "-m", "venv", folder])
    if sys.platform == "win32" and (found := shutil.which("py")):
        makers.append([found, f"-{minor}", "-m", "venv", folder])
    if found := shutil.which("uv"):
        makers.append([found, "venv", "--quiet", "--seed", "--python", minor, folder])
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


def _install(packages, folder, note):
    """Install packages into an environment by its own pip."""
    names = dict.fromkeys(each.partition(";")[0].strip() for each in packages)
    note(f"installing {', '.join(names)} ...")
    pip = [_python_of(folder), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    problem = _problem([*pip, *packages])
    if problem:
        raise ValueError(f"pip could not install into {folder}: {problem}")


def _requirements():
    """What the extra `cpu` of this package needs, for pip."""
    try:
        lines = importlib.metadata.requires("vtk-mls") or ()
    except importlib.metadata.PackageNotFoundError:
        raise ValueError("vtk_mls is not installed, only found: pip install it first") from None
    parts = [line.partition(";") for line in lines]
    of_extra = [(name, marker) for name, _, marker in parts if re.search(r"extra == .cpu.", marker)]
    return [_without_extra(name, marker) for name, marker in of_extra]


def _without_extra(name, marker):
    """A requirement that does not ask for the extra any more."""
    marker = re.sub(r"\s*(and)?\s*extra == .cpu.\s*", "", marker).strip()
    return f"{name.strip()}; {marker}" if marker else name.strip()


def _is_environment(folder):
    return (folder / "pyvenv.cfg").is_file()


def _python_of(folder):
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def _minor(version):
    """`3.12` of a version of Python."""
    return ".".join(re.findall(r"\d+", version)[:2])


def _problem(command):
    """The last words of a command that fails; empty if it does not."""
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
    words = done.stdout.strip().splitlines() or [f"exit status {done.returncode}"]
    return words[-1] if done.returncode else ""
