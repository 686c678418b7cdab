"""Writes docs/formats.md from the table of formats: python docs/formats_page.py"""

from __future__ import annotations

from pathlib import Path

from vtk_mls.files import formats

SECTIONS = {
    "Images": (formats.IMAGE, formats.MEDICAL),
    "Transforms and displacement fields": (formats.FIELD, formats.AFFINE),
    "Meshes": (formats.MESH, formats.POLYDATA, formats.STRUCTURED, formats.UNSTRUCTURED),
    "Blocks, pieces and time steps": (formats.BLOCKS,),
    "Control points and landmarks": (formats.POINTS, formats.POINT_DATA),
    "Surfaces of cuts": (formats.SURFACE,),
}
HEAD = """# File formats

Formats of `vtk-mls`, `vtk_mls.io` and ParaView's dialogs. Data in memory are in LPS. Readers
convert files in other frames to LPS; writers convert back ([Coordinate frames](frames.md)).
Made by `python docs/formats_page.py` from `vtk_mls/files/formats.py`.
"""
SHAPES = """With `--handle-shapes cells`, or `vtk_mls.io.read_handles`, files hold handles with a
shape. In `.vtp`, `.vtu`, `.vts` and `.vtk` with point vectors `Displacement`, vertices and points
without a cell are points, lines are curves, and closed surfaces that move rigidly are rigid
regions; cells with a volume count by their outer faces. In `.mrk.json` markups of the types Curve
and ClosedCurve are curves, straight from point to point. `vtk_mls.io.write_handles` writes `.vtp`
and `.vtk`.

The places of control points between p and q are the point array `Path` of `.vtp`, `.vtu`, `.vts`
and `.vtk`, with 3 k components: the displacements from p to the places at k equally spaced times.
`write_handles(..., between=)` writes it. Or each time has a file of positions, of any format above,
and `--path` names the series: `.pvd`, `.series` or a pattern in quotes (`'turn_*.csv'`).
"""
COLUMNS = """The columns of a table are what its header says, in any order and letters of any case:

| columns | meaning |
|---|---|
| `px py pz qx qy qz` | control points, from p at rest to q |
| `x_moving ..`, `x_fixed ..` | the same: BigWarp's moving points are p, its fixed points are q |
| `x_rest ..`, `x_deformed ..` | the same; `rest_x` and `x (rest)` are alike |
| `source`, `target` in their place | the same; also old, new; before, after; pre, post |
| `x y z`, `x1 y1 z1` | p, q; also `x y z new_x new_y new_z`, `x1 .. x2 ..`, `x.1` of pandas |
| `x y z dx dy dz` | p and q - p; also `Displacement:0 ..` of ParaView |
| `x y z`, `l p s`, `r a s` | positions |
| `weight` | a factor of each control point |
| `time` | control points move in time: lines with one time are the points of that time |
| `label` or `name` | texts by which the points of two files are paired |
| `use` or `active`, `defined` | lines with `false` or 0 are left out |

Without a header, lines are `px,py,pz,qx,qy,qz[,weight]` or `x,y,z`, after a label or not, or those
of BigWarp: name, `true` or `false`, moving x,y,z, fixed x,y,z. Cells are separated by commas, tabs,
blanks or semicolons; numbers between semicolons or tabs may have decimal commas.

In tag points of MINC with two volumes, p is the point of the second volume and q that of the first,
for MINC's programs move the second onto the first. Points of IDAV Landmark at 9999, 9999, 9999 are
missing.

Nothing is guessed. Columns of numbers that fit none of these rules are an error, which asks for
column names. Rows of seven numbers are such an error if the first or last column can be an index. A
file of control points with `x,y,z` and other columns that may be a position (`u,v,w` or
`x_sym,y_sym,z_sym`) is an error that says how to rename them. The header `0,1,2,..` that pandas
writes for columns without names is taken for one if there is an index column, if a column has texts
in all other lines, or if no number in the other lines is an integer (`40`, not `40.0`). Otherwise
it may be a point, which is an error, too.
"""
TRANSFORMS = """`vtk_mls.io.read_transform` and `write_transform`; also `vtk-mls field`, but `.mat`.
Transforms of ITK may be linear, displacement fields, or composites of them; B-splines are not read.
Files get the best affine transform and the rest of the field, or what an `Affine`, a `Field` or a
chain of them holds. NIfTI fields with the intent code 1006 have vectors in RAS, as ITK 5.4 reads
them; those with 1007 have vectors in LPS, as ANTs and nitransforms read them
(`--field-convention ants`).
"""
ZARR = """`vtk-mls deform` and `vtk-mls field` also write an OME-Zarr, of an OME-Zarr, in blocks
([Deform a terabyte](large.md)). Other commands and `vtk_mls.io` read its finest resolution, which
must fit in memory. Versions 0.4 and 0.5 are read. Plates are not.
"""
IMAGES = """**Volumes in time.** In {in_time} a fourth axis is time. `vtk-mls deform` takes
volume by volume into a file of the same format, or into `.pvd`. First time, time step and
units stay. The files hold equal time steps only. NRRD is written as ITK does,
with `space dimension: 4`. Volumes with components are all in memory for NIfTI, and so are
all volumes of a NRRD file whose time axis is not the slowest.

**DICOM.** Give a folder with one series, or one slice of a series, whose name may have any
ending. A missing or broken slice, slices of different sizes or spacing, and a tilted gantry
are errors. So is a folder with several series, which are listed with a file of each.
Enhanced DICOM, all slices in one file, is not read, for SimpleITK does not place its
slices.

**TIFF.** Pages are layers. Spacing, time step and unit come from the metadata of ImageJ or
OME, and coordinates are in that unit: micrometers stay micrometers, and handles are in
micrometers, too. NRRD and NIfTI outputs state the unit. Other TIFF files have voxels of
size 1. Several images of different sizes in one file are refused.

**Not read**: N5, and the HDF5 of BigDataViewer. Export a TIFF stack or NRRD from Fiji.
"""
SERIES = """`.pvd`, `.series` and patterns in quotes (`'beat_*.vti'`) are series of all of these.

Blocks that are images of one lattice, with the same arrays, are sampled as one image if
they fill a box. A warning says so where material that crosses a border of other blocks is
lost. Images of AMR are refused.
"""


