"""Python's garbage collector does not clear functions that ParaView calls."""

from __future__ import annotations

import pytest
from gui_scenes import ASIDE, HANDLE, PULL

# Collects before and after all observers of a drag, and between the request for a late render and
# the render. It keeps no observed object alive, since the collector would then spare its observers.
COLLECT = """
collections = []

def collect(*_):
    collections.append(gc.collect())

def collect_at_timers(interactor, event):
    if gc.get_count()[0] > 50:  # more objects than the timer of the tests makes
        collect()

for observed, events in (
    (view.GetInteractor(), ("LeftButtonPressEvent", "MouseMoveEvent", "LeftButtonReleaseEvent")),
    (view.GetRenderer(), ("StartEvent", "EndEvent")),
    (view.GetRenderWindow(), ("StartEvent", "EndEvent")),
    (deform.SMProxy.GetProperty("DeformedPoints"), ("UncheckedPropertyModifiedEvent",)),
):
    for event in events:
        for priority in (1000.0, -1000.0):
            observed.AddObserver(event, collect, priority)
view.GetInteractor().AddObserver("TimerEvent", collect_at_timers, 1000.0)
del observed
"""
PLACES = HANDLE, (-10, 10, 0), (10, -10, 0), (10, 0, 10), (0, 10, 10), (10, 10, -10)


def drag(gui, place, by, condition):
    """Drag a handle; again if ParaView was busy with the last drag and missed this one."""
    for _ in range(5):
        with gui.dragging(place, by):
            gui.move((3, 2))
        if gui.value(condition):
            return
    raise AssertionError(f"no handle at {place}")


@pytest.mark.parametrize(
    "representation", ["Outline", pytest.param("Volume", marks=pytest.mark.matrix)]
)
@pytest.mark.parametrize(
    "auto_apply",
    [pytest.param(True, id="auto", marks=pytest.mark.matrix), pytest.param(False, id="apply")],
)
def test_drags_with_a_collection_at_every_event(gui, auto_apply, representation):
    gui.run(f"settings.SetAutoApply({auto_apply})")
    gui.run(f"""
display = simple.GetDisplayProperties(wavelet, view)
simple.ColorBy(display, ("POINTS", "RTData"))
display.SetRepresentationType({representation!r})
simple.Render(view)
del display""")
    gui.run("import gc; gc.collect(); gc.freeze()")  # makes the collections of the test fast
    gui.add_deform(apply=False)
    if not auto_apply:
        gui.press("alt+a")
    gui.until("is_straight()")
    gui.run(COLLECT)
    for count, place in enumerate(PLACES, start=1):
        drag(gui, place, PULL if count % 2 else ASIDE, f"len(dragged()) == {count}")
    if not auto_apply:
        gui.press("ctrl+z", "ctrl+y", "alt+a")
    gui.until(f"len(applied_drags()) == {len(PLACES)} and is_bent()")
    assert gui.value("len(collections)") > 10 * len(PLACES)
    gui.run("simple.Delete(deform); del deform; collect(); simple.Render(view)")
