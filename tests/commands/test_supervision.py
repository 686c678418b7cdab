"""The command in a process that is watched: crashes, signals, and what they leave."""

import os
import signal
import subprocess
import sys

import pytest
from command_fixtures import AT, PARENT, PROJECT, run
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import io
from vtk_mls.commands import supervision
from vtk_mls.vtk.objects import output_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")

DEFORM = ["deform", "in.vti", "handles.csv", "out.mhd", "--device", "reference"]
PLACES = ["argparse", "numpy", "vtkmodules", "vtk_mls.filters", "the replacing"]
STOP = "os.kill(os.getppid(), signal.{}); forever()"


def _run(place, code, *arguments):
    return run(*(arguments or DEFORM), child=AT.format(place=place, code=code))


@pytest.mark.parametrize("place", PLACES)
def test_ctrl_c_ends_everything_at_once(files, place):
    (files / "out.mhd").write_text("the old one")
    before = {path.name: path.read_bytes() for path in files.iterdir()}
    status, out, err = _run(place, STOP.format("SIGINT"))
    assert (status, out, err) == (130, "", "\n")
    assert {path.name: path.read_bytes() for path in files.iterdir()} == before


@pytest.mark.parametrize(("name", "status"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_other_signals_end_it_too(files, name, status):
    assert _run("the replacing", STOP.format(name)) == (status, "", "")
    assert sorted(path.name for path in files.iterdir()) == ["handles.csv", "in.vti"]


def test_a_signal_that_is_ignored_stays_so(files):
    program = AT.format(place="numpy", code="os.kill(os.getppid(), signal.SIGHUP)")
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        status, _, err = run(*DEFORM, child=program)
    finally:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    assert (status, err) == (0, "")


def test_the_child_does_not_outlive_a_killed_parent(files, tmp_path):
    child = AT.format(place="numpy", code="print('begun', flush=True); forever()")
    process = subprocess.Popen(
        [sys.executable, "-c", PARENT.format(child=child), *DEFORM],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(PROJECT), "TMPDIR": str(tmp_path)},
    )
    assert process.stdout.readline() == b"begun\n"
    process.kill()
    assert process.communicate(timeout=30) == (b"", None)  # the child held the pipe, too
    assert not [*tmp_path.glob("vtk_mls-*")]


@pytest.mark.parametrize(
    ("place", "code", "sentence"),
    [
        (
            "vtk_mls.files.formats",
            "os.kill(os.getpid(), signal.SIGSEGV)",
            "the process crashed (SIGSEGV)",
        ),
        (
            "the replacing",
            "os.kill(os.getpid(), signal.SIGSEGV)",
            "`out.mhd` could not be written: the process crashed (SIGSEGV)",
        ),
        (
            "the replacing",
            "os.kill(os.getpid(), signal.SIGKILL)",
            "`out.mhd` could not be written: the system killed the process, as a rule because "
            "memory ran out (SIGKILL)",
        ),
    ],
)
def test_a_crash_is_one_sentence(files, place, code, sentence):
    assert _run(place, code) == (1, "", f"vtk-mls: {sentence}\n")
    assert sorted(path.name for path in files.iterdir()) == ["handles.csv", "in.vti"]


def test_a_crash_after_the_work_does_not_count(files):
    code = "import atexit; atexit.register(os.kill, os.getpid(), signal.SIGSEGV)"
    status, out, err = _run("the replacing", code)
    assert (status, err) == (0, "")
    assert "out.mhd" in out


def test_a_reader_that_crashes(files):
    path = files / "in.ply"
    io.write_dataset(output_of(vtkSphereSource()), path)
    path.write_bytes(path.read_bytes().replace(b"element face 96", b"element face 9999999"))
    status, out, err = run("deform", "in.ply", "handles.csv", "out.ply", "--device", "reference")
    assert (status, out) == (1, "")
    assert err.startswith("vtk-mls: `in.ply` could not be read: VTK's reader crashed (SIG")
    assert err.count("\n") == 1


def test_a_reader_that_does_not_end(files):
    code = """
from vtk_mls import io
from vtk_mls.commands import supervision
supervision.MIN_SECONDS = 0.1
def endless(path):
    while True: pass
io.read_dataset = endless
# here"""
    child = AT.format(place="nothing", code="pass").replace("# here", code)
    sentence = (
        "`in.vti` could not be read: VTK's reader does not come to an end; the file is broken"
    )
    assert run(*DEFORM, child=child) == (1, "", f"vtk-mls: {sentence}\n")


def test_the_parent_does_not_import_numpy():
    code = "import sys, vtk_mls.commands.cli; print('numpy' in sys.modules, vtk_mls.Grid.__name__)"
    assert run(code=code) == (0, "False Grid\n", "")
    code = "import vtk_mls; vtk_mls.nothing"
    assert "module `vtk_mls` has no attribute `nothing`" in run(code=code)[2]
    assert run(code="from vtk_mls import *; print(KINDS, Deformation)")[0] == 0


@pytest.mark.parametrize("status", [0, 1, 7])
def test_a_reader_that_exits(files, status):
    """As the libraries for Exodus do with some broken files."""
    stop = f"""
from vtk_mls.files import image_files
image_files.read_xml = lambda path: os._exit({status})
# here"""
    child = AT.format(place="nothing", code="pass").replace("# here", stop)
    found, out, err = run(*DEFORM, child=child)
    assert (found, out) == (1, "")
    assert err.startswith(
        f"vtk-mls: `in.vti` could not be read: VTK's reader crashed (exit status {status}"
    )
    assert err.count("\n") == 1


def test_errors_of_python_are_not_repeated(files):
    status, _, err = _run("vtk_mls.filters", "raise AttributeError('by a mistake')")
    assert status == 1
    assert err.endswith("AttributeError: by a mistake\n")


def test_a_small_file_that_names_large_ones_has_time_for_them(tmp_path):
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "x_0.vtu").write_bytes(bytes(2_000_000))
    (tmp_path / "x.vtm").write_text("x/x_0.vtu")
    (tmp_path / "other.vtu").write_bytes(bytes(2_000_000))
    seconds = supervision._reading_time(tmp_path / "x.vtm")
    assert 130 <= seconds < 131
    for name in ("none/none.vtm", ".", "/", ""):
        assert supervision._reading_time(name) == 120
    assert supervision._reading_time("..") >= 120
