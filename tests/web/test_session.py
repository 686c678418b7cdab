"""The session of a page, without a page; pairs of landmarks, and stopped saves."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from command_fixtures import python
from vtk_fixtures import scalar_image
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import Grid, io
from vtk_mls.editor import State, time_steps
from vtk_mls.editor.matching.target import Comparison, Target
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import output_of
from vtk_mls.web import edits, panel_values
from vtk_mls.web.picture import Picture
from vtk_mls.web.session import Session


class Panel:
    """Values of the panel; raises `error` once."""

    def __init__(self):
        self.values, self.error = {}, None

    def __call__(self, changed):
        error, self.error = self.error, None
        if error is not None:
            raise error
        self.values.update(changed)


def ball_mesh():
    return output_of(vtkSphereSource())


def opened(*data, paths=("ball.vtp",)):
    session = Session(Panel())
    session.call(lambda: session.open(list(data), State([], []), paths, None)).result()
    return session


def do(session, name, value=None):
    session.call(lambda: edits.apply(session, name, value)).result()
    return session._on_change.values


@pytest.mark.parametrize(("scale", "away"), [(1, 0), (1e-9, 0), (1, 5e5), (300, -40)])
def test_the_table_has_enough_decimals_to_distinguish_handles(scale, away):
    rest = away + scale * np.array([(0, 0, 1e-17), (1 / 3, -1e-16, 1), (0.125, 0.5, 2 / 3)])
    rows = panel_values.values_of(_Editor(State(rest, rest)), {})["rows"]
    at = np.array([row["at"] for row in rows])
    np.testing.assert_allclose(at, rest, atol=1e-5 * scale)
    assert max(len(repr(number)) for number in at.ravel().tolist()) < 13
    assert "e" not in repr(at.tolist()) or scale < 1


class _Editor:
    """The part of an editor that the handle table needs."""

    message = offer = status = ""
    is_drawing_curve, target, comparison = False, None, Comparison()
    slices = SimpleNamespace(pane="3-D")
    selected = np.zeros(0, int)
    document = SimpleNamespace(grabbed=None, is_saved=True)
    saver = SimpleNamespace(uses_target_grid=True, datasets=[ball_mesh()], times=(), step=0)
    view = SimpleNamespace(distortion=SimpleNamespace(mode=0, has_colors=False), preset=0)
    scene = SimpleNamespace(items=[SimpleNamespace(preset_names=["plain"])], flat_axis=None)

    def __init__(self, state):
        self.state = state


def test_the_thread_survives_a_failure_and_reports_it():
    session = opened(ball_mesh())
    failed = []

    def idle():
        session.on_idle = lambda: None
        failed.append(True)
        raise OSError("there is no memory for a frame")

    session.on_idle = idle
    for _ in range(1000):
        session.call(lambda: None).result()
        if failed and "frame" in session._on_change.values["message"]:
            break
    assert session._thread.is_alive()
    assert session._on_change.values["message"].endswith(
        "(there is no memory for a frame): reload it."
    )
    assert len(do(session, "lay_lattice")["rows"]) == 64


def test_a_failed_update_of_the_panel_is_repeated():
    session = opened(ball_mesh())
    session._on_change.error = RuntimeError("the loop is busy")
    with pytest.raises(RuntimeError, match="the loop is busy"):
        do(session, "lay_lattice")
    assert len(do(session, "say", "x")["rows"]) == 64


def test_numbers_without_a_slider_are_typed():
    session = opened(ball_mesh())
    assert do(session, "smoothing", " 0.25 ")["smoothing"] == 0.25
    assert session.editor.state.smoothing == 0.25
    for value in ("-2", "much", "nan", "inf", None):
        message = do(session, "smoothing", value)["message"]
        assert message == "`smoothing` must be a number from 0 on."
    assert session.editor.state.smoothing == 0.25
    assert do(session, "undo")["smoothing"] == 0
    do(session, "map_tolerance", 0.5)  # the page has no control for it
    assert session.editor.state.map_tolerance == 0.02


def test_invalid_data_leave_the_session_unchanged():
    session = opened(ball_mesh())
    do(session, "lay_lattice")
    image, before = vtkImageData(), session.editor
    image.SetDimensions(3, 3, 3)
    arrays.add(image.GetCellData(), "of cells", np.arange(8.0))
    future = session.call(lambda: session.open([image], State([], []), ["cells.vti"], None))
    with pytest.raises(ValueError, match="no values at its points"):
        future.result()
    assert session.editor is before
    assert len(do(session, "undo")["rows"]) == 27
    assert "nothing" not in session._on_change.values["message"]
    session.call(lambda: session.open([ball_mesh()], State([], []), ["x.vtp"], None)).result()
    assert session.editor is not before
    assert len(do(session, "lay_lattice")["rows"]) == 64


def test_shapes_names_and_numbers_by_the_panel():
    session = opened(ball_mesh())
    do(session, "select", [4])
    assert do(session, "name", [4, " tip "])["rows"][4]["name"] == "tip"
    row = do(session, "position", [4, "1", "2", "3"])["rows"][4]
    assert (row["at"], row["is_point"]) == ([1, 2, 3], True)
    assert do(session, "rest", [4, 0, 0, 0.5])["rows"][4]["rest"] == [0, 0, 0.5]
    values = do(session, "turn_handle")
    assert values["rows"][26]["name"] == "rigid 1"
    assert values["selected"] == [26]
    assert "that can be changed" in do(session, "rest", [26, 0, 0, 0])["message"]
    assert "Only point handles" in do(session, "name", [26, "jaw"])["message"]
    values = do(session, "change_mask")
    assert values["has_mask"]
    assert [row["name"] for row in values["rows"][27:]] == ["mask", "mask radius", "mask fall-off"]
    assert do(session, "draw_curve")["is_drawing"]
    values = do(session, "draw_curve")
    assert not values["is_drawing"]
    assert not values["has_curve"]
    for _ in range(5):
        do(session, "undo")
    values = session._on_change.values
    assert (values["has_mask"], len(values["rows"]), values["rows"][4]["name"]) == (False, 27, "5")


def test_a_closed_page_releases_the_mouse():
    session = opened(ball_mesh())
    picture = Picture(session)
    width, height = session.window.GetSize()

    def send(kind, by=0, **more):
        editor = session.editor
        position = editor.document.committed.deformed[[13]]
        x, y = editor.scene.projection.pixels(position)[0, :2]
        at = {"x": (x + by) / (width - 1), "y": 1 - y / (height - 1)}
        session.call(lambda: session.send({"type": kind, **at, **more})).result()

    send("move")
    send("down", button=0)
    send("move", by=40)
    assert session.editor.document.grabbed == 13
    picture._release_buttons()
    session.call(lambda: None).result()
    assert session.editor.document.grabbed is None
    assert not session.editor.document.committed.is_resting[13]
    moved = session.editor.state
    send("move", by=80)
    assert session.editor.state is moved
    # the camera neither, when the press was beside handles
    camera = session.editor.scene.renderer.GetActiveCamera()
    session.call(lambda: session.send({"type": "down", "x": 0, "y": 0, "button": 0})).result()
    picture._release_buttons()
    session.call(lambda: None).result()
    position = camera.GetPosition()
    session.call(lambda: session.send({"type": "move", "x": 0.4, "y": 0.2})).result()
    assert camera.GetPosition() == position


@pytest.mark.parametrize("pane", ["3-D", "axial"])
def test_two_fingers_zoom_and_show_the_same_place_again(pane):
    session = opened(ball_mesh())
    do(session, "pane", pane)
    slices, camera = session.editor.slices, session.editor.scene.renderer.GetActiveCamera()

    def zoom(x, step, factor):
        event = {"type": "zoom", "x": x, "y": x, "dx": step, "dy": step, "factor": factor}
        session.call(lambda: session.send(event)).result()
        return [slices.zoom, *slices.center, *camera.GetPosition(), *camera.GetFocalPoint()]

    before = zoom(0.5, 0, 1.0)
    assert zoom(0.4, 0.1, 1.7) != pytest.approx(before, abs=0.02)
    assert zoom(0.5, -0.1, 1 / 1.7) == pytest.approx(before, abs=0.02)


def test_slices_have_the_preset_of_the_panel(monkeypatch):
    session, calls = opened(ball_mesh()), []
    session.call(session.editor.toggle_slices).result()
    monkeypatch.setattr(session.editor.slices, "show", lambda is_final: calls.append(is_final))
    do(session, "preset", 0)
    assert calls == [True]


def test_the_panel_sets_how_the_deformation_is_shown():
    session = opened(ball_mesh())
    do(session, "distortion", 3)
    assert session.editor.view.distortion.has_grid
    assert session.editor.view.distortion.has_colors
    assert session._panel["distortion"] == 3
    session.call(lambda: session.editor.do("change_distortion")).result()
    assert session._panel["distortion"] == 0
    do(session, "distortion", "grid")  # the page never sends it
    assert session.editor.view.distortion.mode == 0


def test_another_time_step_is_shown_and_saved(tmp_path, rng):
    nibabel = pytest.importorskip("nibabel")
    values = (200 * rng.random((9, 8, 7, 3))).astype(np.float32)
    nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), tmp_path / "series.nii.gz")
    path = tmp_path / "series.nii.gz"
    session = opened(time_steps.read(path), paths=(path,))
    assert session._on_change.values["times"] == ["1: 0", "2: 1", "3: 2"]
    assert do(session, "step", 3)["step"] == 0  # there is none
    row = session.editor.state.rest[0]
    do(session, "position", [0, *(row + 1)])
    assert do(session, "step", 2)["step"] == 2
    assert session.editor.scene.items[0]._image.GetScalarRange() == pytest.approx(
        (values[..., 2].min(), values[..., 2].max())
    )
    session.editor.saver.folder = tmp_path / "saved"
    assert session.call(session.editor.save).result()
    source = nibabel.load(tmp_path / "saved" / "series-step-3.nii.gz")
    np.testing.assert_array_equal(source.get_fdata(dtype=np.float32), values[..., 2])
    deformed = tmp_path / "saved" / "series-deformed.nii.gz"
    before = deformed.read_bytes()
    assert python(tmp_path / "saved" / "deform.py")[0] == 0
    assert deformed.read_bytes() == before


SIZE = 28
_SHIFT = np.array((2.0, -1, 0))


def _texture(rng):
    """Smooth random values (SIZE, SIZE, SIZE)."""
    values = rng.normal(size=(SIZE,) * 3)
    for axis in range(3):
        for _ in range(3):
            values = values + np.roll(values, 1, axis)
    return 100 + 50 * values / values.std()


def _image(values):
    geometry = ImageGeometry.of_grid(Grid(values.shape[::-1]))
    return scalar_image(values.astype(np.float32).ravel(), geometry, "gray")


@pytest.fixture
def session(rng, tmp_path, monkeypatch):
    """A session of two images; the target is the moving one, shifted by whole points."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vtk_mls.web.session._SIZE", (160, 120))  # software draws it
    values = _texture(rng)
    images = _image(values), _image(np.roll(values, _SHIFT.astype(int)[::-1], (0, 1, 2)))
    for name, image in zip(("moving.vti", "target.vti"), images):
        io.write_dataset(image, name)
    p = np.array([(13.0, 13, 13), (15, 12, 14), (12, 15, 15)])
    state = State(p, p, labels=["a", "b", "c"])
    session, target = Session(Panel()), Target(images[1], tmp_path / "target.vti")
    session.call(lambda: session.open(images[:1], state, ["moving.vti"], None, target)).result()
    do(session, "say", "")
    return session


