"""Drivers from pip are found; devices that fail their check in a child process are not used."""

import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import types
from pathlib import Path

import pytest
from control_point_sets import DEVICES, LOCAL_POINTS

from vtk_mls.base import child_process, messages
from vtk_mls.engine import dispatch
from vtk_mls.engine.device import caches, device_check, drivers
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.device.device_check import BASIC, CUTS, SUBJECTS, Result

USUAL = caches.folder()
HANDLE = types.SimpleNamespace(native_vector_width_float=16)
FAKE = device.Device("0:0", "Processor", "Maker", "cpu", "OpenCL 3.0", HANDLE, "1.0")

# A stand-in for Python in the child, which runs `{behavior}`.
STUB = """
import json, os, signal, sys, time
from pathlib import Path
folder = Path(sys.argv[1]).parent
(folder / "step").write_text("the first step")
{behavior}
"""
DIES = "os.kill(os.getpid(), signal.SIGSEGV)"
HANGS = "time.sleep(60)"
SPINS = "(folder / 'seconds').write_text('599\\n601\\n'); time.sleep(60)"
# A slow child: it ends after several intervals, and uses processor time in each of them.
WORKS = """
with open(folder / "seconds", "w", buffering=1) as file:
    for second in range(30):
        file.write(f"{second}\\n")
        time.sleep(0.1)"""
