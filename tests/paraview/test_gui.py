"""What a user does in ParaView's GUI, by real keys and mouse events, in each ParaView there is."""

from __future__ import annotations

import os
import shutil
from functools import partial

import nibabel
import numpy as np
import pytest
from gui import LISTENER, running
from test_scripts import (  # noqa: F401
    NOISE,
    PICTURES,
    PROJECT,
    display,
    paraview,
)
from vtkmodules.vtkImagingCore import vtkImageShrink3D, vtkRTAnalyticSource
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from vtk_mls.demo import volumes

HANDLE = (10, 10, 0)  # the middle of an edge of the wavelet
PULL = (60, 50)  # pixels
ASIDE = (120, 40)

SETUP = """
import numpy as np
from paraview import smtrace
smtrace.start_trace()
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings
from vtkmodules.util.numpy_support import vtk_to_numpy
simple.LoadPlugin("paraview_plugin/vtk_mls_plugin.py", ns=vars(simple))
settings = vtkPVGeneralSettings.GetInstance()

def rtdata(proxy):
    data = proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0)
    filled = data and data.GetPointData().GetNumberOfArrays()
    return vtk_to_numpy(data.GetPointData().GetArray(0)) if filled else np.empty(0)

def is_bent():
    return len(rtdata(deform)) == len(volume) and not is_straight()

def is_straight():
    return np.array_equal(rtdata(deform), volume)

def dragged(pending=False):
    rest = np.reshape(deform.RestPoints, (-1, 3))
    moved = deform.SMProxy.GetProperty("DeformedPoints")
    count = moved.GetNumberOfUncheckedElements()
    pulled = [moved.GetUncheckedElement(i) for i in range(count)]
    moved = np.reshape(pulled if pending else deform.DeformedPoints, (-1, 3))
    return [int(i) for i in np.flatnonzero((moved != rest).any(axis=1))]

wavelet = simple.Wavelet()
wavelet.UpdatePipeline()
simple.Show(wavelet, view)
view.ResetCamera()
simple.Render(view)
simple.SetActiveSource(wavelet)
volume = rtdata(wavelet).copy()
"""

HAS_QT = """
try:
    import gui_places
    answer = True
except ModuleNotFoundError:
    answer = False
"""

BRAIN = """
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
file = simple.GetActiveSource()

def output(proxy):
    data = proxy.SMProxy.GetClientSideObject().GetOutputDataObject(0)
    return data if data and data.GetPointData().GetNumberOfArrays() else None

def values(proxy, name):
    return vtk_to_numpy(output(proxy).GetPointData().GetArray(name))

def pending(name):
    changed = deform.SMProxy.GetProperty(name)
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

def dragged():  # numbers of the handles that are not where they rest, pending edits included
    rest, moved = (np.reshape(pending(n), (-1, 3)) for n in ("RestPoints", "DeformedPoints"))
    return [int(i) for i in np.flatnonzero((moved != rest).any(axis=1))]

def rest_of(number):
    return pending("RestPoints")[3 * number:3 * number + 3]

def counts():
    return [len(pending(n)) for n in ("RestPoints", "DeformedPoints", "Weights")]

def on_screen(places):
    from vtkmodules.vtkRenderingCore import vtkCoordinate
    coordinate = vtkCoordinate()
    coordinate.SetCoordinateSystemToWorld()
    seen = []
    for place in places:
        coordinate.SetValue(*place)
        seen.append(coordinate.GetComputedDisplayValue(view.GetRenderer()))
    return np.array(seen)

def in_sight():  # numbers and places of handles on the sides with no other before or behind
    places = np.reshape(pending("DeformedPoints"), (-1, 3))
    seen = on_screen(places)
    near = np.linalg.norm(seen[:, None] - seen, axis=2) < 20
    is_side = ((places == places.min(axis=0)) | (places == places.max(axis=0))).any(axis=1)
    return [(n, list(p)) for n, p in enumerate(places) if is_side[n] and near[n].sum() == 1]

def free(places):  # the one that is farthest, as it is seen, from every handle
    handles = np.reshape(pending("DeformedPoints"), (-1, 3))
    apart = np.linalg.norm(on_screen(places)[:, None] - on_screen(handles), axis=2)
    return places[int(apart.min(axis=1).argmax())]

def void_begins():  # at what x
    void = np.flatnonzero(values(deform, "Void"))
    return min(output(deform).GetPoint(int(each))[0] for each in void)

def is_bent():
    return not np.array_equal(values(deform, "T1"), values(file, "T1"))

def is_cut():
    return output(deform).GetPointData().HasArray("Void") and bool(values(deform, "Void").any())
"""

