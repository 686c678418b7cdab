"""The command and the script reproduce the saved files bit by bit."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import python, run
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh
from pipelines import picture_of

from vtk_mls import Ball, BallMask, Grid, HalfPlane, Labels, Plane, RegionHandle, Surface, io
from vtk_mls.commands.cli import main
from vtk_mls.editor import State
from vtk_mls.editor.matching.target import Target
from vtk_mls.files import control_point_files, session_files
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

POLYGON = Surface.polygon([(12, 2, 2), (MIDDLE, 21, 2), (MIDDLE, 21, 21), (MIDDLE, 2, 21)])
_MOTION = np.array([(0.8, -0.6, 0, 4), (0.6, 0.8, 0, -2), (0, 0, 1, 1), (0, 0, 0, 1.0)])
STATES = {
    "plain": {},
    "map": {"kind": "polynomial", "alpha": 1.7, "degree": 3, "blend": 0.7, "smoothing": 1.5},
    "plane": {"cuts": [Plane((MIDDLE,) * 3, (1, 0.2, 0.3))], "cut_frame": "deformed"},
    "shapes": {
        "handles": [
            RegionHandle(Ball((8, 8, 8), 2.5), _MOTION),
            RegionHandle(Ball((16, 15, 16), 2), np.eye(4)),
        ],
        "mask": BallMask((MIDDLE,) * 3, 7, 3),
        "blend": 0.8,
        "places": 2,
    },
    "cuts": {"cuts": [HalfPlane((MIDDLE,) * 3, (0.3, 1, 0.1), (0, 0, 1)), POLYGON], "nu": 3.3},
}
_REST = sorted(STATES.keys() - {"plane"})


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The folder of a test, in which the editor saves."""
    monkeypatch.chdir(tmp_path)


def state(rng, places=0, **options):
    """A State of 9 handles with some intermediate places."""
    rest = rng.uniform(2, SIZE - 3, (9, 3))
    weights = rng.uniform(0.5, 2, 9)
    path = rest + rng.normal(size=(places, *rest.shape))
    return State(rest, rest + rng.normal(size=rest.shape), weights, path=path, **options)


def commands_of(script):
    lines = [line.strip() for line in script.read_text().splitlines()]
    return [shlex.split(line)[1:] for line in lines if line.startswith("vtk-mls deform ")]


def assert_made_again(paths, monkeypatch):
    """The script beside files makes them again to the bit, and so do the commands in it."""
    before, script = [path.read_bytes() for path in paths], paths[0].with_name("deform.py")
    status, _, stderr = python(script)
    assert status == 0, stderr
    assert [path.read_bytes() for path in paths] == before
    monkeypatch.chdir(script.parent)
    for path in paths:
        path.unlink()
    for command in commands_of(script):
        assert run(*command)[::2] == (0, "")
    assert [path.read_bytes() for path in paths] == before


@pytest.mark.parametrize(
    "name",
    ["plane", *(pytest.param(name, marks=pytest.mark.matrix) for name in _REST)],
)
def test_command_and_script_make_the_same_files(name, tmp_path, monkeypatch):
    io.write_dataset(ball_image(), "ball.nii.gz")
    io.write_dataset(ball_mesh(), "ball.stl")
    paths = ["ball.nii.gz", "ball.stl"]
    data = [io.read_dataset(path) for path in paths]
    hands = Hands(data, state(np.random.default_rng(3), **STATES[name]), paths=paths)
    hands.press("s")
    folder = tmp_path / "ball-edited"
    assert f"Saved in {folder.name}" in hands.message
    deformed = sorted(folder.glob("ball-deformed.*"))
    assert len(deformed) == 2
    before = (folder / "displacement-field.nrrd").read_bytes()
    grid = ImageGeometry.of_image(data[0]).grid
    displacement = hands.state.deformation().displacement_field(grid).displacement
    field = io.read_dataset(folder / "displacement-field.nrrd").GetPointData().GetScalars()
    saved = arrays.to_numpy(field).reshape(displacement.shape)
    # a ball is saved as a surface of some thousand triangles
    np.testing.assert_allclose(saved, displacement, atol=0.05 if name == "shapes" else 1e-5)

    assert_made_again(deformed, monkeypatch)
    options = [word for word in commands_of(folder / "deform.py")[0] if word.startswith("--")]
    handles = "handles.vtp" if name == "shapes" else "handles.csv"
    status, _, stderr = run("field", "../ball.nii.gz", handles, "field.nrrd", *options)
    assert status == 0, stderr
    assert (folder / "field.nrrd").read_bytes() == before


