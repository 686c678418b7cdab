"""What is to be said of a deformed mesh: folded cells, arrays that the file does not hold."""

from __future__ import annotations

from pathlib import Path

_COUNTS = ("InvertedCells", "UncheckedCells")
_DETERMINANT = "JacobianDeterminant"


class InvertedCells:
    """Counts cells that a filter turns inside out, and leaves the output as it would be without.

    Parameters
    ----------
    deform : MLSDeform
    dataset : vtkDataObject
        Its input. Images are not counted, for which the count takes long, nor is a mesh that has
        the filter's arrays already.
    """

    def __init__(self, deform, dataset):
        from vtk_mls.files.blocks import blocks

        self._deform = deform
        self._counts = all(_can_count(block) for block in blocks(dataset))
        deform.SetGenerateJacobianDeterminant(self._counts)

    def taken(self):
        """The number of cells; the arrays that say so leave the output."""
        from vtk_mls.files.blocks import blocks

        if not self._counts:
            return 0
        count = 0
        for block in blocks(self._deform.GetOutput()):
            field = block.GetFieldData()
            inverted = field.GetArray(_COUNTS[0])
            count += 0 if inverted is None else int(inverted.GetValue(0))
            block.GetPointData().RemoveArray(_DETERMINANT)
            for name in _COUNTS:
                field.RemoveArray(name)
        return count


def said_of(inverted):
    """The end of a sentence about the number of cells that are inside out."""
    return f"; {inverted} cell{'s' * (inverted != 1)} inside out" * (inverted > 0)


def left_out(output, path):
    """The end of a sentence about arrays of the input that a file does not hold."""
    from vtk_mls import io
    from vtk_mls.vtk import array_table

    own = {array.name for array in array_table.TABLE if array_table.MESH in array.writers}
    names = [f"`{name}`" for name in io.left_out(output, path) if name not in own]
    if not names:
        return ""
    return f"; without {', '.join(names)}, which {Path(path).suffix} cannot hold"


def _can_count(dataset):
    return not (
        dataset.IsA("vtkImageData")
        or dataset.GetPointData().HasArray(_DETERMINANT)
        or any(dataset.GetFieldData().HasArray(name) for name in _COUNTS)
    )
