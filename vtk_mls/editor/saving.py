"""What is edited, as files: made as `vtk-mls deform` makes them from the saved handles."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from vtk_mls import Surface, io
from vtk_mls.editor import script
from vtk_mls.files import control_point_files
from vtk_mls.files.replacing import replacing
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.filters.updating import update
from vtk_mls.vtk import arrays

HANDLES, AT_REST, MOVED = "handles.csv", "handles-at-rest.mrk.json", "handles-moved.mrk.json"
FIELD, PICTURE, SCRIPT = "displacement-field.nrrd", "picture.png", "deform.py"
_OTHERS = ".vti", ".vtp", ".vtu", ".vts"  # for what the format of the input cannot hold


class Saver:
    """Saves into a folder.

    Parameters
    ----------
    datasets : list of vtkDataSet
    paths : list of path
        Where they came from. Those of none are saved, too.
    folder : path, optional
        One that is named after the first path, in the current folder and new, if not given.

    Attributes
    ----------
    folder : Path or None
    within : Path
        Where a new one is made.
    copies_data : bool
        Whether the data are saved, too, as they came: their paths do not last.
    files : list of Path
        What the last `save` has written.
    progress : callable or None
        Called with the fraction that is done while it saves.
    """

    def __init__(self, datasets, paths=(), folder=None):
        self._datasets, self._paths = datasets, [Path(path).resolve() for path in paths]
        self.folder = None if folder is None else Path(folder)
        self.within, self.copies_data, self.files = Path(), False, []
        self.progress, self._done = None, 0

    def save(self, state, window):
        """Save all of a `State`, and the picture that a vtkRenderWindow shows.

        Returns
        -------
        str
            A sentence that says where.

        Raises
        ------
        OSError, ValueError
            Naming the file.
        """
        folder = self._made_folder()
        before = _versions(folder)
        _write_picture(window, folder / PICTURE)
        self._write_handles(state, folder)
        surfaces = self._write_surfaces(state, folder)
        deform, field = MLSDeform(), MLSDisplacementField()
        deform.keeps_images = False  # each is asked for once
        self._done = 0
        for algorithm in (deform, field):
            _apply(algorithm, state, folder, surfaces)
        targets = []
        for number in self._numbers:
            targets.append(self._write_deformed(deform, number, folder, targets))
        field.SetInputData(0, self._datasets[0])
        self._update(field)
        io.write_field(field.GetOutput(), folder / FIELD)
        files = list(zip((self._source(number, folder) for number in self._numbers), targets))
        _write_text(folder / SCRIPT, script.script(state, HANDLES, surfaces, files))
        self.files = sorted(path for path, _ in _versions(folder) - before)
        return f"Saved in {folder}: handles, deformed data, displacement field, picture, script."

    def _update(self, algorithm):
        update(algorithm, self._note_progress)
        self._done += 1

    def _note_progress(self, share):
        if self.progress is not None:
            self.progress((self._done + share) / (len(self._datasets) + 1))

    @property
    def _numbers(self):
        return range(len(self._datasets))

    def _made_folder(self):
        if self.folder is None:
            name = f"{self._name(0)[0]}-edited"
            numbers = ("" if i == 1 else f"-{i}" for i in range(1, 10_000))
            self.folder = next(
                path
                for path in (self.within / (name + number) for number in numbers)
                if not path.exists()
            )
        self.folder.mkdir(parents=True, exist_ok=True)
        return self.folder

    def _name(self, number):
        """Stem and ending of a file."""
        if number >= len(self._paths):
            return f"data-{number + 1}", ".vti"
        name = self._paths[number].name
        stem, dot, ending = name.partition(".") if name.endswith(".gz") else name.rpartition(".")
        return stem, dot + ending

    def _source(self, number, folder):
        """Where the script finds a dataset."""
        if number < len(self._paths):
            path = self._paths[number]
            if not self.copies_data:
                return os.fspath(path)
            with replacing(folder / path.name) as new:
                shutil.copyfile(path, new)
            return path.name
        return _write_dataset(self._datasets[number], folder, f"data-{number + 1}", ".vti")

    def _write_handles(self, state, folder):
        values = state.rest, state.deformed, state.weights, state.labels
        control_point_files.write(folder / HANDLES, *values)
        numbers = [label or f"handle-{i}" for i, label in enumerate(state.labels, 1)]
        for name, positions in ((AT_REST, state.rest), (MOVED, state.deformed)):
            control_point_files.write(folder / name, positions, positions, None, numbers)

    def _write_surfaces(self, state, folder):
        """Names of the files of cuts that are surfaces."""
        names = []
        for cut in state.cuts:
            if isinstance(cut, Surface):
                names.append(f"cut-{len(names) + 1}.vtp")
                io.write_dataset(_polydata_of(cut), folder / names[-1])
        return names

    def _write_deformed(self, deform, number, folder, taken):
        """The name of the file; none that is taken."""
        stem, ending = self._name(number)
        endings = ending, *_OTHERS
        numbers = ("" if i == 1 else f"-{i}" for i in range(1, 2 + len(taken)))
        stem = next(
            each
            for each in (f"{stem}-deformed{number}" for number in numbers)
            if not {each + ending for ending in endings} & set(taken)
        )
        deform.SetInputData(0, self._datasets[number])
        self._update(deform)
        return _write_dataset(deform.GetOutput(), folder, stem, ending)


def _apply(algorithm, state, folder, surfaces):
    """Give a filter what is saved, as the script and the command do."""
    algorithm.SetInputData(1, io.read_control_points(folder / HANDLES))
    for name, _, value in script.settings_of(state):
        getattr(algorithm, f"Set{name}")(value)
    for cut in state.cuts:
        numbers = script.numbers_of(cut)
        if numbers:
            algorithm.AddCut(type(cut)(*numbers))
    for name in surfaces:
        for cut in io.read_cuts(folder / name):
            algorithm.AddCut(cut)


def _write_dataset(dataset, folder, stem, ending):
    """Write in the format of this ending, or one of VTK's; the name of the file."""
    for each in (ending, *_OTHERS):
        try:
            io.check_writable(folder / f"{stem}{each}", dataset)
        except ValueError:
            continue
        try:
            io.write_dataset(dataset, folder / f"{stem}{each}")
        except ValueError:
            if each == _OTHERS[-1]:
                raise
            continue
        return f"{stem}{each}"
    raise ValueError(f"there is no format for a {dataset.GetClassName()}")


def _polydata_of(surface):
    """The triangles of a Surface."""
    points, triangles, polydata = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(arrays.from_numpy(surface.points, VTK_DOUBLE))
    rows = surface.triangles.astype(np.int64)
    triangles.SetData(arrays.ids(3 * np.arange(len(rows) + 1)), arrays.ids(rows.ravel()))
    polydata.SetPoints(points)
    polydata.SetPolys(triangles)
    return polydata


def _versions(folder):
    """(path, version) of each file: what is replaced has another version."""
    files = [path for path in folder.iterdir() if path.is_file()]
    return {(path, (path.stat().st_ino, path.stat().st_mtime_ns)) for path in files}


def _write_picture(window, path):
    grab, writer = vtkWindowToImageFilter(), vtkPNGWriter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    with replacing(path) as new:
        writer.SetInputConnection(grab.GetOutputPort())
        writer.SetFileName(os.fspath(new))
        writer.Write()


def _write_text(path, text):
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8")
