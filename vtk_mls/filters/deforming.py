"""What the filters share that ask something of a deformation."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from vtk_mls import Deformation, arrays
from vtk_mls.filters.algorithm import Algorithm, ask_for_all

_DISPLACEMENT, _WEIGHT = "Displacement", "Weight"


class DeformingFilter(Algorithm):
    """Base of the filters with control points on input port 1 and an image as output.

    Control points are polydata: their points are p, in the undeformed space; a point vector array
    holds q - p. Which one says `SetInputArrayToProcess(0, 1, 0, POINTS, name)`, "Displacement" by
    itself; `SetInputArrayToProcess(1, 1, 0, POINTS, name)` names an array with a positive factor
    for each, by itself "Weight", which may be absent.

    Properties are those of `vtk_mls.Deformation`: Kind, Alpha, Degree and Device, the last "" for
    automatic choice.
    """

    def __init__(self, input_type):
        super().__init__(
            nInputPorts=2, inputType=input_type, nOutputPorts=1, outputType="vtkImageData"
        )
        self._kind = "rigid"
        self._alpha = 1.0
        self._degree = 2
        self._device = ""
        self._known = None  # what the control points and properties were, and the deformation

    def FillInputPortInformation(self, port, info):
        kind = "vtkPolyData" if port == 1 else self.InputType
        info.Set(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), kind)
        return 1

    def SetInputData(self, *port_and_data):
        """`(data)` for port 0 or `(port, data)`: input that no algorithm makes."""
        self.SetInputDataObject(*port_and_data)

    def SetKind(self, kind):
        """One of `vtk_mls.KINDS`."""
        self._set("_kind", kind)

    def GetKind(self):
        return self._kind

    def SetAlpha(self, alpha):
        """How local control points are, above 0."""
        self._set("_alpha", alpha)

    def GetAlpha(self):
        return self._alpha

    def SetDegree(self, degree):
        """1, 2 or 3, of the polynomial kind."""
        self._set("_degree", degree)

    def GetDegree(self):
        return self._degree

    def SetDevice(self, device):
        """As `device` of `vtk_mls.Deformation`; "" for automatic choice."""
        self._set("_device", device or "")

    def GetDevice(self):
        return self._device

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        for port in (0, 1):
            ask_for_all(inInfo[port].GetInformationObject(0))
        return 1

    def _deformation(self, polydata):
        """The deformation by control-point polydata; the same object until something changes."""
        displacement = self._array_name(0, polydata) or _DISPLACEMENT
        weight = self._array_name(1, polydata) or _WEIGHT
        if weight == _WEIGHT and not polydata.GetPointData().HasArray(weight):
            weight = None
        state = (polydata, polydata.GetMTime(), displacement, weight)
        state += (self._kind, self._alpha, self._degree, self._device)
        if self._known is None or self._known[0] != state:
            rest, deformed, weights = arrays.control_points(polydata, displacement, weight)
            deformation = Deformation(
                rest,
                deformed,
                kind=self._kind,
                alpha=self._alpha,
                degree=self._degree,
                weights=weights,
                device=self._device or None,
            )
            self._known = state, deformation
        return self._known[1]

    def _array_name(self, index, polydata):
        """Name that SetInputArrayToProcess gave, or of the attribute that it asked for."""
        info = self.GetInputArrayInformation(index)
        if info.Has(vtkDataObject.FIELD_NAME()):
            return info.Get(vtkDataObject.FIELD_NAME())
        if info.Has(vtkDataObject.FIELD_ATTRIBUTE_TYPE()):
            kind = info.Get(vtkDataObject.FIELD_ATTRIBUTE_TYPE())
            active = polydata.GetPointData().GetAbstractAttribute(kind)
            return active.GetName() if active else None
        return None
