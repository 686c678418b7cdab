"""Saves an edit: handles, cuts, deformed data, displacement field, picture and script."""

from __future__ import annotations

import itertools
import os
import shutil
from pathlib import Path

from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from vtk_mls import Aborted, io
from vtk_mls.base.messages import message_handlers
from vtk_mls.base.sampling import AUTOMATIC
from vtk_mls.blocks import image_job as job
from vtk_mls.editor import script
from vtk_mls.editor.grips import names_of
from vtk_mls.editor.handle_polydata import handle_polydata
from vtk_mls.files import control_point_files, session_files, vtk_io
from vtk_mls.files.ome_zarr import is_ome_zarr
from vtk_mls.files.paths import replacing
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.filters.updating import update
from vtk_mls.queries.handle_warnings import overlap_warnings
from vtk_mls.vtk.cells import triangle_polydata

SESSION = "session.mls.json"
HANDLES, AT_REST, MOVED = "handles.csv", "handles-at-rest.mrk.json", "handles-moved.mrk.json"
SHAPES = "handles.vtp"  # instead, if there are regions, curves or paths
FIELD, PICTURE, SCRIPT = "displacement-field.nrrd", "picture.png", "deform.py"
_FALLBACK_ENDINGS = ".vti", ".vtp", ".vtu", ".vts"  # for data that the format cannot hold


def picture_of(window):
    """The last picture of a vtkRenderWindow: a vtkImageData."""
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    grab.Update()
    return grab.GetOutput()


class Saver:
    """Saves edits in a folder.

    Parameters
    ----------
    datasets : list of vtkDataSet
    paths : list of path
        Files of the datasets. Datasets without a file are saved, too.

    Attributes
    ----------
    datasets : list of vtkDataSet
    paths : list of Path
        Files of the datasets, absolute.
    session : Path or None
        The session file; None: `save_session` makes one in the folder.
    folder : Path or None
        Of saved files; or a session file, which is saved instead of them. None: the first save
        makes one in `within`, named after the first dataset.
    within : Path
    copies_data : bool
        Whether to copy the files of the datasets, for files that are temporary.
    files : list of Path
        Files of the last save.
    progress : callable or None
        Called with the saved fraction; a true return value stops with `Aborted`.
    """

    def __init__(self, datasets, paths=()):
        self.datasets, self.paths = datasets, [Path(path).resolve() for path in paths]
        self.session = None
        self.folder, self.within, self.copies_data, self.files = None, Path(), False, []
        self.progress, self._done, self._warnings = None, 0, []

    def save(self, state, picture):
        """Save a `State` and a picture, as of `picture_of`; a sentence with folder and warnings.

        All files are computed from the saved handles, as by `vtk-mls deform`. OSErrors and
        ValueErrors name the file.
        """
        folder, state = self._make_folder(), state.enabled_only()
        before = _versions(folder)
        vtk_io.write_png(picture, folder / PICTURE)
        _write_handles(state, folder)
        surfaces = _write_surfaces(state, folder)
        deform, field = MLSDeform(), MLSDisplacementField()
        deform.keeps_images = False  # each image is deformed once
        deform.SetAutomaticBackground(True)
        self._done, self._warnings = 0, _overlap_warnings(state)
        for algorithm in (deform, field):
            _configure(algorithm, state, folder, surfaces)
        targets = []
        for index in range(len(self.datasets)):
            targets.append(self._write_deformed(deform, index, folder, targets))
        field.SetInputData(0, self.datasets[0])
        self._update(field)
        io.write_field(field.GetOutput(), folder / FIELD)
        sources = [self._source(index, folder) for index in range(len(self.datasets))]
        text = script.script(state, _handles_file(state), surfaces, list(zip(sources, targets)))
        with replacing(folder / SCRIPT) as new:
            new.write_text(text, encoding="utf-8")
        self.files = sorted(path for path, _ in _versions(folder) - before)
        saved = f"Saved in {folder}: handles, deformed data, displacement field, picture, script."
        warnings = [f"{text[0].upper()}{text[1:]}." for text in dict.fromkeys(self._warnings)]
        return " ".join([saved, *warnings])

    @property
    def takes_session(self):
        """Whether a session is saved instead of files in a folder."""
        return self.folder is not None and session_files.is_session(self.folder)

    def session_place(self):
        """The session file, and the files of the data that it names; ValueError if one has none."""
        if not self.paths:
            raise ValueError("a session names the files of its data, and these have none")
        path = self.folder if self.takes_session else self.session
        path = path or self._make_folder() / SESSION
        if not self.copies_data:
            return path, self.paths
        folder = path.parent
        return path, [folder / self._source(index, folder) for index in range(len(self.paths))]

    def _update(self, algorithm):
        with message_handlers(None, self._warnings.append):
            update(algorithm, self._note_progress)
        self._done += 1
        if self._note_progress(0):  # fast filters report no progress
            raise Aborted("stopped as `progress` asked")

    def _note_progress(self, fraction):
        if self.progress is None:
            return False
        return self.progress((self._done + fraction) / (len(self.datasets) + 1))

    def _make_folder(self):
        if self.folder is None:
            folders = map(self.within.joinpath, _numbered(f"{self._name(0)[0]}-edited"))
            self.folder = next(path for path in folders if not path.exists())
        self.folder.mkdir(parents=True, exist_ok=True)
        return self.folder

    def _name(self, index):
        """Stem and ending of the file of a dataset."""
        if index >= len(self.paths):
            return f"data-{index + 1}", ".vti"
        name = self.paths[index].name
        if self._is_ome_zarr(index):
            stem = name.partition(".")[0]
            return stem, name.removeprefix(stem)
        if "." not in name:  # a folder of DICOM
            return name, ".vti"
        is_compound = name.endswith((".gz", ".seg.nrrd"))
        stem, dot, ending = name.partition(".") if is_compound else name.rpartition(".")
        return stem, dot + ending

    def _is_ome_zarr(self, index):
        """Whether a dataset is a coarse level of an OME-Zarr, whose finest one is deformed."""
        return index < len(self.paths) and is_ome_zarr(self.paths[index])

    def _source(self, index, folder):
        if index >= len(self.paths):
            return _write_dataset(self.datasets[index], folder, f"data-{index + 1}", ".vti")
        path = self.paths[index]
        if not self.copies_data:
            return os.fspath(path)
        with replacing(folder / path.name) as new:
            shutil.copyfile(path, new)
        return path.name

    def _write_deformed(self, deform, index, folder, other_names):
        """Write a deformed dataset; the name of its file, which is not among the others."""
        stem, ending = self._name(index)
        endings = ending, *_FALLBACK_ENDINGS
        stem = next(
            stem
            for stem in _numbered(f"{stem}-deformed")
            if not {stem + ending for ending in endings} & set(other_names)
        )
        if self._is_ome_zarr(index):
            return self._write_ome_zarr(deform, index, folder / f"{stem}{ending}")
        deform.SetInputData(0, self.datasets[index])
        self._update(deform)
        return _write_dataset(deform.GetOutput(), folder, stem, ending)

    def _write_ome_zarr(self, deform, index, target):
        """Deform all resolutions of an OME-Zarr, block by block; the name of its folder."""
        settings = {
            "interpolation": deform.GetInterpolation(),
            "background": AUTOMATIC,
            "void_values": deform.GetVoidValues(),
        }
        transform = deform.updated_deformation()
        source, progress = self.paths[index], self._note_progress
        job.deform(source, target, transform, settings, progress=progress)
        self._done += 1
        return target.name


