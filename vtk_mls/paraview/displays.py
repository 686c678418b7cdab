"""The displays of ParaView: copies of their settings, default colors, and those of our mappers."""

import json

import numpy as np
from paraview.modules.vtkRemotingServerManager import vtkSMSettings
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataAssembly,
    vtkDataAssemblyUtilities,
)

from vtk_mls.paraview.server_manager import indexed_blocks, input_of, pending_value, pending_values
from vtk_mls.rendering import volume_colors
from vtk_mls.rendering.rest_surface import DETERMINANT

# All but the representation itself.
_COPIED = (
    *("ColorArrayName", "LookupTable", "MapScalars", "InterpolateScalarsBeforeMapping"),
    *("UseSeparateColorMap", "ScalarOpacityFunction", "UseTransfer2D", "TransferFunction2D"),
    *("UseSeparateOpacityArray", "OpacityArrayName", "Opacity", "AmbientColor", "DiffuseColor"),
    *("EdgeColor", "LineWidth", "PointSize", "Interpolation", "Specular", "Shade", "BlendMode"),
    *("InterpolationType", "VolumeRenderingMode", "ScalarOpacityUnitDistance"),
    *("IsosurfaceValues", "Slice", "SliceMode"),
    # of blocks
    *("Assembly", "BlockSelectors", "BlockColors", "BlockColorsDistinctValues", "BlockOpacities"),
    *("BlockColorArrayNames", "BlockLookupTables", "BlockMapScalars", "BlockUseSeparateColorMaps"),
    "BlockInterpolateScalarsBeforeMappings",
)
_PRIORITY = 1.5  # of default colors: above the settings of the site, below those of the user
_HIERARCHY = "Hierarchy"
_BLOCK_SETTINGS = ("Assembly", "BlockSelectors", "BlockColors", "BlockOpacities")
_BLOCK_COLORS = "vtkBlockColors"
_BLOCK_COLOR_COUNT = 12  # ParaView's table repeats after so many blocks


def copy_settings_of_input(display, displays):
    """Show the output of MLSDeform as one of the displays shows its input."""
    names = copied_settings(display)
    source = input_of(input_of(display)[0]) if names else None
    for other in displays:
        if source is None or input_of(other) != source:
            continue
        for name in names:
            if display.GetProperty(name) and other.GetProperty(name):
                display.GetProperty(name).Copy(other.GetProperty(name))
        display.UpdateVTKObjects()
        if display.GetProperty("Representation") and other.GetProperty("Representation"):
            display.SetRepresentationType(other.GetProperty("Representation").GetElement(0))
        return


def copied_settings(display):
    """The names of the settings that a display has from that of the input; () for other proxies."""
    deform = input_of(display) if display.IsA("vtkSMRepresentationProxy") else None
    return _COPIED if deform and deform[0].GetXMLName() == "MLSDeform" else ()


def color_array(display):
    """Whether cells have the array that colors a display, and its name; "" without an array."""
    association, name = pending_values(display.GetProperty("ColorArrayName"))[3:5]
    return association == "1", name


def color_settings(display):
    """The settings that `apply_colors` reads, as a value to compare."""
    table = _color_table(display)
    return color_array(display), _is_mapped(display), table.GetGlobalID() if table else None


def apply_colors(mapper, display):
    """Color the data of a mapper as a display does."""
    is_of_cells, name = color_array(display)
    table = _color_table(display)
    if not name or table is None:
        mapper.ScalarVisibilityOff()
        return
    set_scalar_mode(mapper, is_of_cells)
    mapper.SelectColorArray(name)
    if not _is_mapped(display):
        mapper.SetColorModeToDirectScalars()
        return
    mapper.SetColorModeToMapScalars()
    mapper.SetLookupTable(table.GetClientSideObject())
    mapper.UseLookupTableScalarRangeOn()
    if hasattr(mapper, "SetInterpolateScalarsBeforeMapping"):
        mapper.SetInterpolateScalarsBeforeMapping(not is_of_cells)