def test_pairs_are_edited_by_the_table(session):
    values = session._on_change.values
    assert values["has_target"]
    assert values["pane"] == "axial"  # a small picture has no room for all slices
    assert [pair["name"] for pair in values["pairs"]] == ["a", "b", "c"]
    do(session, "enable", [1, False])
    assert [pair["enabled"] for pair in values["pairs"]] == [True, False, True]
    state = session.editor.state
    assert state.enabled.tolist() == [True, False, True]
    distances = np.linalg.norm(state.deformed - state.rest, axis=1)
    np.testing.assert_array_equal([pair["distance"] for pair in values["pairs"]], distances)
    do(session, "name", [2, "nose"])
    do(session, "jump", [2])
    assert values["selected"] == [2]
    np.testing.assert_allclose(session.editor.slices.point, (12, 15, 15))
    do(session, "delete_pair", [0])
    assert [pair["name"] for pair in values["pairs"]] == ["b", "nose"]
    do(session, "undo")
    assert [pair["enabled"] for pair in values["pairs"]] == [True, False, True]
    for mode in ("difference", "fade"):
        assert do(session, "comparison", mode)["comparison"] == mode
    assert do(session, "share", 0.25)["share"] == 0.25
    before = session.editor.state
    for name, value in (
        ("comparison", "magic"),
        ("share", 7),
        ("enable", [9, True]),
        ("jump", [-1]),
        ("delete_pair", [99]),
        ("enable", []),
        ("delete_pair", 3),
    ):
        do(session, name, value)
    assert session.editor.state is before
    assert values["share"] == 0.25
    session.call(lambda: session.editor.place("moving", np.array((5.0, 5, 5)))).result()
    assert len(values["pairs"]) == 4
    assert not any(pair["outlier"] for pair in values["pairs"])


