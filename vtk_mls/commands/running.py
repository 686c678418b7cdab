"""Reading files and running filters, with what the terminal is to see of it."""

from __future__ import annotations

import sys
from contextlib import contextmanager

from vtk_mls.commands.supervision import step

_BAR = 40  # characters


def read(reader, path):
    """What a reader of files makes of one."""
    with _warnings_kept(), step("read", path):
        return reader(path)


@contextmanager
def _warnings_kept():
    """Say at the end what there is to say meanwhile, while stderr is silent."""
    from vtk_mls.base.messages import message_handlers, warn

    warnings = []
    with message_handlers(None, warnings.append):
        yield
    for each in warnings:
        warn(each)


@contextmanager
def each_said_once():
    """Meanwhile say each warning once, however many time steps have it."""
    from vtk_mls.base.messages import message_handlers, warn

    said = set()

    def say(sentence):
        if sentence not in said:
            said.add(sentence)
            with message_handlers(None, None):
                warn(sentence)

    with message_handlers(None, say):
        yield


def update(algorithm, options, done=0, total=1):
    """Run a filter on the file and the control points of the options.

    Parameters
    ----------
    algorithm : vtkAlgorithm
    options : argparse.Namespace
    done, total : int
        How often it has been run before, and will be in all: for the progress bar.

    Raises
    ------
    ValueError
        What the filter complains of, with the names of the files.
    """
    with _warnings_kept(), step("deform", options.input):
        try:
            _update(algorithm, shows_progress(options), done, total)
        except ValueError as error:  # the command has files, not inputs
            names = [f"`{each}`" for each in (options.handles, options.deformed) if each]
            text = str(error).replace("`ControlPoints`", " and ".join(names))
            text = text.replace("where the data are", f"where the data of `{options.input}` are")
            raise ValueError(text) from error


def shows_progress(options):
    """Whether a progress bar is wanted."""
    return options.progress or sys.stderr.isatty()


def draw_bar(done):
    """Show the progress bar; `done` goes from 0 to 1."""
    bar = ("#" * round(_BAR * done)).ljust(_BAR, ".")
    print(f"\r[{bar}] {done:4.0%}", end="", file=sys.stderr, flush=True)


def _update(algorithm, has_bar, done, total):
    """Run a filter, and show its progress."""
    from vtk_mls.filters.updating import update as run

    if not has_bar:
        return run(algorithm)
    try:
        run(algorithm, lambda share: draw_bar((done + share) / total))
    except ValueError:
        done = total - 1  # the bar ends here
        raise
    finally:
        if done + 1 == total:
            print(file=sys.stderr)
