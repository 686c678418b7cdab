"""Installs the wheel in empty environments, the oldest and the newest: `make environments`.

With the argument `all` also in those between them.
Each has a Python, and what pip takes by itself or versions that are named. The Python is one on
PATH or of pyenv, or that of a Debian which tests/paraview/install.sh has made: into that what pip
takes is put from outside. One that is not here is said loudly, and no failure. An environment
takes 1.3 GB, and two are made at a time.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
WORK = PROJECT / "build/environments"
CACHE = Path(os.environ.get("VTK_MLS_PARAVIEW_CACHE", PROJECT / ".cache/paraview"))
IN_ROOT = PROJECT / "tests/paraview/in_root.sh"
PIP = "-m", "pip", "install", "--quiet", "--no-compile"  # Python compiles what is imported
PLATFORMS = "manylinux_2_28_x86_64", "manylinux2014_x86_64"
# Python, extra with an OpenCL driver, pinned packages
ENDS = [("3.9", "pocl", ("numpy==1.24.4", "vtk==9.2.6")), ("3.14", "cpu", ())]
BETWEEN = [("3.10", "cpu", ()), ("3.12", "cpu", ("numpy==1.26.4", "vtk==9.3.1"))]


def main(*arguments):
    environments = [*ENDS, *(BETWEEN if "all" in arguments else ())]
    shutil.rmtree(WORK, ignore_errors=True)
    build = [sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", WORK, PROJECT]
    run(*build)
    (wheel,) = WORK.glob("*.whl")
    with ThreadPoolExecutor(2) as pool:
        outcomes = list(pool.map(partial(outcome, wheel), *zip(*environments)))
    print("", *outcomes, sep="\n")
    return any("FAILS" in outcome for outcome in outcomes)


def outcome(wheel, version, driver, pinned):
    """A line on one environment, which is removed afterwards."""
    name = f"Python {version}, {driver}, {', '.join(pinned) or 'what pip takes'}"
    folder = WORK / f"{version}-{len(pinned)}"
    print(f"{name} ...", flush=True)
    try:
        said = tried(version, [f"{wheel}[vtk,{driver}]", *pinned], folder)
    except subprocess.CalledProcessError as error:
        said = f"FAILS: {(error.stdout or str(error)).strip()[-2000:]}"
    shutil.rmtree(folder, ignore_errors=True)
    return f"{name}: {said or '****** LEFT OUT: no such Python is here ******'}"


def tried(version, packages, folder):
    """What the check says in an environment of a Python; None without that Python."""
    found = interpreter(version)
    if found:
        run(found, "-m", "venv", folder)
        python = folder / "bin/python"
        run(python, *PIP, "--disable-pip-version-check", *packages)
        return check([python], folder)
    # of a Debian
    root = next((path.parents[2] for path in CACHE.glob(f"*/usr/bin/python{version}")), None)
    if not root or os.geteuid() != 0:
        return None
    into = ["--target", folder, "--python-version", version, "--only-binary", ":all:"]
    for platform in PLATFORMS:
        into += ["--platform", platform]
    run(sys.executable, *PIP, *into, *packages)
    seen = "/project" / folder.relative_to(PROJECT)  # from there
    return check([IN_ROOT, root, "env", f"PYTHONPATH={seen}", f"python{version}"], seen, "/project")


def check(python, environment, project=PROJECT):
    """What the check says, run by a Python, in a folder with no checkout."""
    script = Path(project, "tests/environments/check.py")
    with tempfile.TemporaryDirectory() as elsewhere:
        told = run(*python, script, environment, cwd=elsewhere)
    return told[told.index("WORKS") :].strip()


def interpreter(version):
    """A Python of a version that makes virtual environments, on PATH or of pyenv; or None."""
    of_pyenv = sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
    for program in filter(None, [shutil.which(f"python{version}"), *of_pyenv]):
        command = [program, "-c", "import ensurepip, venv"]
        if subprocess.run(command, capture_output=True, check=False).returncode == 0:
            return program
    return None


def run(*command, cwd=None):
    """What a command prints, which must succeed."""
    hidden = "PYTHON", "VIRTUAL_ENV"
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env={name: value for name, value in os.environ.items() if not name.startswith(hidden)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        raise subprocess.CalledProcessError(done.returncode, command, done.stdout)
    return done.stdout


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
