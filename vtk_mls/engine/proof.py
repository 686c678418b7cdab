"""A device proves itself before it is used: in a child process, against the specification.

Drivers miscompile, crash and hang. What becomes of a child says whether a device may be used, and
with how many points per work item; the verdict is kept, so that this happens once.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import platform
import queue
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from vtk_mls.announcements import announce, warn
from vtk_mls.engine import device as devices
from vtk_mls.engine import records
from vtk_mls.engine.patience import Patience
from vtk_mls.resources import resource

# A step of the test takes about a second where it is slow and nothing else is done.
_SECONDS_PER_STEP = 20
_NO_END = "it does not come to an end"
# What failed at every width, or did not end, may have done so because the machine was short of
# something just then.
_SECONDS_OF_A_DOUBT = 24 * 3600
MARK = "vtk_mls self-test: "  # before what a child tells
# A child is asked by files beside this script: pvpython keeps standard input for itself.
_CHILD = """
import json, sys
folder = __file__.rpartition("child.py")[0]
with open(folder + "request.json") as file:
    request = json.load(file)
sys.path[:] = request["path"]
from vtk_mls.engine import self_test
self_test.main(request, folder)
"""
MEASURE = "measure"  # a file that tells it to go on
# Programs started by a child must not take themselves for a process of the parent's MPI job.
_MPI_VARIABLES = re.compile(r"(OMPI|OPAL|PMIX?|PRTE|MPI|MPIR|MV2|PALS|SLURM|HYDRA|HYDI)_")


@dataclass(frozen=True)
class Verdict:
    """What is known of a device.

    Attributes
    ----------
    lanes : int
        Points per work item that it may be used with; 0 if it may not.
    failures : tuple of str
        Why not with more.
    speed : float
        Points per second of a rigid map with 15 control points; 0 if it was not measured.
    proven : bool
        Whether this was tested; else the lanes are those that are known to be safe.
    """

    lanes: int
    failures: tuple[str, ...] = ()
    speed: float = 0.0
    proven: bool = True


def verdicts(found: list[devices.Device], retest: bool = False) -> list[Verdict]:
    """The verdict on each device; those that are not known yet are tested, side by side.

    Parameters
    ----------
    found : list of Device
    retest : bool, optional
        Test all of them again.
    """
    names = [records.name(identity(device)) for device in found]
    with _lock:
        unknown = dict(zip(names, found)) if retest else _unknown(names, found)
        if unknown:
            with records.one_at_a_time():
                # another process may have been here first
                unknown = unknown if retest else _unknown(unknown, unknown.values())
                _known.update(zip(unknown, _tested(list(unknown.values()))))
                for name, device in unknown.items():
                    _keep(name, device)
        return [_known[name] for name in names]


def known(device: devices.Device) -> Verdict | None:
    """The verdict on `device` without a test."""
    name = records.name(identity(device))
    with _lock:
        _unknown([name], [device])
        return _known.get(name)


_known: dict[str, Verdict] = {}
_lock = threading.RLock()


def _unknown(names, found):
    """Devices without a verdict by their names; those kept in files become known."""
    for name in names:
        if name not in _known and (verdict := _kept(name)) is not None:
            _known[name] = verdict
    return {name: device for name, device in zip(names, found) if name not in _known}


@functools.cache
def identity(device: devices.Device) -> str:
    """Everything that a verdict depends on: drivers, processor, kernels."""
    others = sorted({(d.platform, d.driver) for d in devices.list_devices()})
    return repr((described(device)[1:], others, _processor(), _kernels()))


def _processor():
    """The processor that a CPU driver compiles for: several machines may share a home."""
    try:
        with open("/proc/cpuinfo") as info:
            lines = info.read(8192).splitlines()
    except OSError:
        return platform.machine(), platform.processor()
    return [line for line in lines if line.startswith(("model name", "flags", "Features"))][:2]


@functools.cache
def _kernels():
    """What tells the text of all kernels, and of the test, from others."""
    here, package = Path(__file__), Path(__file__).parents[1]
    files = [*sorted(resource("opencl").glob("*.cl")), here.with_name("self_test.py")]
    files += [here.with_name(name) for name in ("kernel_arguments.py", "cut_tables.py")]
    files += [*sorted(package.glob("kinds/*.py")), *sorted(package.glob("cuts/*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def described(device: devices.Device) -> list[str]:
    """What tells a device from others in any process that has the same drivers."""
    about = [device.key, device.name, device.platform, device.kind]
    return [*about, device.version, device.driver]


def record_path(device: devices.Device) -> Path | None:
    """The file that keeps the verdict on `device`; None where nothing can be kept."""
    folder = records.folder()
    return folder and folder / records.name(identity(device))


def _kept(name):
    record = records.read(name)
    try:
        lanes, failures, speed = (record[key] for key in ("lanes", "failures", "speed"))
        verdict = Verdict(int(lanes), tuple(map(str, failures)), float(speed))
        old = not 0 <= time.time() - record["time"] < _SECONDS_OF_A_DOUBT
    except (KeyError, TypeError, ValueError):
        return None
    doubtful = verdict.lanes == 0 or any(_NO_END in failure for failure in verdict.failures)
    if verdict.lanes not in (0, 1, 4, 8, 16) or (doubtful and old):
        return None
    return verdict


def _keep(name, device):
    verdict = _known[name]
    if verdict.proven:
        records.write(name, {"device": str(device), **asdict(verdict), "time": time.time()})


def _tested(found):
    """Verdicts on devices, none of which is known."""
    if not found:
        return []
    python = interpreter()
    if python is None:
        warn(
            "OpenCL devices cannot be tested, for this program has no Python to start: "
            "they are used with the widest vectors that are known to be safe"
        )
        return [Verdict(device.widths[0], proven=False) for device in found]
    names = ", ".join(f"{device.name} ({device.platform})" for device in found)
    announce(f"Testing OpenCL on {names} before its first use, once: up to a minute or two ...")
    contests = [_Contest(device, python) for device in found]
    try:
        with ThreadPoolExecutor(len(contests)) as pool:
            try:
                list(pool.map(_Contest.run, contests))
            except BaseException:  # interrupted: the pool waits for its threads
                for contest in contests:
                    contest.abandon()
                raise
        for contest in contests:  # one after the other, on a machine that is quiet by now
            contest.measure()
    finally:
        for contest in contests:
            contest.close()
    return [contest.verdict() for contest in contests]


class _Contest:
    """Trials of a device with fewer and fewer points per work item, until one is passed."""

    def __init__(self, device, python):
        self.device, self.python = device, python
        self.widths = list(device.widths)
        self.failures, self.speed, self.trial = [], 0.0, None
        self.untestable = None
        self._abandoned = False

    def run(self):
        while self.widths and self.untestable is None and not self._abandoned:
            self.trial = _Trial(self.device, self.widths[0], self.python)
            try:
                self.trial.prove()
                return
            except _UntestableError as error:
                self.untestable = str(error)
            except _FailedError as error:
                self._failed(error)
            self.close()

    def measure(self):
        while self.trial is not None:
            try:
                self.speed = self.trial.speed()
                return
            except _FailedError as error:
                self._failed(error)
            self.close()
            self.run()

    def _failed(self, error):
        self.failures.append(f"with {_points(self.widths.pop(0))} {error}")

    def abandon(self):
        """End soon, from another thread."""
        self._abandoned = True
        trial = self.trial
        if trial is not None:
            trial.kill()

    def close(self):
        if self.trial is not None:
            self.trial.close()
            self.trial = None

    def verdict(self):
        device = self.device
        if self.untestable is not None:
            warn(
                f"{device} cannot be tested ({self.untestable}): it is used with the widest "
                "vectors that are known to be safe"
            )
            return Verdict(device.widths[0], proven=False)
        for failure in self.failures:
            warn(f"{device}: {failure}")
        if not self.widths:
            warn(
                f"{device} is not used, for it fails at every width; "
                "`vtk-mls doctor --retest` tries again"
            )
        return Verdict(self.widths[0] if self.widths else 0, tuple(self.failures), self.speed)


def _points(count):
    return f"{count} point{'s' * (count > 1)} per work item"


class _FailedError(Exception):
    """A device did not pass; says what happened."""


class _UntestableError(Exception):
    """A child came to nothing for reasons that are not the device's."""


