"""The command in two processes: one works, the other waits for it.

VTK's readers trust a file. A few wrong bytes in a .ply, .vtu or most other formats make them write
to memory that is not theirs, or ask for more than there is, and that ends the process. Also Ctrl-C
has to wait for VTK to return, or meets libraries that are just being loaded. So the command splits
in two before it has loaded anything: the worker does all of the work, and the supervisor, which
does nothing else, says in a sentence what became of it. One process that reads and hands over what
it has read would hold a volume twice, and leave filters and writers as they are; this costs some
milliseconds and megabytes whatever the file, and nothing is read twice or copied.

A signal that ends the command (Ctrl-C) kills the worker at once, and what it has not finished is
removed. Where processes cannot be split safely, on Windows and macOS, all happens in one.
"""

from __future__ import annotations

import mmap
import os
import signal
import sys
from contextlib import contextmanager, suppress

IS_POSSIBLE = hasattr(os, "fork") and sys.platform != "darwin"
_SECONDS, _BYTES_PER_SECOND = 60, 200_000
_PARENT_DIED = 1  # PR_SET_PDEATHSIG of Linux
_JOURNAL = 1 << 16  # bytes; more than the names of two files
_VERBS = {"read": "read", "deform": "deformed", "write": "written", "show": "shown"}

_journal = None  # memory that both share, where the worker writes what it does
_written = ""  # file that the worker wrote to last
_temporary = ""  # folder that is gone with the worker


def supervise(work):
    """Call a function in a process of its own.

    Parameters
    ----------
    work : callable
        Returns an exit status. It is called, and this function returns, in the new process too.

    Returns
    -------
    int
        The exit status of `work`, 1 after a sentence on stderr if its process has been killed.
        A signal that ends this process makes it 128 and the signal's number.
    """
    signals = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    signals = {each for each in signals if signal.getsignal(each) != signal.SIG_IGN}  # nohup
    sys.stdout.flush()
    sys.stderr.flush()
    journal = mmap.mmap(-1, _JOURNAL)
    signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    supervisor = os.getpid()
    worker = os.fork()
    if worker == 0:
        _become_worker(journal, supervisor, signals)
        try:
            status = work()
            sys.stdout.flush()  # before the interpreter's end, which may fail
        except BaseException:
            _note("done", "1")  # Python says itself what has happened
            raise
        _note("done", str(status))
        return status

    def stop(number, frame):
        for each in signals:
            signal.signal(each, signal.SIG_IGN)
        with suppress(ProcessLookupError, ChildProcessError):  # it has just ended by itself
            os.kill(worker, signal.SIGKILL)
            os.waitpid(worker, 0)
        _remove_remains(worker, journal)
        if number == signal.SIGINT:
            os.write(2, b"\n")
        os._exit(128 + number)

    for each in signals:
        signal.signal(each, stop)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)
    status = os.waitstatus_to_exitcode(os.waitpid(worker, 0)[1])
    doing, what, *_ = _entry(journal)
    if status >= 0 and doing in ("", "done"):
        return status
    if doing == "done":  # only the interpreter's end has failed
        return int(what)
    _remove_remains(worker, journal)
    # libraries within VTK's readers have their own ways to give up
    name = signal.Signals(-status).name if status < 0 else f"exit status {status}"
    print(f"vtk-mls: {_obituary(doing, what, name)}", file=sys.stderr)
    return 1


@contextmanager
def step(doing, path):
    """Say what is being done, "read", "deform", "write" or "show", with which file.

    What libraries print while a broken file makes them crash is not shown, and reading that goes on
    and on ends.
    """
    _note(doing, str(path))
    if _journal is None or doing != "read":
        yield
        return
    seconds = _processor_time(path)
    shown, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    sys.stderr.flush()
    os.dup2(nowhere, 2)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        sys.stderr.flush()
        os.dup2(shown, 2)
        os.close(shown)
        os.close(nowhere)


@contextmanager
def temporary_folder():
    """A folder that is removed at the end, also that of a worker which is killed.

    If the supervisor is killed, too, the next such folder's maker removes it.
    """
    from vtk_mls.commands import temporary_folder as folders

    global _temporary
    with folders.made() as folder:
        _temporary = folder
        if _journal is not None:
            _note(*_entry(_journal)[:2])
        yield folder


def _processor_time(path):
    """Seconds of computing that are many times enough to read a file, and those of its name.

    A small one can name large ones: as a rule `x.vtm` those in the folder `x`, `x.pvtu` `x_0.vtu`.
    """
    import glob
    from pathlib import Path

    path, size = Path(path), 0
    if not path.name:  # a folder, which no reader takes
        return _SECONDS
    pieces = path.parent.glob(f"{glob.escape(path.stem)}*")
    for each in (*pieces, *path.with_suffix("").glob("*")):
        with suppress(OSError):
            size += each.stat().st_size
    return _SECONDS + size / _BYTES_PER_SECOND


def _become_worker(journal, supervisor, signals):
    global _journal
    _journal = journal
    _die_with(supervisor)
    for each in signals:
        signal.signal(each, signal.SIG_DFL)
    if signal.SIGINT in signals:
        # it is for the supervisor; SIG_IGN would be inherited by programs that are started
        signal.signal(signal.SIGINT, lambda number, frame: None)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, signals)


def _die_with(supervisor):
    """Have this process killed when the supervisor is killed."""
    with suppress(ImportError, OSError, AttributeError):  # elsewhere than on Linux it goes on
        import ctypes

        ctypes.CDLL(None).prctl(_PARENT_DIED, signal.SIGKILL)
    if os.getppid() != supervisor:
        os._exit(1)


def _note(doing, what):
    global _written
    if doing == "write":
        _written = what
    if _journal is not None:
        entry = os.fsencode(f"{doing}\0{what}\0{_written}\0{_temporary}\0")[:_JOURNAL]
        _journal[: len(entry)] = entry


def _entry(journal):
    """What the worker did last, with what, what it wrote to last, and its temporary folder.

    Each is empty if it did not say.
    """
    return tuple(os.fsdecode(part) for part in journal[:].split(b"\0", 4)[:4])


def _remove_remains(worker, journal):
    written, temporary = _entry(journal)[2:]
    if written:
        from vtk_mls.files.replacing import remove_remains

        remove_remains(written, worker)
    if temporary:
        import shutil

        shutil.rmtree(temporary, ignore_errors=True)


def _obituary(doing, path, name):
    """A sentence about a worker that `name`, a signal or an exit status, has ended."""
    if name == "SIGKILL":
        reason = "the system killed the process, as a rule because memory ran out (SIGKILL)"
    elif name == "SIGPROF":
        reason = "VTK's reader does not come to an end; the file is broken"
    elif doing == "read":
        reason = f"VTK's reader crashed ({name}); the file is broken, or too large for the memory"
    elif doing == "show":
        reason = (
            f"the process crashed ({name}), as a rule in the graphics driver; unsaved handles are "
            "kept, and the next start offers them; LIBGL_ALWAYS_SOFTWARE=1 draws without the driver"
        )
    else:
        reason = f"the process crashed ({name})"
    return f"`{path}` could not be {_VERBS[doing]}: {reason}" if path else reason
