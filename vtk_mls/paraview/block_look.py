"""What a display says of single blocks: which are seen, in which color, how opaque."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataAssembly,
    vtkDataAssemblyUtilities,
)

from vtk_mls.paraview.server_manager import elements

_HIERARCHY = "Hierarchy"
_NAMES = ("Assembly", "BlockSelectors", "BlockColors", "BlockOpacities")


def settings(display):
    """All that a display says of blocks, as one value that can be compared."""
    return [_values(display, name) for name in _NAMES]


class BlockLook:
    """The looks of blocks, by their indices.

    Attributes
    ----------
    hidden : set of int
    colors : dict of [red, green, blue]
        Those that were chosen.
    opacities : dict of float
        Those that were chosen.

    Parameters
    ----------
    display : proxy of a representation
    data : vtkDataObject
        What it shows, or data with the same blocks.
    """

    def __init__(self, display, data):
        self.hidden, self.colors, self.opacities = set(), {}, {}
        assembly = _values(display, "Assembly") or [_HIERARCHY]
        if not isinstance(data, vtkCompositeDataSet) or assembly != [_HIERARCHY]:
            return
        self._tree = vtkDataAssembly()
        vtkDataAssemblyUtilities.GenerateHierarchy(data, self._tree)
        self._parts = self._parts_of(data)
        if selectors := _values(display, "BlockSelectors"):
            self.hidden = set(range(len(self._parts))) - self._selected(selectors)
        self.colors = self._rows(display, "BlockColors", 3)
        opacities = self._rows(display, "BlockOpacities", 1)
        self.opacities = {index: opacity for index, (opacity,) in opacities.items()}

    def _parts_of(self, data):
        """The leaf of the tree, by its flat index, that each block belongs to."""
        leaves = np.array(sorted(self._leaves(self._tree.GetRootNode())))
        indices, iterator = [], data.NewIterator()
        iterator.InitTraversal()
        while not iterator.IsDoneWithTraversal():
            indices.append(iterator.GetCurrentFlatIndex())
            iterator.GoToNextItem()
        return leaves[np.searchsorted(leaves, indices, side="right") - 1].tolist()

    def _leaves(self, node):
        """Flat indices of the leaves below a node, itself included."""
        below = self._tree.GetChildNodes(node, True) or [node]
        leaves = (each for each in below if self._tree.GetNumberOfChildren(each) == 0)
        return {index for each in leaves for index in self._tree.GetDataSetIndices(each, False)}

    def _selected(self, selectors):
        """Indices of the blocks that selectors name."""
        nodes = self._tree.SelectNodes(selectors)
        named = set().union(*(self._leaves(node) for node in nodes))
        return {index for index, part in enumerate(self._parts) if part in named}

    def _rows(self, display, name, count):
        """Numbers by the indices of blocks, from selectors, each with so many numbers."""
        values, found = _values(display, name), {}
        rows = [values[i : i + 1 + count] for i in range(0, len(values), 1 + count)]
        # what is said of a part counts more than what is said of the whole
        for selector, *numbers in sorted(rows, key=lambda row: row[0].count("/")):
            found.update({index: [*map(float, numbers)] for index in self._selected([selector])})
        return found


def _values(display, name):
    changed = display.GetProperty(name)
    return elements(changed) if changed else []
