"""Pipelines of VTK: filters, their inputs and outputs. Tests import them."""

from __future__ import annotations

import numpy as np
from vtk_fixtures import DEFORMED, REST, make_image
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

KEYS = vtkStreamingDemandDrivenPipeline


def control_points(rest=REST, deformed=DEFORMED, weights=()):
    source = configured(MLSControlPoints(), RestPoints=rest, DeformedPoints=deformed)
    return configured(source, Weights=weights)


def connect(deforming, image, handles):
    """Connect a filter to an image (data or algorithm) and control points."""
    for port, source in enumerate((image, handles)):
        if hasattr(source, "GetOutputPort"):
            deforming.SetInputConnection(port, source.GetOutputPort())
        else:
            deforming.SetInputDataObject(port, source)
    return deforming


def update(algorithm):
    """The output after an update."""
    assert algorithm.GetExecutive().Update()
    return algorithm.GetOutputDataObject(0)


def assert_fails(algorithm, messages, match):
    """An update reports one error, a sentence, and the output is empty."""
    assert not algorithm.GetExecutive().Update()
    messages.assert_one(match)
    assert algorithm.GetOutputDataObject(0).GetNumberOfPoints() == 0


def values_of(image, name):
    """A point array of an image as (nz, ny, nx) or (nz, ny, nx, components) array."""
    values = arrays.to_numpy(image.GetPointData().GetArray(name))
    return values.reshape(image.GetDimensions()[::-1] + values.shape[1:])


def content(dataset):
    """All numbers of a dataset, copied, by the kind of data and the name of the array."""
    found = {"bounds": dataset.GetBounds(), "cells": dataset.GetNumberOfCells()}
    for kind in ("Point", "Cell", "Field"):
        data = getattr(dataset, f"Get{kind}Data")()
        for array in map(data.GetArray, range(data.GetNumberOfArrays())):
            if array is not None:
                found[kind, array.GetName()] = arrays.to_numpy(array).copy()
    if hasattr(dataset, "GetPoints") and dataset.GetPoints():
        found["points"] = arrays.to_numpy(dataset.GetPoints().GetData()).copy()
    return found


def assert_same(found, expected):
    """Two datasets, or contents of datasets, are the same to the bit."""
    found, expected = (c if isinstance(c, dict) else content(c) for c in (found, expected))
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=str(name))


class Executions:
    """Counts how often an algorithm runs."""

    def __init__(self, algorithm):
        self.count = 0
        algorithm.AddObserver("StartEvent", self._add)

    def _add(self, *_):
        self.count += 1


def ball(center, radius, resolution=30, normals=True):
    """The surface of a ball."""
    source = configured(vtkSphereSource(), Center=center, Radius=radius, GenerateNormals=normals)
    return update(configured(source, ThetaResolution=resolution, PhiResolution=resolution))


def picture_of(window):
    """The picture in a vtkRenderWindow: (height, width, 3) float, 0 to 255."""
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    settings = {"Input": window, "ReadFrontBuffer": False, "ShouldRerender": False}
    image = update(configured(vtkWindowToImageFilter(), **settings))
    width, height, _ = image.GetDimensions()
    pixels = arrays.to_numpy(image.GetPointData().GetScalars())
    return pixels.reshape(height, width, -1)[..., :3].astype(float)


class Source(VTKPythonAlgorithmBase):
    """Makes data for a time: of the last step that is not later, or without steps of any time."""

    def __init__(self, fill, steps=(), ends=None, output_type="vtkPolyData"):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType=output_type)
        self.fill, self.steps, self.ends, self.times = fill, steps, ends, []

    def RequestInformation(self, request, in_info, out_info):
        info = out_info.GetInformationObject(0)
        ends = self.ends or [self.steps[0], self.steps[-1]]
        if self.steps:
            info.Set(KEYS.TIME_STEPS(), self.steps, len(self.steps))
        info.Set(KEYS.TIME_RANGE(), ends, 2)
        if self.OutputType == "vtkImageData":
            info.Set(KEYS.WHOLE_EXTENT(), make_image().GetExtent(), 6)
        return 1

    def RequestData(self, request, in_info, out_info):
        info = out_info.GetInformationObject(0)
        time = info.Get(KEYS.UPDATE_TIME_STEP()) if info.Has(KEYS.UPDATE_TIME_STEP()) else None
        if self.steps:
            earlier = [step for step in self.steps if time is not None and step <= time]
            time = earlier[-1] if earlier else self.steps[0]
        self.times.append(time)
        output = vtkDataObject.GetData(out_info)
        self.fill(output, time)
        output.GetInformation().Set(output.DATA_TIME_STEP(), time)
        return 1
