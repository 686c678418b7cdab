"""Properties of filters as options of methods, and control points and cuts as their arguments."""

from __future__ import annotations

import inspect
from textwrap import fill, indent

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkPointSet, vtkPolyData

from vtk_mls.base.validation import short_repr
from vtk_mls.filters import property_tables
from vtk_mls.filters.properties import Items
from vtk_mls.model import arguments
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import fill_polydata

# What arguments say otherwise: control points and cuts.
_ARGUMENTS = {
    each.name
    for each in (
        *property_tables.OWN_CONTROL_POINTS,
        property_tables.CUT_TYPE,
        property_tables.CUT_ORIGIN,
        property_tables.CUT_NORMAL,
        property_tables.CUT_INWARD,
        property_tables.CUTS,
    )
}
_WIDTH = 92


def takes(table):
    """Give a method with `**options` the properties of a table as its options.

    They come into its signature and its docstring, which says where by `{options}`.
    """
    properties = [each for each in table if each.name not in _ARGUMENTS]

    def decorate(method):
        signature = inspect.signature(method)
        named = [each for each in signature.parameters.values() if each.kind != each.VAR_KEYWORD]
        named += [
            inspect.Parameter(each.option, inspect.Parameter.KEYWORD_ONLY, default=each.default)
            for each in properties
        ]
        method.__signature__ = signature.replace(parameters=named)
        text = "\n".join(map(_documented, properties))
        method.__doc__ = inspect.cleandoc(method.__doc__).replace("{options}", text)
        return method

    return decorate


def apply(algorithm, options):
    """Set properties of a filter by options; an error names the option."""
    properties = {each.option: each for each in algorithm.PROPERTIES if each.name not in _ARGUMENTS}
    for name, value in options.items():
        if name not in properties:
            raise TypeError(f"`{name}` is no option; there are {', '.join(properties)}")
        each = properties[name]
        if isinstance(each, Items) and isinstance(value, str):
            value = (value,)
        try:
            each.assign(algorithm, value)
        except TypeError as error:
            raise TypeError(f"`{name}` must be {each.values}, got {short_repr(value)}") from error


def in_words_of_options(sentence, algorithm):
    """A filter's error with the names that the caller has used."""
    for each in algorithm.PROPERTIES:
        sentence = sentence.replace(f"`{each.name}`", f"`{each.option}`")
    return sentence.replace("`ControlPoints`", "`rest`").replace("`Input`", "the dataset")


def control_points(rest, deformed=None, weights=None):
    """Control-point polydata.

    Parameters
    ----------
    rest : (n, 3) array_like or vtkPointSet, world coordinates
        p; a point set alone has q - p, too.
    deformed : (n, 3) array_like or vtkPointSet, world coordinates, optional
        q.
    weights : (n,) array_like, optional

    Raises
    ------
    TypeError, ValueError
        Naming the argument.
    """
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


def each_cut(cuts):
    """Cuts, and surfaces as polydata, of one or several."""
    return cuts if isinstance(cuts, (list, tuple)) else (cuts,)


def _positions(name, value):
    """Points (n, 3) float64."""
    if isinstance(value, vtkPointSet):
        points = value.GetPoints()
        value = np.empty((0, 3)) if points is None else arrays.to_numpy(points.GetData())
    return arguments.control_points(name, value)


def _documented(each):
    text = f"{' '.join(each.help.split())} {' '.join(each.more.split())}".strip()
    return indent(f"{each.option}\n{indent(fill(f'{text} {each.expected}', _WIDTH), '    ')}", "")
