"""The command `vtk-mls`."""

from __future__ import annotations

import os
import sys

from vtk_mls import __version__
from vtk_mls.supervision import IS_POSSIBLE, step, supervise

_BAR = 40  # characters


def main(arguments=None):
    """Run a command.

    Parameters
    ----------
    arguments : list of str, optional
        Instead of those of the process; all is done in this process then, and what makes VTK
        crash ends it.

    Returns
    -------
    int
        Exit status: 0, 1 after one sentence on stderr, or 130 after Ctrl-C.
    """
    try:
        # ParaView is a process of its own, and Ctrl-C is for it too
        if arguments is None and IS_POSSIBLE and sys.argv[1:2] != ["paraview"]:
            return supervise(lambda: _run(None))
        return _run(arguments)
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return 130


def _run(arguments):
    import warnings

    from vtk_mls import Aborted, DeviceError

    options = _parser().parse_args(arguments)
    try:
        with warnings.catch_warnings():
            # numpy's remarks about values that are not finite, in files or for want of digits
            warnings.simplefilter("ignore", RuntimeWarning)
            return options.run(options)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("vtkmodules", "vtk"):
            raise
        message = "VTK is not installed: pip install 'vtk-mls[vtk]'"
    except (Aborted, DeviceError, OSError, ValueError) as error:
        message = str(error)
    except MemoryError:
        message = "there is not enough memory"
    print(f"vtk-mls: {' '.join(message.split())}", file=sys.stderr)
    return 1


