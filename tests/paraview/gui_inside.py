"""Functions of the tests inside ParaView's GUI.

`gui_listener` runs this file in the namespace of the tests' requests. That has `view`, the render
view; most tests define `deform`, a filter, and `volume`, the values of its input.
"""
# ruff: noqa: F821  names that tests define

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkCoordinate, vtkWindowToImageFilter

drawn, frames = [], []


def output(proxy):
    """The output of a proxy; None while it has no point arrays."""
    data = proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0)
    return data if data and data.GetPointData().GetNumberOfArrays() else None


def values(proxy, name=0):
    data = output(proxy)
    return vtk_to_numpy(data.GetPointData().GetArray(name)) if data else np.empty(0)


def is_straight():
    return np.array_equal(values(deform), volume)


def is_bent():
    return len(values(deform)) == len(volume) and not is_straight()


def is_cut():
    return output(deform).GetPointData().HasArray("Void") and bool(values(deform, "Void").any())


def pending(name, proxy=None):
    prop = (deform if proxy is None else proxy).SMProxy.GetProperty(name)
    return [prop.GetUncheckedElement(i) for i in range(prop.GetNumberOfUncheckedElements())]


def pending_rows(name):
    return np.reshape(pending(name), (-1, 3))


def edit(name, elements, proxy=None):
    prop = (deform if proxy is None else proxy).SMProxy.GetProperty(name)
    if len(elements) == 1:
        prop.SetUncheckedElement(0, elements[0])  # of strings, too
    else:
        prop.SetUncheckedElements(elements, len(elements))


def counts():
    """Lengths of the lists of handles: p, q, weights."""
    lists = pending_rows("RestPoints"), pending_rows("DeformedPoints"), pending("Weights")
    return [len(rows) for rows in lists]


def dragged():
    """Indices of dragged handles, pending edits included."""
    is_moved = pending_rows("DeformedPoints") != pending_rows("RestPoints")
    return np.flatnonzero(is_moved.any(axis=1)).tolist()


def applied_drags():
    is_moved = np.not_equal(deform.DeformedPoints, deform.RestPoints)
    return np.flatnonzero(is_moved.reshape(-1, 3).any(axis=1)).tolist()


def rest_of(index):
    return pending_rows("RestPoints")[index].tolist()


def on_screen(places):
    """Pixels (n, 2) of places in the world."""
    coordinate, pixels = vtkCoordinate(), []
    coordinate.SetCoordinateSystemToWorld()
    for place in places:
        coordinate.SetValue(*place)
        pixels.append(coordinate.GetComputedDisplayValue(view.GetRenderer()))
    return np.array(pixels)


def handles_in_sight():
    """Indices and places of handles that no other handle covers."""
    places = pending_rows("DeformedPoints")
    pixels = on_screen(places)
    is_near = np.linalg.norm(pixels[:, None] - pixels, axis=2) < 20
    return [(n, place.tolist()) for n, place in enumerate(places) if is_near[n].sum() == 1]


def drag_of_the_tutorial():
    """The place of the upper white ball in front of the right half of the brain, and a drag of it.

    The drag, in pixels, goes to the edge of the brain.
    """
    x, y, z = places = pending_rows("DeformedPoints").T
    row = np.where((x > 100) & (z > 100), y, -np.inf).argmax()  # mm: right of the plane, in front
    place = places[:, row]
    start, end = on_screen([place, [154, *place[1:]]])
    return place.tolist(), (end - start).tolist()


def picture():
    """The colors (n, 3) of the view's pixels."""
    shot = vtkWindowToImageFilter()
    shot.SetInput(view.GetRenderWindow())
    shot.ReadFrontBufferOff()
    shot.Update()
    return vtk_to_numpy(shot.GetOutput().GetPointData().GetScalars()).astype(int)


def items(collection):
    return [collection.GetItemAsObject(i) for i in range(collection.GetNumberOfItems())]


def widget_proxies(kind, other=None):
    """Proxies of representations in a view whose names contain `kind`."""
    prop = (view if other is None else other).SMProxy.GetProperty("HiddenRepresentations")
    proxies = [prop.GetProxy(i) for i in range(prop.GetNumberOfProxies())]
    return [proxy for proxy in proxies if kind in proxy.GetXMLName()]


