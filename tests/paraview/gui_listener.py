"""Runs inside ParaView's GUI (`paraview --script`): executes the requests of `Gui`.

A request is a Python file in the folder PARAVIEW_GUI_FOLDER; a timer of the render view looks for
it. The value of its variable `answer` is the reply. It can import the modules of this folder.
"""

import json
import os
import sys
import traceback

from paraview import servermanager, simple

folder = os.environ["PARAVIEW_GUI_FOLDER"]
sys.path.append("tests/paraview")
names = {"simple": simple, "servermanager": servermanager}
with open("tests/paraview/gui_inside.py") as functions:
    exec(functions.read(), names)
if "VTK_MLS_OPEN" in os.environ:  # started by vtk-mls with this script instead of its own
    with open("vtk_mls/paraview/scene.py") as scene:
        exec(scene.read(), {})


def listen(interactor, event):
    request = os.path.join(folder, "request.py")
    if not os.path.exists(request):
        return
    if servermanager.ActiveConnection.Session.GetPendingProgress():
        return  # ParaView handles timers during computations, too
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
names["listen"] = listen  # for a test that closes the view
names["view"] = simple.GetActiveViewOrCreate("RenderView")
# Python must not keep the interactor, whose observers the garbage collector would then spare.
names["view"].GetInteractor().AddObserver("TimerEvent", listen)
names["view"].GetInteractor().CreateRepeatingTimer(20)
