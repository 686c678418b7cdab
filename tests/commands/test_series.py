"""Time series go through `vtk-mls deform` as a whole."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import AT, run, write_collection, write_moving
from mesh_fixtures import grid_of
from pipelines import Source
from vtk_fixtures import DEFORMED, REST, add_scalars, make_image
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import VTK_TETRA
from vtkmodules.vtkIOHDF import vtkHDFWriter

from vtk_mls import Deformation, io
from vtk_mls.commands import series
from vtk_mls.commands.cli import main
from vtk_mls.files.block_files import blocks
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

pytestmark = pytest.mark.usefixtures("folder")
TIMES = (0.5, 2.0, 10.0)


def places(time):
    return np.arange(12.0).reshape(4, 3) % 5 + 0.1 * time


def mesh(time):
    """A tetrahedron whose points move with time."""
    return grid_of(places(time), [(VTK_TETRA, range(4))])


def moved(time):
    return Deformation(REST, DEFORMED, device="reference").forward(places(time))


def points_of(dataset):
    return arrays.to_numpy(dataset.GetPoints().GetData())


def write_steps(names, make=mesh):
    for name, time in zip(names, TIMES):
        io.write_dataset(make(time), name)
    return names


def write_input(how):
    """The input of a series of `mesh` at TIMES."""
    if how == ".pvd":
        names = write_steps(["b.vtu", "a.vtu", "c.vtu"])
        return write_collection([(10, "c.vtu"), (0.5, "b.vtu"), (2.0, names[1])])
    if how == ".series":
        names = write_steps(["1.vtu", "2.vtu", "3.vtu"])
        files = [{"name": name, "time": time} for name, time in zip(names, TIMES)]
        Path("in.vtu.series").write_text(json.dumps({"files": files}))
        return "in.vtu.series"
    if how == "pattern":
        write_steps(["step_8.vtu", "step_9.vtu", "step_10.vtu"])
        return "step_*.vtu"

    def at_time(output, time):
        output.ShallowCopy(mesh(time))

    source = Source(at_time, TIMES, None, "vtkUnstructuredGrid")
    writer = configured(vtkHDFWriter(), FileName="in.vtkhdf", WriteAllTimeSteps=True)
    assert configured(writer, InputConnection=source.GetOutputPort()).Write()
    return "in.vtkhdf"


def deform(name, output="out.pvd", *options):
    return main(["deform", name, "handles.csv", output, *options])


@pytest.mark.parametrize("how", [".pvd", ".series", "pattern", ".vtkhdf"])
def test_every_time_step_is_deformed(folder, how, capsys):
    assert deform(write_input(how)) == 0
    assert "out.pvd: 3 time steps, rigid" in capsys.readouterr().out
    steps = series.read_steps("out.pvd")
    expected = (0.0, 1.0, 2.0) if how == "pattern" else TIMES
    assert tuple(time for time, _ in steps) == expected
    for (_, read), time in zip(steps, TIMES):
        np.testing.assert_allclose(points_of(read()), moved(time), atol=1e-5)
    names = ["out_0000.vtu", "out_0001.vtu", "out_0002.vtu"]
    assert sorted(path.name for path in (folder / "out").iterdir()) == names
    assert np.abs(moved(0.5) - places(0.5)).max() > 0.1
    assert np.abs(moved(0.5) - moved(10)).max() > 0.1


def constant_at(time, vtk_type=None):
    return add_scalars(make_image(), "values", np.full(504, time), vtk_type)


def test_a_series_of_images_and_of_blocks(capsys):
    write_steps(["1.vti", "2.vti", "3.vti"], constant_at)
    assert deform("?.vti") == 0
    values = [
        arrays.to_numpy(read().GetPointData().GetArray("values")).max()
        for _, read in series.read_steps("out.pvd")
    ]
    np.testing.assert_allclose(values, TIMES)
    write_steps(["1.vtu", "2.vtu", "3.vtu"])
    write_collection([(0, "1.vtu"), (0, "2.vti"), (1, "3.vtu")])
    assert deform("in.pvd") == 0
    (first, read_blocks), (second, read_mesh) = series.read_steps("out.pvd")
    assert (first, second) == (0, 1)
    assert [block.GetClassName() for block in blocks(read_blocks())] == [
        "vtkUnstructuredGrid",
        "vtkImageData",
    ]
    np.testing.assert_allclose(points_of(read_mesh()), moved(TIMES[2]), atol=1e-5)


def test_what_holds_for_all_time_steps_is_reported_once(caplog):
    write_steps(["1.vti", "2.vti", "3.vti"], lambda time: constant_at(time, VTK_UNSIGNED_CHAR))
    assert deform("?.vti", "out.pvd", "--background", "300") == 0
    assert [record.getMessage()[:12] for record in caplog.records] == ["`background`"]


def test_one_time_step_fits_into_any_file():
    write_steps(["1.vtu"])
    assert deform(write_collection([(7, "1.vtu")]), "out.vtu") == 0
    np.testing.assert_allclose(points_of(io.read_dataset("out.vtu")), moved(TIMES[0]), atol=1e-5)
    assert deform("1.vtu", "out.pvd") == 0
    assert [time for time, _ in series.read_steps("out.pvd")] == [0]


def test_progress_goes_over_the_whole_series(capsys):
    assert deform(write_input("pattern"), "out.pvd", "--progress") == 0
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    percents = [int(bar.rpartition("]")[2].strip(" %\n")) for bar in printed.split("\r")[1:]]
    assert percents == sorted(percents)
    assert percents[-1] == 100


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "`in.pvd` is not a time series: it is not XML"),
        ("<VTKFile/>", "`in.pvd` is not a time series: it is not a ParaView collection"),
        ('<VTKFile type="Collection"/>', "`in.pvd` is not a time series: it names no files"),
        ("nan.vtu", "`in.pvd` is not a time series: its times must be finite"),
        ("none.vtu", "`in.pvd` is not a time series: there is no data file"),
        ("../1.vtu", "`in.pvd` is not a time series: its data file `../1.vtu` is not in its own"),
        ("in.pvd", "cannot read an image or a mesh from `in.pvd`"),
        ("broken.vtu", "`broken.vtu`"),
    ],
)
def test_errors_are_one_sentence_and_leave_nothing(folder, refused, text, sentence):
    write_steps(["1.vtu"])
    Path("broken.vtu").write_text("<VTKFile")
    if text.endswith((".vtu", ".pvd")):
        time = "nan" if text == "nan.vtu" else "1"
        write_collection([(0, "1.vtu"), (time, text)])
    else:
        Path("in.pvd").write_text(text)
    Path("out.pvd").write_text("the old one")
    before = sorted(folder.rglob("*"))
    assert sentence in refused("deform", "in.pvd", "handles.csv", "out.pvd")
    assert sorted(folder.rglob("*")) == before
    assert Path("out.pvd").read_text() == "the old one"


@pytest.mark.parametrize("text", ["[]", "{", '{"files": 3}', '{"files": [{}]}', "[" * 100000])
def test_bad_file_series(text):
    Path("in.series").write_text(text)
    with pytest.raises(ValueError, match=r"`in\.series` is not a time series: "):
        series.read_steps("in.series")


def test_a_file_in_the_place_of_the_folder(refused):
    Path("out").write_text("mine")
    error = refused("deform", write_input("pattern"), "handles.csv", "out.pvd")
    assert error.startswith("`out.pvd` cannot be written: ")
    assert Path("out").read_text() == "mine"


def test_a_full_disk_is_reported_for_the_series(disk):
    write_steps(["1.vtu"])
    disk(100)
    with (
        pytest.raises(OSError, match=r"^`out\.pvd` could not be written: (No space|File too)"),
        series.writing("out.pvd", (0.0,)) as write,
    ):
        write(mesh(1))
    assert not list(Path().glob("*out*"))


@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGSEGV", 1)])
def test_what_a_killed_series_leaves(folder, name, status):
    """The second step is being read then; the first is written, for the time being."""
    write_input("pattern")
    before = sorted(folder.rglob("*"))
    target = "os.getppid()" if name == "SIGINT" else "os.getpid()"
    code = f"os.kill({target}, signal.{name}); forever()"
    stop = """
