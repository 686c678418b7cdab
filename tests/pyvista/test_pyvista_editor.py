"""The editor in a plotter of PyVista and in a notebook: events, and the edited state."""

from __future__ import annotations

import importlib
import os

import numpy as np
import pytest
from command_fixtures import PROJECT

from vtk_mls import Deformation, Plane
from vtk_mls.model.options import MAP_TOLERANCE

pyvista = pytest.importorskip("pyvista", "0.48", reason="PyVista is not installed")
mls = importlib.import_module("vtk_mls.pyvista")  # registers `mesh.mls`

DEFAULT = MAP_TOLERANCE.interactive_default


@pytest.fixture
def plotter(opengl):
    plotter = pyvista.Plotter(off_screen=True, window_size=(240, 240))
    yield plotter
    plotter.close()


def send(plotter, event, pixel, symbol=None):
    x, y = np.rint(pixel).astype(int).tolist()
    interactor = plotter.iren.interactor
    interactor.SetEventInformation(x, y, 0, 0, symbol or chr(0), 0, symbol)
    interactor.InvokeEvent(event)


def drag(plotter, editor, by):
    """Drag the handle that is nearest to the eye; its row."""
    pixels = editor.scene.projection.pixels(editor.state.deformed)
    row = int(pixels[:, 2].argmin())
    start = pixels[row, :2]
    send(plotter, "MouseMoveEvent", start)
    send(plotter, "LeftButtonPressEvent", start)
    send(plotter, "MouseMoveEvent", start + by)
    send(plotter, "LeftButtonReleaseEvent", start + by)
    return row


def test_a_drag_deforms_the_picture_and_the_result(plotter):
    mesh = pyvista.Sphere()
    edit = plotter.mls.edit(mesh, kind="affine", smoothing=0.05)
    plotter.show(auto_close=False)
    before = plotter.screenshot(return_img=True).astype(float)
    row = drag(plotter, edit.editor, (40, 20))
    assert np.abs(plotter.screenshot(return_img=True) - before).mean() > 0.3
    state = edit.state
    assert np.flatnonzero(~state.is_resting).tolist() == [row]
    deformation = Deformation(state.rest, state.deformed, kind="affine", smoothing=0.05)
    expected = deformation.forward(mesh.points)
    np.testing.assert_allclose(edit.deformed.points, expected, atol=1e-5)
    assert edit.deformed == mesh.mls.deform(edit.handles, kind="affine", smoothing=0.05)
    send(plotter, "KeyPressEvent", (5, 5), "z")
    assert edit.state.is_resting.all()


def test_the_edit_survives_the_window(plotter):
    image, mesh = pyvista.Wavelet(extent=(-8, 8, -8, 8, -8, 8)), pyvista.Sphere(radius=6)
    edit = plotter.mls.edit([image, mesh], cuts=Plane((0, 0, 0), (1, 0, 0)))
    plotter.show(auto_close=False)
    drag(plotter, edit.editor, (30, 0))
    before, field = edit.deformed, edit.field
    plotter.close()
    assert edit.deformed == before
    assert [type(item) for item in before] == [type(image), type(mesh)]
    assert edit.field == field
    with pytest.raises(ValueError, match="the window is closed"):
        edit.save("anywhere")
    with pytest.raises(ValueError, match="the plotter is closed"):
        plotter.mls.edit(mesh)


def test_handles_to_begin_with_are_saved_as_by_the_key(plotter, tmp_path):
    mesh = pyvista.Sphere()
    rest = mesh.points[::50]
    edit = plotter.mls.edit(mesh, rest, rest + 0.1, np.full(len(rest), 2.0))
    np.testing.assert_array_equal(edit.handles["Weight"], 2)
    edit.save(tmp_path / "saved")
    handles = mls.read(tmp_path / "saved" / "handles.csv")
    assert mesh.mls.deform(handles) == edit.deformed


@pytest.mark.parametrize(("options", "tolerance"), [({}, DEFAULT), ({"map_tolerance": 0}, 0)])
def test_the_result_has_the_tolerance_of_the_picture(plotter, options, tolerance):
    image = pyvista.Wavelet(extent=(-24, 24, -20, 20, -22, 22))
    rest = np.array([(10, 3, 1), (-14, -8, 5), (2, 9, -12)])
    edit = plotter.mls.edit(image, rest, rest + [(3, 2, 0), (0, 0, 4), (0, -3, 0)], **options)
    fields = [image.mls.field(edit.handles, map_tolerance=t) for t in (DEFAULT, 0)]
    assert [edit.field == field for field in fields] == [tolerance == t for t in (DEFAULT, 0)]


@pytest.mark.parametrize(
    ("options", "message"),
    [({"kind": "soft"}, "`kind` must be one of"), ({"knd": 1}, "`knd` is no option of the editor")],
)
def test_errors_of_an_editor_name_the_argument(plotter, options, message):
    with pytest.raises((TypeError, ValueError), match=message):
        plotter.mls.edit(pyvista.Sphere(), **options)


def test_one_view_and_one_editor(plotter):
    two_views = pyvista.Plotter(off_screen=True, shape=(1, 2), window_size=(400, 200))
    with pytest.raises(ValueError, match="one view, got 2"):
        two_views.mls.edit(pyvista.Sphere())
    two_views.close()
    plotter.mls.edit(pyvista.Sphere())
    with pytest.raises(ValueError, match="has an editor"):
        plotter.mls.edit(pyvista.Sphere())


CELLS = (
    """
import urllib.request
import pyvista, vtk_mls.pyvista
mesh = pyvista.Sphere()
plotter = pyvista.Plotter(notebook=True, window_size=(300, 200))
edit = plotter.mls.edit(mesh)
viewer = plotter.show(jupyter_backend="server", return_viewer=True)
viewer
""",
    # the request of the page; the loop of the kernel must be free to answer
    """
import asyncio
page = await asyncio.to_thread(lambda: urllib.request.urlopen(viewer.src, timeout=20).read())
assert b"<html" in page, page[:200]
""",
    """
edit.editor.document.start_drag([13], 13)
edit.editor.document.drag_to([edit.state.rest[13] + 0.2])
edit.editor.document.end_drag()
assert (~edit.state.is_resting).sum() == 1
assert edit.deformed == mesh.mls.deform(edit.handles)
edit.editor.undo()
assert edit.state.is_resting.all()
""",
)


@pytest.mark.matrix
def test_a_notebook_edits(monkeypatch, opengl):
    needed = "nbclient", "nbformat", "ipykernel", "ipywidgets", "trame_pyvista"
    nbclient, nbformat, *_ = (
        pytest.importorskip(name, reason=f"{name} is not installed") for name in needed
    )
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])
    )
    cells = [nbformat.v4.new_code_cell(text) for text in CELLS]
    notebook = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    (output,) = [output for output in notebook.cells[0].outputs if output.output_type != "stream"]
    assert "iframe" in output["data"]["text/plain"]
