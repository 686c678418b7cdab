"""Options of the map, which every command with control points has."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from vtk_mls.commands import property_options
from vtk_mls.commands.running import read
from vtk_mls.model.options import DEFORMATION_OPTIONS, values_of

HANDLES = (
    "control points, from p at rest to q: .csv .txt with lines px,py,pz,qx,qy,qz[,weight], or a "
    "header that names the columns (as docs/formats.md says), or the landmarks of BigWarp (p "
    "moving, q target); .vtp .vtu .vts .vtk with point vectors Displacement; or, with --deformed, "
    "positions p alone"
)


def add(parser, is_seen=False):
    """Add the options to a parser.

    What is seen at once has no progress bar, and a tolerance that nobody sees.
    """
    from vtk_mls.filters.property_tables import (
        COMPUTING,
        CUT_OPTIONS,
        INTERACTIVE_COMPUTING,
        MAP,
        SPACE,
    )

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
        "--handles-space",
        choices=SPACE.choices,
        default=SPACE.default,
        help="frame of files of points that do not say theirs (markups of 3D Slicer and its tables "
        "do, and that counts): ras for those who come from nibabel or FreeSurfer; cuts are in LPS "
        "as ever; default: %(default)s",
    )
    for option in MAP:
        property_options.add(parser, option)
    add(
        "--cut-plane",
        metavar="OX,OY,OZ,NX,NY,NZ",
        action="append",
        default=[],
        help="cut everything apart along the plane through O with normal N (may be repeated)",
    )
    add(
        "--cut-half-plane",
        metavar="OX,OY,OZ,NX,NY,NZ,IX,IY,IZ",
        action="append",
        default=[],
        help="cut along half of a plane, from its edge through O in the direction I (may be "
        "repeated)",
    )
    add(
        "--cut-surface",
        metavar="FILE",
        action="append",
        default=[],
        help="cut along the surfaces of a file: .vtp .vtk .stl (may be repeated)",
    )
    for option in (*CUT_OPTIONS, *(INTERACTIVE_COMPUTING if is_seen else COMPUTING)):
        property_options.add(parser, option)
    if not is_seen:
        text = "show a progress bar although not on a terminal"
        add("--progress", action="store_true", help=text)
        text = "go on if nothing moves, because all control points rest; otherwise an error"
        add("--allow-identity", action="store_true", help=text)


def apply(options, algorithm):
    """Set the properties of a filter, its control points on port 1, as the options say."""
    algorithm.SetInputData(1, _moving_control_points(options))
    property_options.apply(options, algorithm)
    for cut in _cuts(options):
        algorithm.AddCut(cut)


def deformation(options):
    """The `Deformation` that the options say."""
    from vtk_mls import Deformation

    rest, deformed, weights = _as_arrays(_moving_control_points(options))
    if options.blend != 1:
        deformed = rest + options.blend * (deformed - rest)
    return Deformation(rest, deformed, weights=weights, **map_arguments(options))


def control_points(options):
    """p, q and weights (or None) of the files."""
    return _as_arrays(_read_control_points(options)[0])


def map_arguments(options):
    """What a `Deformation` takes beside control points, by name."""
    settings = values_of(options, DEFORMATION_OPTIONS)
    return {**settings, "device": options.device or None, "cuts": _cuts(options)}


def _moving_control_points(options):
    """Control-point polydata of the files.

    Raises
    ------
    ValueError
        If nothing moves, unless that is allowed.
    """
    from vtk_mls.vtk import arrays

    handles, has_partners = _read_control_points(options)
    displacement = arrays.to_numpy(handles.GetPointData().GetArray("Displacement"))
    if options.allow_identity or (displacement.any() and options.blend != 0):
        return handles
    count, what = len(displacement), "add --allow-identity to go on"
    if options.blend == 0 and displacement.any():
        raise ValueError(f"nothing moves: `--blend` is 0; give another, or {what}")
    if options.deformed:
        found = f"the {count} positions of `{options.deformed}` are those of `{options.handles}`"
    elif has_partners:
        found = f"`{options.handles}` has {count} control points, and each goes where it is (p = q)"
    else:
        found = f"`{options.handles}` has {count} positions, and not where they go"
    raise ValueError(
        f"nothing moves: {found}; say where they go in columns qx,qy,qz or by --deformed, or {what}"
    )


def _as_arrays(handles):
    """p, q and weights (or None) of control-point polydata."""
    from vtk_mls.vtk import arrays

    weight = "Weight" if handles.GetPointData().HasArray("Weight") else None
    return arrays.control_points(handles, "Displacement", weight)


def _read_control_points(options):
    """Control-point polydata of the files, and whether they have q."""
    from vtk_mls import io

    reader = partial(io.read_landmarks, space=options.handles_space)
    if not Path(options.handles).exists():
        raise FileNotFoundError(
            f"there is no file `{options.handles}`; `vtk-mls view` makes one: drag handles over "
            "the data, then press S"
        )
    if options.deformed:
        rest, deformed = (read(reader, path) for path in (options.handles, options.deformed))
        return io.control_points(rest, deformed), True
    rest = read(partial(reader, is_alone=True), options.handles)
    return io.control_points(rest), rest.partners is not None


def _cuts(options):
    """The cuts, in the order of planes, half-planes and surfaces."""
    from vtk_mls import HalfPlane, Plane, io

    cuts = [Plane(*_vectors("--cut-plane", text, 2)) for text in options.cut_plane]
    cuts += [HalfPlane(*_vectors("--cut-half-plane", text, 3)) for text in options.cut_half_plane]
    return cuts + [cut for path in options.cut_surface for cut in read(io.read_cuts, path)]


def _vectors(option, text, count):
    """`count` vectors of three numbers from an option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 * count:
        raise ValueError(f"`{option}` must be {3 * count} numbers with commas, got `{text:.60}`")
    return [values[start : start + 3] for start in range(0, 3 * count, 3)]
