"""Draws docs/editor.png: the editor with a brain that is cut and being opened.

Run: python docs/editor_picture.py
"""

from pathlib import Path

import numpy as np
from brain_editor import open_editor, save_picture

from vtk_mls import HalfPlane

editor, window = open_editor()
low, high = editor.scene.bounds
middle = (low + high) / 2
camera = editor.scene.renderer.GetActiveCamera()
camera.SetFocalPoint(middle)
camera.SetPosition(middle + 3.0 * (high - low).max() * np.array((0.28, -0.72, 0.62)))
camera.SetViewUp(0, 0, 1)
editor.toggle_slices()
editor.move_slices(middle + (0, 8, 12))

# what four keys and two drags would do
cut = HalfPlane(middle + (1.5, 0, -0.1 * (high - low)[2]), (1, 0, 0), (0, 0, 1))
state = editor.state.changed(cuts=[cut])
top = state.rest[:, 2] > middle[2] + 1
for side, sign in ((state.rest[:, 0] > middle[0] + 5, 1), (state.rest[:, 0] < middle[0] - 5, -1)):
    rows = np.flatnonzero(side & top)
    state = state.moved(rows, state.rest[rows] + sign * np.array((20.0, 0, -3.0)))
editor.change(state)
right = np.flatnonzero((state.rest[:, 0] > middle[0] + 5) & top)
editor.select(right)
editor.document.hover(int(right[0]))
save_picture(editor, window, Path(__file__).with_name("editor.png"))