ARROWS = """
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

def actors(seen):  # of arrows, and whether a widget shows its handles
    renderers = seen.GetRenderWindow().GetRenderers()
    for renderer in (renderers.GetItemAsObject(i) for i in range(renderers.GetNumberOfItems())):
        props = renderer.GetViewProps()
        for prop in (props.GetItemAsObject(i) for i in range(props.GetNumberOfItems())):
            data = prop.IsA("vtkActor") and prop.GetMapper() and prop.GetMapper().GetInput()
            if data and data.GetPointData().HasArray("Displacement"):
                yield prop

def arrows(seen=view):  # bounds of what they cover
    return [list(actor.GetMapper().GetInput().GetBounds()) for actor in actors(seen)]

def widgets(seen=view):  # how many of handles are shown
    shown = seen.SMProxy.GetProperty("HiddenRepresentations")
    shown = [shown.GetProxy(i) for i in range(shown.GetNumberOfProxies())]
    shown = [each for each in shown if each.GetXMLName() == "PolyLineWidgetRepresentation"]
    return sum(each.GetClientSideObject().GetWidget().GetEnabled() for each in shown)

def amber():  # pixels of their colour in the view
    shot = vtkWindowToImageFilter()
    shot.SetInput(view.GetRenderWindow())
    shot.ReadFrontBufferOff()
    shot.Update()
    red, green, blue = vtk_to_numpy(shot.GetOutput().GetPointData().GetScalars()).T.astype(int)
    return int(((red > 100) & (blue < red // 5) & (abs(3 * green - 2 * red) < red // 4)).sum())
"""

REPLAY = """
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
deform = FindSource("MLSDeform1")
UpdatePipeline(proxy=deform)
output = deform.SMProxy.GetClientSideObject().GetOutputDataObject(0)
bent = np.load("{folder}/bent.npy")
np.testing.assert_array_equal(vtk_to_numpy(output.GetPointData().GetArray("RTData")), bent)
"""


