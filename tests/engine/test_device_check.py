"""Devices are checked in a child process; those that fail are not used."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import pytest
from control_point_sets import DEVICES, LOCAL_POINTS

from vtk_mls.base import child_process, messages
from vtk_mls.engine import dispatch
from vtk_mls.engine.device import caches, device_check
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.device.device_check import MARK, Result

# What drivers and pyopencl have built before; else a test of a real device takes long.
USUAL = caches.folder()
BUILT = {"XDG_CACHE_HOME": f"{USUAL}", "POCL_CACHE_DIR": f"{USUAL}/pocl/kcache"} if USUAL else {}
HANDLE = types.SimpleNamespace(native_vector_width_float=16)
FAKE = device.Device("0:0", "Processor", "Maker", "cpu", "OpenCL 3.0", HANDLE, "1.0")

# A stand-in for Python in the child: reads the request and runs `{behavior}`.
STUB = """
import json, os, signal, sys, time
folder = os.path.dirname(sys.argv[1])
with open(os.path.join(folder, "request.json")) as file:
    request = json.load(file)["arguments"][0]
lanes, part = request["lanes"], request["part"]
def report(**message):
    print({mark!r} + json.dumps(message), flush=True)
report(step="the first step")
{behavior}
report(speed=2e6 * lanes)
"""
DIES = "os.kill(os.getpid(), signal.SIGSEGV)"
HANGS = "time.sleep(60)"
SPINS = "[None for _ in iter(int, 1)]"
LIES = "report(failure='it computes wrong numbers (the first step: off by 0.3)'); sys.exit()"
COMPILER = "print('LLVM ERROR: cannot select'); sys.stdout.flush(); os.abort()"


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """As in a new process whose user has no results yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    caches.folder.cache_clear()
    monkeypatch.setattr(device_check, "_results", {})
    monkeypatch.setattr(device_check, "STEP_TIMEOUT", 3)
    monkeypatch.setattr(child_process, "_processes_per_processor", lambda: 1)
    yield tmp_path
    caches.folder.cache_clear()


@pytest.fixture
def child(fresh, monkeypatch):
    """Let children behave like this."""

    def behave(behavior):
        stub = fresh / "stub.py"
        stub.write_text(STUB.format(mark=MARK, behavior=behavior))
        monkeypatch.setattr(child_process, "interpreter", lambda: [sys.executable, str(stub)])

    return behave


def messages_of(function, *arguments):
    """What `function` returns, and the messages to the user meanwhile."""
    sentences = []
    with messages.message_handlers(sentences.append, sentences.append):
        return function(*arguments), sentences


def test_a_sound_device_is_tested_once(child, monkeypatch):
    child("")
    (result,), sentences = messages_of(device_check.results, [FAKE])
    assert result == Result(16, speed=32e6)
    assert len(sentences) == 1
    assert sentences[0].startswith("Testing OpenCL on Processor (Maker)")
    child(DIES)
    assert device_check.results([FAKE]) == [result]
    monkeypatch.setattr(device_check, "_results", {})  # another process
    assert messages_of(device_check.results, [FAKE]) == ([result], [])
    assert json.loads(device_check.result_path(FAKE).read_text())["device"] == str(FAKE)


