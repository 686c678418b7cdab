"""Devices prove themselves in a child process: what becomes of those that cannot."""

import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import pytest
from conftest import DEVICES, LOCAL_POINTS

from vtk_mls import announcements
from vtk_mls.engine import caches, device, dispatch, drivers, intel_runtime, proof, records
from vtk_mls.engine.proof import MARK

# What drivers and pyopencl have built before; else a test of a real device takes long.
USUAL = caches.folder()
BUILT = {"XDG_CACHE_HOME": f"{USUAL}", "POCL_CACHE_DIR": f"{USUAL}/pocl/kcache"} if USUAL else {}
HANDLE = types.SimpleNamespace(native_vector_width_float=16)
FAKE = device.Device("0:0", "Processor", "Maker", "cpu", "OpenCL 3.0", HANDLE, "1.0")

# Stands for Python in a child: reads the request, and does as `{behaviour}` says.
STUB = """
import json, os, signal, sys, time
folder = os.path.dirname(sys.argv[1])
with open(os.path.join(folder, "request.json")) as file:
    lanes = json.load(file)["lanes"]
def tell(**what):
    print({mark!r} + json.dumps(what), flush=True)
def wait():
    while not os.path.exists(os.path.join(folder, "measure")):
        time.sleep(0.01)
tell(step="the first step")
{behaviour}
tell(proven="")
wait()
tell(speed=2e6 * lanes)
"""
DIES = "os.kill(os.getpid(), signal.SIGSEGV)"
HANGS = "time.sleep(60)"
SPINS = "[None for _ in iter(int, 1)]"
SLOW = "while time.process_time() < 4: pass"
LIES = "tell(failure='it computes wrong numbers (the first step: off by 0.3)'); sys.exit()"
COMPILER = "print('LLVM ERROR: cannot select'); sys.stdout.flush(); os.abort()"


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """As in a new process whose user has no verdicts yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    caches.folder.cache_clear()
    monkeypatch.setattr(proof, "_known", {})
    monkeypatch.setattr(proof, "_SECONDS_PER_STEP", 3)
    yield tmp_path
    caches.folder.cache_clear()


@pytest.fixture
def child(fresh, monkeypatch):
    """Let children behave like this."""

    def behave(behaviour):
        stub = fresh / "stub.py"
        stub.write_text(STUB.format(mark=MARK, behaviour=behaviour))
        monkeypatch.setattr(proof, "interpreter", lambda: [sys.executable, str(stub)])

    return behave


def announced(function, *arguments):
    """What `function` returns, and the sentences that were announced meanwhile."""
    sentences = []
    with announcements.heard_by(sentences.append, sentences.append):
        return function(*arguments), sentences


def test_a_sound_device_is_tested_once(child, monkeypatch):
    child("")
    (verdict,), sentences = announced(proof.verdicts, [FAKE])
    assert verdict == proof.Verdict(16, speed=32e6)
    assert len(sentences) == 1
    assert sentences[0].startswith("Testing OpenCL on Processor (Maker)")
    child(DIES)
    assert proof.verdicts([FAKE]) == [verdict]
    monkeypatch.setattr(proof, "_known", {})  # another process
    assert announced(proof.verdicts, [FAKE]) == ([verdict], [])
    assert json.loads(proof.record_path(FAKE).read_text())["device"] == str(FAKE)


@pytest.mark.parametrize(
    ("behaviour", "sentence"),
    [
        pytest.param(DIES, "the process ends by signal 11, SIGSEGV", id="dies"),
        pytest.param(HANGS, "it does not come to an end (the first step: no answer", id="hangs"),
        pytest.param(SPINS, "it does not come to an end (the first step: no answer", id="spins"),
        pytest.param(LIES, "it computes wrong numbers (the first step: off by 0.3)", id="lies"),
        pytest.param(COMPILER, "signal 6, SIGABRT (the first step: LLVM ERROR", id="compiler"),
        pytest.param("print(0); sys.exit(3)", "ends by status 3", id="exits"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_a_driver_that_only_fails_at_16_points(child, behaviour, sentence):
    child(f"if lanes == 16: {behaviour}")
    (verdict,), sentences = announced(proof.verdicts, [FAKE])
    assert (verdict.lanes, verdict.speed, verdict.proven) == (8, 16e6, True)
    assert len(verdict.failures) == 1
    assert sentence in verdict.failures[0]
    assert sentences[1] == f"{FAKE}: {verdict.failures[0]}"
    assert verdict.failures[0].startswith("with 16 points per work item ")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="it tells processor time in /proc")
def test_a_device_that_works_long_is_waited_for(child):
    """As on a machine that is busy with other things."""
    child(SLOW)
    (verdict,), _ = announced(proof.verdicts, [FAKE])
    assert verdict == proof.Verdict(16, speed=32e6)


def test_a_driver_that_fails_at_every_width(child, monkeypatch):
    child(LIES)
    (verdict,), sentences = announced(proof.verdicts, [FAKE])
    assert verdict.lanes == 0
    assert len(verdict.failures) == 4
    assert sentences[-1].startswith(f"{FAKE} is not used, for it fails at every width")
    child("")
    monkeypatch.setattr(proof, "_known", {})
    assert proof.verdicts([FAKE]) == [verdict]  # not tried again and again
    assert proof.verdicts([FAKE], retest=True)[0].lanes == 16
    assert proof.verdicts([FAKE])[0].lanes == 16


@pytest.mark.parametrize(
    ("behaviour", "next_day"),
    [
        pytest.param(LIES, 16, id="failed at every width"),
        pytest.param(f"if lanes == 16: {HANGS}", 16, id="did not end"),
        pytest.param(f"if lanes == 16: {LIES}", 8, id="narrower"),
    ],
)
def test_what_may_have_been_the_machines_fault_is_tested_again(
    child, behaviour, next_day, monkeypatch
):
    child(behaviour)
    (before,) = proof.verdicts([FAKE])
    child("")
    monkeypatch.setattr(proof, "_known", {})
    assert proof.verdicts([FAKE]) == [before]
    monkeypatch.setattr(proof, "_known", {})
    monkeypatch.setattr(proof, "_SECONDS_OF_A_DOUBT", -1)
    assert proof.verdicts([FAKE])[0].lanes == next_day


def test_a_device_that_fails_while_its_speed_is_measured(child):
    child("if lanes == 16: tell(proven=''); wait(); sys.exit(1)")
    (verdict,) = proof.verdicts([FAKE])
    assert verdict.lanes == 8
    assert "ends by status 1" in verdict.failures[0]


def test_children_that_cannot_be_started(fresh, monkeypatch):
    for nothing in (None, [str(fresh / "nothing")], [sys.executable, "-c", "raise ImportError"]):
        monkeypatch.setattr(proof, "interpreter", lambda nothing=nothing: nothing)
        monkeypatch.setattr(proof, "_known", {})
        (verdict,), sentences = announced(proof.verdicts, [FAKE])
        assert verdict == proof.Verdict(16, proven=False)
        assert "the widest vectors that are known to be safe" in sentences[-1]
        assert not proof.record_path(FAKE).exists()


def test_a_device_that_a_child_does_not_find(fresh):
    (verdict,), sentences = announced(proof.verdicts, [FAKE])
    assert not verdict.proven
    assert "the device is not there in a process of its own" in sentences[-1]


def test_devices_of_one_kind_are_tested_once(child):
    child("")
    twin = dataclasses.replace(FAKE, key="0:1")
    verdicts, sentences = announced(proof.verdicts, [FAKE, twin])
    assert verdicts[0] is verdicts[1]
    assert sentences[0].count("Processor") == 1


def test_several_devices_are_tested_side_by_side(child, fresh):
    """Each child waits until all of them are there."""
    child(
        f"""
