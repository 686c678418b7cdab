"""Properties of filters as keyword arguments of methods; control points and cuts as arguments."""

import inspect
from collections.abc import Iterable
from textwrap import fill, indent

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkPointSet, vtkPolyData

from vtk_mls.base.validation import short_repr
from vtk_mls.filters import property_tables
from vtk_mls.filters.properties import Items, Values
from vtk_mls.model import arguments
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import fill_polydata

# Properties that are positional arguments: control points and cuts.
_ARGUMENTS = {
    row.name
    for row in (
        *property_tables.OWN_CONTROL_POINTS,
        property_tables.CUT_TYPE,
        *property_tables.CUT_FIELDS.values(),
        property_tables.CUTS,
    )
}
_WIDTH = 92


def takes(table):
    """A decorator that documents the `**options` of a method by a table of properties.

    They are added to its signature and, in place of `{options}`, to its docstring.
    """
    properties = [row for row in table if row.name not in _ARGUMENTS]

    def decorate(method):
        signature = inspect.signature(method)
        parameters = [p for p in signature.parameters.values() if p.kind != p.VAR_KEYWORD]
        parameters += [
            inspect.Parameter(row.option, inspect.Parameter.KEYWORD_ONLY, default=row.default)
            for row in properties
        ]
        method.__signature__ = signature.replace(parameters=parameters)
        text = "\n".join(map(_documented, properties))
        method.__doc__ = inspect.cleandoc(method.__doc__).replace("{options}", text)
        return method

    return decorate


def apply(algorithm, options):
    """Set properties of a filter by options; an error names the option."""
    properties = {row.option: row for row in algorithm.PROPERTIES if row.name not in _ARGUMENTS}
    for name, value in options.items():
        if name not in properties:
            raise TypeError(f"`{name}` is no option; there are {', '.join(properties)}")
        row = properties[name]
        is_one = isinstance(row, Values) and not isinstance(value, Iterable)
        if is_one or (isinstance(row, Items) and isinstance(value, str)):
            value = (value,)
        try:
            row.assign(algorithm, value)
        except TypeError as error:
            raise TypeError(f"`{name}` must be {row.values}, got {short_repr(value)}") from error


def argument_names(algorithm):
    """The caller's names of the properties and inputs of a filter, for its errors."""
    names = {row.name: f"`{row.option}`" for row in algorithm.PROPERTIES}
    return {**names, "ControlPoints": "`rest`", "Input": "the dataset"}


def control_points(rest, deformed=None, weights=None):
    """Control-point polydata of p and q, (n, 3) array_like or vtkPointSet, and weights (n,).

    A point set alone has q - p, too. Errors name the argument.
    """
    if rest is None:
        raise TypeError("`rest` is missing: give the positions of control points, or `handles`")
    if deformed is None and isinstance(rest, vtkPointSet):
        if weights is not None:
            raise TypeError("`weights` of control points in a dataset are its array `Weight`")
        return rest
    for name, value in (("rest", rest), ("deformed", deformed)):
        if isinstance(value, vtkDataObject) and not isinstance(value, vtkPointSet):
            raise TypeError(
                f"`{name}` must be positions or a dataset with points of its own, such as PolyData "
                f"or UnstructuredGrid, got {type(value).__name__}"
            )
    if deformed is None:
        raise TypeError(
            "`deformed` is missing: give the positions to which control points are dragged, or a "
            "dataset with point vectors `Displacement` as `rest`"
        )
    p, q = _positions("rest", rest), _positions("deformed", deformed)
    if p.shape != q.shape:
        raise ValueError(f"`deformed` must have the shape {p.shape} of `rest`, got {q.shape}")
    if weights is not None:
        weights = arguments.positive_weights(weights, len(p))
    polydata = vtkPolyData()
    fill_polydata(polydata, p, q, weights)
    return polydata


def as_cuts(cuts):
    """One cut, or several, as a sequence."""
    return cuts if isinstance(cuts, (list, tuple)) else (cuts,)


def _positions(name, value):
    """Points (n, 3) float64."""
    if isinstance(value, vtkPointSet):
        points = value.GetPoints()
        value = np.empty((0, 3)) if points is None else arrays.to_numpy(points.GetData())
    return arguments.control_points(name, value)


def _documented(row):
    text = " ".join(f"{row.help} {row.more} {row.expected}".split())
    return f"{row.option}\n{indent(fill(text, _WIDTH), '    ')}"
