"""Checks an OpenCL device once before its first use, in child processes.

Drivers miscompile, crash and hang. Two children at once run kernels on the device and compare them
with the numpy reference (`kernel_checks`). What images and meshes need is checked first; other
kinds, fields, gradients and cuts before their first use. The results are saved in the user's
cache folder, one file per driver, processor, version of the kernels, and subject.
"""

import hashlib
import json
import os
import re
import subprocess
import tempfile
import threading
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

from vtk_mls.base import child_process, lazy
from vtk_mls.base.messages import inform, warn
from vtk_mls.base.resources import resource
from vtk_mls.engine.device import caches, devices
from vtk_mls.model.kinds import ALL_KINDS

# A child hangs if it needs more seconds of processor time than this, some hundred times the usual,
# or if it uses almost none between two looks. Other limits would be missed by a busy machine.
MAX_SECONDS, MIN_SECONDS = 600, 0.5
INTERVAL = 300  # seconds between two looks
PARTS = 2  # of the check of a subject, one for each child
# Subjects: what images and meshes need, for the kind "rigid"; what others need in addition.
BASIC, FIELDS, CUTS = "rigid", "fields", "cuts"
SUBJECTS = BASIC, *(kind for kind in ALL_KINDS if kind != BASIC), FIELDS, CUTS
STEP, SECONDS = "step", "seconds"  # files that a child writes to its folder
_CHECK = "vtk_mls.commands.kernel_checks:main"  # called by a child
# A child is not a process of the parent's MPI job.
_MPI_VARIABLES = re.compile(r"(OMPI|OPAL|PMIX?|PRTE|MPI|MPIR|MV2|PALS|SLURM|HYDRA|HYDI)_")


@dataclass(frozen=True)
class Result:
    """The result of the check of one device."""

    failure: str = ""  # why the device must not be used; empty if it may be used
    # False if the check did not end, or if no child process could run; then the device is used
    is_checked: bool = True


_results: dict[str, Result] = {}  # by file name
_lock = threading.RLock()


def results(found, subjects=SUBJECTS, recheck=False):
    """The worst result of the subjects for each device, checked now where there is none.

    To `recheck`, all are. Nothing is checked on a device after its first failure.
    """
    checked = set()
    with _lock:
        return [_worst(device, subjects, checked, recheck) for device in found]


def _worst(device, subjects, checked, recheck):
    worst = Result()
    for subject in subjects:
        name = _file_name(device, subject)
        if (recheck and name not in checked) or _cached(device, subject) is None:
            _results[name] = _check(device, subject)
            _write(device, subject, _results[name])
        checked.add(name)
        if _results[name].failure:
            return _results[name]
        if not _results[name].is_checked:
            worst = _results[name]
    return worst


def failure(device):
    """Why `device` must not be used, without a check; empty if no failure is known."""
    found = [_cached(device, subject) for subject in SUBJECTS]
    return next((result.failure for result in found if result and result.failure), "")


def _cached(device, subject):
    name = _file_name(device, subject)
    with _lock:
        if name not in _results:
            with suppress(OSError, AttributeError, KeyError, TypeError, ValueError):
                record = json.loads(result_path(device, subject).read_text())
                _results[name] = Result(str(record["failure"]), bool(record["is_checked"]))
        return _results.get(name)


def result_path(device, subject=BASIC):
    """The file with the result for `device`; None without a cache folder."""
    folder = caches.folder()
    return folder and folder / "vtk_mls" / "devices" / _file_name(device, subject)


def description(device):
    """Identifies `device` in any process that has the same drivers."""
    return [device.key, device.name, device.platform, device.kind, device.version, device.driver]


@lazy.cached
def _file_name(device, subject=BASIC):
    """A digest of everything that a result depends on: drivers, processor, kernels, the subject."""
    drivers = sorted({(d.platform, d.driver) for d in devices.list_devices()})
    identity = repr((description(device)[1:], drivers, caches.processor(), _kernels(), subject))
    return hashlib.sha256(identity.encode()).hexdigest()[:24] + ".json"


@lazy.cached
def _kernels():
    """A digest of the kernels and of the code that the check runs."""
    package = Path(__file__).parents[2]
    patterns = "*/kernel_checks.py", "*/*/kernel_arguments.py", "*/*/cut_tables.py", "*/*/quirks.py"
    patterns += "model/kinds/*.py", "model/cuts/*.py"
    files = [file for pattern in patterns for file in sorted(package.glob(pattern))]
    files += sorted(resource("opencl").rglob("*.[ch]*"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _write(device, subject, result):
    """Save a result. Without a writable folder or a child each process checks again."""
    path = result_path(device, subject)
    if path is None or not (result.is_checked or result.failure):
        return
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, new = tempfile.mkstemp(dir=path.parent)
        with os.fdopen(handle, "w") as file:
            json.dump({"device": str(device), "subject": subject, **asdict(result)}, file)
        os.replace(new, path)


def _check(device, subject):
    what = "OpenCL" if subject == BASIC else f"{subject} with OpenCL"
    name = f"{device.name} ({device.platform})"
    inform(f"Testing {what} on {name} before the first use, once: some seconds ...")
    try:
        _compare(device, subject)
        return Result()
    except TimeoutError as error:
        result = Result(f"not checked, {error}", is_checked=False)
    except OSError as error:
        warn(f"{device} is used, but not checked, because no process can check it: {error}")
        return Result(is_checked=False)
    except ValueError as error:
        result = Result(f"it fails the check ({error})")
    warn(f"{device} is not used: {result.failure}; `vtk-mls doctor --retest` tries again")
    return result


def _compare(device, subject):
    """Compare kernels on a device with the reference.

    ValueError if the device fails, TimeoutError if a child hangs, OSError if a child fails for
    reasons other than the device.
    """
    environment = {k: v for k, v in os.environ.items() if not _MPI_VARIABLES.match(k)}
    # Standard input is not free: pvpython reads it.
    streams = {"stdin": subprocess.DEVNULL, "stderr": subprocess.STDOUT, "env": environment}
    with tempfile.TemporaryFile("w+", errors="replace") as output, ExitStack() as stack:
        start = partial(child_process.started, _CHECK, description(device), subject, stdout=output)
        parts = PARTS if subject in (BASIC, FIELDS, CUTS) else 1  # a kind has a single check
        starts = [start(part, **streams) for part in range(parts)]
        for child, folder in [stack.enter_context(start) for start in starts]:
            status = _status(child, folder)
            if status:
                output.seek(0)
                raise _failure(status, folder, output.read().strip().rpartition("\n")[2])


def _status(child, folder):
    """The exit status of a child, or TimeoutError if it hangs."""
    used = -MIN_SECONDS
    while True:
        with suppress(subprocess.TimeoutExpired):
            return child.wait(INTERVAL)
        path = folder / SECONDS
        lines = path.read_text().split() if path.exists() else []
        before, used = used, float([0, *lines][-1])
        if not before + MIN_SECONDS <= used <= MAX_SECONDS:
            raise TimeoutError(f"no result after {used:.0f} s of processor time")


def _failure(status, folder, last_line):
    """The exception for a child with an exit status other than 0."""
    step = (folder / STEP).read_text() if (folder / STEP).exists() else ""
    error = child_process.error(folder)
    crash = f"the process ended by {child_process.ending(status)}: {last_line[:200]}"
    reason = crash if error is None else str(error) or type(error).__name__
    if not step and status > 0:  # Python itself, or one of its imports
        return OSError(reason)
    return ValueError(f"{step or 'start'}: {reason}")