place = {str(fresh)!r}
open(os.path.join(place, "here" + str(os.getpid())), "w").close()
while sum(name.startswith("here") for name in os.listdir(place)) < 3:
    time.sleep(0.05)
"""
    )
    others = [dataclasses.replace(FAKE, name=name) for name in "abc"]
    assert [v.lanes for v in proof.verdicts(others)] == [16] * 3


@pytest.mark.parametrize("text", ["", "{", "[]", '{"lanes": 3}', '{"lanes": "x", "time": 0}', "\0"])
def test_broken_records_do_no_harm(child, text, monkeypatch):
    child("")
    place = proof.record_path(FAKE)
    place.parent.mkdir(parents=True)
    place.write_text(text)
    assert proof.verdicts([FAKE])[0].lanes == 16
    monkeypatch.setattr(proof, "_known", {})
    child(DIES)
    assert proof.verdicts([FAKE])[0].lanes == 16


def test_records_that_cannot_be_written(child, monkeypatch):
    child("")
    monkeypatch.setattr(records, "folder", lambda: None)
    assert proof.verdicts([FAKE])[0].lanes == 16
    monkeypatch.setattr(records, "folder", lambda: Path("/proc/none/devices"))
    monkeypatch.setattr(proof, "_known", {})
    assert proof.verdicts([FAKE])[0].lanes == 16


def test_two_at_once_wait_for_one_test(child):
    """Another process holds the lock, as if it were testing; its verdict is taken over."""
    child(DIES)
    held, done = threading.Event(), []

    def test_elsewhere():
        with records.one_at_a_time():
            held.set()
            time.sleep(1)
            name = records.name(proof.identity(FAKE))
            record = {"lanes": 4, "failures": [], "speed": 1.0, "time": time.time()}
            records.write(name, record)

    other = threading.Thread(target=test_elsewhere)
    other.start()
    held.wait()
    done = proof.verdicts([FAKE])
    other.join()
    if records.fcntl is not None:
        assert done == [proof.Verdict(4, speed=1.0)]


def test_a_child_is_no_process_of_the_parents_mpi_job(child, monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "3")
    monkeypatch.setenv("PMIX_RANK", "3")
    child("any('MPI' in k or 'PMI' in k for k in os.environ) and sys.exit(1)")
    assert proof.verdicts([FAKE])[0].lanes == 16


def test_an_identity_tells_drivers_and_kernels_apart(monkeypatch):
    before = proof.identity(FAKE)
    assert proof.identity(dataclasses.replace(FAKE, key="3:0")) == before
    assert proof.identity(dataclasses.replace(FAKE, driver="1.1")) != before
    proof.identity.cache_clear()
    monkeypatch.setattr(proof, "_kernels", lambda: [b"others"])
    assert proof.identity(FAKE) != before
    proof.identity.cache_clear()


def test_python_is_found_in_embedding_programs(tmp_path, monkeypatch):
    def program(name):
        path = tmp_path / name
        path.write_text("")
        path.chmod(0o755)
        return str(path)

    assert proof.interpreter() == [sys.executable]
    monkeypatch.setattr(sys, "executable", program("paraview"))
    monkeypatch.setattr(sys, "_base_executable", "")
    found = proof.interpreter()
    assert Path(found[0]).name.startswith("python")  # of base_prefix
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    monkeypatch.setattr(os.path, "realpath", lambda path: str(tmp_path / "paraview"))
    assert proof.interpreter() is None
    pvpython = program("pvpython")
    assert proof.interpreter() == [pvpython]
    monkeypatch.setattr(sys, "executable", pvpython)
    (tmp_path / "bin").mkdir()
    python = program("bin/python{}.{}".format(*sys.version_info))
    assert proof.interpreter() == [python]  # which loads less


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize(
    ("question", "changed", "found"),
    [
        ("jacobian", "answer + 0.01", "rigid Jacobian, cut: off by 0.01"),
        ("jacobian", "answer * float('nan')", "rigid Jacobian, cut: off by nan"),
        ("forward", "(answer[0] + 0.1, answer[1])", "rigid inverse, cut: off by "),
    ],
)
def test_wrong_numbers_are_noticed(question, changed, found, fresh, monkeypatch):
    """The real test of a real device whose kernels are wrong at two widths in a hard to see way."""
    stub = fresh / "stub.py"
    stub.write_text(
        f"""
