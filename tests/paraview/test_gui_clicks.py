"""What the README promises of ParaView's GUI, by mouse, in each ParaView there is.

`make test` follows the README; the rest is for `make matrix`.
"""

from __future__ import annotations

import nibabel
import numpy as np
import pytest
from gui_fixtures import (  # noqa: F401  fixtures
    ASIDE,
    BRAIN,
    HAS_QT,
    OWN,
    PROJECT,
    PULL,
    brain,
    by_vtk_mls,
    display,
    gui,
    noise,
    paraview,
    start,
    unavailable,
)
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from vtk_mls.commands import demo


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


@pytest.mark.matrix
def test_nifti_after_vtk_mls(start):
    """A packed NIfTI image opens as a volume under its name, and can be deformed."""
    file = OWN / "brain.nii.gz"
    (PROJECT / OWN).mkdir(parents=True, exist_ok=True)
    whole = nibabel.load(demo.brain_file())
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


@pytest.mark.matrix
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
    gui.enter(f"{gui.folder}/ras.nrrd", "button('Set reader as default')")
    gui.screenshot("1_asked")
    gui.click("button('OK')")
    gui.until("simple.GetActiveSource() != wavelet")
    assert gui.value("simple.GetActiveSource().SMProxy.GetXMLName()") == "MLSImageReader"
    gui.run("read = simple.FindSource('ras.nrrd'); read.UpdatePipeline()")
    bounds = gui.value("list(read.GetDataInformation().GetBounds())")
    assert bounds == [-6, -3, -7, -4, 5, 8]


@pytest.mark.matrix
def test_edits_after_vtk_mls(start):
    """Handles added, removed and laid anew, undo, redo, the cut moved, a state."""
    file = OWN / "wavelet.vti"
    wavelet = vtkRTAnalyticSource()
    writer = vtkXMLImageDataWriter()
    writer.SetInputConnection(wavelet.GetOutputPort())
    (PROJECT / OWN).mkdir(parents=True, exist_ok=True)
    writer.SetFileName(str(PROJECT / file))
    assert writer.Write()
    with start(command=by_vtk_mls(file)) as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        gui.run(BRAIN)
        gui.run("simple.GetDisplayProperties(file, view).SetRepresentationType('Outline')")
        gui.launch("MLS Deform")
        gui.run("deform = simple.GetActiveSource()")
        gui.run("deform.CutFrame = 'deformed'")  # then all that is behind the plane is void
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
