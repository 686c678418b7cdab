"""The scene of `vtk-mls paraview`: the given file, or a volume to deform."""

import os

from paraview import simple

view = simple.GetActiveViewOrCreate("RenderView")
file = os.environ.get("VTK_MLS_OPEN")
if file:
    source = simple.OpenDataFile(file, registrationName=os.path.basename(file))
else:
    volume = simple.Wavelet(registrationName="Volume")
    source = simple.MLSDeform(registrationName="Deformed", Input=volume)
    view.CameraPosition = [25, 18, 60]
display = simple.Show(source, view)
if not file:
    simple.ColorBy(display, ("POINTS", "RTData"))
    display.SetRepresentationType("Surface")
elif source.GetDataInformation().GetDataSetTypeAsString() == "vtkImageData":
    display.SetRepresentationType("Volume")  # the default is an outline
simple.SetActiveSource(source)
simple.ResetCamera(view)
simple.Render(view)
