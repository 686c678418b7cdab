"""Python's garbage collector, which must leave whatever ParaView calls."""

from __future__ import annotations

import pytest
from gui_fixtures import (  # noqa: F401  fixtures
    ASIDE,
    HANDLE,
    PULL,
    SETUP,
    display,
    gui,
    noise,
    paraview,
    start,
)

COLLECTING = """
import gc
gc.collect()
"""

# Collects at every event of what a drag goes through, before the plugin hears of it and after.
COLLECT = """
collections = []

def collect(*_):
    collections.append(gc.collect())

def collect_at_timers(interactor, event):
    if len(collections) % 5 == 0:  # the listener's own comes 50 times a second
        collect()
    else:
        collections.append(0)

def watch(thing, *events):
    for event in events:
        for priority in (1000.0, -1000.0):
            thing.AddObserver(event, collect, priority)

watch(view.GetInteractor(), "LeftButtonPressEvent", "MouseMoveEvent", "LeftButtonReleaseEvent")
watch(view.GetRenderer(), "StartEvent", "EndEvent")
watch(view.GetRenderWindow(), "StartEvent", "EndEvent")
view.GetInteractor().AddObserver("TimerEvent", collect_at_timers, 1000.0)
from vtk_mls.paraview import late_render
_ask = late_render.ask
def ask(n):
    print("ASK", n, late_render._due, flush=True); _ask(n); print("DUE", late_render._due, flush=True)
late_render.ask = ask
"""


@pytest.mark.parametrize("is_applied_at_once", [True, False], ids=["auto", "apply"])
def test_drags_with_a_collection_at_every_event(start, is_applied_at_once):  # noqa: F811
    with start() as gui:  # noqa: F811
        gui.run(COLLECTING)
        gui.run(SETUP)
        gui.run(f"settings.SetAutoApply({is_applied_at_once})")
        gui.launch("MLS Deform")
        gui.run("deform = simple.GetActiveSource()")
        if not is_applied_at_once:
            gui.press("alt+a")
        gui.until("is_straight()")
        gui.run(COLLECT)
        gui.run("import time; t=time.time(); gc.collect(); answer=time.time()-t; print('GC', answer)")
        places = [HANDLE, (-10, 10, 0), (10, -10, 0), (10, 0, 10), (0, 10, 10), (10, 10, -10)]
        for count, place in enumerate(places, start=1):
            with gui.dragging(place, PULL if count % 2 else ASIDE):
                gui.until(f"len(dragged(pending=True)) == {count}")
            gui.run("import time; time.sleep(0.2)")
        if not is_applied_at_once:
            gui.press("alt+a")
        gui.until(f"len(dragged()) == {len(places)} and is_bent()")
        assert gui.value("len(collections)") > 100
        assert noise(gui) == []
        print(gui.printed)
