"""Sentences about what takes a while or is not as it should be, to whoever listens."""

from __future__ import annotations

import contextlib
import contextvars
import logging

_log = logging.getLogger("vtk_mls")
# Announcements are no warnings: where that makes a difference, they are handled apart.
LOG = logging.getLogger("vtk_mls.base.messages")
_listeners = contextvars.ContextVar("listeners", default=(None, None))


@contextlib.contextmanager
def listening(progress, warning):
    """Meanwhile hand announcements to `progress(sentence)`, warnings to `warning(sentence)`."""
    token = _listeners.set((progress, warning))
    try:
        yield
    finally:
        _listeners.reset(token)


def inform(sentence, *, logged=True):
    """Say what is done now; on the terminal, too, if it is `logged`."""
    if logged:
        LOG.warning(sentence)  # the level from which on Python shows it by itself
    progress, _ = _listeners.get()
    if progress is not None:
        progress(sentence)


def warn(sentence):
    """Say what is not as it should be: to who listens, else on the terminal."""
    _, warning = _listeners.get()
    (warning or _log.warning)(sentence)
