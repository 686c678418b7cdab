"""Undo for edits that wait for Apply.

ParaView's undo stack has only applied edits: after a drag, Ctrl+Z would undo the last Apply and
keep the drag. Therefore each edit is an empty step on the stack, and is undone here when the stack
reaches the step.
"""

from paraview.modules.vtkPVVTKExtensionsCore import vtkUndoSet
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings

_edits = {}  # owner, state before and state after, by the empty steps
_observed_stack = None


def add(label, owner, before, after):
    """Push an edit on the stack, unless it is applied at once or comes from Undo or Redo.

    Undo and Redo call `owner.restore` with the state before or after it; the menu shows the label.
    """
    if vtkPVGeneralSettings.GetInstance().GetAutoApply() or is_running():
        return
    stack = _stack()
    stack.Push(label, vtkUndoSet())  # the stack pushes a copy
    _edits[stack.GetNextUndoSet()] = owner, before, after


def amend(owner, after):
    """Change the state after the owner's last edit."""
    step = _stack().GetNextUndoSet() if _stack().CanUndo() else None
    if step in _edits and _edits[step][0] is owner:
        _edits[step] = owner, _edits[step][1], after


def forget(owner):
    """Remove the edits of an owner, which were applied or reset."""
    if is_running():
        return
    stack = _stack()
    steps = {step for step, (editor, *_) in _edits.items() if editor is owner}
    while stack.CanUndo() and stack.GetNextUndoSet() in steps:
        stack.PopUndoStack()
    for step in steps:
        del _edits[step]


def is_running():
    """Whether ParaView executes an Undo or a Redo."""
    return _stack().GetInUndo() or _stack().GetInRedo()


def _stack():
    global _observed_stack
    stack = vtkSMProxyManager.GetProxyManager().GetUndoStackBuilder().GetUndoStack()
    if stack is not _observed_stack:
        _observed_stack = stack
        stack.AddObserver("StartEvent", _step_starts)
    return stack


def _step_starts(stack, event):
    step = stack.GetNextUndoSet() if stack.GetInUndo() else stack.GetNextRedoSet()
    if step in _edits:
        owner, before, after = _edits[step]
        owner.restore(before if stack.GetInUndo() else after)
