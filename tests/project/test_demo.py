"""`make demo` leaves the files and pictures of the README."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkImagingCore import vtkExtractVOI
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter, vtkXMLPolyDataReader

from vtk_mls import KINDS
from vtk_mls.vtk.objects import configured, output_of

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples" / "demo"))
import make_demo as run

pytestmark = pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("nilearn", "pyvista"))),
    reason="the demo's data come with pyvista and nilearn",
)


@pytest.fixture(scope="module", params=["coarse", pytest.param("whole", marks=pytest.mark.matrix)])
def output(request, tmp_path_factory):
    """The folder that the demo filled, and what it printed; with every fourth voxel of the frog."""
    folder = tmp_path_factory.mktemp("a folder") / "demo"
    printed = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(printed):
        if request.param == "coarse":
            small = _every_fourth_voxel(folder.parent / "frog.vti")
            patch.setattr(run.demo, "file_of", lambda *_: small)
            patch.setattr(run, "cut_open", lambda _: None)
        run.main(folder)
    return folder, printed.getvalue()


def _every_fourth_voxel(file):
    """Write the frog's, to a file."""
    whole = run.demo.file_of("pyvista", "examples/frog_tissues.vti", "0.44")
    frog = output_of(vtkXMLImageDataReader(), FileName=str(whole))
    some = configured(vtkExtractVOI(), InputData=frog, VOI=frog.GetExtent(), SampleRate=(4, 4, 4))
    configured(vtkXMLImageDataWriter(), InputData=output_of(some), FileName=str(file)).Write()
    return file


def _read(reader, file):
    return output_of(reader, FileName=str(file))


def test_each_kind_moves_the_frog_differently(output):
    volumes = {}
    for kind in KINDS:
        labels = _read(vtkXMLImageDataReader(), output[0] / f"{kind}.vti").GetPointData()
        volumes[kind] = vtk_to_numpy(labels.GetScalars())
        assert np.isin(volumes[kind], np.arange(30)).all()
        assert np.count_nonzero(volumes[kind]) > 1000
        assert kind in output[1]
    assert len({np.count_nonzero(volume) for volume in volumes.values()}) == len(KINDS)


def test_handles_are_written(output):
    handles = _read(vtkXMLPolyDataReader(), output[0] / "handles.vtp")
    assert handles.GetNumberOfPoints() == len(run.CONTROL_POINTS) == 15
    drag = vtk_to_numpy(handles.GetPointData().GetArray("Displacement"))
    np.testing.assert_array_equal(drag, [drag for _, drag in run.CONTROL_POINTS.values()])


@pytest.mark.parametrize(
    ("output", "name", "height"),
    [
        ("coarse", "demo", 640),
        pytest.param("whole", "demo", 640, marks=pytest.mark.matrix),
        pytest.param("whole", "cut", 740, marks=pytest.mark.matrix),
    ],
    indirect=["output"],
)
def test_picture_or_what_to_install(output, name, height):
    picture = output[0] / f"{name}.png"
    if picture.is_file():
        assert str(picture) in output[1]
        pixels = vtk_to_numpy(_read(vtkPNGReader(), picture).GetPointData().GetScalars())
        assert pixels.reshape(height, 2400, 3).std(axis=(0, 1)).min() > 20
    else:
        assert "libegl1" in output[1]


def test_a_crash_of_opengl_names_the_missing_package(monkeypatch, capsys, tmp_path):
    crashed = subprocess.CompletedProcess([], -11)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: crashed)
    run.draw(tmp_path)
    assert "apt-get install libegl1 libgl1-mesa-dri" in capsys.readouterr().out


def test_without_the_volume_the_error_names_the_package(monkeypatch, tmp_path):
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(FileNotFoundError, match="pip install pyvista"):
        run.main(tmp_path)


def test_without_the_brain_the_error_names_the_package(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    run.cut_open(tmp_path)
    assert "pip install nilearn" in capsys.readouterr().out
