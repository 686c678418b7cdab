"""`vtk-mls paraview --setup`: the virtual environment that a downloaded ParaView needs."""

from __future__ import annotations

import json
import re
import sys

import pytest

from vtk_mls.commands.cli import main
from vtk_mls.commands.installation import report
from vtk_mls.commands.paraview import _requirements
from vtk_mls.engine.device import caches
from vtk_mls.paraview import installation

HAS = {"python": "3.77.2", "vtk": "9.4.0", "numpy": "2.1.1", "plugin": True}
LACKS, GOOD = {**HAS, "problem": "no pyopencl"}, {**HAS, "device": "0:0 Fast"}

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="its programs are shell scripts")


def write_program(path, lines):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + lines)
    path.chmod(0o755)


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder for caches, and a PATH with the programs of the tests."""
    (tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:/usr/bin:/bin")
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setenv("DISPLAY", "none")
    monkeypatch.setattr(caches, "folder", lambda: tmp_path / "caches")
    monkeypatch.setattr(installation, "_USUAL_FOLDERS", ())
    return tmp_path


@pytest.fixture
def paraview(home):
    """A downloaded ParaView: it has a device with a virtual environment only."""

    def make(version="5.13.2", alone=LACKS, with_venv=GOOD):
        write_program(
            home / "pv/bin/pvpython",
            f"""case $1 in
              --version) echo paraview version {version};;
              --venv=*) echo 'FOUND{json.dumps(with_venv)}';;
              *) echo 'FOUND{json.dumps(alone)}';;
            esac""",
        )
        write_program(home / "pv/bin/paraview", 'echo started with "$@"')
        return ["paraview", "--paraview", str(home / "pv")]

    return make


@pytest.fixture
def python(home):
    """A Python of ParaView's version, whose environments have a pip that records its arguments."""

    def make(pip="exit 0"):
        write_program(
            home / "bin/python3.77",
            f"""[ "$1 $2" = "-m venv" ] || exit 9
            mkdir -p "$3/bin"
            echo version = 3.77.1 >"$3/pyvenv.cfg"
            printf '#!/bin/sh\\necho "$@" >>{home}/arguments\\n{pip}\\n' >"$3/bin/python"
            chmod +x "$3/bin/python" """,
        )

    return make


def test_the_environment_is_used_afterwards(home, paraview, python, capfd):
    command = paraview()
    python()
    assert main(command) == 0
    out = capfd.readouterr().out
    assert "no pyopencl; or install it for ParaView with `vtk-mls paraview --setup`" in out
    assert "--venv" not in out
    folder = home / "caches/vtk_mls/paraview-python3.77"
    for _ in range(2):  # the second time replaces the first
        assert main([*command, "--setup"]) == 0
        out = capfd.readouterr().out
        assert "has 0:0 Fast now: start it with vtk-mls paraview" in out
        assert str(folder) in out
    arguments = (home / "arguments").read_text()
    assert arguments.count("-m pip install") == 2
    assert "numpy==2.1.1" in arguments
    assert "pyopencl" in arguments
    assert "extra" not in arguments
    assert main(command) == 0
    out = capfd.readouterr().out
    assert f"started with --venv={folder}" in out
    assert "no pyopencl" not in out


def test_the_doctor_reports_it(home, paraview, python, monkeypatch):
    paraview()
    python()
    monkeypatch.setattr("shutil.which", {"paraview": str(home / "pv/bin/paraview")}.get)
    assert any(problem.endswith("with `vtk-mls paraview --setup`") for problem in report()[1])
    (home / "caches/vtk_mls/paraview-python3.77").mkdir(parents=True)
    (home / "caches/vtk_mls/paraview-python3.77/pyvenv.cfg").touch()
    lines, problems = report()
    assert any("the plugin loads, 0:0 Fast" in str(line) for line in lines)
    assert not any("pyopencl" in problem and "ParaView" in problem for problem in problems)


def test_a_given_folder(home, paraview, python, capsys):
    command, folder = paraview(), home / "mine"
    python()
    assert main([*command, "--setup", "--venv", str(folder)]) == 0
    assert f"start it with vtk-mls paraview --venv {folder}" in capsys.readouterr().out
    assert (folder / "pyvenv.cfg").exists()
    assert not (home / "caches").exists()


@pytest.mark.parametrize("name", ["chapter", "pyvenv.cfg"])
def test_an_existing_folder_is_refused(name, home, paraview, python, capsys):
    """Even a virtual environment."""
    command, file = paraview(), home / "thesis" / name
    python()
    file.parent.mkdir()
    file.write_text("1")
    for path in (file.parent, file):
        assert main([*command, "--setup", "--venv", str(path)]) == 1
        assert "is there already: remove it, or name another" in capsys.readouterr().err
    assert file.read_text() == "1"


def test_uv_brings_a_python(home, paraview, capsys):
    write_program(
        home / "bin/uv",
        'mkdir -p "$6/bin"; echo "$@" >>"$6/pyvenv.cfg"; cp /bin/true "$6/bin/python"',
    )
    assert main([*paraview(), "--setup"]) == 0
    folder = home / "caches/vtk_mls/paraview-python3.77"
    arguments = (folder / "pyvenv.cfg").read_text().split()
    assert arguments == f"venv --quiet --seed --python 3.77 {folder}".split()


@pytest.mark.parametrize(
    ("version", "pip", "with_venv", "message"),
    [
        ("5.12.1", "exit 0", GOOD, "takes no virtual environment, which ParaView 5.13 and later"),
        ("5.13.2", None, GOOD, "no Python 3.77 makes a virtual environment here"),
        ("5.13.2", "echo no wheel; exit 1", GOOD, "pip could not install into .*: no wheel"),
        ("5.13.2", "exit 0", LACKS, "is made, and yet in ParaView 5.13.2 .*: no pyopencl"),
    ],
)
def test_errors(version, pip, with_venv, message, home, paraview, python, capsys):
    if pip is not None:
        python(pip)
    assert main([*paraview(version, with_venv=with_venv), "--setup"]) == 1
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1
    assert re.search(message, error), error
    is_whole = "is made" in message
    assert (home / "caches/vtk_mls/paraview-python3.77").exists() == is_whole


def test_a_paraview_with_a_device_needs_nothing(home, paraview, capsys):
    assert main([*paraview(alone=GOOD), "--setup"]) == 0
    assert "needs nothing, it has 0:0 Fast" in capsys.readouterr().out
    assert not (home / "caches").exists()


def test_requirements_are_those_of_the_extras():
    requirements = _requirements()
    for package in ("pyopencl", "nibabel"):
        assert any(name.startswith(package) for name in requirements)
    assert not any("extra" in name for name in requirements)