import json, os, runpy, sys
os.environ.update({BUILT})
with open(os.path.join(os.path.dirname(sys.argv[1]), "request.json")) as file:
    sys.path[:] = json.load(file)["path"]
from vtk_mls.engine import engine
right = engine.Engine.{question}
def wrong(self, *arguments):
    answer = right(self, *arguments)
    return {changed} if self.device.lanes > 4 else answer
engine.Engine.{question} = wrong
runpy.run_path(sys.argv[1])
"""
    )
    monkeypatch.setattr(proof, "interpreter", lambda: [sys.executable, str(stub)])
    monkeypatch.setattr(proof, "_SECONDS_PER_STEP", 60)
    chosen = dispatch.choose(DEVICES[0])
    (verdict,) = proof.verdicts([chosen])
    wide = [width for width in chosen.widths if width > 4]
    assert verdict.lanes == (4 if len(chosen.widths) > 1 else 1)
    assert len(verdict.failures) == len(wide)
    for failure in verdict.failures:
        assert f"it computes wrong numbers ({found}" in failure


ASK = """
import time
start = time.monotonic()
from vtk_mls import Deformation
print(Deformation([[0, 0, 0]], [[1, 2, 3]]).backward([[5, 5, 5]]).tolist())
"""


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize(
    "home", ["empty", pytest.param("read-only", marks=pytest.mark.long), "none"]
)
def test_processes_that_start_together(tmp_path, home):
    """With an empty record, or no place for one, and for no other cache."""
    variables = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")}
    variables["HOME"] = {"empty": str(tmp_path), "read-only": "/proc/1", "none": "/dev/null"}[home]
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
    said = [process.communicate(timeout=180) for process in children]
    assert [out for out, _ in said] == ["[[4.0, 3.0, 2.0]]\n"] * 2, said
    if records.fcntl is not None:
        assert sorted(err.count("Testing OpenCL") for _, err in said) == [0, 1], said
    assert all("Traceback" not in err for _, err in said)


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_an_interrupt_ends_the_children(tmp_path):
    code = f"""
