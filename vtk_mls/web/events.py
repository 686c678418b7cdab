"""Events of a page's mouse and keys, as an interactor has them."""

from __future__ import annotations

_MOUSE = {
    "move": "MouseMoveEvent",
    "leave": "LeaveEvent",
    **{
        f"{what}{button}": f"{name}Button{event}Event"
        for button, name in enumerate(("Left", "Middle", "Right"))
        for what, event in (("down", "Press"), ("up", "Release"))
    },
}
# What X calls the keys that browsers name otherwise.
_SYMBOLS = {
    "Backspace": "BackSpace",
    "Enter": "Return",
    " ": "space",
    "Spacebar": "space",
}
_MOST_STEPS = 10  # of the wheel at once


def newest(events):
    """The events without moves of the mouse that are followed by another one."""
    return [
        event
        for event, after in zip(events, [*events[1:], {}])
        if not event["type"] == after.get("type") == "move"
    ]


def send(interactor, event):
    """Send an event of the page to an interactor.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    event : dict
        `type`: "move", "leave", "down" or "up" with `button`, "wheel" with `steps`, "key" with
        `key`; `x` and `y` as fractions of the picture, from its upper left corner; `ctrl`, `shift`.
    """
    kind = event["type"]
    if kind == "wheel":
        steps = max(-_MOST_STEPS, min(_MOST_STEPS, int(event["steps"])))
        name = "MouseWheelForwardEvent" if steps > 0 else "MouseWheelBackwardEvent"
        for _ in range(abs(steps)):
            _invoke(interactor, event, name)
    elif kind == "key":
        symbol = _SYMBOLS.get(event["key"], event["key"])
        for name in ("KeyPressEvent", "CharEvent", "KeyReleaseEvent"):
            _invoke(interactor, event, name, symbol)
    else:
        button = int(event["button"]) if kind in ("down", "up") else ""
        _invoke(interactor, event, _MOUSE[f"{kind}{button}"])


def _invoke(interactor, event, name, symbol=None):
    x, y = interactor.GetEventPosition()
    if "x" in event:
        width, height = interactor.GetRenderWindow().GetSize()
        x = round(float(event["x"]) * (width - 1))
        y = round((1 - float(event["y"])) * (height - 1))
    code = symbol if symbol and len(symbol) == 1 and symbol.isascii() else chr(0)
    modifiers = int(bool(event.get("ctrl"))), int(bool(event.get("shift")))
    interactor.SetEventInformation(x, y, *modifiers, code, 0, symbol)
    interactor.InvokeEvent(name)
