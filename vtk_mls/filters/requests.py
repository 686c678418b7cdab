"""What a filter asks of its inputs, and what is asked of it, in the pipeline's information."""

from __future__ import annotations

from vtkmodules.vtkCommonExecutionModel import (
    vtkExtentTranslator,
    vtkStreamingDemandDrivenPipeline,
)

from vtk_mls.vtk.arrays import ImageGeometry


def ask_for_all(info):
    """Request the whole of an input, on every process."""
    keys = vtkStreamingDemandDrivenPipeline
    if info.Has(keys.WHOLE_EXTENT()):
        info.Set(keys.UPDATE_EXTENT(), info.Get(keys.WHOLE_EXTENT()), 6)
    info.Set(keys.UPDATE_PIECE_NUMBER(), 0)
    info.Set(keys.UPDATE_NUMBER_OF_PIECES(), 1)
    info.Set(keys.UPDATE_NUMBER_OF_GHOST_LEVELS(), 0)


def ask_within_the_whole(info):
    """Take back a request for what is not there any more: VTK keeps it, and fails by it."""
    keys = vtkStreamingDemandDrivenPipeline
    whole, asked = info.Get(keys.WHOLE_EXTENT()), info.Get(keys.UPDATE_EXTENT())
    if whole and asked and not ImageGeometry(whole).holds(asked):
        info.Set(keys.UPDATE_EXTENT(), whole, 6)


def ask_for_extent(info, extent):
    """Request a part of an image, on every process its own."""
    ask_for_all(info)
    info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT(), extent, 6)
    info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT_INITIALIZED(), 1)


def requested_extent(info):
    """The extent of an image that is asked for, as such or as a piece of the whole.

    Only in RequestData has VTK done this itself.
    """
    keys = vtkStreamingDemandDrivenPipeline
    if info.Get(keys.UPDATE_EXTENT_INITIALIZED()) or info.Get(keys.UPDATE_NUMBER_OF_PIECES()) < 2:
        return info.Get(keys.UPDATE_EXTENT())
    translator, extent = vtkExtentTranslator(), [0] * 6
    split = translator.UPDATE_SPLIT_MODE()
    translator.PieceToExtentThreadSafe(
        info.Get(keys.UPDATE_PIECE_NUMBER()),
        info.Get(keys.UPDATE_NUMBER_OF_PIECES()),
        info.Get(keys.UPDATE_NUMBER_OF_GHOST_LEVELS()),
        info.Get(keys.WHOLE_EXTENT()),
        extent,
        info.Get(split) if info.Has(split) else translator.GetSplitMode(),
        0,
    )
    return tuple(extent)