def test_the_table_names_the_spline_that_is_chosen(session, rng):
    values = session._on_change.values
    assert values["choice"] == ""
    q = rng.uniform(4, SIZE - 4, (9, 3))
    state = State(q * (1.0, 0.5, 1.5), q, kind="auto")
    session.call(lambda: session.editor.change(state)).result()
    assert values["choice"].startswith("spline of order ")
    assert values["kind"] == "auto"


def test_landmarks_are_refined(session):
    editor, values = session.editor, session._on_change.values
    do(session, "select", [1])
    session.call(editor.refine).result()
    assert values["message"].startswith("Landmark b is moved by 2.2")
    np.testing.assert_allclose(editor.state.deformed[1] - editor.state.rest[1], _SHIFT, atol=0.1)
    assert values["pairs"][1]["score"] > 0.99
    assert values["pairs"][0]["score"] is None
    drawn = []

    def note(done):
        drawn.append(editor.view.drawn_message)
        return False

    session.call(lambda: editor.refine_all(progress=note)).result()
    assert set(drawn) == {"Refining ..."}
    assert values["message"].startswith("3 of 3 landmarks are refined; moved by")
    shift = editor.state.deformed - editor.state.rest
    np.testing.assert_allclose(shift, [_SHIFT] * 3, atol=0.1)
    do(session, "position", [0, 25, 2, 2])
    session.call(lambda: editor.refine([0])).result()
    assert "Landmark a is not moved: " in values["message"]
    assert values["pairs"][0]["refused"]
    np.testing.assert_array_equal(editor.state.deformed[0], (25, 2, 2))
    before = editor.state
    session.call(lambda: editor.refine_all(progress=lambda done: done > 0.3)).result()
    assert values["message"] == "Refining was stopped; no landmark has moved."
    assert editor.state is before


