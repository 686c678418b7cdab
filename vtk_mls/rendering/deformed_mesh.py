"""A mesh that is drawn deformed."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls import Deformation
from vtk_mls.filters.algorithm import Algorithm, CachedValue
from vtk_mls.filters.warping import stamps
from vtk_mls.rendering.coarse_forward import MAX_EXACT_POINTS, CoarseForward
from vtk_mls.rendering.rest_surface import RestSurface, state_of

# Subclasses of vtkPolyDataMapper for composite data.
_COMPOSITE = "vtkCompositePolyDataMapper", "vtkCompositePolyDataMapper2"


class DeformedMesh:
    """Draws the mesh of an actor deformed.

    A `MeshDeformer` is inserted into VTK's pipeline before the actor's mapper. It outputs the
    surface of the mesh, with points moved by the exact inverse of the backward map as in
    `MLSDeform`, cells split along cuts, and normals transformed. The mesh itself is not changed. A
    change of the mesh, of the mapper's input or of the actor's mapper shows in the next picture.

    Parameters
    ----------
    actor : vtkActor
        With a vtkPolyDataMapper or a vtkDataSetMapper. The deformation is in the coordinates of
        the mesh; the transformation of the actor is applied after it.

    Raises
    ------
    TypeError, ValueError
        For another mapper, or an actor whose mesh is drawn deformed already.
    """

    def __init__(self, actor: vtkActor) -> None:
        mapper = actor.GetMapper()
        if not _is_mesh_mapper(mapper):
            got = "none" if mapper is None else mapper.GetClassName()
            raise TypeError(
                "`actor` must have a vtkPolyDataMapper or a vtkDataSetMapper, "
                f"got {got}; of composite data give each block an actor of its own"
            )
        if _is_moved(mapper):
            raise ValueError("`actor` shows a deformed mesh already; update or detach that one")
        self._actor, self._deformer = actor, MeshDeformer()
        self._mapper, self._observers = None, []

    def update(
        self, deformation: Deformation, exact: bool = True, has_distortion: bool = False
    ) -> None:
        """Draw the mesh deformed by `deformation` from the next Render on.

        Parameters
        ----------
        deformation : Deformation
        exact : bool
            False while the mouse drags: a mesh with more than 262144 points is then moved by a map
            that is interpolated between some 64 x 64 x 64 points, with an error of at most about
            1/2000 of the mesh's size. Smaller meshes and points at cuts are always exact.
        has_distortion : bool
            Whether the drawn mesh has the point arrays "RestPosition", x of the undeformed space,
            and "JacobianDeterminant", det J_G, which is not positive where space folds.

        Raises
        ------
        TypeError, ValueError, DeviceError, MemoryError
            The drawn mesh stays as it was.
        """
        if not isinstance(deformation, Deformation):
            raise TypeError(f"`deformation` must be a Deformation, got {deformation!r}")
        if not self._observers:
            self._observe(self._actor)
        self._follow()
        self._deformer.deform(deformation, exact, has_distortion)

    def detach(self) -> None:
        """Draw the undeformed mesh; an update deforms it again."""
        for observed, tag in self._observers:
            observed.RemoveObserver(tag)
        self._observers.clear()
        self._leave()

    def _observe(self, subject):
        self._observers.append((subject, subject.AddObserver("ModifiedEvent", self._follow)))

    def _follow(self, *_):
        """Connect the deformer between the actor's mapper and the mapper's input."""
        if not vars(self):  # cleared by Python's garbage collector before the actor is deleted
            return
        mapper = self._actor.GetMapper()
        if mapper is not self._mapper:
            self._leave()
        if not _is_mesh_mapper(mapper):
            return
        if mapper is not self._mapper:
            self._mapper = mapper
            self._observe(mapper)
        if mapper.GetNumberOfInputConnections(0) > 0 and not _is_moved(mapper):
            self._deformer.SetInputConnection(0, mapper.GetInputConnection(0, 0))
            mapper.SetInputConnection(0, self._deformer.GetOutputPort())

    def _leave(self):
        """Reconnect the mapper to its own input."""
        mapper, self._mapper = self._mapper, None
        for observed, tag in self._observers[:]:
            if observed is mapper:
                observed.RemoveObserver(tag)
                self._observers.remove((observed, tag))
        if mapper is not None and _producer(mapper) is self._deformer:
            mapper.SetInputConnection(0, self._deformer.GetInputConnection(0, 0))
        self._deformer.RemoveAllInputConnections(0)


class MeshDeformer(Algorithm):
    """A pipeline stage whose output is the deformed surface of its input.

    The split surface at rest depends on the mesh and the cuts only, and is cached.
    """

    def __init__(self):
        super().__init__()
        self._deformation, self._is_exact, self._has_distortion = None, True, False
        self._rest_surface, self._coarse_map = CachedValue(), CachedValue()
        self._output = CachedValue()

    def deform(self, deformation, exact, has_distortion=False):
        """Set the Deformation, and update the output; unchanged after an error."""
        options = exact, has_distortion
        has_input = self.GetNumberOfInputConnections(0) > 0
        if has_input:
            self._polydata(self._update_input(0), deformation, *options)
        self._deformation, (self._is_exact, self._has_distortion) = deformation, options
        self.Modified()
        if has_input:  # static mappers do not update it
            self.Update()

    def RequestData(self, request, inInfo, outInfo):
        mesh, output = vtkDataSet.GetData(inInfo[0]), vtkPolyData.GetData(outInfo)
        options = self._is_exact, self._has_distortion
        output.ShallowCopy(self._polydata(mesh, self._deformation, *options))
        output.GetFieldData().ShallowCopy(mesh.GetFieldData())
        return 1

    def _polydata(self, mesh, deformation, exact, has_distortion):
        cuts = () if deformation is None else deformation.cuts
        state = stamps(mesh), state_of(cuts)
        surface = self._rest_surface.of(state, lambda: RestSurface(mesh, cuts))
        count = len(surface.positions)
        if deformation is None or count == 0:
            return surface.surface
        # with cuts in the deformed frame the forward map is not smooth
        is_smooth = deformation.in_rest_frame or not cuts
        is_coarse = not exact and count > MAX_EXACT_POINTS and is_smooth

        def moved():
            mover = surface
            if is_coarse:
                mover = self._coarse_map.of(surface, lambda: CoarseForward(surface, cuts))
            return mover.moved(deformation, has_distortion)

        with np.errstate(all="ignore"):  # points may be NaN or far away
            return self._output.of((surface, deformation, is_coarse, has_distortion), moved)


def _is_mesh_mapper(mapper):
    """Whether a mapper draws a single mesh."""
    is_composite = mapper is not None and any(mapper.IsA(name) for name in _COMPOSITE)
    return isinstance(mapper, (vtkPolyDataMapper, vtkDataSetMapper)) and not is_composite


def _is_moved(mapper):
    return isinstance(_producer(mapper), MeshDeformer)


def _producer(mapper):
    if mapper.GetNumberOfInputConnections(0) == 0:
        return None
    return mapper.GetInputConnection(0, 0).GetProducer()
