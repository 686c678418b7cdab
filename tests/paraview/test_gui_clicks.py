"""The steps of the README in ParaView's GUI, and further edits, by mouse."""

from __future__ import annotations

import nibabel
import numpy as np
import pytest
from gui_fixtures import require_qt
from gui_scenes import ASIDE, BRAIN, OWN, PROJECT, PULL, noise, vtk_mls_command, write_image
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls.commands import demo


def test_clicks_of_the_readme(start, brain):
    """From `vtk-mls paraview FILE` to a volume that is bent and cut open."""
    with start(command=vtk_mls_command(brain)) as gui:
        require_qt(gui)
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
        gui.click("drop_down('CutType')")  # visible without scrolling
        gui.click("option('CutType', 'plane')")
        clicks = gui.clicks

        # Each visible handle can be dragged alone, and undone.
        handles = gui.value("handles_in_sight()")
        assert len(handles) > 10
        for number, place in handles[::5]:
            with gui.dragging(place, (12, 9)):
                gui.until("dragged()")
            assert gui.value("dragged()") == [number]
            gui.press("ctrl+z")
            gui.until("not dragged()")

        gui.clicks = clicks
        number, place = max(handles, key=lambda handle: handle[1][0])
        with gui.dragging(place, ASIDE):
            gui.until("dragged()")
            gui.screenshot("2_dragging")
        gui.click("button('Apply')")
        assert gui.clicks == 6
        gui.until("output(deform) and is_cut() and is_bent()")
        assert gui.value("dragged()") == [number]
        assert gui.value("is_cut()")
        gui.run("displays = [simple.GetDisplayProperties(data, view) for data in (file, deform)]")
        assert gui.value("all(display.Representation == 'Volume' for display in displays)")
        assert gui.value("[display.ColorArrayName[1] for display in displays]") == ["T1", "T1"]
        assert gui.value("displays[0].LookupTable.SMProxy is displays[1].LookupTable.SMProxy")
        gui.run("simple.Render(view)")
        gui.screenshot("3_open")

        # Ctrl+Z after one more drag undoes that drag only.
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
    """A compressed NIfTI image opens as a volume with its name, and can be deformed."""
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
    with start(command=vtk_mls_command(file)) as gui:
        gui.run(BRAIN)
        assert gui.value("next(iter(simple.GetSources()))[0]") == "brain.nii.gz"
        bounds = gui.value("list(output(file).GetBounds())")
        in_lps = np.sort([low * [-1, -1, 1, 1], high * [-1, -1, 1, 1]], axis=0)[:, :3]
        np.testing.assert_allclose(np.reshape(bounds, (3, 2)).T, in_lps, atol=1e-3)
        assert gui.value("simple.GetDisplayProperties(file, view).Representation == 'Volume'")
        gui.run("simple.Render(view)")
        gui.screenshot("1_opened")
        gui.add_deform(apply=False)
        number, place = gui.value("handles_in_sight()")[0]
        with gui.dragging(place, ASIDE):
            gui.until("dragged()")
        assert gui.value("dragged()") == [number]
        gui.press("alt+a")
        gui.until("is_bent()")
        gui.screenshot("2_bent")
        assert noise(gui) == []


@pytest.mark.matrix
def test_open_has_our_reader_selected(gui):
    """In ParaView's dialog of readers, Return selects ours."""
    require_qt(gui)
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
    gui.run("image = simple.FindSource('ras.nrrd'); image.UpdatePipeline()")
    bounds = gui.value("list(read.GetDataInformation().GetBounds())")
    assert bounds == [-6, -3, -7, -4, 5, 8]


