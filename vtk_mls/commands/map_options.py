"""Options of the map, common to all commands with control points."""

from functools import partial

from vtk_mls.commands import property_options
from vtk_mls.commands.running import BALL, FIXED, MASK, SLIDING
from vtk_mls.files.landmarks import PAIR_BY
from vtk_mls.filters import property_tables as tables
from vtk_mls.model.cuts import BY_NUMBERS

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
    add = parser.add_argument
    add_files(parser)
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
        tables.HANDLE_SHAPES_CHOICE,
        text="handles in a file: points; or cells: lines, and curves of .mrk.json, are curves, "
        "closed surfaces are rigid regions, other points are points",
    )
    for option in tables.MAP:
        more = "of two files of points, and of BigWarp or tags: auto"
        if is_interactive:
            more = "with --target: auto"
        property_options.add(parser, option, more=more * (option.name == "Kind"))
    parser.set_defaults(kind="")
    _add_cuts(parser)
    computing = tables.INTERACTIVE_COMPUTING if is_interactive else tables.COMPUTING
    for option in (*tables.CUT_OPTIONS, *computing):
        property_options.add(parser, option)
    _add_limits(parser, is_interactive)
    if not is_interactive:
        property_options.add(
            parser,
            tables.INITIAL_TRANSFORM,
            text="transform that moves the material first, so that the control points correct it: "
            "of ITK, ANTs or 3D Slicer, as it resamples images (.h5 .tfm .txt .mat need SimpleITK; "
            "displacement fields .nii.gz .nii .nrrd .nhdr .mha .mhd). Control points at rest p, "
            "and cuts in the rest frame, are in the space that it leads to",
        )
        add("--progress", action="store_true", help="show a progress bar even without a terminal")
        text = "continue if all control points rest and nothing moves, instead of an error"
        add("--allow-identity", action="store_true", help=text)


def add_files(parser):
    parser.set_defaults(path=None)
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
        choices=tables.SPACE.choices,
        default=tables.SPACE.default,
        help="frame of files of points that do not declare one (markups and tables of 3D Slicer "
        "do): ras for points from nibabel or FreeSurfer; cuts are always in LPS; "
        "default: %(default)s",
    )


def _add_cuts(parser):
    add = partial(parser.add_argument, action="append", default=[])
    for name, shape in BY_NUMBERS.items():
        *parts, last = (field.title or field.name for field in shape.fields)
        text = f"cut along a {name}, by its {', '.join(parts)} and {last}; may be repeated; "
        text += shape.help[:1].lower() + shape.help[1:].removesuffix(".")
        add(f"--cut-{name}", metavar=",".join(shape.labels()).upper(), help=text)
    text = "cut along the surfaces of a file: .vtp .vtk .stl; may be repeated"
    add("--cut-surface", metavar="FILE", help=text)


def _add_limits(parser, is_interactive):
    """Masks and faces; interactive commands have the ball only."""
    property_options.add(parser, tables.MASK_BALL, flag=BALL)
    if is_interactive:
        parser.set_defaults(mask=None, fixed_planes=(), sliding_planes=())
        return
    property_options.add(
        parser,
        tables.MASK,
        flag=MASK,
        text="image in the deformed space by which displacements are multiplied, from 0 to 1; of "
        "integers, as of labels, what is not 0 counts as 1; outside of it nothing moves",
    )
    property_options.add(parser, tables.FIXED_PLANES, flag=FIXED, more="may be repeated")
    property_options.add(parser, tables.SLIDING_PLANES, flag=SLIDING, more="may be repeated")
