"""The image whose grid the output of MLSDeform has."""

from dataclasses import replace

from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData

from vtk_mls import Grid
from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import short_repr
from vtk_mls.filters import pipeline, property_tables
from vtk_mls.filters.algorithm import CachedValue
from vtk_mls.queries import arrival
from vtk_mls.vtk.arrays import ImageGeometry

PORT = 5


class ReferenceInput:
    """A `DeformingFilter` with the property Reference, and an optional image on the last port."""

    def __init__(self, **keywords):
        super().__init__(**keywords)
        self._arrived = CachedValue()

    def DisconnectReference(self):
        """Remove the input from port 5: OutputGrid counts again."""
        self.RemoveAllInputConnections(PORT)

    def has_reference(self):
        """Whether there is a Reference, as a property or an input."""
        return self.GetReference() is not None or self.GetNumberOfInputConnections(PORT) > 0

    def _reference_geometry(self):
        """ImageGeometry of the Reference, None without; the pipeline has that of the input.

        TypeError or ValueError if it is no grid, or an empty one.
        """
        value = self.GetReference()
        if not self.has_reference():
            return None
        if value is None:
            info = self._reference_information()
            geometry, image = ImageGeometry.of_information(info), vtkImageData.GetData(info)
            if image is not None and self._lacks_directions():  # known once it is updated
                geometry = replace(geometry, direction=ImageGeometry.of_image(image).direction)
        elif isinstance(value, vtkImageData):
            geometry = ImageGeometry.of_image(value)
        elif isinstance(value, Grid):
            geometry = ImageGeometry.of_grid(value)
        else:
            expected = property_tables.REFERENCE.values
            raise TypeError(f"`Reference` must be {expected}, got {short_repr(value)}")
        if geometry.is_empty:
            raise InputError("is an empty image; it must have a point", argument="Reference")
        return geometry

    def _lacks_directions(self):
        """Whether only the data of the input have its directions: so it is in ParaView 5.11."""
        info = self._reference_information()
        return info is not None and not info.Has(vtkDataObject.DIRECTION())

    def _reference_information(self):
        """The pipeline information of the input, or None."""
        if not self.GetNumberOfInputConnections(PORT):
            return None
        return self.GetExecutive().GetInputInformation(PORT, 0)

    def _request_reference(self):
        """Request as little of the input as possible: its values do not count."""
        info = self._reference_information()
        if info is not None:
            pipeline.request_extent(info, pipeline.first_cell(ImageGeometry.of_information(info)))

    def _refuse_reference_of(self, mesh):
        if self.has_reference():
            raise InputError(
                f"is the grid of a deformed image, and the input is a {mesh.GetClassName()}, which "
                "keeps its own points; leave the reference out",
                argument="Reference",
            )

    def _check_arrival(self, deformation, source, target):
        """Warn once if nothing on one ImageGeometry arrives on another, that of the Reference."""

        def warn():
            if not arrival.arrives(deformation, source.grid, target.grid):
                moved, grid = arrival.boxes(deformation, source.grid, target.grid)
                self._warn(
                    "nothing of the input arrives on the grid of the reference: deformed, the "
                    f"input is in {moved}; the grid is in {grid}"
                )

        if self.has_reference():
            self._arrived.of((deformation, source, target), warn)