LIES = """
error = {"classes": [["builtins", "ArithmeticError"]], "message": "off by 0.3", "cause": None}
(folder / "error.json").write_text(json.dumps(error)); sys.exit(1)"""
COMPILER = "print('LLVM ERROR: cannot select'); sys.stdout.flush(); os.abort()"


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """As in a new process whose user has no results yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    caches.folder.cache_clear()
    monkeypatch.setattr(device_check, "_results", {})
    yield tmp_path
    caches.folder.cache_clear()


@pytest.fixture
def child(fresh, monkeypatch):
    """Let the child behave like this."""

    def behave(behavior):
        stub = fresh / "stub.py"
        stub.write_text(STUB.format(behavior=behavior))
        monkeypatch.setattr(child_process, "interpreter", lambda: [sys.executable, str(stub)])

    return behave


def messages_of(function, *arguments):
    """What `function` returns, and the messages to the user meanwhile."""
    sentences = []
    with messages.message_handlers(sentences.append, sentences.append):
        return function(*arguments), sentences


def test_a_sound_device_is_tested_once(child, monkeypatch):
    child("")
    (result,), sentences = messages_of(device_check.results, [FAKE], [BASIC])
    assert result == Result()
    assert len(sentences) == 1
    assert sentences[0].startswith("Testing OpenCL on Processor (Maker)")
    child(DIES)
    assert device_check.results([FAKE], [BASIC]) == [result]
    monkeypatch.setattr(device_check, "_results", {})  # another process
    assert messages_of(device_check.results, [FAKE], [BASIC]) == ([result], [])
    assert json.loads(device_check.result_path(FAKE).read_text())["device"] == str(FAKE)


@pytest.mark.parametrize(
    ("behavior", "sentence"),
    [
        pytest.param(DIES, "the first step: the process ended by SIGSEGV", id="dies"),
        pytest.param(LIES, "the first step: off by 0.3", id="lies"),
        pytest.param(COMPILER, "the process ended by SIGABRT: LLVM ERROR", id="compiler"),
        pytest.param("print(0); sys.exit(3)", "ended by exit status 3", id="exits"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_a_driver_that_fails_is_not_used(child, behavior, sentence, monkeypatch):
    child(behavior)
    (result,), sentences = messages_of(device_check.results, [FAKE], [BASIC])
    assert result.is_checked
    assert result.failure.startswith("it fails the check (")
    assert sentence in result.failure
    assert sentences[1].startswith(f"{FAKE} is not used: {result.failure}")
    child("")
    monkeypatch.setattr(device_check, "_results", {})
    assert device_check.results([FAKE], [BASIC]) == [result]  # not tried again and again
    for recheck in (True, False):
        assert device_check.results([FAKE], [BASIC], recheck) == [Result()]


@pytest.mark.parametrize(("behavior", "seconds"), [(HANGS, 0), (SPINS, 601), (WORKS, None)])
def test_only_a_child_that_hangs_is_ended(child, behavior, seconds, monkeypatch):
    """Processor time decides: on a busy machine a sound child can take long."""
    child(behavior)
    monkeypatch.setattr(device_check, "INTERVAL", 0.9)
    (result,), sentences = messages_of(device_check.results, [FAKE], [BASIC])
    if seconds is None:
        assert result == Result()
    else:
        reason = f"not checked, no result after {seconds} s of processor time"
        assert result == Result(reason, is_checked=False)
        assert sentences[1].startswith(f"{FAKE} is not used: {reason}; ")
    monkeypatch.setattr(device_check, "_results", {})
    assert device_check.results([FAKE], [BASIC]) == [result]


def test_children_that_cannot_be_started(fresh, monkeypatch):
    for nothing in (None, [str(fresh / "nothing")], [sys.executable, "-c", "raise ImportError"]):
        monkeypatch.setattr(child_process, "interpreter", lambda nothing=nothing: nothing)
        monkeypatch.setattr(device_check, "_results", {})
        (result,), sentences = messages_of(device_check.results, [FAKE], [BASIC])
        assert result == Result(is_checked=False)
        assert sentences[-1].startswith(f"{FAKE} is used, but not checked")
        assert not device_check.result_path(FAKE).exists()


def test_a_device_that_a_child_does_not_find(fresh):
    (result,), sentences = messages_of(device_check.results, [FAKE], [BASIC])
    assert not result.is_checked
    assert "the child process does not find the device" in sentences[-1]


def test_kinds_and_cuts_are_tested_before_their_first_use(child):
    child("")
    asked = [(BASIC,), (BASIC, "affine", CUTS)]
    _, sentences = messages_of(device_check.results, [FAKE], asked[0])
    child(DIES)
    assert device_check.results([FAKE], asked[0]) == [Result()]
    (result,), more = messages_of(device_check.results, [FAKE], asked[1])
    assert (len(sentences), len(more)) == (1, 2)  # nothing after the first failure
    assert more[0].startswith("Testing affine with OpenCL on Processor (Maker)")
    assert result.failure == device_check.failure(FAKE)
    child("")
    assert device_check.results([FAKE], recheck=True) == [Result()]
    assert device_check.failure(FAKE) == ""
    assert all(device_check.result_path(FAKE, subject).exists() for subject in SUBJECTS)


def test_devices_of_one_kind_are_tested_once(child):
    child("")
    twin = dataclasses.replace(FAKE, key="0:1")
    found, sentences = messages_of(device_check.results, [FAKE, twin], [BASIC])
    assert found == [Result()] * 2
    assert sentences[0].count("Processor") == 1


@pytest.mark.parametrize("text", ["", "{", "[]", '{"failure": ""}', "\0"])
def test_broken_records_do_no_harm(child, text):
    child("")
    place = device_check.result_path(FAKE)
    place.parent.mkdir(parents=True)
    place.write_text(text)
    assert device_check.results([FAKE], [BASIC]) == [Result()]
    assert json.loads(place.read_text())["failure"] == ""


@pytest.mark.parametrize("folder", [None, Path("/proc/none")])
def test_results_that_cannot_be_written(child, folder, monkeypatch):
    child("")
    with monkeypatch.context() as patch:
        patch.setattr(caches, "folder", lambda: folder)
        assert device_check.results([FAKE], [BASIC]) == [Result()]


def test_a_child_is_no_process_of_the_parents_mpi_job(child, monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "3")
    monkeypatch.setenv("PMIX_RANK", "3")
    child("any('MPI' in k or 'PMI' in k for k in os.environ) and sys.exit(1)")
    assert device_check.results([FAKE], [BASIC]) == [Result()]


def test_a_result_is_of_a_driver_and_kernels(monkeypatch):
    before = device_check.result_path(FAKE)
    assert device_check.result_path(dataclasses.replace(FAKE, key="3:0")) == before
    assert device_check.result_path(dataclasses.replace(FAKE, driver="1.1")) != before
    monkeypatch.setattr(device_check, "_kernels", lambda: "others")
    device_check._file_name.cache_clear()
    assert device_check.result_path(FAKE) != before
    device_check._file_name.cache_clear()


def test_python_is_found_in_embedding_programs(tmp_path, monkeypatch):
    def program(name):
        path = tmp_path / name
        path.write_text("")
        path.chmod(0o755)
        return str(path)

    assert child_process.interpreter() == [sys.executable]
    monkeypatch.setattr(sys, "executable", program("paraview"))
    monkeypatch.setattr(sys, "_base_executable", "")
    found = child_process.interpreter()
    assert Path(found[0]).name.startswith("python")  # of base_prefix
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    monkeypatch.setattr(os.path, "realpath", lambda path: str(tmp_path / "paraview"))
    assert child_process.interpreter() is None
    pvpython = program("pvpython")
    assert child_process.interpreter() == [pvpython]
    monkeypatch.setattr(sys, "executable", pvpython)
    (tmp_path / "bin").mkdir()
    python = program("bin/python{}.{}".format(*sys.version_info))
    assert child_process.interpreter() == [python]  # which loads less


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize(
    ("subject", "question", "changed", "failure"),
    [
        (BASIC, "jacobian", "answer + 0.01", "rigid Jacobian: wrong numbers, off by 0.01"),
        (CUTS, "jacobian", "answer * float('nan')", "Jacobian, fixed cut: wrong numbers, off by n"),
        (BASIC, "forward", "(answer[0] + 0.1, answer[1])", "rigid inverse: wrong numbers, off by "),
        ("affine", "backward", "answer + 0.1", "map at points: wrong numbers, off by "),
    ],
)
def test_wrong_results_are_detected(subject, question, changed, failure, fresh, monkeypatch):
    """The real test of a real device whose kernels are wrong in a way that is hard to see."""
    stub = fresh / "stub.py"
    stub.write_text(
        f"""
