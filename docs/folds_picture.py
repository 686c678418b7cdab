"""Draws docs/folds.png: the deformed grid and the change of volume in a brain, in the editor.

Run: python docs/folds_picture.py
"""

from pathlib import Path

import numpy as np
from brain_editor import open_editor, save_picture

# Drags: a rest position in fractions of the half size from the middle, and a displacement in mm.
DRAGS = ((1, 0, 0), (26, 0, 6)), ((0, -1, 0.6), (0, 42, 20)), ((-1, 0, 0), (22, -8, 0))

editor, window = open_editor()
low, high = editor.scene.bounds
middle, half = (low + high) / 2, (high - low) / 2
camera = editor.scene.renderer.GetActiveCamera()
camera.SetFocalPoint(middle)
camera.SetPosition(middle + 6.0 * half.max() * np.array((0.28, -0.72, 0.62)))
camera.SetViewUp(0, 0, 1)
state = editor.state
for place, drag in DRAGS:
    row = np.linalg.norm(state.rest - middle - half * place, axis=1).argmin()
    state = state.moved([row], state.rest[[row]] + drag)
editor.toggle_slices()
editor.change(state)
editor.set_distortion(3)  # what key J would do in three steps
editor.say("")
editor.move_slices(middle + (0, -2, 10))
save_picture(editor, window, Path(__file__).with_name("folds.png"))
