"""Options of the map, which every command with control points has."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from vtk_mls.commands import property_options
from vtk_mls.commands.running import read

HANDLES = (
    "control points, from p at rest to q: .csv .txt with lines px,py,pz,qx,qy,qz[,weight] or the "
    "landmarks of BigWarp (p moving, q target); .vtp .vtu .vts .vtk with point vectors "
    "Displacement; or, with --deformed, positions p alone"
)


def add(parser, is_seen=False):
    """Add the options to a parser.

    What is seen at once has no progress bar, and a tolerance that nobody sees.
    """
    from vtk_mls.filters.property_tables import COMPUTING, COMPUTING_SEEN, SPACE

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
    property_options.add(parser, "Kind")
    property_options.add(parser, "Alpha")
    property_options.add(parser, "Degree", more="for the polynomial kind, 1, 2 or 3")
    property_options.add(parser, "Nu")
    property_options.add(parser, "Blend")
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
    property_options.add(parser, "CutFrame")
    for each in COMPUTING_SEEN if is_seen else COMPUTING:
        property_options.add(parser, each)
    if not is_seen:
        text = "show a progress bar although not on a terminal"
        add("--progress", action="store_true", help=text)


def apply(options, algorithm):
    """Set the properties of a filter, its control points on port 1, as the options say."""
    algorithm.SetInputData(1, _control_points(options))
    property_options.apply(options, algorithm)
    for cut in _cuts(options):
        algorithm.AddCut(cut)


def remark(algorithm):
    """What is to be said of what may not have been meant."""
    from vtk_mls import arrays

    dataset, handles = (algorithm.GetInputDataObject(port, 0) for port in (0, 1))
    displacement = handles.GetPointData().GetArray("Displacement")
    if not arrays.to_numpy(displacement).any():
        return "; nothing moves, for all control points rest (see --deformed)"
    if _are_far_away(arrays.to_numpy(handles.GetPoints().GetData()), dataset):
        return "; all control points are far from the data: is their frame right (--handles-space)?"
    has_degree = algorithm.GetDegree() != property_options.value("Degree")
    if has_degree and algorithm.GetKind() != "polynomial":
        return "; the degree is that of polynomials, and counts for nothing here"
    return ""


def _are_far_away(points, dataset):
    """Whether none is in the bounds of the data, enlarged by half of their longest side."""
    import numpy as np

    from vtk_mls.files.blocks import blocks

    bounds = [np.reshape(each.GetBounds(), (3, 2)) for each in blocks(dataset)]
    bounds = [each for each in bounds if (each[:, 0] <= each[:, 1]).all()]
    if not bounds or len(points) == 0:
        return False
    low, high = np.min(bounds, axis=0)[:, 0], np.max(bounds, axis=0)[:, 1]
    margin = (high - low).max() / 2
    return not ((points >= low - margin) & (points <= high + margin)).all(axis=1).any()


def deformation(options):
    """The `Deformation` that the options say."""
    from vtk_mls import Deformation

    rest, deformed, weights = control_points(options)
    if options.blend != 1:
        deformed = rest + options.blend * (deformed - rest)
    return Deformation(rest, deformed, weights=weights, **map_arguments(options))


def control_points(options):
    """p, q and weights (or None) of the files."""
    from vtk_mls import arrays

    handles = _control_points(options)
    weight = "Weight" if handles.GetPointData().HasArray("Weight") else None
    return arrays.control_points(handles, "Displacement", weight)


def map_arguments(options):
    """What a `Deformation` takes beside control points, by name."""
    return {
        "kind": options.kind,
        "alpha": options.alpha,
        "degree": options.degree,
        "cuts": _cuts(options),
        "nu": options.nu,
        "cut_frame": options.cut_frame,
        "map_tolerance": options.map_tolerance,
        "device": options.device or None,
    }


def _control_points(options):
    """Control-point polydata of the files."""
    from vtk_mls import io

    reader = partial(io.read_landmarks, space=options.handles_space)
    if not Path(options.handles).exists():
        raise FileNotFoundError(
            f"there is no file `{options.handles}`; `vtk-mls view` makes one: drag handles over "
            "the data, then press S"
        )
    if not options.deformed:
        return io.control_points(read(partial(reader, is_alone=True), options.handles))
    return io.control_points(read(reader, options.handles), read(reader, options.deformed))


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