def unavailable(what):
    reason = f"{what}: tests/paraview/install.sh says why"
    (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(reason)


@pytest.fixture
def start(paraview, display, request):
    """A context manager for a running GUI."""
    missing = [tool for tool in ("Xvfb", "xdotool", "import") if not shutil.which(tool)]
    if missing:
        unavailable(f"no {', '.join(missing)} on this system")
    name = request.node.originalname.removeprefix("test_")
    folder = PICTURES / request.node.callspec.id / name
    return partial(running, paraview, PROJECT, folder, display)


@pytest.fixture
def gui(start):
    """A running GUI with a wavelet, which must not print an error or a warning."""
    with start() as gui:
        gui.run(SETUP)
        yield gui
        assert noise(gui) == []


@pytest.fixture(scope="module")
def brain():
    """File of a volume, relative to the project."""
    reader = vtkNIFTIImageReader()
    reader.SetFileName(str(volumes.brain()))
    smaller = vtkImageShrink3D()
    smaller.SetInputConnection(reader.GetOutputPort())
    smaller.SetShrinkFactors(2, 2, 2)
    smaller.Update()
    smaller.GetOutput().GetPointData().GetScalars().SetName("T1")
    writer = vtkXMLImageDataWriter()
    writer.SetInputConnection(smaller.GetOutputPort())
    file = PICTURES / "brain.vti"
    (PROJECT / PICTURES).mkdir(parents=True, exist_ok=True)
    writer.SetFileName(str(PROJECT / file))
    assert writer.Write()
    return file


def noise(gui):
    """The errors and warnings that it has printed."""
    return [line for line in gui.printed.splitlines() if NOISE.search(line)]


def test_harness_can_fail(start):
    with start() as gui:
        with pytest.raises(AssertionError, match="no_such_name"):
            gui.run("no_such_name")
        gui.run(SETUP)
        assert noise(gui) == []
        gui.run("simple.MLSDeform(Input=wavelet, Alpha=-1.0).UpdatePipeline()")
        assert any("`alpha`" in line for line in noise(gui))


def test_drag_apply_undo_and_keep(gui, paraview, display):
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    gui.screenshot("1_applied")

    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
        gui.screenshot("2_dragging")
        assert gui.value("dragged()") == []
    gui.press("alt+a")
    gui.until("is_bent()")
    (number,) = gui.value("dragged()")
    assert gui.value(f"deform.RestPoints[{3 * number}:{3 * number + 3}]") == list(HANDLE)
    deformed = gui.value(f"deform.DeformedPoints[{3 * number}:{3 * number + 3}]")
    assert deformed[0] > HANDLE[0] + 2
    assert deformed[1] > HANDLE[1] + 2
    gui.screenshot("3_bent")

    gui.press("ctrl+z")
    gui.until("dragged() == []")
    gui.until("is_straight()")
    gui.press("ctrl+y")
    gui.until(f"dragged() == [{number}]")
    gui.until("is_bent()")

    gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
    gui.run(f"np.save('{gui.folder}/bent.npy', rtdata(deform))")
    trace = PROJECT / gui.folder / "trace.py"
    trace.write_text(gui.value("smtrace.stop_trace()") + REPLAY.format(folder=gui.folder))
    paraview.check(gui.folder / trace.name, display=display)

    gui.run("simple.Delete(deform); simple.Delete(wavelet); del deform, wavelet")
    gui.until("not simple.GetSources()")
    gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
    gui.run("deform = simple.FindSource('MLSDeform1'); deform.UpdatePipeline()")
    assert gui.value("is_bent()")
    assert gui.value(f"np.array_equal(rtdata(deform), np.load('{gui.folder}/bent.npy'))")
    assert gui.value("dragged()") == [number]
    gui.run("simple.SetActiveSource(deform)")
    with gui.dragging(deformed, (0, 80)):
        gui.until("len(dragged(pending=True)) == 1")


def test_arrows_show_what_was_dragged(gui):
    gui.run(ARROWS)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight() and widgets() == 1")
    assert gui.value("[arrows(), amber()]") == [[], 0]  # handles that rest have none

    # While a handle is dragged, when it is let go, undone, done again and applied.
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True) and arrows()")
        gui.screenshot("1_dragging")
        assert gui.value("dragged()") == []
    gui.run("moved = deform.SMProxy.GetProperty('DeformedPoints')")
    gui.run("ends = [moved.GetUncheckedElement(i) for i in range(81)]")
    gui.run("ends = np.reshape(ends, (-1, 3))[dragged(pending=True)[0]]")
    (bounds,) = gui.value("arrows()")
    for axis in (0, 1):
        assert bounds[2 * axis] < HANDLE[axis] + 0.1
        assert bounds[2 * axis + 1] == pytest.approx(gui.value(f"ends[{axis}]"), abs=0.2)
    assert gui.value("amber()") > 20
    flags = "[[each.GetPickable(), each.GetUseBounds()] for each in actors(view)]"
    assert gui.value(flags) == [[0, 0]]
    gui.press("ctrl+z")
    gui.until("not arrows() and not amber()")
    gui.press("ctrl+y")
    gui.until("arrows() and amber() > 20")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("arrows()") == [bounds]
    gui.screenshot("2_applied")

    # Only with the widget, in the view that shows it.
    gui.run("""
other = simple.CreateView("RenderView")
simple.AssignViewToLayout(view=other)
simple.Show(deform, other)
simple.ResetCamera(other)""")
    gui.until("widgets(other) == 1 and widgets() == 0")
    assert gui.value("arrows(other)") == [bounds]
    assert gui.value("arrows()") == []
    gui.run("simple.Render(other)")
    gui.screenshot("3_two_views")
    gui.run("simple.Delete(other); del other; simple.SetActiveView(view)")
    gui.until("widgets() == 1 and arrows()")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.until("widgets() == 0")
    assert gui.value("[arrows(), amber()]") == [[], 0]
    gui.run("simple.SetActiveSource(deform)")
    gui.screenshot("4_selected_again")
    gui.run("simple.Delete(deform); del deform, moved")
    gui.until("len(simple.GetSources()) == 1")
    assert gui.value("[arrows(), amber()]") == [[], 0]