class _Trial:
    """A child process that tests a device with caches of its own."""

    def __init__(self, device, lanes, python):
        self._lines = queue.Queue()
        self._last = self._step = ""
        self._folder = tempfile.TemporaryDirectory(prefix="vtk_mls-", ignore_cleanup_errors=True)
        script = Path(self._folder.name, "child.py")
        script.write_text(_CHILD)
        request = {
            "path": [os.path.abspath(folder) for folder in sys.path],
            "device": described(device),
            "lanes": lanes,
        }
        script.with_name("request.json").write_text(json.dumps(request))
        try:
            self._child = subprocess.Popen(
                [*python, str(script)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                env=self._environment(),
                text=True,
                errors="replace",
            )
        except OSError as error:
            self._child, self._problem = None, str(error)
            return
        threading.Thread(target=self._read, daemon=True).start()

    def prove(self):
        """Wait for what becomes of it.

        Raises
        ------
        _FailedError, _UntestableError
        """
        if self._child is None:
            raise _UntestableError(self._problem)
        self._wait_for("proven")

    def speed(self):
        """Points per second. Raises _FailedError."""
        Path(self._folder.name, MEASURE).touch()
        return float(self._wait_for("speed"))

    def kill(self):
        if self._child is not None:
            self._child.kill()

    def close(self):
        self.kill()
        if self._child is not None:
            self._child.wait()
            self._child.stdout.close()
        self._folder.cleanup()

    def _environment(self):
        own = self._folder.name
        kept = {k: v for k, v in os.environ.items() if not _MPI_VARIABLES.match(k)}
        return {
            **kept,
            "XDG_CACHE_HOME": own,
            "POCL_CACHE_DIR": os.path.join(own, "pocl"),
            "CUDA_CACHE_PATH": os.path.join(own, "cuda"),
        }

    def _read(self):
        with contextlib.suppress(ValueError):  # closed meanwhile
            for line in self._child.stdout:
                self._lines.put(line)
        self._lines.put(None)

    def _wait_for(self, name):
        """What the child tells under a name, sooner or later."""
        patience = Patience(self._child.pid, _SECONDS_PER_STEP)
        while True:
            try:
                line = self._lines.get(timeout=_SECONDS_PER_STEP)
            except queue.Empty:
                if not patience.ends():
                    continue
                waited = f"no answer for {patience.waited:.0f} s"
                raise _FailedError(f"{_NO_END} ({self._step or 'start'}: {waited})") from None
            patience.begin()
            if line is None:
                self._ended()
            elif not line.startswith(MARK):
                self._last = line.strip() or self._last
                continue
            told = json.loads(line[len(MARK) :])
            if "failure" in told:
                raise _FailedError(told["failure"])
            if "untestable" in told:
                raise _UntestableError(told["untestable"])
            if name in told:
                return told[name]
            self._step = told["step"]

    def _ended(self):
        status = self._child.wait()
        words = f": {self._last[:200]}" if self._last else ""
        if not self._step and status > 0:  # Python itself, or what it imports
            raise _UntestableError(f"its process ends with status {status}{words}")
        how = f"status {status}"
        if status < 0:
            with contextlib.suppress(ValueError):
                how = f"signal {-status}, {signal.Signals(-status).name}"
        raise _FailedError(f"the process ends by {how} ({self._step or 'start'}{words})")


def interpreter() -> list[str] | None:
    """What starts a Python like this one; None if there is none, as in some embedded ones."""
    version = "{}.{}".format(*sys.version_info)
    program = Path(os.path.realpath("/proc/self/exe")) if os.name == "posix" else None
    beside = [Path(sys.executable).parent] if sys.executable else []
    beside += [program.parent] if program else []
    suffix = ".exe" if sys.platform == "win32" else ""
    candidates = [sys.executable, getattr(sys, "_base_executable", None)]
    candidates += [Path(sys.base_prefix, "bin", f"python{version}")]
    candidates += [Path(sys.base_prefix, f"python{suffix}")]
    candidates += [folder / f"pvpython{suffix}" for folder in beside]
    found = [str(each) for each in candidates if each and os.access(each, os.X_OK)]
    names = (r"python[\d.]*(\.exe)?", r"(pv|vtk)python[\d.]*(\.exe)?")  # the latter load much more
    for name in names:
        for candidate in found:
            if re.fullmatch(name, Path(candidate).name.lower()):
                return [candidate]
    return None
