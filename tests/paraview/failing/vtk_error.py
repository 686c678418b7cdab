"""Must fail: a pipeline that only prints a VTK error."""

from vtkmodules.vtkFiltersCore import vtkContourFilter

vtkContourFilter().Update()