def test_a_picture_on_a_full_disk_leaves_the_old_one(tmp_path, monkeypatch):
    hands = Hands(ball_mesh(), state(np.random.default_rng(3)))
    (tmp_path / "data-1-edited").mkdir()
    hands.editor.saver.folder = tmp_path / "data-1-edited"
    (tmp_path / "data-1-edited" / "picture.png").write_bytes(b"the old one")

    def fails(path, content):
        with open(path, "wb") as file:
            file.write(bytes(content)[:100])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fails)
    hands.press("s")
    assert "picture.png` could not be written: No space left on device" in hands.message
    files = {path.name: path.read_bytes() for path in (tmp_path / "data-1-edited").iterdir()}
    assert files == {"picture.png": b"the old one"}


def test_handles_are_saved_for_slicer_and_for_the_next_edit(tmp_path):
    hands = Hands(ball_mesh(), state(np.random.default_rng(4)))
    hands.press("s")
    edited, folder = hands.state, tmp_path / "data-1-edited"
    for names in (
        ("handles.csv", None),
        ("handles-at-rest.mrk.json", "handles-moved.mrk.json"),
    ):
        paths = [folder / name if name else None for name in names]
        rest, deformed, weights, *_ = control_point_files.read_pairs(*paths)
        np.testing.assert_array_equal(rest, edited.rest)
        np.testing.assert_array_equal(deformed, edited.deformed)
    assert weights is None
    assert (folder / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_a_segmentation_is_saved_as_one(tmp_path):
    path = "ball.seg.nrrd"
    io.write_dataset(ball_image(), path)
    hands = Hands(io.read_dataset(path), state(np.random.default_rng(5)), paths=[path])
    hands.press("s")
    assert (tmp_path / "ball-edited/ball-deformed.seg.nrrd").exists()


def test_without_handles_the_data_are_saved_as_they_are(tmp_path):
    path = "ball.vti"
    io.write_dataset(ball_image(), path)
    hands = Hands(io.read_dataset(path), paths=[path])
    hands.press("a", "Ctrl")
    hands.press("x")
    hands.press("s")
    assert len(hands.state.grips) == 0
    saved = io.read_dataset("ball-edited/ball-deformed.vti").GetPointData().GetScalars()
    before = io.read_dataset(path).GetPointData().GetScalars()
    np.testing.assert_array_equal(arrays.to_numpy(saved), arrays.to_numpy(before))


def test_overlapping_bones_have_the_names_of_the_editor(tmp_path):
    """The surface of a cavity is a region in the saved file only."""
    grid = Grid((12,) * 3, spacing=(2, 2, 2))
    hollow, full = (
        np.linalg.norm(grid.points() - center, axis=1).reshape(grid.shape)
        for center in ((7, 12, 12), (18, 12, 12))
    )
    bones = Labels((hollow < 7) & (hollow > 2.5), grid), Labels(full < 4, grid)
    pushed = np.eye(4)
    pushed[0, 3] = -5
    handles = RegionHandle(bones[0], np.eye(4)), RegionHandle(bones[1], pushed)
    hands = Hands(ball_mesh(), State([], [], handles=handles))
    hands.press("s")
    expected = "Rigid regions overlap where they were moved to: rigid 1 and rigid 2."
    assert hands.message.endswith(f"session. {expected}")


def test_data_of_the_same_name_have_separate_files(tmp_path, monkeypatch):
    paths = [f"{folder}/ball.vtp" for folder in "abc"]
    for number, path in enumerate(paths):
        (tmp_path / path).parent.mkdir()
        mesh = ball_mesh()
        mesh.GetPoints().SetPoint(0, 0, 0, number)
        io.write_dataset(mesh, path)
    hands = Hands([*map(io.read_dataset, paths)], state(np.random.default_rng(5)), paths=paths)
    hands.press("s")
    folder = tmp_path / "ball-edited"
    deformed = [folder / f"ball-deformed{number}.vtp" for number in ("", "-2", "-3")]
    assert len({path.read_bytes() for path in deformed}) == 3
    assert_made_again(deformed, monkeypatch)


def test_a_second_save_replaces_the_first_and_another_session_takes_a_new_folder(tmp_path):
    hands = Hands(ball_mesh())
    hands.press("s")
    hands.press("s")
    assert [path.name for path in tmp_path.iterdir()] == ["data-1-edited"]
    other = Hands(ball_mesh())
    other.press("s")
    assert (tmp_path / "data-1-edited-2").is_dir()


@pytest.mark.parametrize("has_files", [True, False])
def test_a_save_has_a_session_that_opens_again(has_files, tmp_path, monkeypatch):
    """Also of landmarks that are left out, and of data without a file."""
    if has_files:
        io.write_dataset(ball_mesh(), "ball.vtp")
    paths, rng = ["ball.vtp"] * has_files, np.random.default_rng(3)
    hands = Hands(ball_mesh(), state(rng).with_enabled([4], False), paths=paths)
    hands.editor.saver.folder = tmp_path / "edited"
    assert hands.editor.document.is_saved
    hands.press("k")
    assert not hands.editor.document.is_saved
    hands.press("s")
    assert hands.editor.document.is_saved
    assert len(control_point_files.read_pairs(tmp_path / "edited" / "handles.csv")[0]) == 8
    shown = []
    monkeypatch.setattr("vtk_mls.editor.window.show", lambda *arguments: shown.append(arguments))
    assert main(["view", "edited", "--window"]) == 0
    [(datasets, saved, _, output, target, (path, _))] = shown
    assert datasets[0].GetNumberOfPoints() == ball_mesh().GetNumberOfPoints()
    assert np.flatnonzero(~saved.enabled).tolist() == [4]
    assert (saved.kind, target) == (hands.state.kind, None)
    np.testing.assert_array_equal(saved.rest, hands.state.rest)
    assert (output, Path(path)) == ("edited", Path("edited/session.mls.json"))


def test_a_session_file_as_output_has_a_folder_of_its_name_beside_it(tmp_path):
    hands = Hands(ball_mesh(), state(np.random.default_rng(3)))
    hands.editor.saver.set_output("case/ball.mls.json")
    hands.press("s")
    assert session_files.read("case/ball.mls.json").data == (tmp_path / "case/data-1.vtp",)
    assert (tmp_path / "case/ball/displacement-field.nrrd").exists()


@pytest.mark.parametrize("uses_target_grid", [True, False])
def test_images_are_saved_on_the_grid_of_the_target(uses_target_grid, tmp_path, monkeypatch):
    fine = ImageGeometry((0, 46, 0, 46, 0, 30), (0.5, 0, 1), (0.5, 0.5, 0.5))
    for name, image in (("ball.nii.gz", ball_image()), ("target.nii.gz", ball_image(fine))):
        io.write_dataset(image, name)
    paths = ["ball.nii.gz"]
    hands = Hands(
        [io.read_dataset("ball.nii.gz"), ball_mesh()],
        state(np.random.default_rng(3)),
        paths=paths,
        target=Target(io.read_dataset("target.nii.gz"), "target.nii.gz"),
    )
    hands.editor.saver.uses_target_grid = uses_target_grid
    hands.press("s")
    folder = tmp_path / "ball-edited"
    expected = (47, 47, 31) if uses_target_grid else (SIZE,) * 3
    for name in ("ball-deformed.nii.gz", "displacement-field.nrrd"):
        assert io.read_dataset(folder / name).GetDimensions() == expected
    assert ("on the grid of target.nii.gz" in hands.message) == uses_target_grid
    assert_made_again([folder / "ball-deformed.nii.gz"], monkeypatch)


def test_a_stopped_save_leaves_no_files(tmp_path):
    hands = Hands(ball_image(), state(np.random.default_rng(3)))
    hands.editor.saver.progress = lambda done: done > 0.6
    hands.press("s")
    assert hands.message == "Saving was stopped; no file has changed."
    assert [*tmp_path.iterdir()] == []
    hands.editor.saver.progress = None
    hands.press("s")
    folder = tmp_path / "data-1-edited"
    before = {path: path.read_bytes() for path in folder.iterdir()}
    hands.press("k")
    hands.editor.saver.progress = lambda done: done > 0.6
    hands.press("s")
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
    assert not hands.editor.document.is_saved


def test_a_field_says_that_it_fills_the_gap_of_a_cut(tmp_path):
    rest = np.array([(4.0, 12, 12), (19, 12, 12), (4, 4, 4), (19, 20, 19)])
    moved = rest + 3 * np.sign(rest[:, :1] - MIDDLE) * np.array([(1, 0, 0)])
    cut = Plane((MIDDLE,) * 3, (1, 0, 0))
    hands = Hands(ball_image(), State(rest, moved, cuts=[cut]))
    hands.press("s")
    sentence = "`displacement-field.nrrd` fills the gap that a cut has opened"
    assert sentence in hands.message
    assert sentence in (tmp_path / "data-1-edited" / "deform.py").read_text()


def test_the_window_shows_that_it_saves(tmp_path):
    hands, counts = Hands(ball_mesh()), []

    def amber_pixels():
        picture = picture_of(hands.editor.scene.window)
        return int(((picture - (255, 199, 89))[:60] < 40).all(axis=2).sum())

    hands.editor.saver.progress = lambda done: counts.append(amber_pixels())
    hands.press("s")
    assert min(counts) > 20


def test_a_failed_save_is_reported(tmp_path):
    (tmp_path / "data-1-edited").write_text("a file")
    hands = Hands(ball_mesh())
    hands.editor.saver.folder = tmp_path / "data-1-edited"
    hands.press("s")
    assert "data-1-edited" in hands.message.replace(" ", "")  # lines break within paths, too
    assert not hands.editor.save()
    hands.press("a", "Ctrl")
    hands.press("x")
    hands.editor.saver.folder = tmp_path / "none"
    assert hands.editor.save()
    names = {path.name for path in (tmp_path / "none").iterdir()}
    assert names >= {"data-1.vtp", "data-1-deformed.vtp", "session.mls.json"}
