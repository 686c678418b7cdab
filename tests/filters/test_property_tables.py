"""Properties of the filters: methods from tables."""

import numpy as np
import pytest
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import BallMask, Deformation, Plane, Sampling, filters
from vtk_mls.base.validation import short_repr
from vtk_mls.filters import properties, property_tables
from vtk_mls.model import options

FILTERS = [getattr(filters, name) for name in filters.__all__]
EACH = [
    pytest.param(cls, p, id=f"{cls.__name__}-{p.name}") for cls in FILTERS for p in cls.PROPERTIES
]
# Another value than the default, as a user gives it.
OTHER = {
    properties.ArrayName: "a",
    properties.ArrayNames: ("a", "b"),
    properties.Values: (Plane((0, 0, 0), (1, 0, 0)),),
    properties.Value: BallMask((0, 0, 0), 1, 1),
    properties.Planes: ((1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 2.0),),
    properties.Factors: (1.0, 2.0),
    properties.FileName: "a.csv",
    properties.TransformFile: "a.nrrd",
    properties.Flag: lambda default: not default,
    properties.Choice: "another",
    properties.Positions: ((1.0, 2.0, 3.0),),
    properties.Slider: lambda default: default + 1,
    properties.Number: lambda default: default + 1,
    properties.Text: "cpu",
    properties.Vector: lambda default: tuple(range(len(default))),
    properties.Dimensions: (1, 2, 3),
}


def other(each):
    value = OTHER[type(each)]
    return value(each.default) if callable(value) else value


@pytest.mark.parametrize(("cls", "each"), EACH)
def test_set_then_get(cls, each):
    algorithm = cls()
    get = getattr(algorithm, f"Get{each.name}")
    assert get() == each.default
    before = algorithm.GetMTime()
    each.assign(algorithm, other(each))
    assert get() == other(each) != each.default
    changed = algorithm.GetMTime()
    assert changed > before
    each.assign(algorithm, get())
    if not isinstance(each, properties.Items):  # cleared, then added again
        assert algorithm.GetMTime() == changed
    assert getattr(cls(), f"Get{each.name}")() == each.default  # not shared by all filters


@pytest.mark.parametrize("cls", FILTERS)
def test_printing_shows_all_properties(cls):
    algorithm = cls()
    for prop in cls.PROPERTIES:
        prop.assign(algorithm, other(prop))
    lines = str(algorithm).splitlines()
    assert lines[0].startswith(f"{cls.__name__} (0x")
    shown = dict(line.strip().partition(": ")[::2] for line in lines)
    for prop in cls.PROPERTIES:
        assert shown[prop.name] == short_repr(getattr(algorithm, prop.attribute))


@pytest.mark.parametrize("cls", FILTERS)
def test_tables_are_whole(cls):
    names = [prop.name for prop in cls.PROPERTIES]
    assert len(set(names)) == len(names)
    for base in cls.__mro__[1:]:
        assert {*getattr(base, "PROPERTIES", ())} <= {*cls.PROPERTIES}
    for prop in cls.PROPERTIES:
        if isinstance(prop, properties.Choice):
            assert prop.default in prop.choices
        condition = prop.shown_when or prop.hidden_when
        assert condition is None or condition[0] in {*names, "ControlPoints"}


def test_interactive_defaults_differ_in_the_tolerance_alone():
    exact, seen = property_tables.COMPUTING, property_tables.INTERACTIVE_COMPUTING
    assert [p.name for p in exact] == [p.name for p in seen]
    assert [(a.default, b.default) for a, b in zip(exact, seen) if a != b] == [(0, 0.02)]


def test_defaults_are_those_of_the_core():
    table = {p.name: p.default for p in filters.MLSDeform.PROPERTIES}
    for option in options.DEFORMATION_OPTIONS:
        default = getattr(Deformation, option.name)
        assert table[option.property_name] == ("" if default is None else default)
    for name, attribute in (
        ("Interpolation", "interpolation"),
        ("Background", "background"),
        ("VoidValues", "void_values"),
    ):
        assert table[name] == getattr(Sampling, attribute)


def test_options_reach_the_deformation():
    deform = filters.MLSDeform()
    deform.SetInputData(vtkImageData())
    given = {"map_tolerance": 0.1, "nu": 3.0, "alpha": 1.5, "steps": 4, "cut_frame": "deformed"}
    for name, value in given.items():
        getattr(deform, f"Set{options.named(name).property_name}")(value)
    found = deform.updated_deformation()
    assert {name: getattr(found, name) for name in given} == given


@pytest.mark.parametrize("given", [(1, 2, 3), ((1, 2, 3),), ([1, 2, 3],), (np.array([1, 2, 3]),)])
def test_vectors_one_by_one_or_as_a_sequence(given):
    deform = filters.MLSDeform()
    deform.SetOutputSpacing(*given)
    assert deform.GetOutputSpacing() == (1, 2, 3)


def test_lists_by_elements():
    handles = filters.MLSControlPoints()
    handles.SetRestPoint(1, 1.0, 2.0, 3.0)
    assert handles.GetRestPoints() == ((0, 0, 0), (1, 2, 3))
    handles.SetNumberOfRestPoints(1)
    handles.SetWeight(2, 4.0)
    assert (handles.GetRestPoints(), handles.GetWeights()) == (((0, 0, 0),), (1, 1, 4))
    assert (handles.GetNumberOfRestPoints(), handles.GetNumberOfWeights()) == (1, 3)
    handles.SetDeformedPoints(np.eye(3))
    assert handles.GetDeformedPoints() == ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def test_rows_with_another_length_are_refused():
    handles = filters.MLSControlPoints()
    with pytest.raises(TypeError, match=r"`row` must be x, y, z, got \(1, 2\)"):
        handles.SetRestPoint(0, 1, 2)
    with pytest.raises(TypeError, match="`row` must be weight, got"):
        handles.SetWeight(0, 1, 2)
    for name in ("RestPoints", "Weights", "Bounds", "LatticeDimensions"):
        with pytest.raises(TypeError, match=f"`{name}` must be .*, got 3"):
            getattr(handles, f"Set{name}")(3)


def test_names_are_listed_once():
    deform = filters.MLSDeform()
    for name in ("a", "b", "a"):
        deform.AddLabelArray(name)
    assert deform.GetLabelArrays() == ("a", "b")
    deform.ClearLabelArrays()
    assert deform.GetLabelArrays() == ()
