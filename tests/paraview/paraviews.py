"""The installed ParaViews, as fixtures.

These are this system's `pvpython`, and root file systems with a ParaView: those in the environment
variable VTK_MLS_PARAVIEW_ROOTS (separated by colons), by default those of install.sh.  Without a
`pvpython` on this system tests are skipped, or fail with CI=true.
"""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
IN_ROOT = PROJECT / "tests/paraview/in_root.sh"
PICTURES = Path("build/paraview")
NOISE = re.compile(r"warn(ing)?\b|\berr(or)?\b|traceback|exception", re.IGNORECASE)
TIMEOUT = 600  # seconds


@dataclass(frozen=True)
class ParaView:
    """A ParaView: the words before its programs in a command, and its environment variables."""

    name: str
    prefix: tuple[str, ...]
    variables: dict[str, str]

    def environment(self, **more):
        """Environment variables without the Python and the display of these tests."""
        hidden = ("PYTHON", "VIRTUAL_ENV", "LD_", "DISPLAY")
        others = {name: value for name, value in os.environ.items() if not name.startswith(hidden)}
        return {**others, **self.variables, **more}

    def run(self, script, *arguments, display=None):
        """Run a script in pvpython from the project folder; returns exit status and output."""
        variables = {"DISPLAY": display} if display else {}
        done = subprocess.run(
            [*self.prefix, "pvpython", str(script), *map(str, arguments)],
            cwd=PROJECT,
            env=self.environment(**variables),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=TIMEOUT,
            check=False,
        )
        return done.returncode, done.stdout

    def check(self, script, *arguments, display=None):
        """Run a script, which must succeed and print no error or warning."""
        status, output = self.run(script, *arguments, display=display)
        noise = [line for line in output.splitlines() if NOISE.search(line)]
        assert (status, noise) == (0, []), f"{script} in {self.name}:\n{output}"


def _system_paraview():
    if shutil.which("pvpython") is None:
        return "no pvpython on this system: tests/paraview/install.sh says why"
    debian12 = {"PYTHONPATH": str(PROJECT / "paraview_plugin" / "debian12")}
    return ParaView("this system's ParaView", (), debian12)


def _root_paraviews():
    named = os.environ.get("VTK_MLS_PARAVIEW_ROOTS")
    if named is not None:
        roots = [Path(name).resolve() for name in named.split(":") if name]
    else:
        cache = Path(os.environ.get("VTK_MLS_PARAVIEW_CACHE", PROJECT / ".cache/paraview"))
        roots = sorted(path.parents[2] for path in cache.glob("*/usr/bin/pvpython"))
    variables = {
        "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow",
        # a warning of pytools about a package that Debian does not have
        "PYTHONWARNINGS": "ignore:Unable to import recommended hash",
    }
    for root in roots:
        yield root, ParaView(f"the ParaView in {root}", (str(IN_ROOT), str(root)), variables)


def _version(root):
    """The version of Debian's ParaView in a root file system; () without."""
    with suppress(OSError):
        packages = Path(root, "var/lib/dpkg/status").read_text(errors="replace")
        found = re.search(
            r"^Package: paraview\n(?:.+\n)*?Version: ([\d.]+)", packages, re.MULTILINE
        )
        if found:
            return tuple(int(part) for part in found[1].split(".") if part)
    return ()


def _all_paraviews():
    """This system's ParaView and those in roots. All but the newest are for `make matrix`."""
    found = [("system", "/", _system_paraview())]
    found += [(root.name, root, paraview) for root, paraview in _root_paraviews()]
    newest = max(found, key=lambda row: _version(row[1]))
    for name, _, paraview in found:
        marks = [] if name == newest[0] else [pytest.mark.matrix]
        yield pytest.param(paraview, id=name, marks=marks)


PARAVIEWS = list(_all_paraviews())


def unavailable(reason):
    """Skip a test; fail it where everything must be installed."""
    (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(reason)


def free_port():
    with socket.socket() as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


@pytest.fixture(params=PARAVIEWS)
def paraview(request):
    found = request.param
    if isinstance(found, str):
        unavailable(found)
    if found.prefix and os.geteuid() != 0:
        pytest.skip(f"entering the root file system of {found.name} needs root")
    return found


@pytest.fixture(scope="session")
def display():
    with virtual_display() as number:
        yield number


@contextmanager
def virtual_display(screen="1280x1024x24"):
    """A virtual X display; without Xvfb the user's own.

    ParaViews in root file systems can use it, since its socket is abstract.
    """
    if shutil.which("Xvfb") is None:
        yield os.environ.get("DISPLAY")
        return
    output, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-noreset", "-ac", "-screen", "0", screen]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, pass_fds=[write], stdout=quiet, stderr=quiet) as server:
        os.close(write)
        with open(output) as pipe:
            number = pipe.readline().strip()
        try:
            yield f":{number}"
        finally:
            server.terminate()
