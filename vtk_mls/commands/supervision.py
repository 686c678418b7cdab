"""Runs a command in a child process, whose crash ends in one sentence.

VTK's readers trust a file. A few wrong bytes make them write to foreign memory, or allocate more
than there is, and that ends the process. So the child does all of the work, and its parent, which
has loaded neither numpy nor VTK, reports how it ended. Ctrl-C or another signal that ends the
parent kills the child at once, and unfinished files are removed.

The child appends each step that it begins to the file `steps` in its folder, which its parent reads
at the end.
"""

import faulthandler
import glob
import json
import os
import signal
import sys
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

from vtk_mls.base import child_process

MIN_SECONDS, BYTES_PER_SECOND = 120, 200_000  # many times what any reader takes
_VERBS = {
    "read": "read",
    "deform": "deformed",
    "write": "written",
    "show": "shown",
    "check": "checked",
}
_DONE, _STEPS = "done", "steps"

_folder = None  # of this process, if it is a supervised child


class _Stopped(BaseException):
    """A signal ends the parent; its argument is the number."""


def supervise(name, arguments):
    """Run the command, the function of the arguments named "module:name", in a child.

    Returns its exit status; 1 after a sentence on stderr if its process crashed; 128 and the number
    of a signal that ends this process.
    """
    signals = [getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP")]
    # nohup ignores one of them
    signals = [n for n in signals if n is not None and signal.getsignal(n) != signal.SIG_IGN]
    try:
        _mask(signals, is_blocked=True)  # until there is a child to kill
        with child_process.started(f"{__name__}:work", name, arguments, signals) as (child, folder):
            for number in signals:
                signal.signal(number, _stop)
            _mask(signals, is_blocked=False)
            try:
                return report(child.wait(), child.pid, folder)
            except _Stopped:
                child.kill()
                child.wait()
                _remove_unfinished(child.pid, _steps(folder))
                raise
    except _Stopped as stopped:
        (number,) = stopped.args
        if number == signal.SIGINT:
            print(file=sys.stderr)
        return 128 + number


def work(folder, name, arguments, signals=()):
    """Run the command in this process, the child.

    The folder is for the file `steps`; the parent handles the `signals`.
    """
    global _folder
    _folder = folder
    if hasattr(signal, "pthread_sigmask"):
        if signal.SIGINT in signals:
            # Ctrl-C is for the parent. Children of this process would inherit SIG_IGN.
            signal.signal(signal.SIGINT, lambda number, frame: None)
        _mask(signals, is_blocked=False)
    try:
        status = child_process.function(name)(arguments)
        sys.stdout.flush()  # before the interpreter's end, which may fail
    except BaseException:
        _note(_DONE, 1)  # Python prints the exception
        raise
    _note(_DONE, status)
    sys.exit(status)


def report(status, process, folder):
    """The exit status of the command, after a sentence if the child crashed.

    `status` is as of `subprocess.Popen.returncode`, `process` the child's id.
    """
    steps = _steps(folder)
    action, detail = steps[-1] if steps else ("", "")
    if status >= 0 and action in ("", _DONE):
        return status
    if action == _DONE:  # only the interpreter's end has failed
        return detail
    _remove_unfinished(process, steps)
    print(f"vtk-mls: {_failure(steps, child_process.ending(status))}", file=sys.stderr)
    return 1


@contextmanager
def step(action, path):
    """Note the step "read", "deform", "write" or "show" of a file.

    During "read" the messages of libraries are hidden, because a broken file can make them crash,
    and a watchdog ends reading that takes too long.
    """
    _note(action, str(path))
    if _folder is None or action != "read":
        yield
        return
    sys.stderr.flush()
    with open(os.devnull, "w") as null, open(os.path.join(_folder, _STEPS), "a") as steps:
        stderr = os.dup(2)
        os.dup2(null.fileno(), 2)
        faulthandler.dump_traceback_later(_reading_time(path), exit=True, file=steps)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
            sys.stderr.flush()
            os.dup2(stderr, 2)
            os.close(stderr)


def temporary_folder():
    """A context with a folder that is removed at the end, also if this process is killed."""
    return tempfile.TemporaryDirectory(prefix=child_process.PREFIX, dir=_folder)


def _reading_time(path):
    """Seconds in which a file and the files that it names can be read.

    A small file can name large ones: as a rule `x.vtm` those in the folder `x`, `x.pvtu` `x_0.vtu`.
    """
    path, size = Path(path), 0
    if not path.name:  # a folder, which no reader takes
        return MIN_SECONDS
    pieces = path.parent.glob(f"{glob.escape(path.stem)}*")
    for piece in (*pieces, *path.with_suffix("").glob("*")):
        with suppress(OSError):
            size += piece.stat().st_size
    return MIN_SECONDS + size / BYTES_PER_SECOND


def _stop(number, frame):
    for other in (signal.SIGINT, signal.SIGTERM, number):
        signal.signal(other, signal.SIG_IGN)
    raise _Stopped(number)


def _mask(signals, is_blocked):
    if hasattr(signal, "pthread_sigmask"):  # elsewhere than on Windows
        signal.pthread_sigmask(signal.SIG_BLOCK if is_blocked else signal.SIG_UNBLOCK, signals)


def _note(action, detail):
    if _folder is not None:
        with suppress(OSError), open(os.path.join(_folder, _STEPS), "a") as file:
            file.write(f"{json.dumps([action, detail])}\n")


def _steps(folder):
    """What the child noted: a list of (doing, path or status); ("timeout", "") for its watchdog."""
    steps = []
    with suppress(OSError), open(os.path.join(folder, _STEPS), errors="replace") as file:
        for line in file:
            if line.startswith("["):
                steps.append(tuple(json.loads(line)))
            elif line.startswith("Timeout"):
                steps.append(("timeout", ""))
    return steps


def _remove_unfinished(process, steps):
    from vtk_mls.files.paths import remove_remains

    for path in {path for action, path in steps if action == "write"}:
        remove_remains(path, process)


def _failure(steps, ending):
    action, path = [step for step in [("", ""), *steps] if step[0] != "timeout"][-1]
    if ending == "SIGKILL":
        reason = "the system killed the process, as a rule because memory ran out (SIGKILL)"
    elif steps[-1:] == [("timeout", "")]:
        reason = "VTK's reader does not come to an end; the file is broken"
    elif action == "read":
        reason = f"VTK's reader crashed ({ending}); the file is broken, or too large for the memory"
    elif action == "show":
        reason = (
            f"the process crashed ({ending}), as a rule in the graphics driver; unsaved handles "
            "are kept, and the next start offers them; LIBGL_ALWAYS_SOFTWARE=1 draws without the "
            "driver"
        )
    else:
        reason = f"the process crashed ({ending})"
    return f"`{path}` could not be {_VERBS[action]}: {reason}" if path else reason