def test_line_between_handles_cannot_be_dragged(gui):
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    gui.run("camera = view.GetActiveCamera()")
    for place in ((10, 10, 5), (-10, 0, 5), (10, -5, 10)):  # where the widget has its line
        gui.run("before = camera.GetPosition()")
        with gui.dragging(place, (40, 0)):
            gui.until("camera.GetPosition() != before")  # as anywhere beside the handles
        assert gui.value("dragged(pending=True)") == []


def by_vtk_mls(file):
    """How `vtk-mls paraview FILE` starts a ParaView."""
    options = ("--dr", f"--script={LISTENER}")
    command = ("python3", "-m", "vtk_mls", "paraview", str(file))
    return (*command, *(f"--option={each}" for each in options))


def test_clicks_of_the_readme(start, brain):
    """From `vtk-mls paraview FILE` to a volume that is bent and cut open, and on; by mouse."""
    with start(command=by_vtk_mls(brain)) as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        gui.run(BRAIN)
        assert gui.value("next(iter(simple.GetSources()))[0]") == "brain.vti"
        gui.run("simple.Render(view)")
        gui.screenshot("1_opened")
        gui.clicks = 0
        gui.click("menu_item('Filters')")
        gui.hover("menu_item('MLS Deformation')")
        gui.click("menu_item('MLS Deform')")
        gui.until("simple.GetActiveSource() != file")
        gui.run("deform = simple.GetActiveSource()")
        gui.click("drop_down('CutType')")  # in sight without scrolling
        gui.click("option('CutType', 'plane')")
        clicks = gui.clicks

        # Any handle of a side can be taken hold of, alone, and let go again.
        handles = gui.value("in_sight()")
        assert len(handles) > 10
        for number, place in handles[::5]:
            with gui.dragging(place, (12, 9)):
                gui.until("dragged()")
            assert gui.value("dragged()") == [number]
            gui.press("ctrl+z")
            gui.until("not dragged()")

        gui.clicks = clicks
        number, place = max(handles, key=lambda each: each[1][0])
        with gui.dragging(place, ASIDE):
            gui.until("dragged()")
            gui.screenshot("2_dragging")
        gui.click("button('Apply')")
        assert gui.clicks == 6
        gui.until("output(deform) and is_cut() and is_bent()")
        assert gui.value("dragged()") == [number]
        assert gui.value("is_cut()")
        gui.run("shown = [simple.GetDisplayProperties(each, view) for each in (file, deform)]")
        assert gui.value("[each.Representation == 'Volume' for each in shown]") == [True, True]
        assert gui.value("[each.ColorArrayName[1] for each in shown]") == ["T1", "T1"]
        assert gui.value("shown[0].LookupTable.SMProxy is shown[1].LookupTable.SMProxy")
        gui.run("simple.Render(view)")
        gui.screenshot("3_open")

        # Ctrl+Z after one more drag takes back that drag alone.
        with gui.dragging(handles[0][1], (30, 20)):
            gui.until("len(dragged()) == 2")
        gui.press("ctrl+z")
        gui.until(f"dragged() == [{number}]")
        gui.press("ctrl+y")
        gui.until("len(dragged()) == 2")
        gui.press("ctrl+z")
        assert gui.value("is_bent()")
        assert noise(gui) == []


