"""What a tolerance of maps leaves: displacements on a grid against the exact ones."""

import matplotlib.pyplot as plt
import numpy as np

import vtk_mls

rest = np.random.default_rng(3).uniform(8, 88, (15, 3))
deformed = rest + np.random.default_rng(4).normal(0, 5, (15, 3))
size = (97, 97, 97)
exact = vtk_mls.Deformation(rest, deformed).displacement_field(size).displacement
figure, panels = plt.subplots(1, 3, figsize=(8.6, 2.8))
for axes, tolerance in zip(panels, (0.01, 0.05, 0.25)):
    d = vtk_mls.Deformation(rest, deformed, map_tolerance=tolerance)
    error = np.linalg.norm(d.displacement_field(size).displacement - exact, axis=-1)
    assert error.max() <= tolerance
    shown = axes.imshow(error[48] / tolerance, origin="lower", vmin=0, vmax=0.15, cmap="magma")
    axes.set_title(f"{tolerance}: off by {error.max():.3f} at most", fontsize=9)
    axes.axis("off")
figure.colorbar(shown, ax=panels, label="error / tolerance")
