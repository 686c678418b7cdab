"""Options of the map, which every command with control points has."""

from __future__ import annotations

from vtk_mls.commands.running import read


def add(parser):
    """Add the options to a parser."""
    from vtk_mls import KINDS

    add = parser.add_argument
    add("--kind", choices=KINDS, default="rigid", help="default: %(default)s")
    add("--alpha", type=float, default=1.0, help="locality of control points; default: %(default)s")
    add("--degree", type=int, default=2, help="of the polynomial kind: 1, 2, 3; default: 2")
    add("--nu", type=float, default=2.0, help="damping behind cuts, > 1; default: %(default)s")
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
    add("--device", default="", help="gpu, cpu, platform:device as in 0:1, or reference")
    add("--progress", action="store_true", help="show a progress bar although not on a terminal")


def apply(options, algorithm):
    """Set the properties of a filter, its control points on port 1, as the options say."""
    from vtk_mls import HalfPlane, Plane, io

    algorithm.SetInputData(1, read(io.read_control_points, options.handles))
    algorithm.SetKind(options.kind)
    algorithm.SetAlpha(options.alpha)
    algorithm.SetDegree(options.degree)
    algorithm.SetDevice(options.device)
    algorithm.SetNu(options.nu)
    for text in options.cut_plane:
        algorithm.AddCut(Plane(*_vectors("--cut-plane", text, 2)))
    for text in options.cut_half_plane:
        algorithm.AddCut(HalfPlane(*_vectors("--cut-half-plane", text, 3)))
    for path in options.cut_surface:
        for cut in read(io.read_cuts, path):
            algorithm.AddCut(cut)


def _vectors(option, text, count):
    """`count` vectors of three numbers from an option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 * count:
        raise ValueError(f"`{option}` must be {3 * count} numbers with commas, got `{text:.60}`")
    return [values[start : start + 3] for start in range(0, 3 * count, 3)]
