"""`vtk-mls paraview` finds, checks and starts ParaView; `--setup` makes its virtual environment."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from paraviews import PARAVIEWS

from vtk_mls.base.resources import resource
from vtk_mls.commands.cli import main
from vtk_mls.commands.installation import report
from vtk_mls.commands.paraview import _requirements
from vtk_mls.engine.device import caches
from vtk_mls.paraview import installation

VERSIONS = {"python": "3.11.2", "vtk": "9.2.0", "numpy": "1.24.2"}
GOOD = {**VERSIONS, "plugin": True, "device": "0:0 Fast"}
# A script for ParaView: exit status 7 if the plugin works.
QUIT = """
import os
from paraview import simple
handles = simple.MLSControlPoints(RestPoints=[0, 0, 0], DeformedPoints=[1, 0, 0])
deform = simple.MLSDeform(Input=simple.Wavelet(), ControlPoints=handles)
deform.UpdatePipeline()
os._exit(7 if deform.GetDataInformation().GetNumberOfPoints() == 21**3 else 8)
"""


def write_program(path, lines):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + lines)
    path.chmod(0o755)


@pytest.fixture
def pretend(tmp_path, monkeypatch):
    """Make a folder with a false ParaView; no other is found."""
    monkeypatch.setenv("PATH", "/usr/bin:/bin" if sys.platform != "win32" else "")
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr(installation, "_USUAL_FOLDERS", ())
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setenv("DISPLAY", "none")

    def make(version, found="", name="pv"):
        folder = tmp_path / name / "bin"
        answer = f"echo 'FOUND{found}'" if found else "echo broken; exit 3"
        for program in ("pvpython", "paraview"):
            script = f'[ "$1" = --version ] && echo paraview version {version} || {answer}\n'
            write_program(folder / program, script)
        return folder

    return make


def test_plugin_path(capsys):
    assert main(["plugin-path"]) == 0
    assert capsys.readouterr().out.strip() == str(resource("paraview_plugin"))


def test_find(pretend, tmp_path, monkeypatch):
    old, new = pretend("5.9.1", name="ParaView-5.9.1"), pretend("5.13.2", name="ParaView-5.13.2")
    with pytest.raises(ValueError, match="no ParaView found on PATH or in the usual places"):
        installation.find()
    with pytest.raises(ValueError, match=r"`--paraview` .* there is no pvpython in it"):
        installation.find(tmp_path)
    for place in (old, old.parent):
        assert installation.find(place) == installation.ParaView(old, (5, 9, 1))
    monkeypatch.setattr(installation, "_USUAL_FOLDERS", (f"{tmp_path}/ParaView*/bin",))
    assert installation.find() == installation.ParaView(new, (5, 13, 2))
    monkeypatch.setattr("shutil.which", lambda name: str(old / name))
    assert installation.find().folder == old


def test_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONHOME", "/elsewhere")
    monkeypatch.setenv("PV_PLUGIN_PATH", "/mine")
    plugin = resource("paraview_plugin")
    for version, paths in (
        ((5, 11, 0), [str(plugin / "debian12"), str(tmp_path)]),
        ((5, 13, 2), [str(tmp_path)]),
    ):
        variables = installation.ParaView(tmp_path, version).environment()
        assert variables["PYTHONPATH"].split(os.pathsep) == paths
        assert variables["PV_PLUGIN_PATH"].split(os.pathsep) == [str(plugin), "/mine"]
        assert "PYTHONHOME" not in variables


@pytest.mark.parametrize(("usual", "expected"), [(None, "/etc/xdg"), ("/a:/b", "/a:/b")])
def test_defaults_of_settings_come_last(usual, expected, monkeypatch, tmp_path):
    if usual is None:
        monkeypatch.delenv("XDG_CONFIG_DIRS", raising=False)
    else:
        monkeypatch.setenv("XDG_CONFIG_DIRS", usual)
    variables = installation.ParaView(tmp_path, (5, 13, 2)).environment()
    before, _, ours = variables["XDG_CONFIG_DIRS"].rpartition(os.pathsep)
    assert before == expected
    text = (Path(ours) / "ParaView.ini").read_text()
    assert text.splitlines() == ["[General]", "GeneralSettings.ShowWelcomeDialog=false"]


@pytest.mark.parametrize(("package", "name"), [("vtkmodules", "VTK"), ("numpy", "numpy")])
def test_a_foreign_vtk_or_numpy_is_refused(package, name, monkeypatch, tmp_path):
    (tmp_path / package).mkdir()
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(ValueError, match=f"whose {name} would take the place of ParaView's own"):
        installation.ParaView(tmp_path, (5, 13, 2)).environment()


def test_virtual_environments(tmp_path):
    new = installation.ParaView(tmp_path, (5, 13, 2))
    with pytest.raises(ValueError, match=r"`--venv` needs ParaView 5.13 or later"):
        installation.ParaView(tmp_path, (5, 11, 0)).check_venv(tmp_path, "3.11.2")
    with pytest.raises(ValueError, match="is not a virtual environment"):
        new.check_venv(tmp_path, "3.13.1")
    (tmp_path / "pyvenv.cfg").write_text("home = /usr/bin\nversion = 3.11.2\n")
    with pytest.raises(ValueError, match=r"has Python 3.11, .* has 3.13: make it with python3.13"):
        new.check_venv(tmp_path, "3.13.1")
    new.check_venv(tmp_path, "3.11.9")
    (tmp_path / "lib/python3.11/site-packages/vtkmodules").mkdir(parents=True)
    with pytest.raises(ValueError, match="whose VTK would take the place"):
        new.check_venv(tmp_path, "3.11.9")


def test_contents(pretend, monkeypatch):
    folder = pretend("5.11.0", json.dumps(GOOD))
    assert installation.find(folder).contents() == GOOD
    failing = {**VERSIONS, "failure": "ImportError: no such thing"}
    folder = pretend("5.11.0", json.dumps(failing), "failing")
    with pytest.raises(ValueError, match=r"the plugin does not load .*: ImportError: no such"):
        installation.find(folder).contents()
    with pytest.raises(ValueError, match="does not run: broken"):
        installation.find(pretend("5.11.0", name="broken")).contents()


def test_a_paraview_that_does_not_answer(pretend, monkeypatch):
    folder = pretend("5.11.0")
    monkeypatch.setattr(installation, "_TIMEOUT", 1)
    (folder / "pvpython").write_text("#!/bin/sh\nexec sleep 60")
    with pytest.raises(ValueError, match="pvpython has not answered for 1 s; try again"):
        installation.find(folder)


def test_the_driver_is_not_checked_before_paraview_starts(monkeypatch, tmp_path):
    if isinstance(PARAVIEWS[0].values[0], str):
        pytest.skip(PARAVIEWS[0].values[0])
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    assert "(cpu, " in installation.find().contents()["device"]
    assert not list(tmp_path.rglob("devices/*"))


def test_the_doctor_reports_it(pretend, monkeypatch):
    def report_of(found, name):
        folder = pretend("5.11.0", found, name)
        monkeypatch.setattr(installation, "_USUAL_FOLDERS", (str(folder),))
        lines, problems = report()
        return next(line for line in lines if line.startswith("ParaView")), problems

    line, problems = report_of(json.dumps(GOOD), "good")
    assert "Python 3.11.2, VTK 9.2.0, numpy 1.24.2; the plugin loads, 0:0 Fast" in line
    assert not any("ParaView" in problem for problem in problems)
    line, problems = report_of(
        json.dumps({**VERSIONS, "plugin": True, "problem": "no OpenCL"}), "slow"
    )
    assert "no OpenCL device" in line
    assert any(problem.endswith("no OpenCL") for problem in problems)
    line, problems = report_of("", "broken")
    assert any("does not run" in problem for problem in problems)


def test_options_are_passed_on(pretend, tmp_path, capfd):
    folder, file = pretend("5.13.2", json.dumps(GOOD)), tmp_path / "a.vti"
    file.touch()
    (folder / "paraview").write_text('#!/bin/sh\necho "$VTK_MLS_OPEN" "$@"; exit 5\n')
    assert main(["paraview", str(file), "--paraview", str(folder), "--option=--mesa"]) == 5
    out, err = capfd.readouterr()
    assert "ParaView 5.13.2" in out
    assert f"{file} --mesa --script={installation.SCENE}" in out
    assert err == ""
    assert main(["paraview", "--paraview", str(folder), "--venv", "/nowhere"]) == 1
    assert "`--venv` /nowhere is not a virtual environment" in capfd.readouterr().err


def test_an_installed_wheel_starts_paraview(distributions, display, tmp_path):
    if isinstance(PARAVIEWS[0].values[0], str):
        pytest.skip(PARAVIEWS[0].values[0])
    if display is None:
        pytest.skip("no X display and no Xvfb to show a window on")
    venv.create(tmp_path / "fresh", with_pip=True, symlinks=True)
    fresh, script = tmp_path / "fresh" / "bin", tmp_path / "quit.py"
    script.write_text(QUIT)
    variables = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    install = [fresh / "python", "-m", "pip", "install", "--quiet", distributions[1]]
    subprocess.run(install, env=variables, check=True)
    done = subprocess.run(
        [fresh / "vtk-mls", "paraview", "--option=--dr", f"--option=--script={script}"],
        env={**variables, "DISPLAY": display},
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=180,
        check=False,
    )
    assert done.returncode == 7, done.stdout


# The virtual environment that a downloaded ParaView needs


HAS = {"python": "3.77.2", "vtk": "9.4.0", "numpy": "2.1.1", "plugin": True}
LACKS, READY = {**HAS, "problem": "no pyopencl"}, {**HAS, "device": "0:0 Fast"}


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder for caches, and a PATH with the programs of the tests."""
    if sys.platform == "win32":
        pytest.skip("its programs are shell scripts")
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

    def make(version="5.13.2", alone=LACKS, with_venv=READY):
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


def test_the_doctor_reports_an_environment(home, paraview, python, monkeypatch):
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
        (
            "5.12.1",
            "exit 0",
            READY,
            "takes no virtual environment, which ParaView 5.13 and later",
        ),
        ("5.13.2", None, READY, "no Python 3.77 makes a virtual environment here"),
        ("5.13.2", "echo no wheel; exit 1", READY, "pip could not install into .*: no wheel"),
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
    assert main([*paraview(alone=READY), "--setup"]) == 0
    assert "needs nothing, it has 0:0 Fast" in capsys.readouterr().out
    assert not (home / "caches").exists()


def test_requirements_are_those_of_the_extras():
    requirements = _requirements()
    for package in ("pyopencl", "nibabel"):
        assert any(name.startswith(package) for name in requirements)
    assert not any("extra" in name for name in requirements)
