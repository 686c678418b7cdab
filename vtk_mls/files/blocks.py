"""Datasets that are made of several: blocks, pieces, partitions."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import (
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
)

COMPOSITE = (vtkMultiBlockDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection)


def blocks(data):
    """The datasets of composite data that are not empty; a dataset alone."""
    if isinstance(data, vtkDataSet):
        return [data]
    found, each = [], vtkDataObjectTreeIterator()
    each.SetDataSet(data)
    each.VisitOnlyLeavesOn()
    each.SkipEmptyNodesOn()
    each.InitTraversal()
    while not each.IsDoneWithTraversal():
        found.append(each.GetCurrentDataObject())
        each.GoToNextItem()
    return [block for block in found if isinstance(block, vtkDataSet) and block.GetNumberOfPoints()]


def joined(datasets):
    """Datasets as one: a single one as it is, more as blocks."""
    if len(datasets) == 1:
        return datasets[0]
    together = vtkMultiBlockDataSet()
    for number, dataset in enumerate(datasets):
        together.SetBlock(number, dataset)
    return together
