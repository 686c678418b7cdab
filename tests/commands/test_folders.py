"""A folder in place of a file, and a file in place of a folder, end in one sentence."""

from pathlib import Path

import pytest
from vtk_fixtures import polydata_of

from vtk_mls import io
from vtk_mls.files.paths import check_folder, existing_file

ARGUMENTS = {
    "deform": ["in.vti", "handles.csv", "out.vti"],
    "field": ["in.vti", "handles.csv", "out.nrrd"],
    "points": ["in.csv", "handles.csv", "out.csv"],
    "view": ["in.vti", "handles.csv"],
}
READ = [
    *((command, position) for command in ARGUMENTS for position in (0, 1)),
    *((command, option) for command in ARGUMENTS for option in ("--deformed", "--cut-surface")),
    ("view", "--with"),
    ("deform", "series"),
]
WRITTEN = ["deform", "field", "points", "deform a mesh", "deform a series"]


@pytest.fixture
def folders(files):
    """The folder with what commands read, and folders of many names."""
    Path("in.csv").write_text("x,y,z\n1,2,3\n")
    for name in ("dir", "dir.vti", "dir.csv", "dir.stl", "dir.vtp", "dir.nrrd", "dir.pvd"):
        Path(name).mkdir()
    triangle = polydata_of([(0, 0, 0), (9, 0, 0), (0, 9, 0)], Polys=[range(3)])
    io.write_dataset(triangle, "mesh.vtp")
    return files


@pytest.mark.parametrize(("command", "argument"), READ)
@pytest.mark.parametrize(
    "name", ["dir", "dir.vti", "dir.csv", "dir.stl", "dir.vtp", ".", "..", "/"]
)
def test_a_folder_is_no_file_to_read(folders, command, argument, name, refused):
    arguments = [command, *ARGUMENTS[command]]
    if argument == "series":
        arguments[1], name = "dir.pvd", "dir.pvd"
    elif isinstance(argument, int):
        arguments[1 + argument] = name
    else:
        arguments += [argument, name]
    assert f"`{name}` is a folder; expected a file" in refused(*arguments)


@pytest.mark.parametrize("position", range(3))
def test_an_empty_name_is_no_file(folders, position, refused):
    arguments = ["deform", *ARGUMENTS["deform"]]
    arguments[1 + position] = ""
    assert refused(*arguments).startswith("no file is named")


def _writing(command, output):
    name, *_ = command.split()
    source, handles, _ = ARGUMENTS[name]
    source = {"deform a mesh": "mesh.vtp"}.get(command, source)
    return [name, source, handles, output]


ENDINGS = {"deform": ".vti", "field": ".nrrd", "points": ".csv", "deform a mesh": ".vtp"}


@pytest.mark.parametrize("command", WRITTEN)
def test_outputs_that_cannot_be(folders, command, refused):
    suffix = ENDINGS.get(command, ".pvd")
    before = sorted(folders.rglob("*"))
    for output, sentence in {
        f"dir{suffix}": f"`dir{suffix}` is a folder; expected the name of a file to write",
        **{name: f"`{name}` is a folder; expected" for name in ("dir", ".", "..", "/")},
        f"none/out{suffix}": f"there is no folder `none` to write `out{suffix}` in",
        f"in.vti/out{suffix}": f"`in.vti` is a file; expected a folder to write `out{suffix}` in",
    }.items():
        assert sentence in refused(*_writing(command, output))
    assert sorted(folders.rglob("*")) == before


@pytest.mark.parametrize("command", ["deform", "deform a mesh"])
def test_outputs_are_looked_at_before_the_work(folders, command, refused, monkeypatch):
    monkeypatch.setattr("vtk_mls.commands.deform.update", lambda *_: pytest.fail("worked"))
    output = f"none/out{ENDINGS[command]}"
    assert "there is no folder `none`" in refused(*_writing(command, output))


def test_a_file_is_no_folder(folders, refused):
    for name in ("in.vti", "in.vti/there"):
        for words in (["view", "in.vti", "--output", name], ["demo", name]):
            assert refused(*words) == "`in.vti` is a file; expected a folder"


def test_files_by_their_names(folders):
    assert existing_file("in.vti") == Path("in.vti")
    with pytest.raises(FileNotFoundError, match="no file is named, got an empty name"):
        existing_file("")
    with pytest.raises(IsADirectoryError, match="`dir` is a folder; expected a file"):
        io.read_dataset("dir")
    with pytest.raises(FileNotFoundError, match="there is no file `in.vti/x.vti`"):
        io.read_dataset("in.vti/x.vti")
    with pytest.raises(OSError, match="`/dev/null` is not a regular file"):
        existing_file("/dev/null")
    check_folder("dir")
    check_folder("new/folder")
