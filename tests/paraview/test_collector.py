"""Python's garbage collector takes nothing away that ParaView calls."""

from __future__ import annotations

import pytest
from gui_fixtures import (  # noqa: F401  fixtures
    ASIDE,
    HANDLE,
    PULL,
    SETUP,
    display,
    gui,
    paraview,
    start,
)

# Collects before and after all that hears the events of a drag, and between a request for a later
# picture and that picture. It keeps no observed object: the collector leaves what is kept.
COLLECT = """
collections = []

def collect(*_):
    collections.append(gc.collect())

def collect_at_timers(interactor, event):
    if gc.get_count()[0] > 50:  # more has happened than the timer of the tests
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
    """Drag a handle; again if it was missed, for ParaView was busy with the last drag."""
    for _ in range(5):
        with gui.dragging(place, by):
            gui.move((3, 2))
        if gui.value(condition):
            return
    raise AssertionError(f"no handle at {place}")


@pytest.mark.parametrize("look", ["Outline", pytest.param("Volume", marks=pytest.mark.matrix)])
@pytest.mark.parametrize("is_applied_at_once", [True, False], ids=["auto", "apply"])
def test_drags_with_a_collection_at_every_event(gui, is_applied_at_once, look):
    gui.run(f"settings.SetAutoApply({is_applied_at_once})")
    gui.run(f"""
shown = simple.GetDisplayProperties(wavelet, view)
simple.ColorBy(shown, ("POINTS", "RTData"))
shown.SetRepresentationType({look!r})
simple.Render(view)
del shown""")
    gui.run("import gc; gc.collect(); gc.freeze()")  # collections of what comes now are quick
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    if not is_applied_at_once:
        gui.press("alt+a")
    gui.until("is_straight()")
    gui.run(COLLECT)
    for count, place in enumerate(PLACES, start=1):
        drag(gui, place, PULL if count % 2 else ASIDE, f"len(dragged(pending=True)) == {count}")
    if not is_applied_at_once:
        gui.press("ctrl+z", "ctrl+y", "alt+a")
    gui.until(f"len(dragged()) == {len(PLACES)} and is_bent()")
    assert gui.value("len(collections)") > 10 * len(PLACES)
    gui.run("simple.Delete(deform); del deform; collect(); simple.Render(view)")