def _numbered(name):
    """`name`, `name-2`, `name-3`, ..."""
    yield name
    yield from (f"{name}-{number}" for number in itertools.count(2))


def _configure(algorithm, state, folder, surfaces):
    """Set a filter up as the script and the command do, from the saved files."""
    algorithm.warns_of_overlap = False  # a surface in a cavity is a region in the saved file
    algorithm.SetInputData(1, io.read_control_points(folder / _handles_file(state)))
    for name, _, value in script.settings_of(state):
        getattr(algorithm, f"Set{name}")(value)
    for cut in state.cuts:
        if cut.labels():
            algorithm.AddCut(cut)
    for name in surfaces:
        for cut in io.read_cuts(folder / name):
            algorithm.AddCut(cut)


def _overlap_warnings(state):
    """Warnings about regions of a `State` that overlap, with their names in the editor."""
    deformation = state.deformation()
    if deformation is None:
        return []
    names, grips = names_of(state), state.grips
    owners = range(len(state.handles))
    return overlap_warnings(deformation, [names[grips.rows_of(owner)[0]] for owner in owners])


def _needs_polydata(state):
    """Whether tables cannot hold the handles."""
    return bool(state.handles) or len(state.path) > 0


def _handles_file(state):
    return SHAPES if _needs_polydata(state) else HANDLES


def _write_handles(state, folder):
    if _needs_polydata(state):
        io.write_dataset(handle_polydata(state), folder / SHAPES)
        return
    values = state.rest, state.deformed, state.weights, state.labels
    control_point_files.write(folder / HANDLES, *values)
    names = [label or f"handle-{i}" for i, label in enumerate(state.labels, 1)]
    for file, positions in ((AT_REST, state.rest), (MOVED, state.deformed)):
        control_point_files.write(folder / file, positions, positions, None, names)


def _write_surfaces(state, folder):
    """Write the cuts that are surfaces; the names of their files."""
    names = []
    for cut in state.cuts:
        if not cut.labels():
            names.append(f"cut-{len(names) + 1}.vtp")
            io.write_dataset(triangle_polydata(cut.points, cut.triangles), folder / names[-1])
    return names


def _write_dataset(dataset, folder, stem, ending):
    """Write in the format of this ending, or one of VTK's; the name of the file."""
    for candidate in (ending, *_FALLBACK_ENDINGS):
        path = folder / f"{stem}{candidate}"
        try:
            io.check_writable(path, dataset)
        except ValueError:
            continue
        try:
            io.write_dataset(dataset, path)
        except ValueError:
            if candidate == _FALLBACK_ENDINGS[-1]:
                raise
            continue
        return path.name
    raise ValueError(f"there is no format for a {dataset.GetClassName()}")


def _versions(folder):
    """(path, version) of each file: a replaced file has another version."""
    files = [path for path in folder.iterdir() if path.is_file()]
    return {(path, (path.stat().st_ino, path.stat().st_mtime_ns)) for path in files}
