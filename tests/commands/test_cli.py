"""The command `vtk-mls`, in this process and in ones of its own."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import WITHOUT, run
from control_point_sets import DEVICES
from pipelines import values_of
from vtk_fixtures import DEFORMED, FAST, REST

from vtk_mls import (
    KINDS,
    Deformation,
    HalfPlane,
    Plane,
    Sampling,
    Surface,
    __version__,
    io,
)
from vtk_mls.commands.cli import main
from vtk_mls.engine.device import caches, device_check, drivers
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


@pytest.mark.parametrize("kind", KINDS)
def test_deform(files, kind, capsys):
    options = ["--kind", kind, "--alpha", "1", "--degree", "1", "--smoothing", "0.5"]
    options += ["--background", "-2", "--device", "reference"]
    assert main(["deform", "in.vti", "handles.csv", "out.vti", *options]) == 0
    image, output = io.read_dataset("in.vti"), io.read_dataset("out.vti")
    map_options = {"alpha": 1, "degree": 1, "smoothing": 0.5}
    value = Deformation(REST, DEFORMED, kind, **map_options, device="reference")
    sampling = Sampling(ImageGeometry.of_image(image).grid, background=-2)
    (expected,) = value.resample([values_of(image, "values")], sampling)
    np.testing.assert_array_equal(values_of(output, "values"), expected)
    printed = capsys.readouterr()
    assert "out.vti: 9 x 8 x 7 points" in printed.out
    assert printed.err == ""


@pytest.mark.parametrize(("options", "tolerance"), [([], 0.02), (["--map-tolerance", "0"], 0)])
def test_the_editor_has_a_small_map_tolerance(files, options, tolerance, monkeypatch):
    states = []
    monkeypatch.setattr("vtk_mls.editor.window.show", lambda _, state, *more: states.append(state))
    assert main(["view", "in.vti", "handles.csv", "--window", *options, "--device", FAST]) == 0
    assert [state.map_tolerance for state in states] == [tolerance]


def test_deform_with_cuts_and_a_gradient(files):
    (files / "cut.stl").write_text(
        "solid cut\nfacet normal 1 0 0\nouter loop\nvertex 3.9 -50 2.6\nvertex 3.9 50 2.6\n"
        "vertex 3.9 4 90\nendloop\nendfacet\nendsolid cut\n"
    )
    options = ["--cut-plane", "4.3,0,0,1,0,0", "--cut-surface", "cut.stl", "--nu", "3"]
    options += ["--cut-half-plane", "0,4.2,3,0,1,0,0,0,1", "--gradient", "values"]
    options += ["--background", "0", "--device", "reference"]
    assert main(["deform", "in.vti", "handles.csv", "out.vti", *options]) == 0
    cuts = [
        Plane((4.3, 0, 0), (1, 0, 0)),
        HalfPlane((0, 4.2, 3), (0, 1, 0), (0, 0, 1)),
        Surface([(3.9, -50, 2.6), (3.9, 50, 2.6), (3.9, 4, 90)], [(0, 1, 2)]),
    ]
    image, output = io.read_dataset("in.vti"), io.read_dataset("out.vti")
    grid = ImageGeometry.of_image(image).grid
    value = Deformation(REST, DEFORMED, cuts=cuts, nu=3, device="reference")
    void = value.void(grid.points())
    assert void.any()
    np.testing.assert_array_equal(values_of(output, "Void").ravel(), void)
    expected = value.corrected_gradient(values_of(image, "values"), grid)
    np.testing.assert_allclose(values_of(output, "Gradient"), expected, atol=1e-4)


def test_void_and_overlapping_points_are_counted(files, capsys):
    options = ["--cut-plane", "4,3,3,1,-1,0", "--background", "0", "--device", FAST]
    for name, more in {"a.vti": [], "b.vti": ["--overlap"], "c.nii.gz": ["--overlap"]}.items():
        assert main(["deform", "in.vti", "handles.csv", name, *options, *more]) == 0
    grid = ImageGeometry.of_image(io.read_dataset("in.vti")).grid
    value = Deformation(REST, DEFORMED, cuts=Plane((4, 3, 3), (1, -1, 0)), device=FAST)
    void, overlap = value.void_field(grid), value.overlap_field(grid)
    assert void.any()
    assert overlap.any()
    np.testing.assert_array_equal(values_of(io.read_dataset("b.vti"), "Overlap"), overlap)
    notes = [line.split("rigid")[1] for line in capsys.readouterr().out.splitlines()]
    both = f"; void: {void.sum()}; overlap: {overlap.sum()}"
    assert notes == [f"; void: {void.sum()}", both, both]


@pytest.mark.parametrize(
    "cut", [["--cut-plane", "-.5,4,3,1,0,0"], ["--cut-half-plane", "-1,4,3,0,1,0,0,0,1"]]
)
def test_numbers_that_begin_with_a_minus_are_no_option(files, cut, capsys):
    outputs = []
    for name, options in {"a.vti": cut, "b.vti": ["=".join(cut)]}.items():
        arguments = ["deform", "in.vti", "handles.csv", name, "--device", FAST]
        assert main([*arguments, *options, "--background", "-1"]) == 0
        outputs.append(values_of(io.read_dataset(name), "VoidDistance"))
    np.testing.assert_array_equal(*outputs)
    with pytest.raises(SystemExit):
        main(["deform", "in.vti", "handles.csv", "a.vti", cut[0], "--alpha", "1"])
    assert "expected one argument" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({0: "none.vti"}, "there is no file `none.vti`"),
        ({1: "none.csv"}, "there is no file `none.csv`"),
        ({1: "in.vti"}, "cannot read control points from `in.vti`"),
        ({2: "out.png"}, "cannot write an image to `out.png`"),
        ({2: "none/out.vti"}, "there is no folder `none`"),
        ({3: "--alpha=0"}, "`alpha` must be a positive number, got 0.0"),
        ({3: "--smoothing=-1"}, "`smoothing` must be a number from 0 on, got -1.0"),
        ({3: "--degree=7"}, "`degree` must be 1, 2 or 3, got 7"),
        ({3: "--label=bone"}, "`LabelArrays` names `bone`"),
        ({3: "--cut-plane=1,2,3"}, "`--cut-plane` must be 6 numbers with commas, got `1,2,3`"),
        ({3: "--cut-half-plane=0,0,0,1,0,0,2,0,0"}, "`inward` must not be parallel"),
        ({3: "--cut-surface=none.stl"}, "there is no file `none.stl`"),
        ({3: "--cut-surface=in.vti"}, "cannot read a surface from `in.vti`"),
        ({3: "--gradient=bone"}, "`GradientArray` must name a point array"),
        ({3: "--device=77:0"}, "no OpenCL device `77:0`"),
        (
            {2: "out.nrrd", 3: "--gradient=values"},
            "`--gradient` adds an array, and only .vti, .vtk",
        ),
    ],
)
def test_errors_are_one_sentence(files, refused, change, sentence):
    arguments = ["in.vti", "handles.csv", "out.vti", "--background=0"]
    for position, argument in change.items():
        arguments[position] = argument
    assert refused("deform", *arguments).startswith(sentence)
    assert not Path("out.vti").exists()


@pytest.mark.parametrize("options", [["--interpolation=cubic"], ["--gradient=values"]])
def test_values_that_are_not_finite_are_no_matter_for_warnings(files, options):
    image = io.read_dataset("in.vti")
    values_of(image, "values").flat[::5] = np.inf
    values_of(image, "values").flat[::7] = -np.inf
    io.write_dataset(image, "in.vti")
    arguments = ["deform", "in.vti", "handles.csv", "out.vti", "--device", "reference", *options]
    status, _, err = run(*arguments)
    assert (status, err) == (0, "")


# To start ParaView takes seconds, and minutes where it finds new OpenCL devices.
NO_PARAVIEW = {"PATH": os.devnull}


@pytest.mark.parametrize("paraview", [NO_PARAVIEW, pytest.param({}, marks=pytest.mark.matrix)])
def test_info(paraview):
    status, out, err = run("info", VTK_MLS_DEVICE="reference", **paraview)
    assert (status, err) == (0, "")
    assert f"vtk_mls    {__version__}" in out
    assert f"numpy      {np.__version__}" in out
    for word in ("Python", "VTK", "pyopencl", "ParaView", "OpenCL devices"):
        assert word in out
    assert "vtk_mls_plugin.py" in out


def test_doctor_lists_problems():
    status, out, _ = run("doctor", VTK_MLS_DEVICE="77:0", **NO_PARAVIEW)
    assert status == 1
    assert "wrong: no OpenCL device `77:0`" in out


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize("cache", ["usual", pytest.param("empty", marks=pytest.mark.matrix)])
def test_doctor_shows_checked_devices(cache, tmp_path):
    folder = str(tmp_path if cache == "empty" else caches.folder())
    variables = {"XDG_CACHE_HOME": folder, **NO_PARAVIEW}
    status, out, err = run("doctor", VTK_MLS_DEVICE=DEVICES[0], **variables)
    assert status == 0
    assert ("Testing" in err) == (cache == "empty")
    assert f"-> {DEVICES[0]} " in out
    assert "computes right with" in out
    assert f"result kept in {folder}" in out
    assert "Testing" not in run("doctor", **variables)[2]
    if cache == "empty":
        assert "Testing" in run("doctor", "--retest", **variables)[2]


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
def test_doctor_checks_devices_again(monkeypatch):
    rechecks, results = [], device_check.results

    def record(devices, subjects=device_check.SUBJECTS, recheck=False):
        rechecks.append(recheck)
        return results(devices, subjects)

    monkeypatch.setattr(device_check, "results", record)
    monkeypatch.setenv("PATH", os.devnull)  # no ParaView
    main(["doctor", "--retest"])
    assert rechecks[0]  # the choice of a device follows


def test_paraview_is_not_started_for_nothing(monkeypatch, refused):
    monkeypatch.setattr("vtk_mls.paraview.installation.find", lambda folder: None)
    monkeypatch.delenv("QT_QPA_PLATFORM", raising=False)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert refused("paraview", "nope.vti") == "there is no file `nope.vti`"
    assert refused("paraview", ".") == "`.` is a folder; expected a file"
    if sys.platform == "linux":
        assert "there is no display" in refused("paraview")


def test_an_environment_for_paraview_has_no_vtk_and_is_not_wrong():
    code = WITHOUT.format(names=["vtkmodules", "vtk"])
    status, out, err = run("doctor", code=code, VTK_MLS_DEVICE="", **NO_PARAVIEW)
    assert (status, err) == (0, "")
    assert "wrong" not in out
    assert "VTK        not installed: ParaView brings its own" in out


def test_without_vtk_and_opencl(files):
    code = WITHOUT.format(names=["vtkmodules", "vtk", "pyopencl"])
    status, out, err = run("info", code=code, VTK_MLS_DEVICE="", **NO_PARAVIEW)
    assert (status, err) == (1, "")
    assert "VTK        not installed" in out
    assert "(pip install vtk)" in out
    assert f"pyopencl is not installed: {drivers.advice()}" in out
    status, out, err = run("deform", "in.vti", "handles.csv", "out.vti", code=code)
    assert (status, out) == (1, "")
    assert err == "vtk-mls: VTK is not installed: pip install vtk\n"
    code = WITHOUT.format(names=["pyopencl"])
    command = "deform", "in.vti", "handles.csv", "out.vti"
    status, _, err = run(*command, code=code, VTK_MLS_DEVICE="")
    assert status == 0
    assert "numpy is used, slowly: no OpenCL device that works: pyopencl cannot be imported" in err
    assert err.count("\n") == 1
    status, _, err = run(*command, "--device=cpu", code=code)
    assert status == 1
    assert err.startswith("vtk-mls: no OpenCL device `cpu`: pyopencl cannot be imported")
    assert err.count("\n") == 1


def test_the_demo_leaves_a_cut_brain(tmp_path, capsys, monkeypatch):
    pytest.importorskip("nilearn", reason="nilearn carries the brain")
    monkeypatch.delenv("VTK_MLS_DEVICE")  # numpy is too slow
    assert main(["demo", str(tmp_path / "demo")]) == 0
    names = {"brain.vti", "handles.vtp", "cut.vti", "cut.png"}
    assert {path.name for path in (tmp_path / "demo").iterdir()} == names
    brain, cut = (io.read_dataset(tmp_path / "demo" / f"{name}.vti") for name in ("brain", "cut"))
    assert brain.GetDimensions() == (197, 233, 189)
    assert brain.GetPointData().GetScalars().GetName() == "T1"
    void = arrays.to_numpy(cut.GetPointData().GetArray("Void"))
    assert 0.01 < void.mean() < 0.2
    assert "vtk-mls view" in capsys.readouterr().out


def test_usage(capsys):
    for arguments in ([], ["deform"], ["deform", "a", "b", "c", "--kind", "elastic"]):
        with pytest.raises(SystemExit, match="2"):
            main(arguments)
        assert "usage: vtk-mls" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out == f"vtk-mls {__version__}\n"
