"""`vtk-mls paraview` finds, checks and starts ParaView."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from paraviews import PARAVIEWS

from vtk_mls.base.resources import resource
from vtk_mls.commands.cli import main
from vtk_mls.commands.installation import report
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
        folder.mkdir(parents=True)
        answer = f"echo 'FOUND{found}'" if found else "echo broken; exit 3"
        script = f'#!/bin/sh\n[ "$1" = --version ] && echo paraview version {version} || {answer}\n'
        for program in ("pvpython", "paraview"):
            (folder / program).write_text(script)
            (folder / program).chmod(0o755)
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
