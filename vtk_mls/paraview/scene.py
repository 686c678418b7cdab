"""What `vtk-mls paraview` shows: the file that it was given, or a volume to deform."""

import os

from paraview import simple

view = simple.GetActiveViewOrCreate("RenderView")
file = os.environ.get("VTK_MLS_OPEN")
if file:
    shown = simple.OpenDataFile(file, registrationName=os.path.basename(file))
else:
    volume = simple.Wavelet(registrationName="Volume")
    shown = simple.MLSDeform(registrationName="Deformed", Input=volume)
    view.CameraPosition = [25, 18, 60]
display = simple.Show(shown, view)
if not file:
    simple.ColorBy(display, ("POINTS", "RTData"))
    display.SetRepresentationType("Surface")
elif shown.GetDataInformation().GetDataSetTypeAsString() == "vtkImageData":
    display.SetRepresentationType("Volume")  # an outline would show nothing of it
simple.SetActiveSource(shown)
simple.ResetCamera(view)
simple.Render(view)
