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

These formats are read and written by `vtk-mls`, `vtk_mls.io` and ParaView's dialogs. Data in
memory are in LPS. Readers convert files in other frames to LPS, and writers convert back
([Coordinate frames](frames.md)). `python docs/formats_page.py` makes this page from
`vtk_mls/files/formats.py`.
"""
SHAPES = """### Handles with a shape

With `--handle-shapes cells`, and with `vtk_mls.io.read_handles`, files hold handles with a
shape.

- In `.vtp`, `.vtu`, `.vts` and `.vtk` files with point vectors `Displacement`, vertices and
  points without a cell are points. Lines are curves. Closed surfaces that move rigidly are rigid
  regions. Cells with a volume count by their outer faces. A segment that several lines share,
  such as the trunk of VMTK's centerlines, counts once.
- In `.mrk.json` files, markups of the types Curve and ClosedCurve are curves, straight from
  point to point.

`vtk_mls.io.write_handles` writes `.vtp` and `.vtk`.

### Paths

The point array `Path` of `.vtp`, `.vtu`, `.vts` and `.vtk` files holds the positions of control
points between p and q. It has 3 k components: the displacements from p to the positions at k
equally spaced times. `write_handles(..., between=)` writes it. Instead, each time can have its
own file of positions, in any format above. `--path` names the series: `.pvd`, `.series` or a
pattern in quotes (`'turn_*.csv'`).
"""
COLUMNS = """### Tables

The header of a table names its columns, in any order, in upper or lower case:

| columns | meaning |
|---|---|
| `px py pz qx qy qz` | control points, from p at rest to q |
| `x y z dx dy dz` | p and q - p; also `Displacement:0 ..` of ParaView |
| `x y z`, `l p s`, `r a s` | positions |
| `label use x y z x1 y1 z1` | landmarks of BigWarp: p in the moving image, q in the fixed one |
| `weight` | a factor of each control point |
| `time` | control points move in time: lines with one time are the points of that time |
| `label` or `name` | texts by which the points of two files are paired |
| `use` or `active`, `defined` | lines with `false` or 0 are left out |

Without a header, lines are `px,py,pz,qx,qy,qz[,weight]` or `x,y,z`, with or without a label
before them. Or they are those of BigWarp: name, `true` or `false`, moving x,y,z, fixed x,y,z.
Cells are separated by commas, tabs, blanks or semicolons. Numbers between semicolons or tabs may
have decimal commas.

**Other tables are errors**, because nothing is guessed. The sentence says which columns are not
known. So are rows of seven numbers whose first or last column counts the rows, and the header
`0,1,2,..` that pandas writes for columns without names: write names into the header.

### Other formats of landmarks

In tag points of MINC with two volumes, p is the point of the second volume and q that of the
first. MINC's programs move the second onto the first, too. Points of IDAV Landmark at 9999,
9999, 9999 are missing.
"""
TRANSFORMS = """`vtk_mls.io.read_transform` and `write_transform` use all of these, and
`vtk-mls field` all but `.mat`. Transforms of ITK can be linear, displacement fields, or
composites of them. B-splines are not read. An `Affine`, a `Field` and a chain of them are
written as they are. Any other map is written as the best affine transform and the rest of the
field.

NIfTI fields with the intent code 1006 have vectors in RAS, as ITK 5.4 reads them. Those with
1007 have vectors in LPS, as ANTs and nitransforms read them (`--field-convention ants`), unless
the intent names another program. NiftyReg's displacements and positions (`NREG_TRANS`) and SPM's
positions (`Mapping`, files `y_*.nii`) are converted from RAS. NiftyReg's velocities and control
points, and all fields of FSL, are refused.
"""
ZARR = """**OME-Zarr.** Versions 0.4 and 0.5 are read; plates are not. `vtk-mls deform` and
`vtk-mls field` write an OME-Zarr if the input is one, in blocks ([Deform a terabyte](large.md)).
Other commands and `vtk_mls.io` read its finest resolution, which must fit in memory.

