"""What VTK says while something is tried."""

from __future__ import annotations

from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow


class Messages:
    """Keeps VTK's messages from where they usually go, until `finish`.

    Several may do so at the same time and finish in any order: all hear the same.
    """

    _open = 0
    _usual = _kept = None  # windows
    _is_taken = False

    def __init__(self):
        if Messages._open == 0:
            Messages._usual, Messages._is_taken = vtkOutputWindow.GetInstance(), False
            Messages._kept = vtkStringOutputWindow()
            vtkOutputWindow.SetInstance(Messages._kept)
        Messages._open += 1

    def finish(self, word):
        """Whether a word was said: who is told so says himself what is wrong.

        If nobody is told so, what was said is passed on when the last one finishes.
        """
        said = Messages._kept.GetOutput()
        is_said = word in said
        Messages._is_taken |= is_said
        Messages._open -= 1
        if Messages._open == 0:
            usual, Messages._usual, Messages._kept = Messages._usual, None, None
            vtkOutputWindow.SetInstance(usual)
            if said and not Messages._is_taken:
                usual.DisplayText(said)
        return is_said

    @staticmethod
    def error(sentence):
        """Say something where VTK's own errors go."""
        window = Messages._usual or vtkOutputWindow.GetInstance()
        window.DisplayErrorText(sentence + "\n")
