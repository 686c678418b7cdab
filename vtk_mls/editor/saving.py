"""Saves an edit: handles, cuts, deformed data, displacement field, picture and script."""

import filecmp
import itertools
import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from vtk_mls import Aborted, io
from vtk_mls.base.messages import message_handlers
from vtk_mls.base.sampling import AUTOMATIC
from vtk_mls.blocks import image_job as job
from vtk_mls.editor import script, time_steps
from vtk_mls.editor.grips import names_of
from vtk_mls.editor.handle_polydata import handle_polydata
from vtk_mls.files import control_point_files, session_files, vtk_io
from vtk_mls.files.ome_zarr import is_ome_zarr
from vtk_mls.files.paths import replacing
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.filters.updating import update
from vtk_mls.queries.handle_warnings import overlap_warnings
from vtk_mls.vtk.cells import triangle_polydata
from vtk_mls.vtk.objects import output_of

HANDLES, AT_REST, MOVED = "handles.csv", "handles-at-rest.mrk.json", "handles-moved.mrk.json"
SHAPES = "handles.vtp"  # instead, if there are regions, curves or paths
FIELD, PICTURE, SCRIPT = "displacement-field.nrrd", "picture.png", "deform.py"
_FILLED = f"`{FIELD}` fills the gap that a cut has opened, and the deformed data leave it empty"
_FALLBACK_ENDINGS = ".vti", ".vtp", ".vtu", ".vts"  # for data that the format cannot hold


def picture_of(window):
    """The last picture of a vtkRenderWindow: a vtkImageData."""
    settings = {"Input": window, "ReadFrontBuffer": False, "ShouldRerender": False}
    return output_of(vtkWindowToImageFilter(), **settings)


