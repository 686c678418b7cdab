"""Shapes describe themselves: by a name, and a table of their fields.

The command, the filters and ParaView's panel, the editor, its page, scripts and session files read
these tables, so that a new shape is one class.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

_SIZES = {"point": 3, "vector": 3, "length": 1}  # numbers of a value


@dataclass(frozen=True)
class ShapeField:
    """An attribute of a shape, and the argument of its class.

    Numbers describe a shape if its fields are points, vectors and lengths.
    """

    name: str
    kind: str  # "point", "vector", "length", "rows" (other numbers), "shape", "mask" or "grid"
    help: str = ""  # for all users
    default: Any = None
    title: str = ""  # for users, by default the name

    @property
    def labels(self) -> list[str]:
        """Names of the numbers of a value."""
        if self.kind == "length":
            return [self.name]
        return [self.name[0] * (self.kind == "vector") + axis for axis in "xyz"]


class Described:
    """A value that is made of fields."""

    name = ""  # in files, options and panels
    help = ""  # a sentence for all users
    fields: tuple[ShapeField, ...] = ()  # the arguments of the class, in their order

    def __init_subclass__(cls) -> None:
        if "name" in vars(cls):
            CLASSES[cls.name] = cls

    @classmethod
    def labels(cls) -> list[str]:
        """Names of the numbers that describe a value; empty if it takes more, or has no name."""
        is_named = CLASSES.get(cls.name) is cls
        if not is_named or not all(field.kind in _SIZES for field in cls.fields):
            return []
        return [label for field in cls.fields for label in field.labels]

    @classmethod
    def expected(cls) -> str:
        """The names of the classes of such values, for errors."""
        *names, last = (c.__name__ for c in CLASSES.values() if issubclass(c, cls))
        return f"{', '.join(names)} or {last}"

    @classmethod
    def of_numbers(cls, numbers: Sequence[float]) -> Any:
        """The value with the numbers of all fields, one after the other."""
        rest = iter(numbers)
        values = [[*islice(rest, _SIZES[field.kind])] for field in cls.fields]
        return cls(*(value[0] if len(value) == 1 else value for value in values))

    def changed(self, **values: Any) -> Any:
        """A copy with other values of some fields."""
        fields = (field.name for field in self.fields)
        return type(self)(*(values.get(name, getattr(self, name)) for name in fields))

    @property
    def arguments(self) -> list[Any]:
        """The values of the fields, with lists instead of arrays."""
        return [np.asarray(getattr(self, field.name)).tolist() for field in self.fields]

    @property
    def numbers(self) -> list[float]:
        """The argument of `of_numbers`."""
        return np.hstack(self.arguments).tolist()


CLASSES: dict[str, type[Described]] = {}  # by their names
