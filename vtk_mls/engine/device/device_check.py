"""Checks an OpenCL device once before its first use, in child processes.

Drivers miscompile, crash and hang. The children run the kernels on the device and compare them with
the numpy reference (`kernel_checks`). The result says whether the device may be used, and with how
many points per work item. It is saved in the user's cache folder, one file per driver, processor
and version of the kernels.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import platform
import re
import shutil
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path

from vtk_mls.base import child_process, lazy
from vtk_mls.base.messages import inform, warn
from vtk_mls.base.resources import resource
from vtk_mls.engine.device import caches, devices

try:
    import fcntl
except ImportError:  # Windows: processes that start together all run the check
    fcntl = None

# Seconds without output from the child. A step takes a few seconds; a busy machine needs more.
STEP_TIMEOUT = 120
# A failure at every width, or a timeout, may be the fault of a busy machine: checked again then.
RETRY_SECONDS = 24 * 3600
MARK = "vtk_mls device check: "  # before each JSON line of the child
# Children that share the checks of a CPU: compilers build one kernel at a time in a process.
_MAX_CHILDREN = 4
_TIMED_OUT = "it does not come to an end"
_CHECK = "vtk_mls.commands.kernel_checks:main"  # called by the child
# The child is not a process of the parent's MPI job.
_MPI_VARIABLES = re.compile(r"(OMPI|OPAL|PMIX?|PRTE|MPI|MPIR|MV2|PALS|SLURM|HYDRA|HYDI)_")


@dataclass(frozen=True)
class Result:
    """The result of the check of one device.

    Attributes
    ----------
    lanes : int
        Points per work item for which results are right; 0 if the device must not be used.
    failures : tuple of str
        Why more points per work item fail.
    speed : float
        Points per second of a rigid map with 15 control points; 0 if it was not measured.
    is_checked : bool
        False if no child process could run; `lanes` is a width known to be safe then.
    time : float
        When it was found, in seconds since 1970.
    """

    lanes: int
    failures: tuple[str, ...] = ()
    speed: float = 0.0
    is_checked: bool = True
    time: float = field(default_factory=time.time, compare=False)

    @property
    def is_stale(self) -> bool:
        """Whether it may be the fault of a busy machine, and is old enough for another check."""
        is_sure = self.is_checked and self.lanes and not any(_TIMED_OUT in f for f in self.failures)
        return not (is_sure or 0 <= time.time() - self.time < RETRY_SECONDS)


_NONE = Result(0, time=-math.inf)
_results: dict[str, Result] = {}  # by file name
_lock = threading.RLock()


def results(found: list[devices.Device], recheck: bool = False) -> list[Result]:
    """The result for each device; devices without one are checked now.

    Parameters
    ----------
    found : list of Device
    recheck : bool, optional
        Check all of them again.
    """
    with _lock:
        pending = _unchecked(found, recheck)
        if pending:
            with _one_process_at_a_time():
                # another process may have checked them meanwhile
                for name, result in _check(_unchecked(pending.values(), recheck)):
                    _results[name] = result
        return [_results[_file_name(device)] for device in found]


def cached_result(device: devices.Device) -> Result | None:
    """The result for `device` without a check."""
    with _lock:
        _unchecked([device])
        return _results.get(_file_name(device))


def result_path(device: devices.Device) -> Path | None:
    """The file with the result for `device`; None without a cache folder."""
    folder = caches.folder()
    return folder and folder / "vtk_mls" / "devices" / _file_name(device)


@lazy.cached
def identity(device: devices.Device) -> str:
    """Everything that a result depends on: drivers, processor, kernels."""
    drivers = sorted({(d.platform, d.driver) for d in devices.list_devices()})
    return repr((description(device)[1:], drivers, _processor(), _kernels()))


def description(device: devices.Device) -> list[str]:
    """Identifies `device` in any process that has the same drivers."""
    about = [device.key, device.name, device.platform, device.kind]
    return [*about, device.version, device.driver]


def _processor():
    """The processor that a CPU driver compiles for; machines may share a home folder."""
    try:
        with open("/proc/cpuinfo") as info:
            lines = info.read(8192).splitlines()
    except OSError:
        return platform.machine(), platform.processor()
    return [line for line in lines if line.startswith(("model name", "flags", "Features"))][:2]


@lazy.cached
def _kernels():
    """A digest of the kernels and of everything that the check runs."""
    package = Path(__file__).parents[2]
    names = "commands/kernel_checks", "engine/launch/kernel_arguments", "engine/map/cut_tables"
    files = [*sorted(resource("opencl").rglob("*.[ch]*")), *(package / f"{n}.py" for n in names)]
    files += [*sorted(package.glob("model/kinds/*.py")), *sorted(package.glob("model/cuts/*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


# Files


def _file_name(device):
    return hashlib.sha256(identity(device).encode()).hexdigest()[:24] + ".json"


def _unchecked(found, recheck=False):
    """Devices without a result, by file name; results in files are read."""
    named = {_file_name(device): device for device in found}
    if recheck:
        return named
    for name, device in named.items():
        if _results.get(name, _NONE).is_stale and (result := _read(device)) is not None:
            _results[name] = result
    return {name: d for name, d in named.items() if _results.get(name, _NONE).is_stale}


def _read(device):
    try:
        record = json.loads(result_path(device).read_text())
        lanes, failures, *numbers = (record[key] for key in ("lanes", "failures", "speed", "time"))
        speed, when = map(float, numbers)
        result = Result(int(lanes), tuple(map(str, failures)), speed, time=when)
    except (OSError, AttributeError, KeyError, TypeError, ValueError):
        return None
    return result if result.lanes in (0, 1, 4, 8, 16) else None


def _write(device, result):
    """Save a result. Without a writable folder each process checks again."""
    path = result_path(device)
    with contextlib.suppress(OSError):
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, new = tempfile.mkstemp(dir=path.parent)
            with os.fdopen(handle, "w") as file:
                json.dump({"device": str(device), **asdict(result)}, file)
            os.replace(new, path)


@contextlib.contextmanager
def _one_process_at_a_time():
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            if fcntl is not None and (cache := caches.folder()) is not None:
                folder = cache / "vtk_mls" / "devices"
                folder.mkdir(parents=True, exist_ok=True)
                fcntl.flock(stack.enter_context(open(folder / "lock", "w")), fcntl.LOCK_EX)
        yield


# The check


class _FailedError(Exception):
    """The device failed the check."""


class _UncheckableError(Exception):
    """The child failed for reasons other than the device."""


def _check(pending):
    """File names and results of devices, checked one after the other."""
    if not pending:
        return
    if child_process.interpreter() is None:
        warn(
            "OpenCL devices cannot be checked, for this program has no Python to start: "
            "they are used with the widest vectors that are known to be safe"
        )
        for name, device in pending.items():
            yield name, Result(device.widths[0], is_checked=False)
        return
    names = ", ".join(f"{device.name} ({device.platform})" for device in pending.values())
    inform(f"Testing OpenCL on {names} before its first use, once: some ten seconds ...")
    for name, device in pending.items():
        result = _check_device(device)
        if result.is_checked:
            _write(device, result)
        yield name, result


def _check_device(device):
    """Try fewer and fewer points per work item until the check passes."""
    failures = []
    for lanes in device.widths:
        try:
            return Result(lanes, tuple(failures), _run_children(device, lanes))
        except _UncheckableError as error:
            warn(
                f"{device} cannot be checked ({error}): it is used with the widest "
                "vectors that are known to be safe"
            )
            return Result(device.widths[0], is_checked=False)
        except _FailedError as error:
            points = f"{lanes} point{'s' * (lanes > 1)} per work item"
            failures.append(f"with {points} {error}")
            warn(f"{device}: {failures[-1]}")
    warn(
        f"{device} is not used, for it fails at every width; `vtk-mls doctor --retest` tries again"
    )
    return Result(0, tuple(failures))


def _run_children(device, lanes):
    """Points per second of a device that computes right, with caches of the children's own."""
    count = min(_processors(), _MAX_CHILDREN) if device.kind == "cpu" else 1
    request = {"device": description(device), "lanes": lanes}
    with tempfile.TemporaryDirectory(prefix="vtk_mls-", ignore_cleanup_errors=True) as folder:
        options = {"env": _child_environment(folder), "text": True, "errors": "replace"}
        # Standard input is not free: pvpython reads it.
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE}
        streams["stderr"] = subprocess.STDOUT
        with contextlib.ExitStack() as stack:
            children = []
            for part in range(count):
                started = child_process.started(
                    _CHECK, {**request, "part": (part, count)}, **streams, **options
                )
                try:
                    children.append(stack.enter_context(started))
                except OSError as error:
                    raise _UncheckableError(str(error)) from error
            pool = stack.enter_context(ThreadPoolExecutor(count))
            for child, _ in children:  # at the first failure: readers end with them
                stack.callback(child.kill)
            found = as_completed([pool.submit(_speed_from, *child) for child in children])
            speed = max(speed.result() for speed in found)  # one child measures it
        _save_kernels(Path(folder))
        return speed