def widgets(kind, other=None):
    """Enabled widgets of this kind in a view."""
    found = [proxy.GetClientSideObject().GetWidget() for proxy in widget_proxies(kind, other)]
    return [widget for widget in found if widget.GetEnabled()]


def shown():
    """How many widgets of handles and of planes are shown."""
    return [len(widgets("PolyLineWidget")), len(widgets("ImplicitPlane"))]


def held_handle():
    """The pending position of the handle that was dragged last."""
    (widget,) = widgets("PolyLineWidget")
    representation = widget.GetRepresentation()
    index = representation.GetCurrentHandleIndex()
    place = pending_rows("DeformedPoints")[index]
    assert np.allclose(place, representation.GetHandlePositions().GetTuple(index))
    return place


def distance_to_mouse():
    """Pixels from the dragged handle to the mouse."""
    pixel = on_screen([held_handle()])[0]
    return float(np.abs(pixel - view.GetInteractor().GetEventPosition()).max())


def mapped_props(kind):
    """Visible props of the view whose mapper is of a class."""
    for prop in items(view.GetRenderer().GetViewProps()):
        mapper = hasattr(prop, "GetMapper") and prop.GetMapper()
        if mapper and mapper.IsA(kind) and prop.GetVisibility():
            yield prop


def markers():
    """Colors (n, 3) and diameters (n,) of the drawn handles; None without."""
    for prop in mapped_props("vtkGlyph3DMapper"):
        data = prop.GetMapper().GetInput().GetPointData()
        if data.GetScalars() is None:
            return None
        return vtk_to_numpy(data.GetScalars()), vtk_to_numpy(data.GetArray("Diameter"))


def marker_count():
    return len(markers()[0]) if markers() else 0


def marker_groups():
    """Indices of handles of each color, the smallest group first."""
    groups = {}
    for index, color in enumerate(markers()[0].tolist()):
        groups.setdefault(tuple(color), []).append(index)
    return sorted(groups.values(), key=len)


def large_markers():
    diameters = markers()[1]
    return np.flatnonzero(diameters > 1.4 * np.median(diameters)).tolist()


def label_count():
    return sum(
        prop.GetMapper().GetNumberOfLabels() for prop in mapped_props("vtkLabeledDataMapper")
    )


def arrow_actors(other=None):
    window = (view if other is None else other).GetRenderWindow()
    for renderer in items(window.GetRenderers()):
        for prop in items(renderer.GetViewProps()):
            data = prop.IsA("vtkActor") and prop.GetMapper() and prop.GetMapper().GetInput()
            if data and data.GetPointData().HasArray("Displacement"):
                yield prop


def arrows(other=None):
    """The bounds of the arrows of each actor."""
    return [list(actor.GetMapper().GetInput().GetBounds()) for actor in arrow_actors(other)]


def arrow_pixels():
    red, green, blue = picture().T
    is_amber = (red > 100) & (blue < red // 5) & (abs(3 * green - 2 * red) < red // 4)
    return int(is_amber.sum())


def volumes(other=None):
    """Class names of the visible volumes in a view."""
    props = items((view if other is None else other).GetRenderer().GetVolumes())
    return [type(prop).__name__ for prop in props if prop.GetVisibility()]


def record_updates(cls):
    """Record the last update of a live prop in `drawn`: the object and the arguments."""
    usual = cls.update

    def update(self, *arguments, **keywords):
        usual(self, *arguments, **keywords)
        drawn[:] = [self, *arguments, *keywords.values()]

    cls.update = update


def record_frame(*_):
    """Record in `frames` whether the frame shows the pending handles."""
    places = pending_rows("DeformedPoints")
    if not np.array_equal(places, np.reshape(deform.DeformedPoints, (-1, 3))):
        frames.append(bool(drawn) and np.array_equal(places, drawn[1].deformed))


def rendered_picture():
    simple.Render(view)
    return picture()


def changed_share(first, second):
    """Thousandths of the pixels in which two pictures differ."""
    return 1000 * float((abs(first - second).max(axis=1) > 16).mean())
