"""A mesh that is drawn deformed."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls import Deformation
from vtk_mls.rendering.moved_mesh import MovedMesh

# Mappers of composite data are made from those of meshes.
_COMPOSITE = "vtkCompositePolyDataMapper", "vtkCompositePolyDataMapper2"


class DeformedMesh:
    """Shows what an actor shows as a deformation moves it.

    A stage is put into VTK's pipeline in front of the actor's mapper. It gives the mapper the
    surface of the mesh, its points moved by the exact inverse of the backward map, as
    `MLSDeform` would move them, cells divided along cuts, and normals transformed. The mesh itself
    is not changed. Only what is drawn moves: of volumetric cells the surface. A change of the mesh,
    of the mapper's input or of the actor's mapper shows in the next picture.

    Parameters
    ----------
    actor : vtkActor
        With a vtkPolyDataMapper or a vtkDataSetMapper. Positions of the deformation are those of
        the mesh, whatever transformation the actor has.

    Raises
    ------
    TypeError, ValueError
        For another mapper, or an actor that shows a deformed mesh already.
    """

    def __init__(self, actor: vtkActor) -> None:
        mapper = actor.GetMapper()
        if not _is_of_meshes(mapper):
            got = "none" if mapper is None else mapper.GetClassName()
            raise TypeError(
                "`actor` must have a vtkPolyDataMapper or a vtkDataSetMapper, "
                f"got {got}; of composite data give each block an actor of its own"
            )
        if _is_moved(mapper):
            raise ValueError("`actor` shows a deformed mesh already; update or detach that one")
        self._actor, self._stage = actor, MovedMesh()
        self._mapper, self._observers = None, []

    def update(self, deformation: Deformation, exact: bool = True) -> None:
        """Show the mesh as a deformation moves it. The next Render draws it.

        Parameters
        ----------
        deformation : Deformation
        exact : bool
            False while something is dragged: a mesh of more than 262144 points is then moved by a
            map that is interpolated between some 64 x 64 x 64 points, and off by about 1/2000 of
            the mesh's size at most. Smaller ones always are where they belong, as are points at
            cuts.

        Raises
        ------
        TypeError, ValueError, DeviceError, MemoryError
            What is drawn stays as it was.
        """
        if not isinstance(deformation, Deformation):
            raise TypeError(f"`deformation` must be a Deformation, got {deformation!r}")
        if not self._observers:
            self._observe(self._actor)
        self._follow()
        self._stage.show(deformation, exact)

    def detach(self) -> None:
        """Show the mesh as it was, to the bit; an update deforms it again."""
        for observed, tag in self._observers:
            observed.RemoveObserver(tag)
        self._observers.clear()
        self._leave()

    def _observe(self, thing):
        self._observers.append((thing, thing.AddObserver("ModifiedEvent", self._follow)))

    def _follow(self, *_):
        """Stand in front of the mapper that the actor has, and behind what it is to show."""
        if not vars(self):  # Python's collector has emptied it before it let the actor go
            return
        mapper = self._actor.GetMapper()
        if mapper is not self._mapper:
            self._leave()
        if not _is_of_meshes(mapper):
            return
        if mapper is not self._mapper:
            self._mapper = mapper
            self._observe(mapper)
        if mapper.GetNumberOfInputConnections(0) > 0 and not _is_moved(mapper):
            self._stage.SetInputConnection(0, mapper.GetInputConnection(0, 0))
            mapper.SetInputConnection(0, self._stage.GetOutputPort())

    def _leave(self):
        """Give the mapper back what it would show."""
        mapper, self._mapper = self._mapper, None
        for observed, tag in [each for each in self._observers if each[0] is mapper]:
            observed.RemoveObserver(tag)
            self._observers.remove((observed, tag))
        if mapper is not None and _producer(mapper) is self._stage:
            mapper.SetInputConnection(0, self._stage.GetInputConnection(0, 0))
        self._stage.RemoveAllInputConnections(0)


def _is_of_meshes(mapper):
    """Whether a mapper shows a single mesh."""
    is_composite = mapper is not None and any(mapper.IsA(name) for name in _COMPOSITE)
    return isinstance(mapper, (vtkPolyDataMapper, vtkDataSetMapper)) and not is_composite


def _is_moved(mapper):
    """Whether what a mapper shows is deformed."""
    return isinstance(_producer(mapper), MovedMesh)


def _producer(mapper):
    """The algorithm in front of a mapper; None without one."""
    if mapper.GetNumberOfInputConnections(0) == 0:
        return None
    return mapper.GetInputConnection(0, 0).GetProducer()