def test_a_mesh_cannot_refine(session):
    editor = session.editor
    session.call(lambda: editor.set_target(ball_mesh())).result()
    do(session, "select", [0])
    session.call(lambda: editor.do("refine")).result()
    assert "landmarks are refined by two images" in editor.message.lower()


def test_a_stopped_save_is_reported(session):
    editor = session.editor
    editor.saver.progress = lambda done: done > 0.1
    assert not session.call(editor.save).result()
    assert session._on_change.values["message"].startswith("Saving was stopped")
    editor.saver.progress = None
    assert session.call(editor.save).result()
    message = session._on_change.values["message"]
    assert message.startswith(f"Saved in {editor.saver.folder}: handles, deformed data on the grid")


def test_a_session_is_saved_and_sent(session, tmp_path):
    editor, values = session.editor, session._on_change.values
    do(session, "enable", [1, False])
    do(session, "comparison", "fade")
    do(session, "share", 0.75)
    assert session.call(editor.save_session).result()
    path = editor.saver.folder / "session.mls.json"
    assert values["is_saved"]
    assert json.loads(path.read_text("utf-8"))["data"] == ["../moving.vti"]
    transfers = pytest.importorskip("vtk_mls.web.transfers").Transfers(session, tmp_path, None)
    do(session, "delete_pair", [0])
    do(session, "comparison", "beside")
    session.call(lambda: transfers._resume(path)).result()
    assert editor.state.enabled.tolist() == [True, False, True]
    assert (values["comparison"], values["share"]) == ("fade", 0.75)
    text = path.read_text("utf-8").replace("target.vti", "other.vti")
    other = tmp_path / "other.mls.json"
    other.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=r"`other.mls.json` is a session of .*`other.vti`"):
        session.call(lambda: transfers._resume(other)).result()
