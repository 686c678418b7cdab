"""A child Python process for work that may crash or hang: OpenCL drivers, VTK's readers.

The child calls one function, and ends when its parent does. The parent makes and removes its
folder, with the program (`child.py`) and the request (`request.json`). The child adds the exception
that ended it (`error.json`): no pickle, because the child reads files that nobody has checked.
"""

import importlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from vtk_mls.base.errors import InputError

PREFIX = "vtk_mls-"  # of the names of folders
_ERROR = "error.json"
_PARENT_INTERVAL = 1.0  # seconds between two checks of the parent
# A file, since some programs that embed Python run nothing else (pvpython).
_PROGRAM = """
import json, os, sys
folder = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(folder, "request.json")) as file:
    request = json.load(file)
sys.path[:] = request["path"]
from vtk_mls.base import child_process
child_process.call(folder, request)
"""


@contextmanager
def started(name, *arguments, **options):
    """A child that calls a function; it is killed when the block ends.

    `name` is "module:name" of the function. Its arguments are the child's folder, and `arguments`,
    values of JSON. Options are those of `subprocess.Popen`; standard input should be `DEVNULL` in
    programs that embed Python. Yields the Popen and the folder. OSError if no child can be started.
    """
    folder = tempfile.mkdtemp(prefix=PREFIX)
    try:
        python = interpreter()
        if python is None:
            raise OSError("this program has no Python interpreter to start")
        path = [os.path.abspath(entry) for entry in sys.path]
        request = {"path": path, "function": name, "arguments": arguments}
        Path(folder, "request.json").write_text(json.dumps(request))
        program = Path(folder, "child.py")
        program.write_text(_PROGRAM)
        with subprocess.Popen([*python, str(program)], **options) as child:
            try:
                yield child, Path(folder)
            finally:
                child.kill()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(name, *arguments, timeout):
    """Call the function "module:name" in a child, and wait for it.

    Raises the `error` that ended it, TimeoutError after `timeout` seconds, or ChildProcessError if
    the process crashed.
    """
    silent = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    with started(f"{__name__}:_call_without_folder", name, *arguments, **silent) as (child, folder):
        try:
            status = child.wait(timeout)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"no result after {timeout} s") from None
        if status:
            raise error(folder) or ChildProcessError(f"the process crashed ({ending(status)})")


def error(folder):
    """The exception that ended the child with this folder, and its causes; None without one.

    It has the class of the child's, if this is a built-in one or of this package, or else a base of
    it, with the name of the class before the message.
    """
    try:
        return _rebuilt(json.loads(Path(folder, _ERROR).read_text()))
    except OSError:
        return None


def ending(status):
    """The signal or the exit status that a process has ended with, by its name."""
    if status >= 0:
        return f"exit status {status if status < 256 else hex(status)}"  # of Windows: hexadecimal
    try:
        return signal.Signals(-status).name
    except ValueError:
        return f"signal {-status}"


def interpreter():
    """The command of a Python like this one; None if there is none, as in some embedded ones."""
    version = "{}.{}".format(*sys.version_info)
    running = Path(os.path.realpath("/proc/self/exe")) if os.name == "posix" else None
    folders = [Path(sys.executable).parent] if sys.executable else []
    folders += [running.parent] if running else []
    suffix = ".exe" if sys.platform == "win32" else ""
    candidates = [sys.executable, getattr(sys, "_base_executable", None)]
    candidates += [Path(sys.base_prefix, "bin", f"python{version}")]
    candidates += [Path(sys.base_prefix, f"python{suffix}")]
    candidates += [folder / f"pvpython{suffix}" for folder in folders]
    programs = [str(path) for path in candidates if path and os.access(path, os.X_OK)]
    patterns = (r"python[\d.]*(\.exe)?", r"(pv|vtk)python[\d.]*(\.exe)?")  # the latter load more
    for pattern in patterns:
        for program in programs:
            if re.fullmatch(pattern, Path(program).name.lower()):
                return [program]
    return None


# In the child


def call(folder, request):
    """Call the function of a request; called by the program of a child."""
    threading.Thread(target=_end_with_parent, args=(folder, os.getppid()), daemon=True).start()
    try:
        function(request["function"])(folder, *request["arguments"])
    except Exception as error:
        Path(folder, _ERROR).write_text(json.dumps(_described(error)))
        raise


def function(name):
    """The function with a name "module:name"."""
    module, _, name = name.partition(":")
    return getattr(importlib.import_module(module), name)


def _call_without_folder(folder, name, *arguments):
    function(name)(*arguments)


def _end_with_parent(folder, parent):
    """End this process when its parent is killed, and remove the folder that the parent made."""
    while os.getppid() == parent:
        time.sleep(_PARENT_INTERVAL)
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def _described(error):
    """An exception and its causes as values of JSON."""
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    classes = [(base.__module__, base.__qualname__) for base in type(error).__mro__]
    fields = {name: value for name, value in vars(error).items() if isinstance(value, (str, tuple))}
    record = {"classes": classes, "message": str(error), "fields": fields}
    return {**record, "cause": cause and _described(cause)}


def _rebuilt(record):
    message, own = record["message"], record["classes"][0][1]
    made = RuntimeError(f"{own}: {message}")
    for module, name in record["classes"]:
        if module == "builtins" or module.startswith("vtk_mls."):
            with suppress(AttributeError, ImportError, TypeError):
                kind = getattr(importlib.import_module(module), name)
                if issubclass(kind, Exception) and kind is not Exception:
                    made = kind(message if name == own else f"{own}: {message}")
                    if isinstance(made, InputError):
                        vars(made).update({name: record["fields"][name] for name in vars(made)})
                    break
    made.__cause__ = record["cause"] and _rebuilt(record["cause"])
    return made
