"""A program as users write it, for mypy, which must know each type; it is not run.

What mypy must refuse is marked `type: ignore`: it complains about marks that are not needed.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from typing_extensions import assert_type
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkVolume

from vtk_mls import Deformation, DisplacementField, Grid, HalfPlane, Plane, Surface
from vtk_mls.filters import MLSDeform
from vtk_mls.rendering import DeformedVolume

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

rest = [(0, 0, 0), (1, 0, 0)]
deformed = np.zeros((2, 3))
half_plane = HalfPlane((0, 0, 0), (0, 1, 0), inward=(0, 0, 1))
surface = Surface.polygon([(20, 60, 90), (90, 60, 90), (90, 60, 150)])
cuts = (half_plane, surface, Plane((0, 0, 0), (1, 0, 0)))
deformation = Deformation(rest, deformed, kind="rigid", alpha=1, cuts=cuts, device="reference")
points = deformation.rest

assert_type(surface, Surface)
assert_type(deformation.backward(points), Float64)
assert_type(deformation.forward([(1, 2, 3)]), Float64)
assert_type(deformation.jacobian(points), Float64)
assert_type(deformation.void(points), Bool)

grid = Grid((64, 64, 64), spacing=(1, 1, 2))
field = deformation.displacement_field(grid)
assert_type(field, DisplacementField)
assert_type(field.grid, Grid)
assert_type(grid.size, int)
assert_type(grid.points(), Float64)
assert_type(deformation.fitted_grid(grid), Grid)

volume, renderer = vtkVolume(), vtkRenderer()
drawn = DeformedVolume(volume, renderer)
drawn.update(deformation, nodes=32, within=grid)
assert_type(drawn.uploads, int)
drawn.update(3)  # type: ignore[arg-type]

deform = MLSDeform()
deform.SetRestPoints(rest)
deform.SetKind("affine")
deform.AddCut(half_plane)
assert_type(deform.GetAlpha(), float)
assert_type(deform.GetRestPoints(), tuple[tuple[float, float, float], ...])
deform.SetKind("affin")  # type: ignore[arg-type]
deform.SetNothing(1)  # type: ignore[attr-defined]

deformation.forward()  # type: ignore[call-arg]
deformation.backward(points, progress=3)  # type: ignore[arg-type]
deformation.fitted_grid("grid")  # type: ignore[arg-type]
deformation.nothing  # type: ignore[attr-defined]  # noqa: B018
Deformation(rest, deformed, kind=3)  # type: ignore[arg-type]
Grid()  # type: ignore[call-arg]
