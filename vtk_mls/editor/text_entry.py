"""A line of text that is typed in the window."""

from __future__ import annotations

_PROMPT = "Type a name, a position x y z, or positions at rest and moved; Return ends: "


class TextEntry:
    """Takes characters until Return or Escape, and shows them in a `Document`."""

    def __init__(self, document):
        self._document, self._text, self._apply = document, "", None

    @property
    def is_open(self):
        """Whether keys are characters."""
        return self._apply is not None

    def open(self, apply):
        """Take characters; `apply(text)` is called at the end."""
        self._text, self._apply = "", apply
        self._document.say(_PROMPT)

    def press(self, symbol, character):
        """Take a key: its name in VTK, and its character or "" for none."""
        document = self._document
        if symbol in ("Return", "KP_Enter"):
            apply, self._apply = self._apply, None
            document.say("")
            with document.reporting_errors():
                apply(self._text.strip())
        elif symbol == "Escape":
            self._apply = None
            document.say("")
        else:
            is_deleted = symbol in ("BackSpace", "Delete")
            self._text = self._text[:-1] if is_deleted else self._text + character
            document.say(f"{_PROMPT}{self._text}_")
        document.draw()
