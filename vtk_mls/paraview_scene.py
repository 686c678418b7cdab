"""What `vtk-mls paraview` shows: the file that it was given, or a volume to deform."""

import os

from paraview import simple


def open_file(file):
    """A reader of the file, under its name: the plugin's where ParaView has none that serves."""
    name = os.path.basename(file)
    if name.lower().endswith((".nii", ".nii.gz")):
        return simple.MLSImageReader(registrationName=name, FileName=file)
    return simple.OpenDataFile(file, registrationName=name)


view = simple.GetActiveViewOrCreate("RenderView")
file = os.environ.get("VTK_MLS_OPEN")
if file:
    shown = open_file(file)
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
