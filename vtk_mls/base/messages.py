"""Messages for the user: progress and warnings, to the handlers of a context or to `logging`."""

import contextlib
import contextvars
import logging

_log = logging.getLogger("vtk_mls")
# A separate logger for progress, which hosts may handle differently from warnings.
LOG = logging.getLogger("vtk_mls.base.messages")
_handlers = contextvars.ContextVar("handlers", default=(None, None))


@contextlib.contextmanager
def message_handlers(progress, warning):
    """In this context pass progress to `progress(sentence)`, and warnings to `warning(sentence)`.

    Either may be None.
    """
    token = _handlers.set((progress, warning))
    try:
        yield
    finally:
        _handlers.reset(token)


def inform(sentence, *, logged=True):
    """Report the current step to the context's handler, and log it unless `logged` is False."""
    if logged:
        LOG.warning(sentence)  # Python shows warnings without configuration
    progress, _ = _handlers.get()
    if progress is not None:
        progress(sentence)


def warn(sentence):
    """Report a warning to the context's handler, else log it."""
    _, warning = _handlers.get()
    (warning or _log.warning)(sentence)
