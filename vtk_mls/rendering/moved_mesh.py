"""A stage of VTK's pipeline, between a mapper and what it would show."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkPolyData

from vtk_mls.filters.algorithm import Algorithm, CachedValue
from vtk_mls.filters.warping import stamps
from vtk_mls.rendering.coarse_forward import MOST_EXACT, CoarseForward
from vtk_mls.rendering.drawn_mesh import DrawnMesh, state_of


class MovedMesh(Algorithm):
    """The surface of its input, deformed.

    What depends on the mesh and the cuts only is kept: they stay while control points are dragged.
    """

    def __init__(self):
        super().__init__(nInputPorts=1, inputType="vtkDataSet", nOutputPorts=1)
        self.OutputType = "vtkPolyData"
        self._shown = None, True
        self._drawn, self._coarse, self._moved = CachedValue(), CachedValue(), CachedValue()

    def show(self, deformation, exact):
        """Move the mesh from now on by a Deformation; an error leaves it where it is."""
        has_input = self.GetNumberOfInputConnections(0) > 0
        if has_input:
            self._polydata(self._update_input(0), deformation, exact)
        self._shown = deformation, exact
        self.Modified()
        if has_input:  # mappers that are static do not ask for it
            self.Update()

    def RequestData(self, request, inInfo, outInfo):
        mesh, output = vtkDataSet.GetData(inInfo[0]), vtkPolyData.GetData(outInfo)
        output.ShallowCopy(self._polydata(mesh, *self._shown))
        output.GetFieldData().ShallowCopy(mesh.GetFieldData())
        return 1

    def _polydata(self, mesh, deformation, exact):
        """The surface of `mesh`, moved."""
        cuts = () if deformation is None else deformation.cuts
        state = stamps(mesh), state_of(cuts)
        drawn = self._drawn.of(state, lambda: DrawnMesh(mesh, cuts))
        count = len(drawn.positions)
        if deformation is None or count == 0:
            return drawn.surface
        # the forward map is not smooth where material comes to a cut that stays
        is_smooth = deformation.in_rest_frame or not cuts
        is_coarse = not exact and count > MOST_EXACT and is_smooth

        def move():
            with np.errstate(all="ignore"):  # points may be NaN or far away
                if not is_coarse:
                    return drawn.moved(deformation)
                return self._coarse.of(drawn, lambda: CoarseForward(drawn, cuts)).moved(deformation)

        return self._moved.of((drawn, deformation, is_coarse), move)
