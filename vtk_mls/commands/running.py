"""Turns the options of `map_options` into control points, arguments of a map and properties.

And reads files and runs filters, with warnings and a progress bar on the terminal.
"""

import sys
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import numpy as np

from vtk_mls import FixedFace, SlidingFace, io
from vtk_mls.base.errors import InputError
from vtk_mls.base.messages import message_handlers, warn
from vtk_mls.commands import property_options, series
from vtk_mls.commands.supervision import step
from vtk_mls.files import control_point_files
from vtk_mls.filters import map_inputs, updating
from vtk_mls.filters.initial_transforms import split_chain
from vtk_mls.model.cuts import BY_NUMBERS
from vtk_mls.model.kinds import splines
from vtk_mls.model.options import DEFORMATION_OPTIONS, KIND, values_of
from vtk_mls.vtk.control_point_polydata import is_moving

BALL, MASK, FIXED, SLIDING = "--mask-ball", "--mask", "--fixed-plane", "--sliding-plane"
_BAR_LENGTH = 40  # characters


def read(reader, path):
    """The result of a reader of files for `path`."""
    with _deferred_warnings(), step("read", path):
        return reader(path)


@contextmanager
def _deferred_warnings():
    """Print warnings at the end of the block, because reading silences stderr."""
    warnings = []
    with message_handlers(None, warnings.append):
        yield
    for warning in warnings:
        warn(warning)


@contextmanager
def distinct_warnings():
    """Print each warning once, however many time steps have it."""
    printed = set()

    def print_once(sentence):
        if sentence not in printed:
            printed.add(sentence)
            with message_handlers(None, None):
                warn(sentence)

    with message_handlers(None, print_once):
        yield


def read_image(option, path):
    image = read(io.read_dataset, path)
    if not image.IsA("vtkImageData"):
        raise ValueError(f"`{option}` must be an image, got a {image.GetClassName()} in `{path}`")
    return image


def update(algorithm, options, done=0, total=1):
    """Run a filter on the file and the control points of the options.

    For the progress bar, `done` of `total` runs came before. A ValueError is that of the filter,
    with the names of the files.
    """
    bar = progress_bar(options, is_last=done + 1 == total)
    with _deferred_warnings(), step("deform", options.input), files_named(options), bar as draw:
        updating.update(algorithm, draw and (lambda fraction: draw((done + fraction) / total)))


@contextmanager
def files_named(options):
    """In errors the inputs of a filter have the names of their files or options."""
    try:
        yield
    except InputError as error:
        paths = options.handles, options.deformed, options.path
        names = {"ControlPoints": " and ".join(f"`{path}`" for path in paths if path)}
        names["Reference"] = f"`{getattr(options, 'reference', None)}`"
        names["SampleDimensions"] = "`--dimensions`"
        raise error.renamed(names) from error


@contextmanager
def progress_bar(options, is_last=True):
    """A function that draws a progress bar for a fraction done; None if none is to be shown.

    The line of the bar ends with the last of its blocks, or with an error.
    """
    if not (options.progress or sys.stderr.isatty()):
        yield None
        return

    def draw(done):
        bar = ("#" * round(_BAR_LENGTH * done)).ljust(_BAR_LENGTH, ".")
        print(f"\r[{bar}] {done:4.0%}", end="", file=sys.stderr, flush=True)

    try:
        yield draw
    except BaseException:
        is_last = True
        raise
    finally:
        if is_last:
            print(file=sys.stderr)


def set_up(algorithm, options, control_points=None):
    """Set the control points (port 1) and the properties of a filter.

    `control_points` is polydata to use instead of the files, and whether it is of marked pairs.
    """
    points, are_marked = control_points or _moving_control_points(options)
    options.kind = options.kind or ("auto" if are_marked else KIND.default)
    arguments = map_arguments(options)
    algorithm.SetInputData(1, points)
    property_options.apply(options, algorithm)
    path = options.initial_transform
    algorithm.SetInitialTransform(read(io.read_transform, path) if path else None)
    algorithm.SetMask(arguments["mask"])
    for face in arguments["constraints"]:
        algorithm.AddConstraint(face)
    for cut in arguments["cuts"]:
        algorithm.AddCut(cut)


def kind_used(algorithm):
    """The kind of the map of a filter, in words; of landmarks also their errors when left out."""
    deformation = split_chain(algorithm.updated_deformation())[1]
    if deformation.order_used == 0:
        return deformation.kind
    lengths = deformation.smoothing_used, deformation.softening_used
    text = splines.in_words(deformation.order_used, *lengths)
    errors = deformation.left_out_errors
    if errors is None:
        return text
    middle, high = np.quantile(errors, (0.5, 0.9))
    return (
        f"{text} (of {len(errors)} landmarks, each left out, the median error is {middle:.3g}, and "
        f"90 % have less than {high:.3g})"
    )


def handle_times(options):
    """The times at which the files give control points, sorted; () if they do not move in time."""
    if options.path:
        return ()
    times = ()
    if options.handles and series.is_series(options.handles):
        times = tuple(time for time, _ in read(series.timed_files, options.handles))
    else:
        with suppress(OSError, ValueError):  # reading the handles reports it
            times = control_point_files.times(options.handles, options.deformed)
    return times if len(times) > 1 else ()


