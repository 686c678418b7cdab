"""The editor in a notebook: a kernel runs it, and the server's rendering shows it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from vtk_fixtures import can_draw

PROJECT = Path(__file__).resolve().parents[2]
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
def test_a_notebook_edits(monkeypatch):
    needed = "nbclient", "nbformat", "ipykernel", "ipywidgets", "trame_pyvista"
    nbclient, nbformat, *_ = (
        pytest.importorskip(name, reason=f"{name} is not installed") for name in needed
    )
    if not can_draw():
        pytest.skip("VTK cannot draw here")
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])
    )
    cells = [nbformat.v4.new_code_cell(text) for text in CELLS]
    notebook = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    (output,) = [output for output in notebook.cells[0].outputs if output.output_type != "stream"]
    assert "iframe" in output["data"]["text/plain"]
