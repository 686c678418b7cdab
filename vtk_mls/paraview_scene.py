"""What ParaView shows when `vtk-mls paraview` starts it without a file: a volume to deform."""

from paraview import simple

volume = simple.Wavelet(registrationName="Volume")
view = simple.GetActiveViewOrCreate("RenderView")
display = simple.Show(volume, view)
simple.ColorBy(display, ("POINTS", "RTData"))
display.SetRepresentationType("Surface")
simple.SetActiveSource(volume)
simple.ResetCamera(view)
simple.Render(view)
