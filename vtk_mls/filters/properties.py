"""Properties of filters: names, values and the methods generated from them.

`property_tables` has a table for each filter, the only source of its methods, of ParaView's panel
and proxies, of options of the command line and of docs/properties.md. VTK is not needed here.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field

from vtk_mls.base.errors import InputError
from vtk_mls.base.grid import Grid
from vtk_mls.base.validation import choice, short_repr

_WIDTH = 88  # of docstrings; those of stubs are indented further


@dataclass(frozen=True)
class Property:
    """A property of a filter: its name, default and help.

    Subclasses have `values`: allowed values, in a few words.
    """

    name: str  # in CamelCase: the methods are Set<name> and Get<name>
    default: object  # of the filter; it must not change a list
    help: str  # for every user: ParaView's tooltip and the help of the command, too
    more: str = ""  # for those who write programs
    unit: str = ""  # unit or frame of numbers
    is_advanced: bool = False  # whether ParaView shows it only among advanced properties
    # ParaView shows it only while another property has one of some values, or has not a value:
    # (name, value, ...). None is the value of an input that is not connected.
    shown_when: tuple | None = None
    hidden_when: tuple | None = None
    shown_with: str | None = None  # an input: while it is connected, `hidden_when` does not count
    only_for: str = ""  # "images" or "meshes": the inputs for which it has an effect

    @property
    def attribute(self):
        """Name of the attribute of the algorithm that holds the value."""
        return f"_{self.option}"

    @property
    def option(self):
        """The name in snake_case."""
        return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", self.name).lower()

    @property
    def singular(self):
        """The name of one element of a list."""
        return self.name.removesuffix("s")

    @property
    def initial(self):
        """The value of a new algorithm."""
        return self.default

    @property
    def expected(self):
        """Allowed values and the default: a sentence."""
        value = f"{self.values}, {self.unit}" if self.unit else self.values
        default = f'"{self.default}"' if isinstance(self.default, str) else self.default
        return f"{value[0].upper()}{value[1:]}; default: {'none' if default == () else default}."

    def methods(self):
        """Functions of an algorithm by their names.

        In their docstrings {0} is the property; those without get the help.
        """
        attribute, converted = self.attribute, self.converted

        def set_value(self, value):
            self._set(attribute, converted(value))

        def get_value(self):
            """The value: see `Set{0.name}`."""
            return getattr(self, attribute)

        return {f"Set{self.name}": set_value, f"Get{self.name}": get_value}

    def converted(self, value):
        """The stored value for an argument of the setter."""
        return value

    def refused(self, value):
        """The TypeError for an argument of the setter that cannot be stored."""
        return TypeError(f"`{self.name}` must be {self.values}, got {short_repr(value)}")

    def assign(self, algorithm, value):
        """Set it."""
        getattr(algorithm, f"Set{self.name}")(value)


@dataclass(frozen=True)
class Number(Property):
    """A number: an integer if its default is one.

    `spellings` are other spellings of values, by text. The value "auto" is that of another
    property, Automatic<name>.
    """

    spellings: Mapping[str, int | str] = field(default_factory=dict, hash=False)

    def parsed(self, text):
        """The value of a text."""
        return self.spellings[text] if text in self.spellings else type(self.default)(text)

    def assign(self, algorithm, value):
        if isinstance(value, str) and value == "auto":
            getattr(algorithm, f"SetAutomatic{self.name}")(True)
        else:
            super().assign(algorithm, value)

    @property
    def values(self):
        return "an integer" if isinstance(self.default, int) else "a number"


@dataclass(frozen=True)
class Slider(Number):
    """A number with a usual range, for a slider; the help gives the allowed range."""

    low: float = 0.0
    high: float = 1.0


@dataclass(frozen=True)
class Vector(Property):
    """Several numbers, as arguments or as a sequence: integers if the default has integers."""

    labels: tuple = ("x", "y", "z")

    @property
    def values(self):
        return f"({', '.join(self.labels)})"

    def methods(self):
        attribute, refused = self.attribute, self.refused

        def set_value(self, *values):
            try:
                self._set(attribute, tuple(values[0]) if len(values) == 1 else values)
            except TypeError:
                raise refused(values[0]) from None

        return super().methods() | {f"Set{self.name}": set_value}


class Dimensions(Vector):
    """Numbers of points."""

    def checked(self, algorithm):
        """The value, three positive integers; an error otherwise."""
        dimensions = getattr(algorithm, self.attribute)
        try:
            return Grid(dimensions).dimensions
        except (TypeError, ValueError):
            raise InputError(
                f"must be three positive integers (nx, ny, nz), got {short_repr(dimensions)}",
                argument=self.name,
            ) from None


@dataclass(frozen=True)
class Choice(Property):
    """One of some words."""

    choices: tuple = ()

    @property
    def values(self):
        return "one of " + ", ".join(f'"{choice}"' for choice in self.choices)

    def checked(self, algorithm):
        """The value; an error if it is not one of the choices."""
        return choice(self.name, getattr(algorithm, self.attribute), self.choices)


@dataclass(frozen=True)
class Flag(Property):
    """On or off; with `is_on_in_paraview` it is on by default there."""

    is_on_in_paraview: bool = False

    values = "True or False"

    def converted(self, value):
        return bool(value)


class Text(Property):
    """A text; None is "", too."""

    values = "a text"

    def converted(self, value):
        return value or ""


@dataclass(frozen=True)
class FileName(Text):
    """The path of a file with control points."""

    default: str = field(default="", init=False)

    values = "the path of a file"


class TransformFile(FileName):
    """The path of a file with a transform, or, from Python, a transform."""

    values = "the path of a file, or a `vtk_mls.Affine`, `Field`, `Chain` or `Deformation`"


class ArrayName(Text):
    """The name of point scalars of the input, "" for none."""

    values = "a name"


@dataclass(frozen=True)
class Items(Property):
    """A tuple to which elements are added one by one."""

    default: tuple = field(default=(), init=False)

    def assign(self, algorithm, value):
        getattr(algorithm, f"Clear{self.name}")()
        for item in value:
            getattr(algorithm, f"Add{self.singular}")(item)

    def methods(self):
        attribute, extended = self.attribute, self.extended

        def add(self, value):
            self._set(attribute, extended(getattr(self, attribute), value))

        def clear(self):
            """Remove all {0.name}."""
            self._set(attribute, ())

        def get_all(self):
            """A tuple: see `Add{0.singular}`."""
            return getattr(self, attribute)

        return {f"Add{self.singular}": add, f"Clear{self.name}": clear, f"Get{self.name}": get_all}

    def extended(self, items, item):
        """The tuple `items` with another item."""
        return (*items, item)


@dataclass(frozen=True)
class ArrayNames(Items):
    """Names of point and cell arrays of the input, each once; `components` 0 is any number."""

    components: int = 0

    values = "names"

    def extended(self, items, item):
        if not isinstance(item, str):
            raise self.refused(item)
        return items if item in items else (*items, item)


@dataclass(frozen=True)
class Values(Items):
    """Values of `vtk_mls`, which only Python can set."""

    values: str = ""


@dataclass(frozen=True)
class Value(Property):
    """A value of `vtk_mls` or None, which only Python can set."""

    default: None = field(default=None, init=False)
    values: str = ""


@dataclass(frozen=True)
class Rows(Property):
    """A list that is set as a whole, or, as ParaView does it, by its length and single elements."""

    default: tuple = field(default=(), init=False)

    columns = ()  # of an element
    new = None  # value of an element that has not been set

    @property
    def initial(self):
        return list(self.default)

    def converted(self, value):
        rows = value.tolist() if hasattr(value, "tolist") else value
        try:
            return list(rows) if len(self.columns) == 1 else [tuple(row) for row in rows]
        except TypeError:
            raise self.refused(value) from None

    def methods(self):
        attribute, converted, new, columns = self.attribute, self.converted, self.new, self.columns

        def set_all(self, values):
            self._set(attribute, converted(values))

        def get_all(self):
            """A tuple: see `Set{0.name}`."""
            return tuple(getattr(self, attribute))

        def set_count(self, count):
            """Keep the first `count` of {0.name}; new ones are {0.new}."""
            resize(self, getattr(self, attribute), count, new)

        def get_count(self):
            """How many {0.name} there are."""
            return len(getattr(self, attribute))

        def set_one(self, index, *row):
            """One of {0.name}, by its {0.columns}; those missing before it are {0.new}."""
            if len(row) != len(columns) or index < 0:
                found = f"{short_repr(row)} at {index}; the first index is 0"
                raise TypeError(f"`row` must be {', '.join(columns)}, got {found}")
            values = getattr(self, attribute)
            resize(self, values, max(index + 1, len(values)), new)
            value = row[0] if len(columns) == 1 else row
            if values[index] != value:
                values[index] = value
                self.Modified()

        return {
            f"Set{self.name}": set_all,
            f"Get{self.name}": get_all,
            f"SetNumberOf{self.name}": set_count,
            f"GetNumberOf{self.name}": get_count,
            f"Set{self.singular}": set_one,
        }


class Positions(Rows):
    """Positions."""

    values = "(n, 3) array_like"
    columns = ("x", "y", "z")
    new = (0.0, 0.0, 0.0)


class Factors(Rows):
    """Positive numbers."""

    values = "(n,) array_like"
    columns = ("weight",)
    new = 1.0


class Planes(Rows):
    """Planes with a fall-off: a point, a normal and a length."""

    values = "rows (x, y, z, nx, ny, nz, falloff)"
    columns = ("x", "y", "z", "nx", "ny", "nz", "falloff")
    new = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0)


def resize(algorithm, values, count, new):
    """Make a list of an algorithm longer by elements `new`, or shorter."""
    if count != len(values):
        values[:] = values[:count] + [new] * (count - len(values))
        algorithm.Modified()


def with_properties(table):
    """A decorator that gives a class of algorithms the methods of a table of properties.

    The table has all that the class has, those of its bases included. Methods that the class itself
    defines, and those of properties of its bases, stay.
    """

    def decorate(cls):
        inherited = getattr(cls, "PROPERTIES", ())
        for row in table:
            for name, method in row.methods().items() if row not in inherited else ():
                if name not in vars(cls):
                    setattr(cls, name, _bound_to(cls, name, method, row))
        cls.PROPERTIES = tuple(table)
        return cls

    return decorate


def _bound_to(cls, name, method, row):
    """A method as if it were defined in the class; without a docstring it gets all of the help."""
    method.__name__, method.__qualname__ = name, f"{cls.__qualname__}.{name}"
    method.__module__ = cls.__module__
    method.__doc__ = method.__doc__.format(row) if method.__doc__ else _full_help(row)
    return method


def _full_help(row):
    paragraphs = (row.help, row.more, row.expected)
    fill = textwrap.TextWrapper(_WIDTH, break_on_hyphens=False).fill
    return "\n\n".join(fill(" ".join(text.split())) for text in paragraphs if text)