import sys
from vtk_mls.engine import proof
proof.interpreter = lambda: [sys.executable, "-c", "import time; time.sleep(600)"]
proof._SECONDS_PER_STEP = 600
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


def test_intels_driver_is_given_a_path_without_spaces(fresh, monkeypatch):
    folder = fresh / "with space" / "lib"
    folder.mkdir(parents=True)
    driver, needed, other = (
        folder / name for name in ("libintelocl.so", "libtbb.so", "libother.so")
    )
    for file in (driver, needed, other):
        file.write_text(file.name)
    installed = {"intel-opencl-rt": [driver], "tbb": [needed]}
    monkeypatch.setattr(intel_runtime, "_files", lambda package: installed.get(package, []))
    found = intel_runtime.library()
    assert found.is_relative_to(fresh / "cache")
    assert {file.name for file in found.parent.iterdir()} == {driver.name, needed.name, "driver"}
    assert os.path.samefile(found, driver)
    assert intel_runtime.library() == found
    monkeypatch.setattr(os, "link", lambda *_: (_ for _ in ()).throw(OSError("another disk")))
    shutil.rmtree(found.parent)
    assert intel_runtime.library().read_text() == "libintelocl.so"
    driver.rename(fresh / driver.name)  # the environment is gone, and there is another
    installed["intel-opencl-rt"] = [fresh / driver.name]
    assert intel_runtime.library() == fresh / driver.name
    intel_runtime._forget_what_is_gone(found.parent.parent)
    assert not found.parent.exists()


def test_intels_driver_from_pip_joins_those_of_the_system(tmp_path, monkeypatch):
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
    monkeypatch.setattr(drivers.intel_runtime, "library", lambda: library)

    def shown():
        with drivers.shown():
            folder = Path(os.environ["OCL_ICD_VENDORS"])
            found = sorted(icd.read_text().strip() for icd in folder.glob("*.icd"))
        assert "OCL_ICD_VENDORS" not in os.environ
        assert not folder.exists()
        return found

    assert shown() == sorted([str(elsewhere), str(library), "libmaker.so.1"])
    (vendors / "intel.icd").write_text("libintelocl.so\n")  # the system's own
    assert shown() == sorted([str(elsewhere), "libintelocl.so", "libmaker.so.1"])
    monkeypatch.setenv("OCL_ICD_VENDORS", "/chosen")
    with drivers.shown():
        assert os.environ["OCL_ICD_VENDORS"] == "/chosen"


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
def test_the_engine_says_when_it_builds():
    chosen = dispatch.choose(DEVICES[0])
    constants = (*LOCAL_POINTS, ("UNLIKE", "others"))
    _, sentences = announced(device.kernel, chosen, "local_points", constants)
    assert sentences == ["Building OpenCL kernels"]
    assert announced(device.kernel, chosen, "local_points", constants)[1] == []
