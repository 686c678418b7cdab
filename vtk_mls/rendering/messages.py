"""What VTK says while something is tried."""

from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow


class Messages:
    """Keeps VTK's messages from where they usually go, until `finish`."""

    def __init__(self):
        self._usual, self._kept = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
        vtkOutputWindow.SetInstance(self._kept)

    def finish(self):
        """What was said, all of it."""
        vtkOutputWindow.SetInstance(self._usual)
        return self._kept.GetOutput()

    @staticmethod
    def error(sentence):
        """Say something where VTK's own errors go."""
        vtkOutputWindow.GetInstance().DisplayErrorText(sentence + "\n")
