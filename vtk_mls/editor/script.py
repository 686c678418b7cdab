"""The Python script, and the commands, that repeat an edit without the editor."""

import shlex

from vtk_mls.files.ome_zarr import is_ome_zarr
from vtk_mls.model.options import OPTIONS

_TEXT = '''\
"""Makes the data again that were deformed with `vtk-mls view`.

In a shell:

{commands}
{remarks}"""

from pathlib import Path

from vtk_mls import {imports}
from vtk_mls.filters import MLSDeform
{more}
here = Path(__file__).parent
deform = MLSDeform()
deform.SetAutomaticBackground(True)
deform.SetInputData(1, io.read_control_points(here / "{handles}"))
{settings}
{work}'''
_LOOP = """\
for source, target, reference in {files}:
    deform.SetReference(io.read_dataset(here / reference) if reference else None)
    deform.SetInputData(0, io.read_dataset(here / source))
    deform.Update()
    io.write_dataset(deform.GetOutput(), here / target)
    print(here / target)
"""
_BLOCKS = """\
keys = "interpolation", "background", "void_values"  # of larger data, which are read in blocks
values = deform.GetInterpolation(), "auto", deform.GetVoidValues()
for source, target, _ in {files}:
    transform = deform.updated_deformation()
    job.deform(here / source, here / target, transform, dict(zip(keys, values)))
    print(here / target)
"""


def settings_of(state):
    """(property, command-line option, value) of each value that is not the default of filters."""
    for option in OPTIONS:
        value = getattr(state, option.name)
        if value != option.default:
            yield option.property_name, option.flag, value
    if state.handles:
        yield "HandleShapes", "--handle-shapes", "cells"
    if state.mask is not None:
        yield "MaskBall", "--mask-ball", tuple(state.mask.numbers)


def script(state, handles, surfaces, files, remarks=()):
    """The text of the script, with remarks about the files.

    `handles` and `surfaces` are names of files in its folder: of control points, and of cuts that
    are surfaces. `files` are (source, target, image with the grid or None) of each deformation,
    relative to that folder.
    """
    settings = [f"deform.Set{name}({value!r})" for name, _, value in settings_of(state)]
    flat = [cut for cut in state.cuts if cut.labels()]
    for cut in flat:
        values = ", ".join(map(str, cut.arguments))
        settings.append(f"deform.AddCut(cuts.{type(cut).__name__}({values}))")
    for name in surfaces:
        settings += [f'for cut in io.read_cuts(here / "{name}"):', "    deform.AddCut(cut)"]
    large = [names for names in files if is_ome_zarr(names[0])]
    others = [names for names in files if names not in large]
    work = _LOOP.format(files=others) if others else ""
    work += _BLOCKS.format(files=large) if large else ""
    return _TEXT.format(
        more="from vtk_mls.blocks import image_job as job\n" if large else "",
        remarks="".join(f"\n{text[0].upper()}{text[1:]}.\n" for text in dict.fromkeys(remarks)),
        work=work,
        commands="\n".join(f"    {line}" for line in commands(state, handles, surfaces, files)),
        imports="cuts, io" if flat else "io",
        handles=handles,
        settings="\n".join(settings),
    )


def commands(state, handles, surfaces, files):
    """`vtk-mls deform` for each of the files, to be run in the folder of the script."""
    options = [f"{option}={_text(value)}" for _, option, value in settings_of(state)]
    options += [
        f"--cut-{cut.name}={_text(tuple(cut.numbers))}" for cut in state.cuts if cut.labels()
    ]
    options += [f"--cut-surface={name}" for name in surfaces]
    for source, target, reference in files:
        grid = [f"--reference={reference}"] if reference and not is_ome_zarr(source) else []
        yield shlex.join(["vtk-mls", "deform", source, handles, target, *options, *grid])


def _text(value):
    return ",".join(map(repr, value)) if isinstance(value, tuple) else value
