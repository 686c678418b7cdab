"""By which array a display colors, for mappers of our own."""

from __future__ import annotations

from vtk_mls.paraview.server_manager import elements

_BLOCK_COLORS, _COUNT = "vtkBlockColors", 12  # as ParaView numbers the colors of blocks


def array(display):
    """Association ("0" of points, "1" of cells) and name of the array that a display shows."""
    return tuple(elements(display.GetProperty("ColorArrayName"))[3:5])


def look(display):
    """What differs when a mapper has to be set up anew."""
    table = _table(display)
    return array(display), _are_mapped(display), table.GetGlobalID() if table else None


def apply(mapper, display):
    """Color what a mapper shows as a display does."""
    association, name = array(display)
    table = _table(display)
    if not name or table is None:
        mapper.ScalarVisibilityOff()
        return
    if association == "1":
        mapper.SetScalarModeToUseCellFieldData()
    else:
        mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(name)
    if not _are_mapped(display):
        mapper.SetColorModeToDirectScalars()
        return
    mapper.SetColorModeToMapScalars()
    mapper.SetLookupTable(table.GetClientSideObject())
    mapper.UseLookupTableScalarRangeOn()
    if hasattr(mapper, "SetInterpolateScalarsBeforeMapping"):
        mapper.SetInterpolateScalarsBeforeMapping(association != "1")


def of_block(display, index):
    """The color by which a display tells a block from others; None if it does not."""
    table = _table(display)
    if array(display)[1] != _BLOCK_COLORS or table is None:
        return None
    color = [0.0, 0.0, 0.0]
    table.GetClientSideObject().GetColor(index % _COUNT, color)
    return color


def _table(display):
    return display.GetProperty("LookupTable").GetProxy(0)


def _are_mapped(display):
    """Whether numbers go through the table; else they are colors themselves."""
    mapped = display.GetProperty("MapScalars")
    return mapped is None or bool(mapped.GetElement(0))
