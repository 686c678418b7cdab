"""Undo for edits that wait for Apply.

ParaView's undo stack knows only what was applied: after a drag, Ctrl+Z would take back what was
applied before it and leave the drag. So each edit is put on the stack too, as a step that is empty,
and done here when the stack comes to it.
"""

from __future__ import annotations

from paraview.modules.vtkPVVTKExtensionsCore import vtkUndoSet
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings

_steps = {}  # by the empty steps: who edited, and what was before and after
_observed = None  # the stack


def add(label, owner, before, after):
    """Put an edit on the stack, unless it is applied at once or an undo itself.

    Parameters
    ----------
    label : str
        For the menu.
    owner : object
        Its `restore(state)` is called on Undo and Redo.
    before, after : any
        The states of this edit.
    """
    if vtkPVGeneralSettings.GetInstance().GetAutoApply() or is_busy():
        return
    stack = _stack()
    stack.Push(label, vtkUndoSet())  # of which it makes another
    _steps[stack.GetNextUndoSet()] = owner, before, after


def amend(owner, after):
    """Count what was done since the owner's last edit as part of it."""
    step = _stack().GetNextUndoSet() if _stack().CanUndo() else None
    if step in _steps and _steps[step][0] is owner:
        _steps[step] = owner, _steps[step][1], after


def forget(owner):
    """Remove the edits of an owner: they were applied, or taken back in another way."""
    if is_busy():
        return
    stack = _stack()
    ended = {step for step, (editor, *_) in _steps.items() if editor is owner}
    while stack.CanUndo() and stack.GetNextUndoSet() in ended:
        stack.PopUndoStack()
    for step in ended:
        del _steps[step]


def is_busy():
    """Whether what happens now is an Undo or a Redo."""
    return _stack().GetInUndo() or _stack().GetInRedo()


def _stack():
    """The undo stack of ParaView's GUI."""
    global _observed
    stack = vtkSMProxyManager.GetProxyManager().GetUndoStackBuilder().GetUndoStack()
    if stack is not _observed:
        _observed = stack
        stack.AddObserver("StartEvent", _moved)
    return stack


def _moved(stack, event):
    """The stack is about to undo or redo a step."""
    step = stack.GetNextUndoSet() if stack.GetInUndo() else stack.GetNextRedoSet()
    if step in _steps:
        owner, before, after = _steps[step]
        owner.restore(before if stack.GetInUndo() else after)