def add_remove_and_replace_handles(gui):
    """In the table of the panel, with Undo, Redo and Reset."""
    gui.run("import gui_places; gui_places.widen('propertiesDock', 550)")
    gui.find_and_click("table", "InteractivePolyLine")
    gui.find_and_click("tool", "Add")
    gui.until("counts() == [28, 28, 0] and len(dragged()) == 1")
    gui.press("ctrl+z")
    gui.until("counts() == [27, 27, 0]")
    gui.press("ctrl+y")
    gui.until("counts() == [28, 28, 0]")
    gui.find_and_click("table", "InteractivePolyLine")
    gui.find_and_click("tool", "Remove")
    in_step = "len(dragged()) == 1 and rest_of(dragged()[0]) == [10, 10, 0]"
    gui.until(f"counts() == [27, 27, 0] and {in_step}")
    gui.press("ctrl+z")
    gui.until(f"counts() == [28, 28, 0] and {in_step}")
    gui.press("ctrl+y")
    gui.until(f"counts() == [27, 27, 0] and {in_step}")
    gui.press("alt+a")
    gui.find_and_click("tool", "AdvancedButton")
    gui.find_and_click("field", "LatticeDimensions")
    gui.press("ctrl+a")
    gui.type("2")
    gui.until("counts() == [18, 18, 0] and not dragged()")
    gui.screenshot("4_lattice")
    gui.click("button('Reset')")
    gui.until("counts() == [27, 27, 0]")


def move_the_cut(gui):
    """By mouse, then by typing. ParaView does not move a plane that is seen from its side."""
    gui.run("view.GetActiveCamera().Azimuth(45); simple.Render(view)")
    assert gui.value("void_begins()") == 0
    gui.run("before = pending('DeformedPoints')")
    # the arrow of the normal turns the plane, and handles cover it
    with gui.dragging(
        gui.value("farthest_from_handles([(0, 5, z) for z in range(-8, 9)])"), (90, 0)
    ):
        gui.until("pending('CutOrigin')[0] > 2")
        gui.screenshot("5_pushing")
    assert gui.value("list(deform.CutOrigin)") == [0, 0, 0]
    gui.press("alt+a")
    gui.until("deform.CutOrigin[0] > 2")
    assert gui.value("list(deform.CutOrigin)[1:]") == [0, 0]
    assert gui.value("list(deform.CutNormal)") == [1, 0, 0]
    assert gui.value("pending('DeformedPoints') == before")
    gui.until("0 <= void_begins() - deform.CutOrigin[0] < 1")  # the next voxels behind it

    gui.find_and_click("field", "originX")
    gui.press("ctrl+a")
    gui.type("4")
    gui.press("alt+a")
    gui.until("deform.CutOrigin[0] == 4")
    gui.run("simple.Render(view)")
    assert gui.value("void_begins()") == 4
    gui.screenshot("6_cut_moved")


def load_and_edit_a_state(gui):
    """A state has the handles and the result."""
    gui.run("expected = values(deform, 'RTData').copy()")
    gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
    gui.run("simple.Delete(deform); simple.Delete(file); del deform, file")
    gui.until("not simple.GetSources()")
    gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
    gui.run("deform = simple.FindSource('MLSDeform1'); deform.UpdatePipeline()")
    assert gui.value("np.array_equal(values(deform, 'RTData'), expected)")
    gui.run("simple.SetActiveSource(deform); edit('LatticeDimensions', [2, 2, 2])")
    assert gui.value("counts()") == [8, 8, 0]


@pytest.mark.matrix
def test_edits_after_vtk_mls(start):
    """Handles added, removed and replaced, Undo, Redo, the cut moved, a state."""
    wavelet = vtkRTAnalyticSource()
    wavelet.Update()
    file = write_image(OWN / "wavelet.vti", wavelet.GetOutput())
    with start(command=vtk_mls_command(file)) as gui:
        require_qt(gui)
        gui.run(BRAIN)
        gui.run("simple.GetDisplayProperties(file, view).SetRepresentationType('Outline')")
        gui.add_deform(apply=False)
        gui.run("deform.CutFrame = 'deformed'")  # then all points behind the plane are void
        gui.click("drop_down('CutType')")
        gui.click("option('CutType', 'plane')")
        with gui.dragging((10, 10, 0), PULL):
            gui.until("dragged()")
        gui.press("alt+a")
        gui.until("output(deform) and is_cut()")
        add_remove_and_replace_handles(gui)
        move_the_cut(gui)
        load_and_edit_a_state(gui)
        assert noise(gui) == []