import json, os, runpy, sys
os.environ["XDG_CACHE_HOME"] = {str(USUAL)!r}  # built kernels
with open(os.path.join(os.path.dirname(sys.argv[1]), "request.json")) as file:
    sys.path[:] = json.load(file)["path"]
from vtk_mls.engine import opencl_engine as engine
right = engine.Engine.{question}
def wrong(self, *arguments):
    answer = right(self, *arguments)
    return {changed}
engine.Engine.{question} = wrong
runpy.run_path(sys.argv[1])
"""
    )
    monkeypatch.setattr(child_process, "interpreter", lambda: [sys.executable, str(stub)])
    (chosen,) = (found for found in device.list_devices() if found.key == DEVICES[0])
    (result,) = device_check.results([chosen], [subject])
    assert failure in result.failure


ASK = """
from vtk_mls import Deformation
print(Deformation([[0, 0, 0]], [[1, 2, 3]]).backward([[5, 5, 5]]).tolist())
"""


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.matrix
@pytest.mark.parametrize("home", ["empty", "none"])
def test_processes_that_start_together(tmp_path, home):
    """With an empty cache, or no place for one."""
    variables = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")}
    variables["HOME"] = {"empty": str(tmp_path), "none": "/dev/null"}[home]
    variables["TMPDIR"] = str(tmp_path)
    children = [
        subprocess.Popen(
            [sys.executable, "-c", ASK],
            env=variables,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    said = [process.communicate(timeout=400) for process in children]
    assert [out for out, _ in said] == ["[[4.0, 3.0, 2.0]]\n"] * 2, said
    assert all("Traceback" not in err for _, err in said)


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_an_interrupt_ends_the_children(tmp_path):
    code = f"""
