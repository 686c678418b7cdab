"""What cannot be drawn."""


class RenderingError(RuntimeError):
    """The graphics driver, or what VTK makes of the actor, cannot draw the deformation."""