def _parser():
    import argparse

    parser = argparse.ArgumentParser(
        prog="vtk-mls", description="Moving-least-squares deformation of volumes by control points."
    )
    parser.add_argument("--version", action="version", version=f"vtk-mls {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_deform(commands)
    info = commands.add_parser(
        "doctor",
        aliases=["info"],
        help="show versions, what OpenCL devices have proven, and what is wrong",
        description="Show versions, what OpenCL devices have proven, and what is wrong. "
        "Exit status 1 if something is.",
    )
    info.add_argument("--retest", action="store_true", help="test the devices again")
    info.set_defaults(run=_info)
    _add_paraview(commands)
    demo = commands.add_parser(
        "demo",
        help="deform a real volume in four ways",
        description="Deform a real volume in four ways; leave .vti files and a picture.",
    )
    demo.add_argument("directory", nargs="?", default="vtk-mls-demo", help="default: %(default)s")
    demo.set_defaults(run=_demo)
    return parser


def _add_paraview(commands):
    paraview = commands.add_parser(
        "paraview",
        help="start ParaView with the plugin loaded",
        description="Start ParaView with the plugin loaded, and with a volume to deform.",
    )
    paraview.add_argument("file", nargs="?", help="what to open, instead of a sample")
    add = paraview.add_argument
    add("--paraview", metavar="DIR", help="where ParaView is, if not on PATH or in a usual place")
    add("--venv", metavar="DIR", help="virtual environment that ParaView is to use (from 5.13 on)")
    add("--option", metavar="TEXT", action="append", default=[], help="handed on to ParaView")
    paraview.set_defaults(run=_paraview)
    path = commands.add_parser(
        "plugin-path",
        help="print the folder of the ParaView plugin",
        description="Print the folder of the ParaView plugin, for ParaView to load it by itself: "
        'export PV_PLUGIN_PATH="$(vtk-mls plugin-path)"',
    )
    path.set_defaults(run=_plugin_path)


def _add_deform(commands):
    from vtk_mls import INTERPOLATIONS, KINDS

    deform = commands.add_parser(
        "deform",
        help="deform an image or a mesh file",
        description="Deform an image or a mesh file. World coordinates of the handles are those of "
        "the file. Formats with one array (MetaImage, NIfTI) get the active scalars.",
    )
    deform.add_argument(
        "input",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz; "
        "mesh: .vtu .vtp .vts .vtr .vtk .stl .ply .obj",
    )
    deform.add_argument(
        "handles",
        help="control points: .csv with lines px,py,pz,qx,qy,qz[,weight] (from p at rest to q), "
        "or .vtp .vtk with point vectors Displacement, or .fcsv .mrk.json for places that stay",
    )
    deform.add_argument(
        "output",
        help="image: .vti .vtk .mha .mhd .nii .nii.gz; mesh: .vtu .vtp .vts .vtk .stl .ply",
    )
    add = deform.add_argument
    add("--kind", choices=KINDS, default="rigid", help="default: %(default)s")
    add("--alpha", type=float, default=1.0, help="locality of control points; default: %(default)s")
    add("--degree", type=int, default=2, help="of the polynomial kind: 1, 2, 3; default: 2")
    add("--interpolation", choices=INTERPOLATIONS, default="linear", help="default: %(default)s")
    add("--background", type=float, default=0.0, help="value outside; default: 0")
    add(
        "--label",
        metavar="NAME",
        action="append",
        default=[],
        help="array of labels, whose values are not mixed (may be repeated)",
    )
    add(
        "--grid",
        choices=("input", "fitted"),
        default="input",
        help="grid of the output: the input's, or one that holds all of the deformed volume",
    )
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
    add(
        "--gradient",
        metavar="NAME",
        default="",
        help="point array whose gradient in the deformed image is wanted, as array Gradient",
    )
    add("--device", default="", help="gpu, cpu, platform:device as in 0:1, or reference")
    add("--progress", action="store_true", help="show a progress bar although not on a terminal")
    deform.set_defaults(run=_deform)


def _deform(options):
    from vtk_mls import HalfPlane, Plane, io
    from vtk_mls.filters import MLSDeform

    deform = MLSDeform()
    dataset = _read(io.read_dataset, options.input)
    is_image = dataset.IsA("vtkImageData")
    if is_image:  # what becomes of a mesh depends on cuts
        io.check_writable(options.output, dataset)
    deform.SetInputData(0, dataset)
    deform.SetInputData(1, _read(io.read_control_points, options.handles))
    deform.SetKind(options.kind)
    deform.SetAlpha(options.alpha)
    deform.SetDegree(options.degree)
    deform.SetInterpolation(options.interpolation)
    deform.SetBackground(options.background)
    deform.SetOutputGrid(options.grid)
    deform.SetDevice(options.device)
    deform.SetNu(options.nu)
    deform.SetGradientArray(options.gradient)
    for text in options.cut_plane:
        deform.AddCut(Plane(*_vectors("--cut-plane", text, 2)))
    for text in options.cut_half_plane:
        deform.AddCut(HalfPlane(*_vectors("--cut-half-plane", text, 3)))
    for path in options.cut_surface:
        for cut in _read(io.read_cuts, path):
            deform.AddCut(cut)
    for name in options.label:
        deform.AddLabelArray(name)
    with step("deform", options.input):
        try:
            _update(deform, options.progress or sys.stderr.isatty())
        except ValueError as error:  # the command has files, not inputs
            text = str(error).replace("`ControlPoints`", f"`{options.handles}`")
            raise ValueError(text) from error
    output = deform.GetOutput()
    with step("write", options.output):
        io.write_dataset(output, options.output)
    if is_image:
        size = " x ".join(str(n) for n in output.GetDimensions())
        print(f"{options.output}: {size} points, {options.kind}")
    else:
        lost = output.GetFieldData().GetArray("FailedInverses").GetValue(0)
        size = f"{output.GetNumberOfPoints()} points, {output.GetNumberOfCells()} cells"
        print(f"{options.output}: {size}, {options.kind}" + (f"; {lost} points lost" * (lost > 0)))
    return 0


def _read(read, path):
    with step("read", path):
        return read(path)


def _vectors(option, text, count):
    """`count` vectors of three numbers from an option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 * count:
        raise ValueError(f"`{option}` must be {3 * count} numbers with commas, got `{text:.60}`")
    return [values[start : start + 3] for start in range(0, 3 * count, 3)]


def _update(algorithm, shows_progress):
    """Run a filter; its error becomes an exception."""
    from vtkmodules.util.misc import calldata_type
    from vtkmodules.vtkCommonCore import VTK_STRING

    errors = []

    @calldata_type(VTK_STRING)
    def heard(caller, event, text):
        errors.append(text.partition(": ")[2])

    def moved(caller, event):
        done = round(_BAR * caller.GetProgress())
        bar = "#" * done + "." * (_BAR - done)
        print(f"\r[{bar}] {caller.GetProgress():4.0%}", end="", file=sys.stderr, flush=True)

    algorithm.AddObserver("ErrorEvent", heard)
    if shows_progress:
        algorithm.AddObserver("ProgressEvent", moved)
    updated = algorithm.GetExecutive().Update()
    if shows_progress:
        print(file=sys.stderr)
    if not updated:
        raise ValueError(errors[0] if errors else "the deformation failed")


def _info(options):
    from vtk_mls.doctor import report

    lines, problems = report(options.retest)
    print("\n".join(lines))
    for problem in problems:
        print(f"wrong: {problem}")
    return 1 if problems else 0


def _paraview(options):
    import subprocess

    from vtk_mls import installation

    found = installation.find(options.paraview)
    contents = found.contents()
    command = [str(found.program), *options.option]
    if options.venv is not None:
        found.check_venv(options.venv, contents["python"])
        contents = found.contents(options.venv)
        command.append(f"--venv={options.venv}")
    if "problem" in contents:
        print(f"vtk-mls: in ParaView's Python {contents['python']}: {contents['problem']}")
    if not any(option.startswith("--script") for option in options.option):
        command.append(f"--script={installation.SCENE}")
    variables = found.environment()
    if options.file is not None:
        variables["VTK_MLS_OPEN"] = os.path.abspath(options.file)
    print(f"{found}, {contents.get('device', 'no OpenCL device')}", flush=True)
    return subprocess.run(command, env=variables, check=False).returncode


def _plugin_path(options):
    from vtk_mls.resources import resource

    print(resource("paraview_plugin"))
    return 0


def _demo(options):
    from vtk_mls import demo

    demo.main(options.directory)
    return 0
