"""Runs inside ParaView's GUI (`paraview --script`): does what `tests/paraview/gui.py` asks for.

A request is a file of Python, left in the folder PARAVIEW_GUI_FOLDER; a timer of the render view
looks for it. What it assigns to `answer` is the reply. It may import what lies in this folder.
"""

import json
import os
import sys
import traceback

from paraview import servermanager, simple

folder = os.environ["PARAVIEW_GUI_FOLDER"]
sys.path.append("tests/paraview")
names = {"simple": simple, "servermanager": servermanager}
if "VTK_MLS_OPEN" in os.environ:  # started by vtk-mls, which runs one script, this
    with open("vtk_mls/paraview/scene.py") as scene:
        exec(scene.read(), {})


def listen(interactor, event):
    request = os.path.join(folder, "request.py")
    if not os.path.exists(request):
        return
    if servermanager.ActiveConnection.Session.GetPendingProgress():
        return  # it computes, and looks at timers between
    with open(request) as file:
        text = file.read()
    os.remove(request)
    names["answer"] = None
    try:
        exec(text, names)
        reply = {"answer": names["answer"]}
    except BaseException:
        reply = {"error": traceback.format_exc()}
    part = os.path.join(folder, "reply.part")
    with open(part, "w") as file:
        json.dump(reply, file)
    os.rename(part, os.path.join(folder, "reply.json"))


if "PARAVIEW_GUI_SERVER" in os.environ:  # its port
    simple.Connect("localhost", int(os.environ["PARAVIEW_GUI_SERVER"]))
names["listen"] = listen  # for those who close the view
names["view"] = simple.GetActiveViewOrCreate("RenderView")
# Of the view's interactor nothing is kept, as in a session without this listener: what Python holds
# its garbage collector leaves.
names["view"].GetInteractor().AddObserver("TimerEvent", listen)
names["view"].GetInteractor().CreateRepeatingTimer(20)
