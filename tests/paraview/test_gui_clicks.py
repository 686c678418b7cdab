"""The steps of the README in ParaView's GUI, by mouse."""

from __future__ import annotations

import nibabel
import numpy as np
import pytest
from gui import HEIGHT, WIDTH
from gui_scenes import ASIDE, BRAIN, OWN, PROJECT, noise, require_qt, vtk_mls_command

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
        gui.hover("menu_item('MLS Deformation')", opens="menu_item('MLS Deform')")
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

        # The drag of the page ends in the same picture in windows of all sizes: no line is printed.
        gui.clicks, ends = clicks, []
        for size in ((1000, 800), (WIDTH, HEIGHT)):
            gui.resize(*size)
            gui.run("simple.ResetCamera(view); simple.Render(view)")
            with gui.dragging(*gui.value("drag_of_the_tutorial()")):
                gui.until("dragged()")
                gui.screenshot(f"2_dragging_{size[0]}")
            (number,) = gui.value("dragged()")
            ends.append([number, *gui.value(f"pending_rows('DeformedPoints')[{number}].tolist()")])
            gui.press("ctrl+z")
            gui.until("not dragged()")
        np.testing.assert_allclose(ends[0], ends[1], atol=1)  # mm, half a pixel
        gui.press("ctrl+y")
        gui.click("button('Apply')")
        assert gui.clicks == 7
        gui.until("output(deform) and is_cut() and is_bent()")
        assert gui.value("dragged()") == [number]
        assert "MLSDeform:" not in gui.printed
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
    bounds = gui.value("list(image.GetDataInformation().GetBounds())")
    assert bounds == [-6, -3, -7, -4, 5, 8]

    # A file with times is a series, and so is a group of files.
    steps = np.stack([np.full((4, 4, 4), value, np.float32) for value in range(2)], axis=-1)
    for name, values in (("beats", steps), ("scan0", steps[..., 0]), ("scan1", steps[..., 1])):
        file = PROJECT / gui.folder / f"{name}.nii"
        nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), file)
    folder = gui.value(f"__import__('os').path.abspath('{gui.folder}')")
    for name in ("beats.nii", "scan..nii"):
        gui.press("ctrl+o")
        gui.hover("button('Cancel')")
        gui.type(f"{folder}/")
        if name == "beats.nii":
            gui.enter(name, "no_button('Cancel')")
        else:
            gui.type(name)  # which selects the group
            gui.click("button('OK')")
        gui.until("simple.GetActiveSource().SMProxy != image.SMProxy")
        gui.run("image = simple.GetActiveSource()")
        assert gui.value("list(image.TimestepValues)") == [0, 1]
        for time in (1, 0):
            gui.run(f"image.UpdatePipeline({time})")
            assert gui.value("float(values(image).min())") == time