import sys
from vtk_mls.base import child_process
from vtk_mls.engine.device import device_check
child_process.interpreter = lambda: [sys.executable, "-c", "import time; time.sleep(600)"]
{ASK}"""
    variables = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "TMPDIR": str(tmp_path)}
    process = subprocess.Popen(
        [sys.executable, "-c", code], env=variables, stderr=subprocess.PIPE, text=True
    )
    assert "Testing OpenCL" in process.stderr.readline()
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in process.communicate(timeout=60)[1]
    assert not list(tmp_path.glob("vtk_mls-*"))  # what children had is gone


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
def test_builds_are_reported():
    chosen = dispatch.choose(DEVICES[0])
    constants = (*LOCAL_POINTS, ("UNLIKE", "others"))
    _, sentences = messages_of(device.kernel, chosen, "local_points", constants)
    assert sentences == ["Building OpenCL kernels"]
    assert messages_of(device.kernel, chosen, "local_points", constants)[1] == []


# Drivers


def test_intels_driver_gets_a_path_without_spaces(fresh, monkeypatch):
    folder = fresh / "with space" / "lib"
    folder.mkdir(parents=True)
    driver, needed, other = (
        folder / name for name in ("libintelocl.so", "libtbb.so", "libother.so")
    )
    for file in (driver, needed, other):
        file.write_text(file.name)
    installed = {"intel-opencl-rt": [driver], "tbb": [needed]}
    monkeypatch.setattr(drivers, "_files_of", lambda package: installed.get(package, []))
    found = drivers.intel_library()
    assert found.is_relative_to(fresh / "cache")
    assert {file.name for file in found.parent.iterdir()} == {driver.name, needed.name, "driver"}
    assert os.path.samefile(found, driver)
    assert drivers.intel_library() == found
    monkeypatch.setattr(os, "link", lambda *_: (_ for _ in ()).throw(OSError("another disk")))
    shutil.rmtree(found.parent)
    assert drivers.intel_library().read_text() == "libintelocl.so"
    driver.rename(fresh / driver.name)  # the environment is gone, and there is another
    installed["intel-opencl-rt"] = [fresh / driver.name]
    assert drivers.intel_library() == fresh / driver.name
    drivers._remove_stale(found.parent.parent)
    assert not found.parent.exists()


def test_intels_driver_from_pip_is_added_to_the_systems(tmp_path, monkeypatch):
    vendors, elsewhere = tmp_path / "vendors", tmp_path / "libgpu.so"
    vendors.mkdir()
    elsewhere.write_text("")
    (vendors / "by_name.icd").write_text("libmaker.so.1\n")
    (vendors / "by_path.icd").write_text(f"{elsewhere}\n")
    (vendors / "gone.icd").write_text("/no/such/libgone.so")
    monkeypatch.setenv("OPENCL_VENDOR_PATH", str(vendors))
    monkeypatch.delenv("OCL_ICD_VENDORS", raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    library = tmp_path / "lib" / "libintelocl.so"
    monkeypatch.setattr(drivers, "intel_library", lambda: library)

    def paths():
        with drivers.registered():
            folder = Path(os.environ["OCL_ICD_VENDORS"])
            found = sorted(icd.read_text().strip() for icd in folder.glob("*.icd"))
        assert "OCL_ICD_VENDORS" not in os.environ
        assert not folder.exists()
        return found

    assert paths() == sorted([str(elsewhere), str(library), "libmaker.so.1"])
    (vendors / "intel.icd").write_text("libintelocl.so\n")  # the system's own
    assert paths() == sorted([str(elsewhere), "libintelocl.so", "libmaker.so.1"])
    monkeypatch.setenv("OCL_ICD_VENDORS", "/chosen")
    with drivers.registered():
        assert os.environ["OCL_ICD_VENDORS"] == "/chosen"


def test_the_lock_of_a_killed_process_is_removed(fresh):
    lock = Path(caches.kernel_folder(), "lock")
    lock.parent.mkdir(parents=True)
    lock.touch()
    caches.kernel_folder()
    assert lock.exists()  # a build in another process
    os.utime(lock, (0, 0))
    caches.kernel_folder()
    assert not lock.exists()
