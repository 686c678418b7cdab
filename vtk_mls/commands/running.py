"""Reads files and runs filters, with warnings and a progress bar on the terminal."""

from __future__ import annotations

import sys
from contextlib import contextmanager

from vtk_mls.base.errors import InputError
from vtk_mls.commands.supervision import step

_BAR_LENGTH = 40  # characters


def read(reader, path):
    """The result of a reader of files for `path`."""
    with _deferred_warnings(), step("read", path):
        return reader(path)


@contextmanager
def _deferred_warnings():
    """Print warnings at the end of the block, because reading silences stderr."""
    from vtk_mls.base.messages import message_handlers, warn

    warnings = []
    with message_handlers(None, warnings.append):
        yield
    for warning in warnings:
        warn(warning)


@contextmanager
def distinct_warnings():
    """Print each warning once, however many time steps have it."""
    from vtk_mls.base.messages import message_handlers, warn

    printed = set()

    def print_once(sentence):
        if sentence not in printed:
            printed.add(sentence)
            with message_handlers(None, None):
                warn(sentence)

    with message_handlers(None, print_once):
        yield


def read_image(option, path):
    """The image of an option."""
    from vtk_mls import io

    image = read(io.read_dataset, path)
    if not image.IsA("vtkImageData"):
        raise ValueError(f"`{option}` must be an image, got a {image.GetClassName()} in `{path}`")
    return image


def update(algorithm, options, done=0, total=1):
    """Run a filter on the file and the control points of the options.

    For the progress bar, `done` of `total` runs came before. A ValueError is that of the filter,
    with the names of the files.
    """
    with _deferred_warnings(), step("deform", options.input), files_named(options):
        _update(algorithm, shows_progress(options), done, total)


@contextmanager
def files_named(options):
    """In errors the inputs of a filter have the names of their files."""
    try:
        yield
    except InputError as error:
        paths = options.handles, options.deformed, options.path
        names = {"ControlPoints": " and ".join(f"`{path}`" for path in paths if path)}
        names["Reference"] = f"`{getattr(options, 'reference', None)}`"
        raise error.renamed(names) from error


def shows_progress(options):
    """Whether to show a progress bar."""
    return options.progress or sys.stderr.isatty()


def draw_bar(done):
    """Show the progress bar; `done` goes from 0 to 1."""
    bar = ("#" * round(_BAR_LENGTH * done)).ljust(_BAR_LENGTH, ".")
    print(f"\r[{bar}] {done:4.0%}", end="", file=sys.stderr, flush=True)


@contextmanager
def progress_bar(options):
    """`draw_bar`, and a new line at the end of the block; None if no bar is to be shown."""
    has_bar = shows_progress(options)
    try:
        yield draw_bar if has_bar else None
    finally:
        if has_bar:
            print(file=sys.stderr)


def _update(algorithm, has_bar, done, total):
    """Run a filter, and show its progress."""
    from vtk_mls.filters.updating import update as run

    if not has_bar:
        return run(algorithm)
    try:
        run(algorithm, lambda fraction: draw_bar((done + fraction) / total))
    except ValueError:
        done = total - 1  # the bar ends here
        raise
    finally:
        if done + 1 == total:
            print(file=sys.stderr)
