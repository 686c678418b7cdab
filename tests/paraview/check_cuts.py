"""Cuts by properties and by polygons open the volume as `vtk_mls.Deformation` says."""

import numpy as np
from paraview import simple
from scene import array, control_points, data, grid, wavelet

import vtk_mls
from vtk_mls.filters import derived_arrays

# Handles on both sides, pulled apart.
REST = np.array([(-4.0, 0.0, 3.0), (4.0, 0.0, 3.0), (-4.0, 0.0, -6.0), (4.0, 0.0, -6.0)])
APART = REST + np.array([(-2.0, 0, 0), (2.0, 0, 0), (0, 0, 0), (0, 0, 0)])
HALF_PLANE = vtk_mls.HalfPlane((0.2, 0, -2.1), (1, 0, 0), (0, 0, 1))

source, handles = wavelet(), control_points(REST, APART)
lattice = grid(data(source))
volume = array(data(source), "RTData")
deform = simple.MLSDeform(Input=source, ControlPoints=handles)
field = simple.MLSDisplacementField(Input=source, ControlPoints=handles)
filters = deform, field
for proxy in filters:
    proxy.MapTolerance = 0
whole = array(data(deform), "RTData").copy()
assert not data(deform).GetPointData().HasArray("Void")
assert not data(deform).GetPointData().HasArray("vtkGhostType")


def check(cut):
    """Both filters against the value outside of the pipeline; the number of void points."""
    value = vtk_mls.Deformation(REST, APART, cuts=cut)
    expected = value.displacement_field(lattice.dimensions, lattice.origin, lattice.spacing)
    assert 20 < np.count_nonzero(expected.void) < 2000
    for proxy in filters:
        np.testing.assert_array_equal(array(data(proxy), "Void"), expected.void)
        distance = array(data(proxy), "VoidDistance")
        np.testing.assert_allclose(distance, expected.void_distance, atol=1e-5)
    displacement = array(data(field), "BackwardDisplacement")
    np.testing.assert_allclose(displacement, expected.displacement, atol=1e-5)
    (resampled,) = value.resample([volume], vtk_mls.Sampling(lattice, background="auto"))
    np.testing.assert_allclose(array(data(deform), "RTData"), resampled, atol=1e-2)
    assert not np.array_equal(resampled, whole)
    np.testing.assert_array_equal(array(data(deform), "vtkGhostType") == 2, expected.void)
    assert not data(field).GetPointData().HasArray("vtkGhostType")
    return np.count_nonzero(expected.void)


def cells_of_surface(proxy):
    surface = simple.ExtractSurface(Input=proxy)
    count = data(surface).GetNumberOfCells()
    simple.Delete(surface)
    return count


# A half-plane by properties.
for proxy in filters:
    proxy.CutType = "half-plane"
    proxy.CutOrigin, proxy.CutNormal, proxy.CutInward = [0.2, 0, -2.1], [2, 0, 0], [0, 0, 1]
half = check(HALF_PLANE)
hidden = cells_of_surface(deform)  # must not crash
deform.HideVoid = 0
visible = cells_of_surface(deform)
# Before VTK 9.3 no cells can be hidden.
assert visible < hidden or (visible == hidden and not derived_arrays.CAN_HIDE_CELLS)
face = simple.Contour(Input=deform, ContourBy=["POINTS", "VoidDistance"], Isosurfaces=[0.0])
assert data(face).GetNumberOfCells() > 50
simple.Delete(face)
del face
# All versions can show the inside by a clip at the face or, with steps, a threshold.
deform.VoidValues = "continued"
# The clip of 5.11 drops the active scalars: something else must be active.
other = simple.Calculator(Input=deform, Function="RTData", ResultArrayName="Copy")
clip = simple.Clip(Input=other, ClipType="Scalar", Scalars=["POINTS", "VoidDistance"])
clip.Value, clip.Invert = 0.0, 0  # afterwards: choosing the scalars sets the value
threshold = simple.Threshold(Input=deform, Scalars=["POINTS", "Void"])
threshold.LowerThreshold = threshold.UpperThreshold = 0.0
for solid in (clip, threshold):
    output = data(solid)
    assert 0.5 * np.prod(lattice.dimensions) < output.GetNumberOfPoints()
    assert -1e-5 < output.GetPointData().GetArray("VoidDistance").GetRange()[0] < 0.1
    assert output.GetPointData().GetArray("RTData").GetRange()[0] > volume.min() - 1  # unmixed
    assert cells_of_surface(solid) > 500
    simple.Delete(solid)
simple.Delete(other)
del clip, threshold, solid, other
contour = simple.Contour(Input=deform, ContourBy=["POINTS", "RTData"], Isosurfaces=[157.0])
clip = simple.Clip(Input=contour, ClipType="Scalar", Scalars=["POINTS", "VoidDistance"])
clip.Value, clip.Invert = 0.0, 0
assert -1e-5 < data(clip).GetPointData().GetArray("VoidDistance").GetRange()[0] < 0.1
assert 500 < data(clip).GetNumberOfCells() < data(contour).GetNumberOfCells() * 1.2
for proxy in (clip, contour):
    simple.Delete(proxy)
del clip, contour, proxy
deform.VoidValues = "background"
deform.HideVoid = 1

# The same half-plane as a large polygon, on the input Cuts.
for proxy in filters:
    proxy.CutType = "none"
polygon = simple.Plane(Origin=[0.2, -90, -2.1], Point1=[0.2, 90, -2.1], Point2=[0.2, -90, 90])
corners = [(0.2, -90, -2.1), (0.2, 90, -2.1), (0.2, 90, 90), (0.2, -90, 90)]
surface = vtk_mls.Surface(corners, [(0, 1, 2), (0, 2, 3)])
for proxy in filters:
    proxy.Cuts = polygon
assert check(surface) == half
polygon.Point1 = [0.2, 90, -1.1]  # a change is noticed
assert np.count_nonzero(array(data(deform), "Void")) != half
polygon.Point1 = [0.2, 90, -2.1]
assert check(surface) == half

for proxy in filters:
    proxy.Cuts = []
np.testing.assert_array_equal(array(data(deform), "RTData"), whole)
assert not data(deform).GetPointData().HasArray("Void")
