"""Python's garbage collector runs between the request for a later picture and that picture."""

import gc

import scene  # noqa: F401  the plugin makes vtk_mls importable
from paraview import simple

from vtk_mls.paraview import views

view = simple.GetActiveViewOrCreate("RenderView")
sphere = simple.Sphere()
simple.Show(sphere, view)
simple.Render(view)
if hasattr(view, "MakeRenderWindowInteractor"):
    view.MakeRenderWindowInteractor(True)
assert view.GetInteractor()
number = view.SMProxy.GetGlobalID()
for radius in (2, 3):
    views.render_later([number])
    views.render_later([number])
    gc.collect()
    assert list(views._pending) == [number]
    sphere.Radius = radius
    simple.Render(view)
    assert not views._pending