def control_points_in_time(options, times):
    """As of `_moving_control_points`, at each of the `handle_times`."""
    found = [read_control_points(options, time)[::2] for time in times]
    is_identity = not any(is_moving(points) for points, _ in found) or options.blend == 0
    if is_identity and not (options.allow_identity or options.initial_transform):
        raise ValueError(
            f"nothing moves: the control points of `{options.handles}` are at rest (p = q) at all "
            f"{len(times)} times; add --allow-identity to go on"
        )
    return found


def map_arguments(options):
    """Keyword arguments of a `Deformation` besides control points."""
    settings = {**values_of(options, DEFORMATION_OPTIONS), "device": options.device or None}
    return {**settings, "cuts": _cuts(options), **_limits(options)}


def _moving_control_points(options):
    """Control-point polydata of the files, and whether they are of marked pairs.

    ValueError if nothing moves and that is not allowed.
    """
    handles, has_partners, are_marked = read_control_points(options)
    is_identity = not is_moving(handles) or options.blend == 0
    if options.allow_identity or options.initial_transform or not is_identity:
        return handles, are_marked
    count, remedy = handles.GetNumberOfPoints(), "add --allow-identity to go on"
    if options.blend == 0 and is_moving(handles):
        raise ValueError(f"nothing moves: `--blend` is 0; give another, or {remedy}")
    moved = options.deformed or options.path
    if moved:
        reason = f"the {count} positions of `{moved}` are those of `{options.handles}`"
    elif has_partners:
        reason = (
            f"`{options.handles}` has {count} control points, and each goes where it is (p = q)"
        )
    else:
        reason = f"`{options.handles}` has {count} positions, and not where they go"
    raise ValueError(
        f"nothing moves: {reason}; say where they go in columns qx,qy,qz or by --deformed, "
        f"or {remedy}"
    )


def read_control_points(options, time=None):
    """Control-point polydata of the files (at a time), whether the files have q, and whether they
    are of pairs marked in two images.
    """
    rest, deformed, between = landmarks(options, time)
    has_partners = deformed is not None or rest.partners is not None
    are_marked = bool(options.deformed) or rest.are_marked
    return io.control_points(rest, deformed, between, options.pair_by), has_partners, are_marked


def landmarks(options, time=None):
    """The `Landmarks` of p, of q or None, and between them, a list, of the files (at a time)."""
    reader, handles = partial(io.read_landmarks, space=options.handles_space), options.handles
    if handles and series.is_series(handles):
        files = dict(read(series.timed_files, handles))
        if time is None and len(files) > 1:
            raise ValueError(
                f"`{handles}` has control points at {len(files)} times, which `vtk-mls deform` "
                "takes, but not for OME-Zarr; here give the file of one time"
            )
        handles = files[min(files) if time is None else time]
    elif time is not None:
        reader = partial(reader, time=time)
    if not Path(handles).exists():
        raise FileNotFoundError(
            f"there is no file `{options.handles}`; `vtk-mls view` makes one: drag handles over "
            "the data, then press S"
        )
    if options.path and options.deformed:
        raise ValueError("`--path` ends with the positions q: leave `--deformed` out")
    if options.path:
        files = [file for _, file in read(series.timed_files, options.path)]
        rest, *between, last = (read(reader, path) for path in (handles, *files))
        return rest, last, between
    if options.deformed:
        return *(read(reader, path) for path in (handles, options.deformed)), []
    if options.pair_by:
        raise ValueError(
            f"`--pair-by {options.pair_by}` pairs the points of two files; `{options.handles}` is "
            "the only one: name the second by --deformed"
        )
    return read(partial(reader, is_alone=True), handles), None, []


def _cuts(options):
    cuts = [
        shape.of_numbers(property_options.numbers(f"--cut-{name}", text, len(shape.labels())))
        for name, shape in BY_NUMBERS.items()
        for text in getattr(options, f"cut_{name.replace('-', '_')}")
    ]
    return cuts + [cut for path in options.cut_surface for cut in read(io.read_cuts, path)]


def _limits(options):
    """The mask, or None, and the faces, a list, by name. Errors name the option or the file."""
    mask = None
    if options.mask_ball is not None:
        numbers = property_options.numbers(BALL, options.mask_ball, 5)
        mask = map_inputs.ball_mask(numbers, f"`{BALL}`")
    if options.mask is not None:
        image = read_image(MASK, options.mask)
        if mask is not None:
            raise ValueError(
                f"a deformation has one mask, got `{BALL}` and `{MASK}`; multiply them to one image"
            )
        mask = map_inputs.image_mask(image, f"`{options.mask}`")
    planes = [(FIXED, text, FixedFace) for text in options.fixed_planes]
    planes += [(SLIDING, text, SlidingFace) for text in options.sliding_planes]
    faces = [
        map_inputs.face(kind, property_options.numbers(flag, text, 7), f"`{flag}`")
        for flag, text, kind in planes
    ]
    return {"mask": mask, "constraints": faces}
