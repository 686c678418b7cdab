"""`vtk-mls view --window` under Xvfb, with mouse and keys."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
from command_fixtures import PROJECT, run
from hands import ball_image, ball_mesh

from vtk_mls import io
from vtk_mls.files import control_point_files

sys.path.append(str(PROJECT / "tests/paraview"))
from paraviews import virtual_display

_TIMEOUT = 180  # seconds


@pytest.fixture(autouse=True)
def screen():
    missing = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]
    if missing:
        report = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
        report(f"no {', '.join(missing)} on this system: tests/paraview/install.sh installs them")


class Window:
    """A running `vtk-mls view --window`."""

    def __init__(self, process, environment):
        self._process, self._environment = process, environment
        self.wait_until(lambda: self._search(), "the window")
        time.sleep(2)  # for the first pictures

    def do(self, *arguments):
        command = ["xdotool", *map(str, arguments)]
        process = subprocess.run(
            command, env=self._environment, capture_output=True, text=True, check=False
        )
        return process.stdout

    def press(self, *keys):
        self.do("key", "--delay", 100, *keys)

    def drag(self, start, by):
        self.do("mousemove", *start)
        time.sleep(0.3)
        self.do("mousedown", 1)
        for step in range(1, 11):
            pixel = [a + b * step // 10 for a, b in zip(start, by)]
            self.do("mousemove", *pixel)
            time.sleep(0.03)
        self.do("mouseup", 1)
        time.sleep(0.5)

    def click(self, pixel):
        self.drag(pixel, (0, 0))

    def end(self):
        """Press Q; (exit status, stderr)."""
        self.press("q")
        _, stderr = self._process.communicate(timeout=_TIMEOUT)
        return self._process.returncode, stderr

    def save(self, folder):
        """Save, and end the window; the folder with the files."""
        self.press("s")
        self.wait_for(folder / "deform.py")
        status, stderr = self.end()
        assert (status, stderr.replace("\n", "")) == (0, "")
        return folder

    def wait_for(self, path):
        self.wait_until(path.exists, path)

    def wait_until(self, exists, name):
        """Wait until `exists()`, for something with a name."""
        until = time.monotonic() + _TIMEOUT
        while not exists():
            assert self._process.poll() is None, self._process.communicate()[1]
            assert time.monotonic() < until, f"no sign of {name}"
            time.sleep(0.1)

    def _search(self):
        return self.do("search", "--name", "vtk-mls").split()


@contextmanager
def window(folder, *arguments):
    """`vtk-mls view --window` with these arguments, started in a folder."""
    with virtual_display("1300x900x24") as display:
        environment = {**os.environ, "DISPLAY": display, "PYTHONPATH": str(PROJECT)}
        environment.pop("VTK_DEFAULT_OPENGL_WINDOW", None)  # set by other tests
        process = subprocess.Popen(
            [sys.executable, "-m", "vtk_mls", "view", "--window", *arguments],
            cwd=folder,
            env=environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            yield Window(process, environment)
        finally:
            process.kill()
            process.wait()
            process.stderr.close()


@pytest.fixture
def folder(tmp_path):
    io.write_dataset(ball_image(), tmp_path / "ball.vti")
    io.write_dataset(ball_mesh(), tmp_path / "ball.vtp")
    # the first handle is in the middle of the window
    (tmp_path / "handles.csv").write_text(
        "px,py,pz,qx,qy,qz\n11.5,11.5,11.5,11.5,11.5,11.5\n2,2,2,2,2,2\n21,21,21,21,21,21\n"
    )
    return tmp_path


@pytest.mark.parametrize("name", ["ball.vti", pytest.param("ball.vtp", marks=pytest.mark.matrix)])
def test_drag_undo_add_save_and_quit(name, folder):
    with window(folder, name, "handles.csv") as viewer:
        viewer.drag((600, 425), (80, -60))
        viewer.press("z", "y")
        viewer.do("mousemove", 560, 470)
        time.sleep(0.3)
        viewer.press("a")
        edited = viewer.save(folder / "ball-edited")
    rest, deformed, *_ = control_point_files.read_pairs(edited / "handles.csv")
    assert len(rest) == 4
    assert np.flatnonzero((rest != deformed).any(axis=1)).tolist()[0] == 0
    deformed = edited / f"ball-deformed{name[4:]}"
    before = deformed.read_bytes()
    paths = folder / name, edited / "handles.csv", deformed
    status, _, stderr = run("deform", *map(str, paths))
    assert (status, stderr) == (0, "")
    assert deformed.read_bytes() == before


def test_edits_of_a_terminated_window_are_offered(folder, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "caches"))
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")  # needs no device check
    with window(folder, "ball.vtp", "handles.csv") as viewer:
        viewer.drag((600, 425), (80, -60))
        viewer.wait_for(folder / "caches" / "vtk_mls" / "unsaved")
        time.sleep(0.5)
    with window(folder, "ball.vtp") as viewer:
        viewer.press("Return", "s")
        viewer.wait_for(folder / "ball-edited" / "deform.py")
        status, stderr = viewer.end()
    assert (status, stderr) == (0, "")
    rest, deformed, *_ = control_point_files.read_pairs(folder / "ball-edited" / "handles.csv")
    assert len(rest) == 3
    assert (rest != deformed).any()
    assert [*(folder / "caches" / "vtk_mls" / "unsaved").iterdir()] == []