def _processors():
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _save_kernels(folder):
    """Move kernels that children have built to the user's `caches.kernel_folder`."""
    cache = caches.folder()
    for built in folder.glob("vtk_mls/kernels/*/binary") if cache else ():
        target = cache / built.parent.relative_to(folder)
        new = target.with_suffix(f".{os.getpid()}")  # as another process never sees a part of it
        with contextlib.suppress(OSError):
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists():
                shutil.move(built.parent, new)
                new.replace(target)


def _child_environment(folder):
    variables = {k: v for k, v in os.environ.items() if not _MPI_VARIABLES.match(k)}
    return {
        **variables,
        "XDG_CACHE_HOME": folder,
        "POCL_CACHE_DIR": os.path.join(folder, "pocl"),
        "CUDA_CACHE_PATH": os.path.join(folder, "cuda"),
    }


def _speed_from(child, folder):
    """Read the output of the child with a folder up to the speed.

    Raises
    ------
    _FailedError, _UncheckableError
    """
    step, last_line = "start", ""
    try:
        for line in child_process.lines(child, STEP_TIMEOUT):
            if not line.startswith(MARK):
                last_line = line.strip() or last_line
                continue
            message = json.loads(line[len(MARK) :])
            if "failure" in message:
                raise _FailedError(message["failure"])
            if "speed" in message:
                return float(message["speed"])
            step = message["step"]
    except TimeoutError as error:
        raise _FailedError(f"{_TIMED_OUT} ({step}: {error})") from None
    status = child.wait()
    words = f": {last_line[:200]}" if last_line else ""
    if (error := child_process.error(folder)) is not None:
        kind = _UncheckableError if step == "start" else _FailedError
        raise kind(f"it ends with {type(error).__name__}: {error}")
    if step == "start" and status > 0:  # Python itself, or one of its imports
        raise _UncheckableError(f"its process ends with status {status}{words}")
    raise _FailedError(f"the process ends by {child_process.ending(status)} ({step}{words})")
