"""Methods of algorithms that come from tables of their properties."""

from __future__ import annotations

import textwrap

_WIDTH = 88  # of docstrings, which stubs have with more before them


def with_properties(table):
    """A decorator that gives a class of algorithms the methods of a table of properties.

    Methods that the class has written itself, and those of properties of its bases, stay.

    Parameters
    ----------
    table : sequence of Property
        All that the class has, those of its bases included.
    """

    def decorate(cls):
        known = getattr(cls, "PROPERTIES", ())
        for each in table:
            for name, method in each.methods().items() if each not in known else ():
                if name not in vars(cls):
                    setattr(cls, name, _named(method, cls, name, each))
        cls.PROPERTIES = tuple(table)
        return cls

    return decorate


def _named(method, cls, name, each):
    """A method as if it were written in the class; without a docstring it gets all of the help."""
    method.__name__, method.__qualname__ = name, f"{cls.__qualname__}.{name}"
    method.__module__ = cls.__module__
    method.__doc__ = method.__doc__.format(each) if method.__doc__ else _help(each)
    return method


def _help(each):
    """Help for those who write programs."""
    paragraphs = (each.help, each.more, each.expected)
    fill = textwrap.TextWrapper(_WIDTH, break_on_hyphens=False).fill
    return "\n\n".join(fill(" ".join(text.split())) for text in paragraphs if text)