def test_nifti_after_vtk_mls(start):
    """A packed NIfTI image opens as a volume under its name, and can be deformed."""
    file = PICTURES / "brain.nii.gz"
    (PROJECT / PICTURES).mkdir(parents=True, exist_ok=True)
    whole = nibabel.load(volumes.brain())
    every_third = nibabel.Nifti1Image(
        np.asarray(whole.dataobj)[::3, ::3, ::3], whole.affine @ np.diag([3, 3, 3, 1])
    )
    nibabel.save(every_third, PROJECT / file)
    low, high = (
        every_third.affine @ [*n, 1] for n in (np.zeros(3), np.array(every_third.shape) - 1)
    )
    with start(command=by_vtk_mls(file)) as gui:
        gui.run(BRAIN)
        assert gui.value("next(iter(simple.GetSources()))[0]") == "brain.nii.gz"
        bounds = gui.value("list(output(file).GetBounds())")
        in_lps = np.sort([low * [-1, -1, 1, 1], high * [-1, -1, 1, 1]], axis=0)[:, :3]
        np.testing.assert_allclose(np.reshape(bounds, (3, 2)).T, in_lps, atol=1e-3)
        assert gui.value("simple.GetDisplayProperties(file, view).Representation == 'Volume'")
        gui.run("simple.Render(view)")
        gui.screenshot("1_opened")
        gui.launch("MLS Deform")
        gui.run("deform = simple.GetActiveSource()")
        number, place = gui.value("in_sight()")[0]
        with gui.dragging(place, ASIDE):
            gui.until("dragged()")
        assert gui.value("dragged()") == [number]
        gui.press("alt+a")
        gui.until(
            "output(deform) and not np.array_equal(values(deform, 'NIFTI'), values(file, 'NIFTI'))"
        )
        gui.screenshot("2_bent")
        assert noise(gui) == []


def test_open_has_our_reader_selected(gui):
    """Where ParaView asks which reader to take, Return is right."""
    if not gui.run(HAS_QT):
        unavailable("no Qt for Python beside this ParaView")
    header = (
        "NRRD0004\ntype: uchar\ndimension: 3\nspace: RAS\nsizes: 4 4 4\nencoding: raw\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (3,4,5)\n\n"
    )
    (PROJECT / gui.folder / "ras.nrrd").write_bytes(header.encode() + bytes(range(64)))
    gui.press("ctrl+o")
    gui.hover("button('Cancel')")
    gui.type(f"{gui.folder}/ras.nrrd")
    gui.hover("button('Set reader as default')")
    gui.screenshot("1_asked")
    gui.click("button('OK')")
    gui.until("simple.GetActiveSource() != wavelet")
    assert gui.value("simple.GetActiveSource().SMProxy.GetXMLName()") == "MLSImageReader"
    gui.run("read = simple.FindSource('ras.nrrd'); read.UpdatePipeline()")
    bounds = gui.value("list(read.GetDataInformation().GetBounds())")
    assert bounds == [-6, -3, -7, -4, 5, 8]