from vtk_mls.commands import series
usual = series.io.read_dataset
series.io.read_dataset = lambda path: meet() if "9" in str(path) else usual(path)
# here"""
    child = AT.format(place="nothing", code=code).replace("# here", stop)
    arguments = ["deform", "step_*.vtu", "handles.csv", "out.pvd"]
    assert run(*arguments, child=child)[0] == status
    assert sorted(folder.rglob("*")) == before


# Handles that move in time


MOVES = (0.0, 1.0, 2.5)  # of the second handle, at HANDLE_TIMES
HANDLE_TIMES = (0.0, 2.0, 5.0)


def handles_at(move):
    return REST, REST + np.outer(np.arange(len(REST)) == 1, (0, move, 0))


def moving_handles(how):
    """Handles at HANDLE_TIMES, as a table or a collection of files."""
    if how == "table":
        rows = [
            [time, *p, *q]
            for time, move in zip(HANDLE_TIMES[::-1], MOVES[::-1])
            for p, q in zip(*handles_at(move))
        ]
        return write_moving("moving.csv", rows)
    for number, move in enumerate(MOVES):
        rest, deformed = handles_at(move)
        io.write_handles(f"h{number}.vtp", rest, deformed)
    entries = [(t, f"h{number}.vtp") for number, t in enumerate(HANDLE_TIMES)]
    return write_collection(entries, "h.pvd")