def set_scalar_mode(mapper, is_of_cells):
    """Let a mapper select its array by name among those of cells or points."""
    if is_of_cells:
        mapper.SetScalarModeToUseCellFieldData()
    else:
        mapper.SetScalarModeToUsePointFieldData()


def _color_table(display):
    return display.GetProperty("LookupTable").GetProxy(0)


def _is_mapped(display):
    """Whether the color table is used; otherwise the values are colors."""
    return bool(pending_value(display, "MapScalars", True))


def block_settings(display):
    """All settings of blocks, as a value to compare."""
    return [_values(display, name) for name in _BLOCK_SETTINGS]


class BlockSettings:
    """The settings of single blocks, by the indices of the blocks.

    Those that are `hidden`, and the `colors` (red, green, blue) and `opacities` that the user has
    chosen in a display, a proxy of a representation of `data`.
    """

    def __init__(self, display, data):
        self.hidden, self.colors, self.opacities = set(), {}, {}
        self._display = display
        assembly = _values(display, "Assembly") or [_HIERARCHY]
        if not isinstance(data, vtkCompositeDataSet) or assembly != [_HIERARCHY]:
            return
        self._tree = vtkDataAssembly()
        vtkDataAssemblyUtilities.GenerateHierarchy(data, self._tree)
        self._nodes = self._nodes_of_blocks(data)
        if selectors := _values(display, "BlockSelectors"):
            self.hidden = set(range(len(self._nodes))) - self._selected_blocks(selectors)
        self.colors = {index: color for index, *color in self._rows("BlockColors", 3)}
        self.opacities = dict(self._rows("BlockOpacities", 1))

    def color(self, index):
        """The color of a block; None for the color of the display."""
        if index in self.colors or color_array(self._display)[1] != _BLOCK_COLORS:
            return self.colors.get(index)
        color, table = [0.0, 0.0, 0.0], _color_table(self._display)
        if table is None:
            return None
        table.GetClientSideObject().GetColor(index % _BLOCK_COLOR_COUNT, color)
        return color

    def _nodes_of_blocks(self, data):
        """The tree's dataset index for each block; partitions of a dataset share one."""
        indices = np.unique(self._tree.GetDataSetIndices(self._tree.GetRootNode(), True))
        blocks = [index for index, _ in indexed_blocks(data)]
        return indices[np.searchsorted(indices, blocks, side="right") - 1].tolist()

    def _selected_blocks(self, selectors):
        """The indices of the blocks that selectors name."""
        nodes = self._tree.SelectNodes(selectors)
        selected = {i for node in nodes for i in self._tree.GetDataSetIndices(node, True)}
        return {index for index, node in enumerate(self._nodes) if node in selected}

    def _rows(self, name, count):
        """The index of a block and `count` values, from a list of selectors and values."""
        values = _values(self._display, name)
        rows = [values[i : i + 1 + count] for i in range(0, len(values), 1 + count)]
        # selectors of parts come after those of the whole, which they override
        for selector, *settings in sorted(rows, key=lambda row: row[0].count("/")):
            for index in self._selected_blocks([selector]):
                yield index, *map(float, settings)


def _values(display, name):
    prop = display.GetProperty(name)
    return pending_values(prop) if prop else []


def add_default_colors():
    """Make the editor's colors of JacobianDeterminant ParaView's default: red in folds.

    Unless the user has set others for arrays of this name. The range does not follow the data, so
    that white always is the volume at rest.
    """
    table = {
        "RGBPoints": volume_colors.table().ravel().tolist(),
        "ColorSpace": 0,  # RGB
        "NumberOfTableValues": volume_colors.TABLE_SIZE,
        "ScalarRangeInitialized": 1,
        "AutomaticRescaleRangeMode": -1,  # never
    }
    settings = {"array_lookup_tables": {DETERMINANT: {"PVLookupTable": table}}}
    vtkSMSettings.GetInstance().AddCollectionFromString(json.dumps(settings), _PRIORITY)