def test_edits_after_vtk_mls(start):
    """Handles added, removed and laid anew, undo, redo, the cut moved, a state."""
    file = PICTURES / "wavelet.vti"
    wavelet = vtkRTAnalyticSource()
    writer = vtkXMLImageDataWriter()
    writer.SetInputConnection(wavelet.GetOutputPort())
    (PROJECT / PICTURES).mkdir(parents=True, exist_ok=True)
    writer.SetFileName(str(PROJECT / file))
    assert writer.Write()
    with start(command=by_vtk_mls(file)) as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        gui.run(BRAIN)
        gui.run("simple.GetDisplayProperties(file, view).SetRepresentationType('Outline')")
        gui.launch("MLS Deform")
        gui.run("deform = simple.GetActiveSource()")
        gui.click("drop_down('CutType')")
        gui.click("option('CutType', 'plane')")
        with gui.dragging((10, 10, 0), PULL):
            gui.until("dragged()")
        gui.press("alt+a")
        gui.until("output(deform) and is_cut()")

        # Add and remove a handle, undo and redo that; and lay a lattice.
        gui.run("import gui_places; gui_places.widen('propertiesDock', 550)")
        gui.find_and_click("table", "InteractivePolyLine")
        gui.find_and_click("tool", "Add")
        gui.until("counts() == [84, 84, 0] and len(dragged()) == 1")  # the lists are in step
        gui.press("ctrl+z")
        gui.until("counts() == [81, 81, 0]")
        gui.press("ctrl+y")
        gui.until("counts() == [84, 84, 0]")
        gui.find_and_click("table", "InteractivePolyLine")
        gui.find_and_click("tool", "Remove")
        in_step = "len(dragged()) == 1 and rest_of(dragged()[0]) == [10, 10, 0]"
        gui.until(f"counts() == [81, 81, 0] and {in_step}")
        gui.press("ctrl+z")
        gui.until(f"counts() == [84, 84, 0] and {in_step}")
        gui.press("ctrl+y")
        gui.until(f"counts() == [81, 81, 0] and {in_step}")
        gui.press("alt+a")
        gui.find_and_click("tool", "AdvancedButton")
        gui.find_and_click("field", "LatticeDimensions")
        gui.press("ctrl+a")
        gui.type("2")
        gui.until("counts() == [54, 54, 0] and not dragged()")
        gui.screenshot("4_lattice")
        gui.click("button('Reset')")
        gui.until("counts() == [81, 81, 0]")

        # Push the plane by mouse. ParaView does not move one that is seen exactly from its side.
        gui.run("view.GetActiveCamera().Azimuth(45); simple.Render(view)")
        assert gui.value("void_begins()") == 0
        gui.run("before = pending('DeformedPoints')")
        # beside the arrows of the normal, which turn it, and away from handles on and before it
        with gui.dragging(gui.value("free([(0, 5, z) for z in range(-8, 9)])"), (90, 0)):
            gui.until("pending('CutOrigin')[0] > 2")
            gui.screenshot("5_pushing")
        assert gui.value("list(deform.CutOrigin)") == [0, 0, 0]
        gui.press("alt+a")
        gui.until("deform.CutOrigin[0] > 2")
        assert gui.value("list(deform.CutOrigin)[1:]") == [0, 0]
        assert gui.value("list(deform.CutNormal)") == [1, 0, 0]
        assert gui.value("pending('DeformedPoints') == before")
        gui.until("0 <= void_begins() - deform.CutOrigin[0] < 1")  # the next voxels behind it

        # Move the cut by typing.
        gui.find_and_click("field", "originX")
        gui.press("ctrl+a")
        gui.type("4")
        gui.press("alt+a")
        gui.until("deform.CutOrigin[0] == 4")
        gui.run("simple.Render(view)")
        assert gui.value("void_begins()") == 4
        gui.screenshot("6_cut_moved")

        # A state, and what the mouse does to what it brings back.
        gui.run("wanted = values(deform, 'RTData').copy()")
        gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
        gui.run("simple.Delete(deform); simple.Delete(file); del deform, file")
        gui.until("not simple.GetSources()")
        gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
        gui.run("deform = simple.FindSource('MLSDeform1'); deform.UpdatePipeline()")
        assert gui.value("np.array_equal(values(deform, 'RTData'), wanted)")
        gui.run("simple.SetActiveSource(deform); before = dragged()")
        gui.run("edited = deform.SMProxy.GetProperty('LatticeDimensions')")
        gui.run("edited.SetUncheckedElements([2, 2, 2], 3)")
        assert gui.value("counts()") == [24, 24, 0]
        assert noise(gui) == []