def image_at(time):
    return add_scalars(make_image(), "values", np.arange(504) * (1 + time))


def test_still_data_at_the_times_of_handles(capsys):
    io.write_dataset(mesh(0), "in.vtu")
    for how in ("table", "collection"):
        assert main(["deform", "in.vtu", moving_handles(how), "out.pvd"]) == 0
        assert "3 time steps, rigid, handles at 3 times" in capsys.readouterr().out
        steps = series.read_steps("out.pvd")
        assert tuple(time for time, _ in steps) == HANDLE_TIMES
        for (_, read), move in zip(steps, MOVES):
            d = Deformation(*handles_at(move), device="reference")
            np.testing.assert_allclose(points_of(read()), d.forward(places(0)), atol=1e-5)


def test_pairs_of_two_files_in_time_take_a_spline(capsys):
    io.write_dataset(mesh(0), "in.vtu")
    for name, step in (("p.csv", 0), ("q.csv", 1)):
        rows = [",".join(map(str, (t, *np.add(p, t * step)))) for t in (0, 1) for p in REST]
        Path(name).write_text("\n".join(["time,x,y,z", *rows]))
    assert main(["deform", "in.vtu", "p.csv", "--deformed=q.csv", "out.pvd"]) == 0
    assert "2 time steps, spline of order" in capsys.readouterr().out


def test_data_in_time_take_the_last_handles_before(capsys):
    """The same bytes as each step deformed by the handles of one time."""
    write_steps(["1.mha", "2.mha", "3.mha"], image_at)
    write_collection([(1.0, "1.mha"), (2.0, "2.mha"), (3.0, "3.mha")])
    arguments = ["--allow-identity", "--background", "0"]
    assert main(["deform", "in.pvd", moving_handles("collection"), "out.mha", *arguments]) == 0
    found = [read() for _, read in series.read_steps("out.mha")]
    for number, handles in enumerate((0, 1, 1)):
        assert main(["deform", f"{number + 1}.mha", f"h{handles}.vtp", "one.mha", *arguments]) == 0
        one = arrays.to_numpy(io.read_dataset("one.mha").GetPointData().GetScalars())
        scalars = arrays.to_numpy(found[number].GetPointData().GetScalars())
        np.testing.assert_array_equal(scalars, one)
    assert (scalars != arrays.to_numpy(image_at(10).GetPointData().GetScalars())).any()


@pytest.mark.parametrize("command", ["field", "points", "view"])
def test_other_commands_take_handles_of_one_time(command, refused):
    io.write_dataset(image_at(0), "in.vti")
    for how in ("table", "collection"):
        name = moving_handles(how)
        Path("p.csv").write_text("x,y,z\n1,2,3\n")
        source = "p.csv" if command == "points" else "in.vti"
        output = {"field": ["f.nrrd"], "points": ["o.csv"], "view": []}[command]
        assert "control points at 3 times" in refused(command, source, name, *output)


def test_moving_handles_that_cannot_be(refused):
    io.write_dataset(image_at(0), "in.vti")
    name = moving_handles("table")
    error = refused("deform", "in.vti", name, "out.vti")
    assert error.startswith("`moving.csv` has 3 time steps, which only these files")
    rows = [[t, *p, *p] for t in (0, 1) for p in REST]
    error = refused("deform", "in.vti", write_moving("still.csv", rows), "out.pvd")
    assert "are at rest (p = q) at all 2 times" in error
    text = Path("moving.csv").read_text().replace("\n5,", "\nnan,", 1)
    Path("broken.csv").write_text(text)
    assert "its time must be finite" in refused("deform", "in.vti", "broken.csv", "out.pvd")