@pytest.mark.parametrize(
    ("behavior", "sentence"),
    [
        pytest.param(DIES, "the process ends by SIGSEGV", id="dies"),
        pytest.param(HANGS, "it does not come to an end (the first step: no answer", id="hangs"),
        pytest.param(SPINS, "it does not come to an end (the first step: no answer", id="spins"),
        pytest.param(LIES, "it computes wrong numbers (the first step: off by 0.3)", id="lies"),
        pytest.param(COMPILER, "ends by SIGABRT (the first step: LLVM ERROR", id="compiler"),
        pytest.param("print(0); sys.exit(3)", "ends by exit status 3", id="exits"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_a_driver_that_only_fails_at_16_points(child, behavior, sentence):
    child(f"if lanes == 16: {behavior}")
    (result,), sentences = messages_of(device_check.results, [FAKE])
    assert (result.lanes, result.speed, result.is_checked) == (8, 16e6, True)
    assert len(result.failures) == 1
    assert sentence in result.failures[0]
    assert sentences[1] == f"{FAKE}: {result.failures[0]}"
    assert result.failures[0].startswith("with 16 points per work item ")


def test_a_driver_that_fails_at_every_width(child, monkeypatch):
    child(LIES)
    (result,), sentences = messages_of(device_check.results, [FAKE])
    assert result.lanes == 0
    assert len(result.failures) == 4
    assert sentences[-1].startswith(f"{FAKE} is not used, for it fails at every width")
    child("")
    monkeypatch.setattr(device_check, "_results", {})
    assert device_check.results([FAKE]) == [result]  # not tried again and again
    assert device_check.results([FAKE], recheck=True)[0].lanes == 16
    assert device_check.results([FAKE])[0].lanes == 16


def test_children_share_the_checks(child, monkeypatch):
    monkeypatch.setattr(device_check, "_processors", lambda: 2)
    child("lanes += part[0]")
    assert device_check.results([FAKE])[0] == Result(16, speed=34e6)  # the highest
    child(f"if lanes > 4 and part == [1, 2]: {LIES}\nif lanes > 4: {HANGS}")
    (result,) = device_check.results([FAKE], recheck=True)
    assert result.lanes == 4  # without a wait for the other children
    assert all("wrong numbers" in failure for failure in result.failures)
    gpu = dataclasses.replace(FAKE, kind="gpu")
    child("assert part == [0, 1]")
    assert device_check.results([gpu])[0].lanes == 1


def test_kernels_of_a_passed_check_are_cached(child, fresh, monkeypatch):
    build = """
path = os.path.join(os.environ["XDG_CACHE_HOME"], "vtk_mls", "kernels", f"key{lanes}")
os.makedirs(path, exist_ok=True)
open(os.path.join(path, "binary"), "w").close()"""
    child(f"{build}\nif lanes == 16: {LIES}")
    assert device_check.results([FAKE])[0].lanes == 8
    cached = fresh / "cache" / "vtk_mls" / "kernels"
    assert [str(path.relative_to(cached)) for path in cached.rglob("*")] == ["key8", "key8/binary"]


@pytest.mark.parametrize(
    ("behavior", "next_day"),
    [
        pytest.param(LIES, 16, id="failed at every width"),
        pytest.param(f"if lanes == 16: {HANGS}", 16, id="did not end"),
        pytest.param(f"if lanes == 16: {LIES}", 8, id="narrower"),
    ],
)
def test_inconclusive_results_are_checked_again(child, behavior, next_day, monkeypatch):
    child(behavior)
    (before,) = device_check.results([FAKE])
    child("")
    monkeypatch.setattr(device_check, "_results", {})
    assert device_check.results([FAKE]) == [before]
    monkeypatch.setattr(device_check, "_results", {})
    monkeypatch.setattr(device_check, "RETRY_SECONDS", -1)
    assert device_check.results([FAKE])[0].lanes == next_day


def test_children_that_cannot_be_started(fresh, monkeypatch):
    for nothing in (None, [str(fresh / "nothing")], [sys.executable, "-c", "raise ImportError"]):
        monkeypatch.setattr(child_process, "interpreter", lambda nothing=nothing: nothing)
        monkeypatch.setattr(device_check, "_results", {})
        (result,), sentences = messages_of(device_check.results, [FAKE])
        assert result == Result(16, is_checked=False)
        assert "the widest vectors that are known to be safe" in sentences[-1]
        assert not device_check.result_path(FAKE).exists()


def test_a_device_that_a_child_does_not_find(fresh, monkeypatch):
    monkeypatch.setattr(device_check, "STEP_TIMEOUT", 120)
    (result,), sentences = messages_of(device_check.results, [FAKE])
    assert not result.is_checked
    assert "the child process does not find the device" in sentences[-1]


def test_devices_of_one_kind_are_tested_once(child):
    child("")
    twin = dataclasses.replace(FAKE, key="0:1")
    found, sentences = messages_of(device_check.results, [FAKE, twin])
    assert found[0] is found[1]
    assert sentences[0].count("Processor") == 1


@pytest.mark.parametrize("text", ["", "{", "[]", '{"lanes": 3}', '{"lanes": "x", "time": 0}', "\0"])
def test_broken_records_do_no_harm(child, text, monkeypatch):
    child("")
    place = device_check.result_path(FAKE)
    place.parent.mkdir(parents=True)
    place.write_text(text)
    assert device_check.results([FAKE])[0].lanes == 16
    monkeypatch.setattr(device_check, "_results", {})
    child(DIES)
    assert device_check.results([FAKE])[0].lanes == 16


@pytest.mark.parametrize("folder", [None, Path("/proc/none")])
def test_results_that_cannot_be_written(child, folder, monkeypatch):
    child("")
    with monkeypatch.context() as patch:
        patch.setattr(caches, "folder", lambda: folder)
        assert device_check.results([FAKE])[0].lanes == 16


def test_two_processes_wait_for_one_check(child):
    """Another thread holds the lock, as a process would; its result is used."""
    child(DIES)
    is_locked = threading.Event()

    def check_elsewhere():
        with device_check._one_process_at_a_time():
            is_locked.set()
            time.sleep(1)
            device_check._write(FAKE, Result(4, speed=1.0))

    other = threading.Thread(target=check_elsewhere)
    other.start()
    is_locked.wait()
    found = device_check.results([FAKE])
    other.join()
    if device_check.fcntl is not None:
        assert found == [Result(4, speed=1.0)]


def test_a_child_is_no_process_of_the_parents_mpi_job(child, monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "3")
    monkeypatch.setenv("PMIX_RANK", "3")
    child("any('MPI' in k or 'PMI' in k for k in os.environ) and sys.exit(1)")
    assert device_check.results([FAKE])[0].lanes == 16


def test_an_identity_depends_on_drivers_and_kernels(monkeypatch):
    before = device_check.identity(FAKE)
    assert device_check.identity(dataclasses.replace(FAKE, key="3:0")) == before
    assert device_check.identity(dataclasses.replace(FAKE, driver="1.1")) != before
    device_check.identity.cache_clear()
    monkeypatch.setattr(device_check, "_kernels", lambda: [b"others"])
    assert device_check.identity(FAKE) != before
    device_check.identity.cache_clear()


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
    ("question", "changed", "found"),
    [
        ("jacobian", "answer + 0.01", "rigid Jacobian, fixed cut: off by 0.01"),
        pytest.param(
            "jacobian",
            "answer * float('nan')",
            "rigid Jacobian, fixed cut: off by nan",
            marks=pytest.mark.matrix,
        ),
        pytest.param(
            "forward",
            "(answer[0] + 0.1, answer[1])",
            "similarity inverse: off by ",
            marks=pytest.mark.matrix,
        ),
    ],
)
def test_wrong_results_are_detected(question, changed, found, fresh, monkeypatch):
    """The real test of a real device whose kernels are wrong at two widths in a hard to see way."""
    stub = fresh / "stub.py"
    stub.write_text(
        f"""
import json, os, runpy, sys
os.environ.update({BUILT})
with open(os.path.join(os.path.dirname(sys.argv[1]), "request.json")) as file:
    sys.path[:] = json.load(file)["path"]
from vtk_mls.engine import opencl_engine as engine
right = engine.Engine.{question}
def wrong(self, *arguments):
    answer = right(self, *arguments)
    return {changed} if self.device.lanes > 4 else answer
engine.Engine.{question} = wrong
runpy.run_path(sys.argv[1])
"""
    )
    monkeypatch.setattr(child_process, "interpreter", lambda: [sys.executable, str(stub)])
    monkeypatch.setattr(device_check, "STEP_TIMEOUT", 60)
    chosen = dispatch.choose(DEVICES[0])
    (result,) = device_check.results([chosen])
    wide = [width for width in chosen.widths if width > 4]
    assert result.lanes == (4 if len(chosen.widths) > 1 else 1)
    assert len(result.failures) == len(wide)
    for failure in result.failures:
        assert f"it computes wrong numbers ({found}" in failure


ASK = """
import time
start = time.monotonic()
from vtk_mls import Deformation
print(Deformation([[0, 0, 0]], [[1, 2, 3]]).backward([[5, 5, 5]]).tolist())
"""


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.matrix
@pytest.mark.parametrize("home", ["empty", "none"])
def test_processes_that_start_together(tmp_path, home):
    """With an empty record, or no place for one, and for no other cache."""
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
    if device_check.fcntl is not None:
        assert sorted(err.count("Testing OpenCL") for _, err in said) == [0, 1], said
    assert all("Traceback" not in err for _, err in said)


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_an_interrupt_ends_the_children(tmp_path):
    code = f"""
import sys
from vtk_mls.base import child_process
from vtk_mls.engine.device import device_check
child_process.interpreter = lambda: [sys.executable, "-c", "import time; time.sleep(600)"]
device_check.STEP_TIMEOUT = 600
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
