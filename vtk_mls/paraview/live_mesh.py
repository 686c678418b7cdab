"""A mesh that ParaView shows, drawn deformed in its stead."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkPointSet, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls.paraview.server_manager import elements, find
from vtk_mls.rendering import DeformedMesh

_SHOWN_AS = ("Surface", "Surface With Edges", "Wireframe", "Points")


class LiveMesh:
    """An actor of our own with the look of ParaView's, which is hidden.

    ParaView's own cannot be drawn deformed: its mapper is for many blocks.

    Parameters
    ----------
    display : proxy of a representation
        One that `can_draw` accepts.
    mesh : vtkPointSet
        To be drawn.
    renderer : vtkRenderer
    """

    def __init__(self, display, mesh, renderer):
        self._mesh, self._renderer, self._display = mesh, renderer, display.GetGlobalID()
        self._hidden, self._looks = _actor_of(display), _looks(display)
        mapper = vtkPolyDataMapper() if isinstance(mesh, vtkPolyData) else vtkDataSetMapper()
        mapper.SetInputDataObject(mesh)
        _color(mapper, display)
        self._actor = vtkActor()
        self._actor.SetMapper(mapper)
        self._actor.SetProperty(self._hidden.GetProperty())
        self._actor.PickableOff()
        renderer.AddViewProp(self._actor)
        self._drawn, self._latest = DeformedMesh(self._actor), None

    @staticmethod
    def can_draw(display, mesh):
        """Whether a display shows the mesh, as a surface or its points and edges."""
        shows = display.GetProperty("Representation")
        if not isinstance(mesh, vtkPointSet) or shows is None:
            return False
        return shows.GetElement(0) in _SHOWN_AS and _actor_of(display) is not None

    def is_of(self, display, mesh):
        """Whether this still draws what the display shows."""
        return (
            self.can_draw(display, mesh)
            and mesh is self._mesh
            and _looks(display) == self._looks
            and _actor_of(display) is self._hidden
        )

    def update(self, deformation, is_held, limits):
        """Draw the mesh as a deformation has it: true, for every graphics card can.

        Parameters
        ----------
        deformation : Deformation
        is_held : bool
            Whether the mouse holds a handle: the map of large meshes is coarser then.
        limits : None
            Meshes have none.
        """
        self._hidden.SetVisibility(False)
        if self._latest != (deformation, is_held):
            self._latest = deformation, is_held
            self._drawn.update(deformation, exact=not is_held)
            self._renderer.ResetCameraClippingRange()
        return True

    def end(self):
        """Let ParaView's actor be seen again."""
        self._drawn.detach()
        self._renderer.RemoveViewProp(self._actor)
        display = find(self._display, "representations")
        if display and _actor_of(display) is self._hidden:
            self._hidden.SetVisibility(display.GetProperty("Visibility").GetElement(0))


def _color(mapper, display):
    """Color what a mapper shows as a display does."""
    *_, association, name = elements(display.GetProperty("ColorArrayName"))
    table = display.GetProperty("LookupTable").GetProxy(0)
    if not name or table is None:
        mapper.ScalarVisibilityOff()
        return
    if association == "1":
        mapper.SetScalarModeToUseCellFieldData()
    else:
        mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(name)
    mapper.SetLookupTable(table.GetClientSideObject())
    mapper.UseLookupTableScalarRangeOn()
    mapper.SetInterpolateScalarsBeforeMapping(association != "1")


def _looks(display):
    """What of a display makes another actor necessary when it changes."""
    table = display.GetProperty("LookupTable").GetProxy(0)
    return (
        elements(display.GetProperty("ColorArrayName")),
        elements(display.GetProperty("Representation")),
        table.GetGlobalID() if table else None,
    )


def _actor_of(display):
    """ParaView's own vtkActor of a display; None where it has none here."""
    active = display.GetClientSideObject().GetActiveRepresentation()
    actor = active.GetActor() if hasattr(active, "GetActor") else None
    return actor if isinstance(actor, vtkActor) else None
