"""A thread that has the editor for itself, so that the page is answered while it computes."""

from __future__ import annotations

import gc
import queue
import threading
import time
from concurrent.futures import Future

_TICK = 0.015  # seconds
_IDLE = 1.0  # seconds without work, after which garbage is collected


class Worker(threading.Thread):
    """Calls functions one after the other; between them, and while there is none, a tick.

    Notes
    -----
    Drawing belongs to the thread that began it. So does what is left of it: Python's collector,
    which runs in any thread, is switched off, and called here.
    """

    def __init__(self, tick):
        super().__init__(daemon=True, name="editor")
        self._calls, self._tick = queue.SimpleQueue(), tick

    def call(self, function):
        """A concurrent.futures.Future of what a function returns that is called there."""
        future = Future()
        self._calls.put((future, function))
        return future

    def run(self):
        """Work until the process ends."""
        gc.disable()
        worked_at, ticked_at = time.monotonic(), 0.0
        while True:
            try:
                future, function = self._calls.get(timeout=_TICK)
            except queue.Empty:
                future = None
            if future is not None:
                _do(future, function)
                worked_at = time.monotonic()
            if time.monotonic() - ticked_at >= _TICK or self._calls.empty():
                ticked_at = time.monotonic()
                self._tick()
            if worked_at is not None and time.monotonic() - worked_at > _IDLE:
                gc.collect()
                worked_at = None


def _do(future, function):
    try:
        future.set_result(function())
    except Exception as error:  # whoever waits for it is told
        future.set_exception(error)
