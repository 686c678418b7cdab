"""Reads files and runs filters, with warnings and a progress bar on the terminal."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from functools import partial

from vtk_mls.commands.supervision import step

_BAR_LENGTH = 40  # characters


def read(reader, path):
    """The result of a reader of files for `path`."""
    with _deferred_warnings(), step("read", path):
        return reader(path)


@contextmanager
def _deferred_warnings(named=str):
    """Print warnings at the end of the block, as `named` returns them: reading silences stderr."""
    from vtk_mls.base.messages import message_handlers, warn

    warnings = []
    with message_handlers(None, warnings.append):
        yield
    for warning in warnings:
        warn(named(warning))


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
    named = partial(_with_files_named, options)
    with _deferred_warnings(named), step("deform", options.input), files_named(options):
        _update(algorithm, shows_progress(options), done, total)


@contextmanager
def files_named(options):
    """Replace names of a filter's inputs in errors by names of files."""
    try:
        yield
    except ValueError as error:
        paths = options.handles, options.deformed, options.path
        names = [f"`{path}`" for path in paths if path]
        text = str(error).replace("`ControlPoints`", " and ".join(names))
        text = text.replace("where the data are", f"where the data of `{options.input}` are")
        raise ValueError(_with_files_named(options, text)) from error


def _with_files_named(options, sentence):
    """A sentence about `Input` and `Reference`, with the names of their files."""
    reference = getattr(options, "reference", None)
    if reference is None or "`Reference`" not in sentence:
        return sentence
    for name, path in (("Input", options.input), ("Reference", reference)):
        sentence = sentence.replace(f"`{name}`", f"`{path}`")
    return sentence


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
