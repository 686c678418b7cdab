"""Verdicts on devices, as files in the user's folder for caches: losing them only costs time."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import tempfile
from pathlib import Path

from vtk_mls.engine import caches

try:
    import fcntl
except ImportError:  # Windows: processes that start together all test
    fcntl = None


def folder() -> Path | None:
    """Where they are kept; None where nothing can be."""
    cache = caches.folder()
    return cache and cache / "vtk_mls" / "devices"


def name(identity: str) -> str:
    """The file of what `identity` describes."""
    return hashlib.sha256(identity.encode()).hexdigest()[:24] + ".json"


def read(file: str) -> dict | None:
    """The record in `file`; None without a readable one."""
    try:
        found = json.loads((folder() / file).read_text())
    except (OSError, TypeError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def write(file: str, record: dict):
    """Keep `record`, whole or not at all."""
    path = folder()
    with contextlib.suppress(OSError):
        if path is None:
            return
        path.mkdir(parents=True, exist_ok=True)
        handle, beside = tempfile.mkstemp(dir=path)
        with os.fdopen(handle, "w") as out:
            json.dump(record, out, indent=1)
        os.replace(beside, path / file)


@contextlib.contextmanager
def one_at_a_time():
    """Waits while another process of this user is here, where the system can do that."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            if fcntl is not None and (path := folder()) is not None:
                path.mkdir(parents=True, exist_ok=True)
                lock = stack.enter_context(open(path / "lock", "w"))
                fcntl.flock(lock, fcntl.LOCK_EX)
        yield