WATCHED = """
wavelet = simple.Wavelet()
wavelet.UpdatePipeline()
deform = simple.MLSDeform(Input=wavelet)
names = ("LatticeDimensions", "DeformedPoints", "RestPoints")
lattice, moved, rest = (deform.SMProxy.GetProperty(name) for name in names)
answer = []
for edited, values in ((lattice, [2] * 3), (moved, [1.0] * 27), (moved, [1.0] * 24)):
    edited.SetUncheckedElements(values, len(values))
    answer.append(rest.GetNumberOfUncheckedElements())
"""
LAID_ADDED_REMOVED = [24, 27, 24]


def test_handles_are_watched_when_loaded_by_path(start, paraview):
    folder = "/project" if paraview.prefix else str(PROJECT)
    with start(PV_PLUGIN_PATH=f"{folder}/paraview_plugin") as gui:
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []


def load_new(gui):
    """Load the plugin in the dialog for plugins, which stays open."""
    gui.click("menu_item('Tools')")
    gui.click("menu_item('Manage Plugins')")
    gui.click("button('Load New')")
    gui.hover("button('Cancel')")
    gui.type("paraview_plugin/vtk_mls_plugin.py")
    gui.until("hasattr(servermanager.filters, 'MLSDeform')")


def test_handles_are_watched_when_loaded_by_mouse(start):
    with start() as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        load_new(gui)
        gui.click("button('Close')")
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []


def test_handles_are_watched_when_loaded_by_themselves(start, paraview, request):
    """Auto Load is ticked by mouse, ParaView left and started again."""
    folder = PICTURES / request.node.callspec.id / "auto_load/home"
    shutil.rmtree(PROJECT / folder, ignore_errors=True)
    (PROJECT / folder / ".config").mkdir(parents=True)
    welcome = "[General]\nGeneralSettings.ShowWelcomeDialog=false\n"
    (PROJECT / folder / ".config/ParaView.ini").write_text(welcome)  # for every version
    home = f"HOME={'/project' if paraview.prefix else PROJECT}/{folder}"
    command = ("env", home, "paraview", f"--script={LISTENER}")
    with start(command=command) as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        load_new(gui)
        gui.find_in_tree("vtk_mls_plugin", clicks=2)  # which opens it
        gui.find_in_tree("Auto Load", column=1)
        gui.screenshot("1_ticked")
        gui.click("button('Close')")
        gui.end()
    with start(command=command) as gui:
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []


def test_weights_that_are_not_used_stay_so(start):
    """Also when all handles are removed and others added."""
    with start() as gui:
        gui.run(SETUP)
        gui.run("""
proxy = servermanager.filters.MLSDeform(Input=wavelet)  # without a panel, whose widget wants one
servermanager.ProxyManager().RegisterProxy("sources", "alone", proxy)
lists = [proxy.SMProxy.GetProperty(name) for name in ("DeformedPoints", "RestPoints", "Weights")]
counts = []
for values in ([], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]):
    lists[0].SetUncheckedElements(values, len(values))
    counts.append([each.GetNumberOfUncheckedElements() for each in lists])""")
        assert gui.value("counts") == [[0, 0, 0], [3, 3, 0], [6, 6, 0]]


def test_auto_apply_follows_the_drag(gui):
    gui.run("settings.SetAutoApply(True)")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.until("is_straight()")
    with gui.dragging(HANDLE, PULL):
        gui.until("is_bent()")
        gui.screenshot("1_dragging")
    assert len(gui.value("dragged()")) == 1


