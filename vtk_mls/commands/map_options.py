"""Options of the map, common to all commands with control points."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path

from vtk_mls.commands import limit_options, property_options
from vtk_mls.commands.running import read
from vtk_mls.files.landmarks import PAIR_BY
from vtk_mls.model.kinds.splines import MIN_LANDMARKS
from vtk_mls.model.options import DEFORMATION_OPTIONS, named, values_of

HANDLES = (
    "control points, from p at rest to q: .csv .txt with lines px,py,pz,qx,qy,qz[,weight], or a "
    "header that names the columns (see docs/formats.md), or the landmarks of BigWarp (p "
    "moving, q target); .vtp .vtu .vts .vtk with point vectors Displacement, whose lines and "
    "closed surfaces are curves and rigid regions by --handle-shapes cells; or, with --deformed "
    "or --path, positions p alone, among them curves (.mrk.json)"
)


def add(parser, is_interactive=False):
    """Add the options to a parser.

    Interactive commands have no progress bar, and a tolerance of the map that cannot be seen.
    """
    from vtk_mls.filters.property_tables import (
        COMPUTING,
        CUT_OPTIONS,
        HANDLE_SHAPES_CHOICE,
        INITIAL_TRANSFORM,
        INTERACTIVE_COMPUTING,
        MAP,
    )

    add = parser.add_argument
    add_files(parser)
    parser.set_defaults(path=None)
    if not is_interactive:
        add(
            "--path",
            metavar="FILES",
            help="instead of --deformed, the way of the control points from p to q: a series of "
            "such files (.pvd .series, or a pattern in quotes as 'turn_*.vtp') with their "
            "positions at equal times. The last are q; the first may be p. Curves and regions "
            "have no path. With it handles turn by more than 180 degrees",
        )
    property_options.add(
        parser,
        HANDLE_SHAPES_CHOICE,
        text="handles in a file: points; or cells: lines, and curves of .mrk.json, are curves, "
        "closed surfaces are rigid regions, other points are points",
    )
    for option in MAP:
        is_kind = option.name == "Kind" and not is_interactive
        more = (
            f"auto from {MIN_LANDMARKS} pairs of landmarks on: two files of points, BigWarp, tags"
        )
        property_options.add(parser, option, more=more * is_kind)
    if not is_interactive:
        parser.set_defaults(kind="")
    _add_cuts(parser)
    for option in (*CUT_OPTIONS, *(INTERACTIVE_COMPUTING if is_interactive else COMPUTING)):
        property_options.add(parser, option)
    limit_options.add(parser, is_interactive)
    if not is_interactive:
        property_options.add(
            parser,
            INITIAL_TRANSFORM,
            text="transform that moves the material first, so that the control points correct it: "
            "of ITK, ANTs or 3D Slicer, as it resamples images (.h5 .tfm .txt .mat need SimpleITK; "
            "displacement fields .nii.gz .nii .nrrd .nhdr .mha .mhd). Control points at rest p, "
            "and cuts in the rest frame, are in the space that it leads to",
        )
        add("--progress", action="store_true", help="show a progress bar even without a terminal")
        text = "continue if all control points rest and nothing moves, instead of an error"
        add("--allow-identity", action="store_true", help=text)


def add_files(parser):
    """Add the options of files of control points."""
    from vtk_mls.filters.property_tables import SPACE

    add = parser.add_argument
    add(
        "--deformed",
        metavar="FILE",
        help="the positions q that the control points have moved to, any of the files of points: "
        "markups of 3D Slicer (.mrk.json .fcsv), its tables, points of ITK, ANTs and elastix, "
        "lines x,y,z or label,x,y,z (.csv .txt .pts), .vtp .vtu .vts .vtk. They go to the control "
        "points with the same labels if each point has one of its own, else in their order",
    )
    add(
        "--pair-by",
        choices=PAIR_BY,
        default="",
        help="how the points of two files make pairs: in their order; by labels; or by the labels "
        "that both files have, without other points; default: by labels if each point has one of "
        "its own, else in their order",
    )
    add(
        "--handles-space",
        choices=SPACE.choices,
        default=SPACE.default,
        help="frame of files of points that do not declare one (markups and tables of 3D Slicer "
        "do): ras for points from nibabel or FreeSurfer; cuts are always in LPS; "
        "default: %(default)s",
    )


def _add_cuts(parser):
    from vtk_mls.model.cuts import BY_NUMBERS

    add = partial(parser.add_argument, action="append", default=[])
    for name, shape in BY_NUMBERS.items():
        *parts, last = (field.title or field.name for field in shape.fields)
        text = f"cut along a {name}, by its {', '.join(parts)} and {last}; may be repeated; "
        text += shape.help[:1].lower() + shape.help[1:].removesuffix(".")
        add(f"--cut-{name}", metavar=",".join(shape.labels()).upper(), help=text)
    text = "cut along the surfaces of a file: .vtp .vtk .stl; may be repeated"
    add("--cut-surface", metavar="FILE", help=text)


def apply(options, algorithm, control_points=None):
    """Set the control points (port 1) and the properties of a filter from the options.

    `control_points` is polydata to use instead of the files.
    """
    algorithm.SetInputData(1, control_points or _moving_control_points(options))
    options.kind = options.kind or named("kind").default
    property_options.apply(options, algorithm)
    limit_options.apply(options, algorithm)
    algorithm.SetInitialTransform(initial_transform(options))
    for cut in _cuts(options):
        algorithm.AddCut(cut)


def initial_transform(options):
    """The transform of the file that the options name, or None."""
    from vtk_mls import io

    path = options.initial_transform
    return read(io.read_transform, path) if path else None


def control_points(options):
    """Control-point polydata of the files."""
    return _read_control_points(options)[0]


def kind_used(options, algorithm):
    """The kind of the map of a filter, in words; of landmarks also their errors when left out."""
    import numpy as np

    from vtk_mls.filters.initial_transforms import split_chain

    deformation = split_chain(algorithm.updated_deformation())[1]
    if deformation.order_used == 0:
        return options.kind
    text = f"spline of order {deformation.order_used}"
    if deformation.smoothing_used > 0:
        text += f" and smoothing {deformation.smoothing_used:.3g}"
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
    from vtk_mls.commands import series
    from vtk_mls.files import control_point_files

    if options.path:
        return ()
    if options.handles and series.is_series(options.handles):
        times = tuple(time for time, _ in read(series.timed_files, options.handles))
        return times if len(times) > 1 else ()
    times = ()
    with suppress(OSError, ValueError):  # reading the handles reports it
        times = control_point_files.times(options.handles, options.deformed)
    return times if len(times) > 1 else ()


def control_points_in_time(options, times):
    """Control-point polydata at each of the `handle_times`; ValueError if nothing moves at any
    time.
    """
    from vtk_mls.vtk.control_point_polydata import is_moving

    polydata = [_read_control_points(options, time)[0] for time in times]
    is_identity = not any(map(is_moving, polydata)) or options.blend == 0
    if is_identity and not (options.allow_identity or options.initial_transform):
        raise ValueError(
            f"nothing moves: the control points of `{options.handles}` are at rest (p = q) at all "
            f"{len(times)} times; add --allow-identity to go on"
        )
    return polydata


def map_arguments(options):
    """Keyword arguments of a `Deformation` besides control points."""
    settings = values_of(options, DEFORMATION_OPTIONS)
    return {**settings, "device": options.device or None, "cuts": _cuts(options)}


def _moving_control_points(options):
    """Control-point polydata of the files; ValueError if nothing moves and that is not allowed."""
    from vtk_mls.vtk.control_point_polydata import is_moving

    handles, has_partners = _read_control_points(options)
    is_identity = not is_moving(handles) or options.blend == 0
    if options.allow_identity or options.initial_transform or not is_identity:
        return handles
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


def _read_control_points(options, time=None):
    """Control-point polydata of the files (at a time), and whether the files have q."""
    from vtk_mls import io
    from vtk_mls.commands import series

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
        return io.control_points(rest, last, between, options.pair_by), True
    if options.deformed:
        rest, deformed = (read(reader, path) for path in (handles, options.deformed))
        points, are_marked = io.control_points(rest, deformed, pair_by=options.pair_by), True
    else:
        check_pairing(options)
        rest = read(partial(reader, is_alone=True), handles)
        points, are_marked = io.control_points(rest), rest.are_marked
    has_cells = options.handle_shapes == "cells" or any(_cuts(options))
    if are_marked and not has_cells and points.GetNumberOfPoints() >= MIN_LANDMARKS:
        options.kind = options.kind or "auto"
    return points, bool(options.deformed) or rest.partners is not None


def check_pairing(options):
    """Raise ValueError if points of one file are to be paired."""
    if options.pair_by:
        raise ValueError(
            f"`--pair-by {options.pair_by}` pairs the points of two files; `{options.handles}` is "
            "the only one: name the second by --deformed"
        )


def _cuts(options):
    """The cuts, first those by numbers, then surfaces."""
    from vtk_mls import io
    from vtk_mls.model.cuts import BY_NUMBERS

    cuts = [
        shape.of_numbers(property_options.numbers(f"--cut-{name}", text, len(shape.labels())))
        for name, shape in BY_NUMBERS.items()
        for text in getattr(options, f"cut_{name.replace('-', '_')}")
    ]
    return cuts + [cut for path in options.cut_surface for cut in read(io.read_cuts, path)]