def page() -> str:
    """The text of docs/formats.md."""
    parts = [HEAD]
    for title, words in SECTIONS.items():
        parts.append(f"## {title}\n\n| format | ending | read | written | frame |")
        parts.append("|---|---|---|---|---|")
        parts += [_row(line, words) for line in formats.TABLE if _is_of(line, words)]
        parts.append("")
        if title == "Images":
            parts.append(ZARR)
            lines = [line for line in formats.TABLE if line.series_writer]
            parts.append(IMAGES.format(in_time=", ".join(line.name for line in lines)))
        if title.startswith("Transforms"):
            parts.append(TRANSFORMS)
        if title.startswith("Blocks"):
            parts.append(SERIES)
        if title.startswith("Control points"):
            parts += [SHAPES, COLUMNS]
    return "\n".join(parts)


def _is_of(line, words):
    return bool({*line.reads, *line.writes} & {*words})


def _row(line, words):
    endings = " ".join(f"`{ending}`" for ending in line.endings.split())
    name = f"{line.name} (`pip install {line.needs}`)" if line.needs else line.name
    # one mesh may be read as blocks
    same = [other for other in formats.TABLE if other.endings == line.endings]
    reads = "yes" if any(other.reads for other in same) else ""
    writes = "yes" if {*line.writes} & {*words} else ""
    return f"| {name} | {endings} | {reads} | {writes} | {line.frame} |"


if __name__ == "__main__":
    Path(__file__).with_name("formats.md").write_text(page())
