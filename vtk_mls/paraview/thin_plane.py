"""ParaView's plane, drawn so that it does not hide the gap of a cut."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkPropCollection


def draw_thin(plane):
    """Draw the edges of a plane as lines, instead of tubes as thick as the gap.

    Parameters
    ----------
    plane : vtkDisplaySizedImplicitPlaneRepresentation or vtkImplicitPlaneRepresentation
    """
    actors = vtkPropCollection()
    plane.GetActors(actors)
    for number in range(actors.GetNumberOfItems()):
        mapper = actors.GetItemAsObject(number).GetMapper()
        drawn = mapper.GetInputAlgorithm()
        if drawn.IsA("vtkTubeFilter"):
            mapper.SetInputConnection(drawn.GetInputConnection(0, 0))
