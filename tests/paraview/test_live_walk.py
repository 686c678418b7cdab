"""Undo, animations, states and deletions while an edit waits for Apply."""

from __future__ import annotations

import pytest
from gui_scenes import AS_VOLUME, HANDLE, LIVE, PULL, VALUES, WAVELET, require_qt

pytestmark = pytest.mark.matrix
VOLUME = ["vtkVolume"]  # ParaView's own is of another class
BLEND = """
track = simple.GetAnimationTrack("Blend", proxy=deform)
track.KeyFrames = [simple.CompositeKeyFrame(KeyTime=t, KeyValues=[t]) for t in (0.0, 1.0)]
scene = simple.GetAnimationScene()
"""


def drag(gui):
    """Leave an edit pending."""
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged() and drawn")


@pytest.fixture(autouse=True)
def deform(gui):
    """A filter that is applied, shown as a volume."""
    gui.run(LIVE)
    gui.add_deform(apply=False)
    gui.press("alt+a")
    gui.until("is_straight() and volumes()")
    gui.run("own = volumes()")


def test_undo_reset_animations_and_states(gui):
    drag(gui)
    assert gui.value("volumes()") == VOLUME
    for keys, is_edited in (("ctrl+z", False), ("ctrl+y", True), ("alt+r", False)):
        gui.press(keys)
        gui.until(f"bool(dragged()) is {is_edited}")
        gui.run("simple.Render(view)")
        assert (gui.value("volumes()") == VOLUME) is is_edited, keys
        gui.screenshot(keys)
    drag(gui)
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.press("ctrl+z")
    gui.until("is_straight()")
    gui.press("ctrl+y")
    gui.until("is_bent()")
    gui.run("simple.Render(view)")
    assert gui.value("volumes() == own")

    # Animation, with another handle's edit pending.
    gui.run("drawn.clear()")
    with gui.dragging((10, -10, 0), PULL):
        gui.until("len(dragged()) == 2 and drawn")
    gui.run(f"""{BLEND}
scene.AnimationTime = 0.5 * (scene.StartTime + scene.EndTime)
simple.Render(view)
half = np.reshape(deform.RestPoints, (-1, 3))
half = half + 0.5 * (pending_rows('DeformedPoints') - half)""")
    assert gui.value("volumes()") == VOLUME
    assert gui.value("abs(drawn[1].deformed - half).max()") < 1e-9
    gui.run("scene.Play(); simple.Delete(track); del track; simple.Render(view)")
    assert gui.value("len(dragged())") == 2

    # A state has the applied values; saving it keeps the edit.
    state = f"{gui.folder}/state.pvsm"
    gui.run(f"simple.SaveState({state!r}); simple.Render(view)")
    assert gui.value("volumes()") == VOLUME
    gui.run(f"simple.LoadState({state!r})")
    gui.run("""
sources = [s for s in simple.GetSources().values() if s.GetXMLName() == "MLSDeform"]
loaded = next(source for source in sources if source != deform)
moved = np.array(loaded.DeformedPoints)
simple.Render(view)""")
    assert gui.value("np.array_equal(moved, deform.DeformedPoints)")
    assert gui.value("volumes()") == VOLUME
    gui.screenshot("state")


def test_a_handle_is_dragged_while_blend_plays(gui):
    """By the buttons of the animation: it follows the mouse, and stays where it was let go."""
    require_qt(gui)
    gui.run("import gui_places; gui_places.hide_tool_bars_except('VCRToolbar')")
    gui.run(BLEND)
    gui.run("""
scene.NumberOfFrames = 40
frames = []
def record(*_):
    frames.append(scene.AnimationTime)
view.GetRenderer().AddObserver("EndEvent", record)""")
    played = "len({*frames}) > 2"
    gui.click("tool('actionVCRLoop')")
    gui.click("tool('actionVCRPlay')")
    gui.until(played)
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged()")
        gui.run("frames.clear()")
        gui.until(played)
        gui.screenshot("1_dragging")
        assert gui.value("volumes()") == VOLUME
        assert gui.value("distance_to_mouse()") < 8
    gui.run("frames.clear(); place = held_handle().tolist()")
    gui.move((90, -60))
    gui.until(played)
    assert gui.value("[held_handle().tolist() == place, volumes()]") == [True, VOLUME]
    gui.click("tool('actionVCRPlay')")  # it pauses
    gui.run("frames.clear()")
    gui.press("alt+a")
    gui.until("len(applied_drags()) == 1 and is_bent()")
    gui.screenshot("2_applied")


def test_a_track_of_a_coordinate(gui):
    """ParaView drops a list's edit when it sets another element: then nothing is live."""
    drag(gui)
    gui.run("""
track = simple.GetAnimationTrack("DeformedPoints", index=0, proxy=deform)
track.KeyFrames = [simple.CompositeKeyFrame(KeyTime=t, KeyValues=[-10 - 4 * t]) for t in (0., 1.)]
scene = simple.GetAnimationScene()
scene.AnimationTime = 0.5 * (scene.StartTime + scene.EndTime)
simple.Render(view)
moved = np.reshape(deform.DeformedPoints, (-1, 3))
is_live = not np.array_equal(pending_rows('DeformedPoints'), moved)""")
    assert gui.value("moved[0].tolist()") == [-12, -10, -10]
    assert gui.value("(volumes() == ['vtkVolume']) is is_live")
    gui.screenshot("1_half")
    gui.run("scene.Play(); simple.Delete(track); del track; simple.Render(view)")
    drag(gui)
    assert gui.value("volumes()") == VOLUME
    gui.press("alt+a")
    gui.until("len(applied_drags()) == 2")
    gui.run("simple.Render(view)")
    assert gui.value("volumes() == own")


def test_reset_session(gui):
    require_qt(gui)
    drag(gui)
    gui.run("""
import gui_places
timer = gui_places.import_module(f"PyQt{gui_places._version}.QtCore").QTimer()
timer.timeout.connect(lambda: listen(None, None))
timer.start(20)
view.GetInteractor().DestroyTimer()
del view, deform, wavelet""")
    gui.click("menu_item('Edit')")
    gui.click("menu_item('Reset Session')")
    gui.click("button('Yes')")
    gui.until("not simple.GetSources()")
    gui.run("view = simple.GetActiveViewOrCreate('RenderView')")
    gui.run(f"{WAVELET}{VALUES}{AS_VOLUME}drawn.clear()")
    gui.add_deform(apply=False)
    drag(gui)
    assert gui.value("volumes(view)") == VOLUME
    gui.screenshot("again")


def test_deleting_while_it_is_dragged(gui):
    gui.run("other = simple.CreateView('RenderView'); layout = simple.GetLayout(view)")
    gui.run("layout.SplitVertical(0, 0.5); layout.AssignView(2, other); simple.Show(deform, other)")
    gui.run("simple.GetDisplayProperties(deform, other).SetRepresentationType('Volume')")
    gui.run("simple.ColorBy(simple.GetDisplayProperties(deform, other), ('POINTS', 'RTData'))")
    gui.run("simple.SetActiveView(view); simple.SetActiveSource(deform); simple.Render(other)")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged() and drawn")
        gui.run("simple.Render(other)")
        assert gui.value("volumes() + volumes(other)") == VOLUME + VOLUME
        gui.run("simple.Delete(other); del other; simple.Render(view)")
        assert gui.value("volumes()") == VOLUME
        gui.run("simple.Delete(wavelet); del wavelet; simple.Render(view)")
        gui.shake(0.5)
        gui.run("simple.Delete(deform); del deform; simple.Render(view)")
        gui.shake(0.5)
    assert gui.value("volumes()") == []