class Saver:
    """Saves edits in a folder.

    Attributes
    ----------
    datasets : list of vtkDataSet
    paths : list of Path
        Files of the datasets, absolute. Datasets without a file are saved, too.
    target : Target or None
        What the data are to match. Images are saved on its grid if it is an image.
    uses_target_grid : bool
        False: images are saved on their own grids.
    session : Path or None
        The session file; None for one in the folder.
    folder : Path or None
        Of saved files. None: the first save makes one in `within`, named after the first dataset.
    within : Path
    copies_data : bool
        Whether to copy the files of the datasets, for files that are temporary.
    times : tuple of float
        Time steps of the first dataset, or (). The one at index `step` is saved.
    files, warnings : lists of Path and of str
        Of the last save.
    progress : callable or None
        Called with the saved fraction; a true return value stops with `Aborted`.
    """

    def __init__(self, datasets, paths=()):
        self.datasets, self.paths = [*datasets], [Path(path).resolve() for path in paths]
        self.target, self.uses_target_grid, self.session = None, True, None
        self.folder, self.within, self.copies_data, self.files = None, Path(), False, []
        self.progress, self._done, self._sources = None, 0, []
        self.times, self.step = time_steps.times_of(self.paths[0]) if self.paths else (), 0
        self.warnings, self._warnings = [], []

    def set_output(self, path):
        """Save in a folder; or in a session file, with the other files in a folder of its name."""
        if session_files.is_session(path):
            self.session = Path(path)
            path = os.fspath(path)[: -len(session_files.ENDING)]
        self.folder = Path(path)

    def take_step(self, index):
        """Save another time step; its dataset."""
        self.step, self.datasets[0] = index, time_steps.read(self.paths[0], index)
        return self.datasets[0]

    @property
    def grid(self):
        """The target whose grid saved images have; None for their own grids."""
        is_used = self.target is not None and self.uses_target_grid
        if is_used and isinstance(self.target.dataset, vtkImageData):
            return None if is_ome_zarr(self.target.path or "") else self.target
        return None

    def save(self, state, picture):
        """Save a `State` and a picture, as of `picture_of`; a sentence with folder and warnings.

        All files are computed from the saved handles, as by `vtk-mls deform`. OSErrors and
        ValueErrors name the file. After an error no file has changed.
        """
        folder = self._make_folder()
        scratch = Path(tempfile.mkdtemp(prefix=".saving-", dir=folder))
        try:
            self._save_in(scratch, state.enabled_only(), picture)
            moved = [_moved(path, folder) for path in scratch.iterdir()]
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
            with suppress(OSError):  # it is not empty
                folder.rmdir()
        self.files = sorted(path for path in moved if path.is_file())
        self.warnings = [f"{text[0].upper()}{text[1:]}." for text in dict.fromkeys(self._warnings)]
        grid = f" on the grid of {self.grid.name}" if self.grid else ""
        saved = f"deformed data{grid}, displacement field, picture, script, session"
        return " ".join([f"Saved in {folder}: handles, {saved}.", *self.warnings])

    def _save_in(self, folder, state, picture):
        """Write all files but the session into a folder."""
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
        field.SetInputData(0, self.grid.dataset if self.grid else self.datasets[0])
        self._update(field)
        void = field.GetOutput().GetPointData().GetArray("Void")
        if void and void.GetRange()[1]:
            self._warnings.append(_FILLED)
        io.write_field(field.GetOutput(), folder / FIELD)
        self._sources = self._write_sources(folder)
        reference = self._sources[-1] if self.grid else None
        files = [
            (source, target, reference if isinstance(dataset, vtkImageData) else None)
            for source, target, dataset in zip(self._sources, targets, self.datasets)
        ]
        text = script.script(state, _handles_file(state), surfaces, files, self._warnings)
        with replacing(folder / SCRIPT) as new:
            new.write_text(text, encoding="utf-8")

    def session_place(self):
        """The session file, the files of the data that it names, and that of the target or None."""
        path = self.session or self._make_folder() / session_files.NAME
        is_written = self._sources and path.parent == self.folder
        sources = self._sources if is_written else self._write_sources(path.parent)
        paths = [path.parent / source for source in sources]
        return path, paths[: len(self.datasets)], paths[-1] if self.target else None

    def _write_sources(self, folder):
        """Names in a folder, or absolute paths, of the data, and of the target if there is one.

        Data without files, and uploads, are written.
        """
        sources = [self._source(index, folder) for index in range(len(self.datasets))]
        return [*sources, _target_file(self.target, folder)] if self.target else sources

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
        name, is_zarr = self.paths[index].name, self._is_ome_zarr(index)
        is_compound = is_zarr or name.endswith((".gz", ".seg.nrrd"))
        stem = name.partition(".")[0] if is_compound else Path(name).stem
        return stem, name.removeprefix(stem) or ".vti" * (not is_zarr)  # of a folder of DICOM

    def _is_ome_zarr(self, index):
        """Whether a dataset is a coarse level of an OME-Zarr, whose finest one is deformed."""
        return index < len(self.paths) and is_ome_zarr(self.paths[index])

    def _source(self, index, folder):
        if index >= len(self.paths):
            return _write_dataset(self.datasets[index], folder, f"data-{index + 1}", ".vti")
        path = self.paths[index]
        if index == 0 and len(self.times) > 1:
            stem, ending = self._name(0)
            return _write_dataset(self.datasets[0], folder, f"{stem}-step-{self.step + 1}", ending)
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
        dataset = self.datasets[index]
        takes_grid = self.grid and isinstance(dataset, vtkImageData)
        deform.SetReference(self.grid.dataset if takes_grid else None)
        deform.SetInputData(0, dataset)
        self._update(deform)
        return _write_dataset(deform.GetOutput(), folder, stem, ending)

    def _write_ome_zarr(self, deform, index, target):
        """Deform all resolutions of an OME-Zarr, block by block; the name of its folder."""
        settings = {"background": AUTOMATIC, "interpolation": deform.GetInterpolation()}
        settings["void_values"] = deform.GetVoidValues()
        arguments = self.paths[index], target, deform.updated_deformation(), settings
        job.deform(*arguments, progress=self._note_progress)
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


def _handles_file(state):
    """The file for handles; tables cannot hold shapes and paths."""
    return SHAPES if state.handles or len(state.path) else HANDLES


def _write_handles(state, folder):
    if _handles_file(state) == SHAPES:
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


def _moved(path, folder):
    """Move a file or a folder into another folder, in place of one of its name; the new path."""
    target = folder / path.name
    if path.is_dir():
        shutil.rmtree(target, ignore_errors=True)
    return path.replace(target)


def _target_file(target, folder):
    """The file of a target, or its name in a folder where it is written beside other files."""
    if target.path is None:
        return _write_dataset(target.dataset, folder, "target", ".vti")
    source = Path(target.path)
    if not target.is_upload:
        return os.fspath(source.resolve())
    for count in itertools.count():
        path = folder / ("target-" * count + source.name)
        if not path.exists():
            shutil.copyfile(source, path)
        if filecmp.cmp(source, path, shallow=False):
            return path.name
