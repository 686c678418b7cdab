"""numpy alone
===========

Bend a straight bar of voxels by six control points, with numpy arrays only.

You will see two side views of the bar, as text: straight before, and bent after its ends were
pulled down. The end checks that every control point arrived and that the bar kept its length.
"""

import numpy as np

import vtk_mls

# A volume has the shape (nz, ny, nx); its voxels lie at origin + spacing * (i, j, k).
grid = vtk_mls.Grid(dimensions=(64, 24, 32), origin=(0, 0, 0), spacing=(1, 1, 1))
volume = np.zeros(grid.shape, np.float32)
volume[18:22, 8:16, 8:56] = 1

# Where the control points were, and where they are now: both ends turn by 30 degrees.
rest = np.array([(8, 12, 20), (12, 12, 20), (28, 12, 20), (36, 12, 20), (52, 12, 20), (56, 12, 20)])
deformed = np.array(
    [(9.5, 12, 12), (13, 12, 14), (28, 12, 20), (36, 12, 20), (51, 12, 14), (54.5, 12, 12)]
)
bend = vtk_mls.Deformation(rest, deformed, kind="rigid")
(bent,) = bend.resample([volume], vtk_mls.Sampling(grid, interpolation="linear"))


def show(title, array):
    print(title)
    for row in array[26:4:-2, 12]:
        print("".join(" .:#"[int(3 * value)] for value in row).rstrip())


show("Before, from the side:", volume)
show("After:", bent)

# The backward map tells where the material now at a point came from.
error = np.abs(bend.backward(deformed) - rest).max()
print(f"Control points arrive within {error:.1e} voxels")
change = bent.sum() / volume.sum() - 1
print(f"The bar's volume changed by {change:+.1%}")
assert error < 1e-4
assert abs(change) < 0.1