def test_lists_keep_in_step(gui):
    gui.launch("MLS Deform")
    gui.run("""
deform = simple.GetActiveSource()
rest, moved, weights, lattice = (
    deform.SMProxy.GetProperty(name)
    for name in ("RestPoints", "DeformedPoints", "Weights", "LatticeDimensions")
)

def pending(changed):
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

def edit(changed, values):
    changed.SetUncheckedElements(values, len(values))

before = pending(moved)
new = [1.0, 2.0, 3.0]""")
    gui.press("alt+a")
    gui.until("is_straight()")

    # A handle that is added rests where it appears; one that is removed does so in both lists.
    gui.run("edit(weights, [2.0] * 27); edit(moved, before[:15] + new + before[15:])")
    assert gui.value("pending(rest) == pending(moved)")
    assert gui.value("pending(weights)") == [2] * 5 + [1] + [2] * 22
    gui.run("edit(rest, before[3:15] + new + before[15:])")
    assert gui.value("pending(moved) == pending(rest)")
    assert gui.value("pending(weights)") == [2] * 4 + [1] + [2] * 22

    # A handle goes along with its place at rest, as far dragged as it is.
    gui.run("edit(moved, [7.0, *pending(moved)[1:]]); first = pending(rest)[0]")
    gui.run("edit(rest, [first + 2, *pending(rest)[1:]])")
    assert gui.value("pending(moved)[0]") == 9
    assert gui.value("pending(moved)[1:] == pending(rest)[1:]")

    # A lattice is laid in one step; a drag and Apply take all of it.
    gui.run("edit(lattice, [2, 2, 4])")
    assert gui.value("pending(moved) == pending(rest)")
    assert gui.value("pending(rest)[:6]") == [-10, -10, -10, 10, -10, -10]
    assert gui.value("pending(weights)") == []
    assert gui.value("len(deform.RestPoints)") == 81
    with gui.dragging((10, 10, 10), PULL):
        gui.until("pending(moved) != pending(rest)")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("[len(deform.RestPoints), len(deform.DeformedPoints)]") == [48, 48]
    gui.press("ctrl+z")
    gui.until("len(deform.RestPoints) == len(deform.DeformedPoints) == 81 and is_straight()")

    # Reset takes an edit back in all lists.
    gui.run("edit(moved, pending(moved)[3:])")
    assert gui.value("len(pending(rest))") == 78
    gui.run("moved.ClearUncheckedElements(); rest.ClearUncheckedElements()")
    gui.run("edit(moved, pending(moved)[:-3])")
    assert gui.value("pending(rest) == pending(moved)")


def test_a_source_two_filters_and_a_reload(gui):
    gui.launch("MLS Control Points")
    gui.run("handles = simple.GetActiveSource()")
    assert gui.value("len(handles.DeformedPoints)") == 24
    table = PROJECT / gui.folder / "handles.csv"
    table.write_text("1,2,3,4,5,6,2\n0,0,0,0,0,0,1\n")
    gui.run(f"""
def pending(name):
    changed = handles.SMProxy.GetProperty(name)
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

handles.SMProxy.GetProperty("Mode").SetUncheckedElement(0, "file")
handles.SMProxy.GetProperty("FileName").SetUncheckedElement(0, "{gui.folder}/{table.name}")""")
    assert gui.value("pending('RestPoints')") == [1, 2, 3, 0, 0, 0]
    assert gui.value("pending('DeformedPoints')") == [4, 5, 6, 0, 0, 0]
    assert gui.value("pending('Weights')") == [2, 1]
    gui.press("alt+a")
    gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.launch("MLS Deform")
    gui.press("alt+a")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("own = rtdata(deform).copy()")
    gui.run("deform.ControlPoints = handles; deform.UpdatePipeline()")
    assert gui.value("is_bent() and not np.array_equal(rtdata(deform), own)")
    gui.run("deform.ControlPoints = None; deform.UpdatePipeline()")
    assert gui.value("np.array_equal(rtdata(deform), own)")
    gui.screenshot("1_two")
    gui.run("for each in (deform, handles): simple.Delete(each)")
    gui.run("del deform, handles, each")
    gui.until("len(simple.GetSources()) == 2")
