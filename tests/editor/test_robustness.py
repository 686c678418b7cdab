"""Failures around the editor lose no edits, and are reported in one sentence."""

from __future__ import annotations

import numpy as np
import pytest
from hands import Hands, ball_image, ball_mesh, key_and_modifiers
from pairwise import one_of
from vtk_fixtures import scalar_image

from vtk_mls import Deformation, Surface
from vtk_mls.editor import State, commands
from vtk_mls.editor.autosave import Autosave
from vtk_mls.vtk.arrays import ImageGeometry


def failing(error):
    def fail(*arguments):
        raise error

    return fail


def close(hands):
    """Close the window as a window manager, and detach as `vtk-mls view` does."""
    hands.send("ExitEvent")
    hands.editor.detach()


@pytest.mark.parametrize("end", [close, lambda hands: hands.press("q")])
def test_the_end_of_the_session_commits_a_drag(end, tmp_path):
    hands = Hands(ball_mesh(), paths=["ball.vtp"], autosave=Autosave("ball.vtp", tmp_path))
    hands.drag(hands.pixel_of(13), (20, 10), released=False)
    end(hands)
    state = Autosave("ball.vtp", tmp_path).offered
    assert not state.is_resting[13]


# all but those that end it: d starts another line
# Up and Down turn the view to another handle, where the next click would miss
KEYS = sorted(set(commands.actions()) - {"p", "d", "Escape", "Up", "Down"})


@pytest.mark.parametrize("symbol", one_of(7, KEYS))
def test_keys_keep_an_unfinished_line(symbol, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    hands = Hands(ball_mesh())
    hands.press("p")
    hands.click((100, 125))
    hands.press(*key_and_modifiers(symbol))
    hands.press("a", "Ctrl")
    hands.click((140, 125))
    hands.press("p")
    assert any(isinstance(cut, Surface) for cut in hands.state.cuts)


def test_a_lost_context_is_recreated():
    """As after a restart of the driver, or on another screen."""
    hands = Hands(ball_image())
    hands.drag(hands.pixel_of(13), (25, 10))
    before = hands.picture()
    hands.editor.scene.window.Finalize()
    hands.editor.scene.window.Render()
    np.testing.assert_allclose(hands.picture(), before, atol=12)
    hands.drag(hands.pixel_of(13), (10, 10))
    assert np.abs(hands.picture() - before).mean() > 0.1


@pytest.mark.matrix
def test_a_large_image_is_edited():
    """512^3 voxels without a copy in float64."""
    import resource

    size = 512
    ramp = np.abs(np.arange(size) - size / 2)
    inside = ramp[:, None, None] ** 2 + ramp[:, None] ** 2 + ramp**2 < (size / 3) ** 2
    values = np.where(inside, 200, 0).astype(np.uint8).ravel()
    image = scalar_image(values, ImageGeometry((0, size - 1) * 3))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    hands = Hands(image, pixels=120)
    hands.drag(hands.pixel_of(13), (10, 5), steps=1)
    hands.press("m")
    hands.press("z")
    assert hands.state.is_resting.all()
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 2**20
    assert grown < 6, f"{grown:.1f} GiB more"


def test_removed_handles_are_neither_hovered_nor_selected(tmp_path):
    """The mouse stays over a handle while fewer handles replace it."""
    fewer = State([(3, 3, 3), (20, 20, 20)], [(4, 3, 3), (20, 20, 20)])
    Autosave("ball.vtp", tmp_path).store(fewer)
    hands = Hands(ball_mesh(), autosave=Autosave("ball.vtp", tmp_path))
    pixels = hands.pixels(hands.state.deformed)
    row = int(pixels[:, 2].argmin())  # no other handle is in front of it
    assert row >= len(fewer)
    hands.move(hands.pixel_of(row))
    hands.click(hands.pixel_of(row))
    hands.press("Return")
    assert hands.state.rest.tolist() == fewer.rest.tolist()
    assert hands.editor.selected.tolist() == []
    hands.press("z")
    hands.move(hands.pixel_of(row))
    assert hands.editor.document.hovered == row
    for count in (64, 125, 8, 27):
        hands.press("l")
        assert len(hands.state) == count
        assert hands.editor.document.hovered is None
    hands.move(hands.pixel_of(row))
    assert hands.editor.document.hovered == row
    hands.editor.select([1, row])
    hands.editor.change(hands.state.without(np.arange(row, 27)))
    assert hands.editor.selected.tolist() == [1]
    assert hands.editor.document.hovered is None


def test_a_device_failure_between_edits_is_reported_and_loses_nothing(monkeypatch):
    """New handles, slices, lines and rays evaluate the map, too."""
    hands = Hands(ball_image(), pixels=360)
    hands.drag(hands.pixel_of(13), (25, 10))
    hands.press("p")
    hands.click((160, 190))
    hands.click((200, 190))
    state, backward = hands.state, Deformation.backward

    error = RuntimeError("the device is lost; set `VTK_MLS_DEVICE`")

    def assert_reported():
        assert hands.message == "The device is lost; set `VTK_MLS_DEVICE`."
        assert hands.state is state
        hands.editor.say("")

    monkeypatch.setattr(Deformation, "backward", failing(error))
    hands.press("p")
    assert_reported()
    hands.click((180, 200))
    assert_reported()
    hands.move((180, 200))
    hands.press("a")
    assert_reported()
    hands.press("m")
    assert_reported()
    hands.send("MouseWheelForwardEvent", (340, 60))
    assert_reported()
    hands.click((345, 50))
    assert_reported()
    hands.press("v")
    assert_reported()
    hands.press("m")
    monkeypatch.setattr(Deformation, "backward", backward)
    hands.press("p")
    (cut,) = hands.state.cuts
    assert len(cut.points) == 6


@pytest.mark.parametrize("modifier", ["Ctrl", "Shift"])
def test_a_device_failure_during_a_drag_is_reported(modifier, monkeypatch):
    hands = Hands(ball_image())
    hands.drag(hands.pixel_of(13), (25, 10))
    camera, backward = hands.camera, Deformation.backward
    hands.send("LeftButtonPressEvent", hands.pixel_of(13))

    monkeypatch.setattr(Deformation, "backward", failing(MemoryError()))
    hands.move(hands.pixel_of(13) + (10, 0), modifier)
    assert hands.message == "There is not enough memory."
    monkeypatch.setattr(Deformation, "backward", backward)
    hands.send("LeftButtonReleaseEvent")
    assert hands.camera == camera
    assert hands.editor.document.grabbed is None
