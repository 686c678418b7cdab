"""The tool that waits for a click, for commands of the page that need a place."""


class ClickTool:
    """Calls a function with the pixel of the next click."""

    def __init__(self):
        self._act, self._is_for_slices = None, False

    def wait(self, act, is_for_slices):
        """Call `act(pixel)` at the next click, in 3-D views and, if `is_for_slices`, in slices."""
        self._act, self._is_for_slices = act, is_for_slices

    def cancel(self):
        """Do not wait."""
        self._act = None

    def click(self, pixel, pane):
        """Act at a pixel of a `SlicePane`, or of a 3-D view for None; whether this waited."""
        act = self._act
        if act is None or (pane is not None and not self._is_for_slices):
            return False
        self.cancel()
        act(pixel)
        return True
