"""Drags of a page's mouse, for tests and for the pictures of the documentation."""

from __future__ import annotations

import time


def drag(mouse, start, by, steps=8, rest=0.3):
    """Drag with the left button of playwright's mouse, from a pixel by so many.

    Before it is pressed it rests over the handle for some seconds, so that this is hovered.
    """
    mouse.move(*start)
    time.sleep(rest)
    mouse.down()
    for step in range(1, steps + 1):
        mouse.move(start[0] + by[0] * step / steps, start[1] + by[1] * step / steps)
        time.sleep(0.04)
    mouse.up()
