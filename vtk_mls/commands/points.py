"""`vtk-mls points`: landmarks move with the material."""

from dataclasses import replace
from functools import partial

import numpy as np

from vtk_mls import io
from vtk_mls.base.progress import whole
from vtk_mls.commands import map_options, property_options
from vtk_mls.commands.running import files_named, kind_used, progress_bar, read, set_up
from vtk_mls.commands.supervision import step
from vtk_mls.files import control_point_files
from vtk_mls.files.landmarks import listed
from vtk_mls.filters import MLSDeform
from vtk_mls.filters.initial_transforms import split_chain
from vtk_mls.queries.handle_warnings import handle_warnings


def add(points):
    points.description = (
        "Move landmarks to where the material at them goes, as `vtk-mls deform` moves "
        "a mesh. The output keeps labels, descriptions and order; from .mrk.json to .mrk.json it "
        "keeps everything else, too. Points without a place in the output are undefined in "
        ".mrk.json, and left out of other files. Of pairs the first positions move."
    )
    points.add_argument(
        "input",
        help="landmarks: markups of 3D Slicer (.mrk.json .fcsv) and its tables (.csv), tables of "
        "ITK and ANTs, landmarks of BigWarp, lines x,y,z or label,x,y,z (.csv .txt), points of "
        "elastix and transformix (.txt .pts), of IDAV Landmark (.pts), tag points of MINC (.tag), "
        "points of .vtp .vtu .vts .vtk",
    )
    points.add_argument("handles", help=map_options.HANDLES)
    points.add_argument(
        "output", help="landmarks: .mrk.json .fcsv .csv (ITK, ANTs) .txt .pts (elastix) .tag"
    )
    text = "move points from the deformed space back to where their material came from"
    property_options.add(points, "Inverse", text=text)
    map_options.add(points)


def run(options):
    control_point_files.check_writable(options.output)
    space = options.handles_space
    landmarks = read(partial(io.read_landmarks, space=space), options.input)
    algorithm = MLSDeform()
    set_up(algorithm, options)
    with files_named(options):
        transform = algorithm.updated_deformation()
    with step("deform", options.input):
        moved = replace(landmarks, positions=_moved(landmarks, transform, options))
    with step("write", options.output):
        left_out = control_point_files.write_landmarks(options.output, moved, options.input, space)
    notes = _losses(landmarks, moved, options, left_out > 0)
    notes += "".join(f"; {sentence}" for sentence in handle_warnings(split_chain(transform)[1]))
    print(f"{options.output}: {len(moved.positions)} points, {kind_used(algorithm)}{notes}")
    return 0


def _moved(landmarks, transform, options):
    """New positions (n, 3), NaN for points without one."""
    is_placed = landmarks.is_placed
    positions = landmarks.positions[is_placed]
    with progress_bar(options) as bar:
        if options.inverse:
            with whole(bar) as progress:
                mapping, finding = progress.divided(1, 1)
                new = transform.backward(positions, mapping)
                new[transform.void(positions, finding)] = np.nan
        else:
            new = transform.forward(positions, bar)
    moved = np.full_like(landmarks.positions, np.nan)
    moved[is_placed] = new
    return moved


def _losses(landmarks, moved, options, are_left_out):
    """Notes on points without a position in the output or in the input."""
    fate = "left out" if are_left_out else "marked so"
    failures = np.flatnonzero(landmarks.is_placed & ~moved.is_placed).tolist()
    unplaced = int((~landmarks.is_placed).sum())
    text = ""
    if failures:
        names = listed([landmarks.labels[i] or f"number {i + 1}" for i in failures])
        text += f"; {len(failures)} have no place in the output and are {fate}: {names}"
    if unplaced and are_left_out:
        text += f"; {unplaced} are not placed in `{options.input}` and are left out"
    return text
