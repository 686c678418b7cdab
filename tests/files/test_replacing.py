"""A file that cannot be written as a whole leaves the old one as it was."""

import os
import stat
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import python
from file_fixtures import MESHES, image_with
from vtk_fixtures import TYPES, add_array, add_scalars, make_image
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
from vtkmodules.vtkFiltersSources import vtkRegularPolygonSource, vtkSphereSource

from vtk_mls import io
from vtk_mls.files import control_point_files
from vtk_mls.files.paths import remove_remains, replacing
from vtk_mls.files.vtk_io import write_png
from vtk_mls.vtk.objects import configured, output_of

pytest.importorskip("resource", reason="the size of files cannot be limited here")

SIZE = 40
POINTS = (".csv", ".txt", ".fcsv", ".mrk.json")


def _image():
    noise = np.random.default_rng(1).normal(size=SIZE**3)
    return add_scalars(make_image((SIZE, SIZE, SIZE)), "values", noise, TYPES["double"])


def _sphere():
    return output_of(vtkSphereSource(), ThetaResolution=60, PhiResolution=60)


def _blocks():
    blocks = vtkMultiBlockDataSet()
    for number in range(2):
        blocks.SetBlock(number, _image())
    return blocks


def _picture():
    pixels = np.random.default_rng(1).integers(0, 256, (4800, 3))
    return add_scalars(make_image((80, 60, 1)), "values", pixels, TYPES["unsigned char"])


DATASETS = {
    **dict.fromkeys((".vti", ".vtk", ".mha", ".mhd", ".nii", ".nii.gz", ".nrrd", ".nhdr"), _image),
    **dict.fromkeys((".vtp", ".stl", ".ply"), _sphere),
    ".vtu": MESHES[".vtu"],
    ".vts": MESHES[".vts"],
    **dict.fromkeys((".vtm", ".vtpc"), _blocks),
    ".png": _picture,
    **dict.fromkeys(POINTS, lambda: np.ones((50, 3))),
}
WRITE = {  # others by io.write_dataset
    ".png": write_png,
    **dict.fromkeys(POINTS, lambda points, path: control_point_files.write(path, points, points)),
}


def _contents(folder):
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# 5,000 bytes before the end is within the last buffer that some writers empty without a look
@pytest.mark.parametrize("missing", [1, 5_000, None], ids=["a byte", "5,000 bytes", "all"])
@pytest.mark.parametrize("suffix", DATASETS)
def test_a_full_disk_is_noticed_and_leaves_the_old_file(tmp_path, disk, suffix, missing):
    dataset, path = DATASETS[suffix](), tmp_path / f"x{suffix}"
    write = WRITE.get(suffix, io.write_dataset)
    write(dataset, path)
    full = max(len(content) for content in _contents(tmp_path).values())
    for file in tmp_path.rglob("x*.*"):
        file.write_bytes(b"the old one")
    before = _contents(tmp_path)
    disk(0 if missing is None else max(full - missing, 0))
    sentence = " could not be written: (No space|File too)"
    if suffix in (".vtm", ".vtpc"):  # VTK does not know the reason
        sentence = ""
    with pytest.raises((OSError, ValueError), match=rf"^`.*x\{suffix}`{sentence}"):
        write(dataset, path)
    assert _contents(tmp_path) == before


# HDF5 keeps what it could not write, and ends the process when it is next used.
_WRITE_HDF = """
import os, resource, sys
from vtk_mls import io
source, path, size = sys.argv[1:]
blocks = io.read_dataset(source)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(size), resource.RLIM_INFINITY))
try:
    io.write_dataset(blocks, path)
except (OSError, ValueError) as error:
    print(error, flush=True)
    os._exit(0)
"""


@pytest.mark.parametrize("missing", [1, 5_000, None], ids=["a byte", "5,000 bytes", "all"])
def test_a_full_disk_is_noticed_by_hdf(tmp_path, missing):
    source, path = tmp_path / "source.vtkhdf", tmp_path / "x.vtkhdf"
    io.write_dataset(_blocks(), source)
    path.write_bytes(b"the old one")
    before = _contents(tmp_path)
    size = 0 if missing is None else source.stat().st_size - missing
    status, said, errors = python("-c", _WRITE_HDF, source, path, size)
    assert status == 0, errors
    assert said.startswith(f"`{path}`")
    assert _contents(tmp_path) == before


def test_a_whole_ply_file_counts_as_whole(tmp_path):
    sphere = _sphere()
    add_array(sphere.GetPointData(), "uv", np.ones((sphere.GetNumberOfPoints(), 2)), TYPES["float"])
    sphere.GetPointData().SetActiveTCoords("uv")
    for _ in range(2):
        io.write_dataset(sphere, tmp_path / "x.ply")
        sphere.GetPointData().Initialize()


def test_a_face_that_ply_cannot_hold_is_refused(tmp_path):
    polygon = configured(vtkRegularPolygonSource(), GeneratePolyline=False)
    with pytest.raises(ValueError, match=r"`.*x\.ply` cannot hold a face of 300 points"):
        io.write_dataset(output_of(polygon, NumberOfSides=300), tmp_path / "x.ply")
    io.write_dataset(output_of(polygon, NumberOfSides=255), tmp_path / "x.ply")
    assert io.read_dataset(tmp_path / "x.ply").GetNumberOfCells() == 1


def test_links_and_permissions_stay(tmp_path):
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "x.vti", tmp_path / "link.vti"
    real.touch()
    real.chmod(0o640)
    link.symlink_to(real)
    io.write_dataset(image_with(np.arange(24), TYPES["short"]), link)
    assert link.is_symlink()
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert io.read_dataset(real).GetNumberOfPoints() == 24
    assert [path.name for path in real.parent.iterdir()] == ["x.vti"]


def test_a_new_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").touch()
    io.write_dataset(image_with(np.arange(24), TYPES["short"]), tmp_path / "x.mhd")
    modes = {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_device_is_not_replaced(tmp_path):
    (tmp_path / "x.vti").symlink_to(os.devnull)
    with pytest.raises(OSError, match=r"`.*x\.vti` cannot be written: it is not a regular file"):
        io.write_dataset(image_with(np.arange(24), TYPES["short"]), tmp_path / "x.vti")
    assert os.path.exists(os.devnull)


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_whatever_ends_the_writing_leaves_nothing(tmp_path, error):
    (tmp_path / "x.mhd").write_text("the old one")

    def write():
        with replacing(tmp_path / "x.mhd") as new:
            new.write_text("half")
            new.with_suffix(".raw").write_text("half")
            raise error(f"in {new}")

    with pytest.raises(error, match=r"x\.mhd"):
        write()
    assert _contents(tmp_path) == {"x.mhd": b"the old one"}


def test_the_file_that_names_others_comes_last(tmp_path, monkeypatch):
    """So that whoever finds it finds those, too."""
    order = []
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda *both: (order.append(both[1].name), replace(*both)))
    with replacing(tmp_path / "x.mhd") as new:
        new.write_text("header")
        new.with_suffix(".raw").write_text("values")
        new.with_suffix(".zraw").write_text("values")
    assert order[-1] == "x.mhd"
    assert len(order) == 3


def test_the_remains_of_a_killed_process_can_be_removed(tmp_path):
    (tmp_path / ".vtk-mls-17-abc").mkdir()
    (tmp_path / ".vtk-mls-17-abc" / "x.vti").touch()
    (tmp_path / ".vtk-mls-171-abc").mkdir()
    remove_remains(tmp_path / "x.vti", 17)
    assert [path.name for path in tmp_path.iterdir()] == [".vtk-mls-171-abc"]