- Positions are in LPS if all axes state their `orientation` (RFC 4). A coordinate is the distance
  from 0 toward the second word: -10 on an axis `right-to-left` is 10 to the right. Words such as
  `dorsal-to-ventral` do not give LPS. Then positions are used as they are, with a warning.
- Axes with different units are converted to the unit of x, also for handles. NRRD and NIfTI outputs
  state the unit; a displacement field in NIfTI is in millimeters.
- The finest resolution is deformed, with all times and channels. The coarser ones lie where their
  metadata say. They are computed as means, or as middle values for labels. If their metadata say
  that they were made by sampling (no translation by half a voxel), they are sampled.
- Label images in the group `labels`, listed or not, are deformed too, and never interpolated. They
  take orientation and unit from their image if they state none. `--label` names channels that hold
  labels, or `OME-Zarr` for an image of one channel. Arrays of bool are labels.
- Metadata, axes, units, chunks and compression are copied from the input, as are other groups, such
  as `tables` and `OME`. A warning names other images, which are not copied.
- A displacement field has three channels: x, y and z in LPS, also if its axes state another
  orientation.
- Memory use does not depend on the size of the image. A process works on a few blocks at a time,
  of about eight million values each.
"""
IMAGES = """**Volumes in time.** In {in_time}, a fourth axis is time. `vtk-mls deform` works
volume by volume and writes a file of one of these formats, or `.pvd`. Times are seconds, for
handles too, if the file states a unit of time, as NIfTI, NRRD and TIFF can. Those of MetaImage are
seconds as in ITK. NIfTI and NRRD outputs state the unit: that of an input of the same format, or
else seconds. Other units, such as Hz, are kept and not converted. The files hold equal time steps
only. NRRD is written as ITK does, with `space dimension: 4`. All volumes are in memory at once,
those of the input and those of the output.

**DICOM.** Give a folder with one series, or one slice of a series, with any ending. Each
slice has its own rescaling; the volume has a type that holds all values. Reports, DICOMDIR and
files of other formats do not matter. These are errors: a missing or broken slice, slices of
different sizes or spacing, a tilted gantry, and a folder with several series (the error lists a
file of each). Enhanced DICOM, with all slices in
one file, is not read, because SimpleITK does not place its slices.

**TIFF.** Pages are layers, also pages that were written one by one. Spacing, time step and units
come from the metadata of ImageJ or OME. Coordinates are in the unit of the first size, usually x,
to which the others are converted: micrometers stay micrometers, for handles too. A size that OME
metadata do not state is that of another axis, with a warning; a missing unit of OME is the
micrometer, or the second. NRRD and NIfTI outputs state the unit; a displacement field in NIfTI is
in millimeters, as ITK reads images in micrometers, but no vectors. Other TIFF files have voxels of
size 1. Several images of different sizes in one file are refused. Files that are compressed by
LZW need the package imagecodecs.

**Not read**: N5, and the HDF5 files of BigDataViewer. Export a TIFF stack or NRRD from Fiji.
"""
SERIES = """`.pvd`, `.series` and patterns in quotes (`'beat_*.vti'`) are series of any of these
files.

Blocks of images are sampled as one image if they lie on one lattice, have the same arrays and
fill a box. For other blocks, a warning says where material that crosses a border is lost. AMR
images are refused.
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
            parts += [COLUMNS, SHAPES]
    return "\n".join(parts)


def _is_of(line, words):
    return bool({*line.reads, *line.writes} & {*words})


def _row(line, words):
    endings = " ".join(f"`{ending}`" for ending in line.endings.split())
    name = f"{line.name} (`pip install {line.needs}`)" if line.needs else line.name
    # one mesh may be read as blocks
    same = [other for other in formats.TABLE if other.endings == line.endings]
    reads = "yes" if any(other.reads for other in same) else ""
    writes = "yes" if {*line.writes} & {*words} else "in blocks" if line.is_folder else ""
    return f"| {name} | {endings} | {reads} | {writes} | {line.frame} |"


if __name__ == "__main__":
    Path(__file__).with_name("formats.md").write_text(page())
