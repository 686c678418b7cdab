"""By default ParaView shows of a volume what the map of each point shows, for all that is seen.

Arguments: a folder for pictures, and the file of a volume of a head.
"""

import sys
from pathlib import Path

import numpy as np
from paraview import simple
from scene import array, control_points, data
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

FOLDER, HEAD = Path(sys.argv[1]), sys.argv[2]
TOLERANCE = 0.02
CUTS = {"none": {}, "half-plane": {"CutNormal": [1, 0.1, 0], "CutInward": [0, 0, 1]}}

source = simple.XMLImageDataReader(FileName=[HEAD])
image = data(source)
scalars = image.GetPointData().GetScalars().GetName()
VALUES = vtk_to_numpy(image.GetPointData().GetScalars())
bounds = np.reshape(image.GetBounds(), (3, 2))
centre, size = bounds.mean(axis=1), np.ptp(bounds, axis=1)


def hard_handles(pulled):
    """Random ones with drags far apart, half of them half a voxel from another, or a cut opened."""
    rng = np.random.default_rng(7)
    rest = centre + rng.uniform(-0.4, 0.4, (24, 3)) * size
    deformed = rest + rng.uniform(-0.05, 0.05, (24, 3)) * size
    if pulled:
        side = np.sign(rest[:, :1] - centre[0])
        return rest, rest + side * [[0.08 * size[0], 0, 0]] * (rest[:, 2:] > centre[2])
    deformed[1::2] = deformed[::2] + 0.5 * np.array(image.GetSpacing()) * [[0.6, 0.64, -0.48]]
    return rest, deformed


def made(kind, cut, tolerance, **settings):
    """A filter as ParaView makes it, or with another tolerance."""
    proxy = kind(Input=source, ControlPoints=control_points(*hard_handles(cut != "none")))
    assert proxy.MapTolerance == proxy.GetClientSideObject().GetMapTolerance() == TOLERANCE
    proxy.CutType = cut
    if cut != "none":
        proxy.CutOrigin = list(centre)
        for name, value in CUTS[cut].items():
            setattr(proxy, name, value)
    for name, value in settings.items():
        setattr(proxy, name, value)
    if tolerance is not None:
        proxy.MapTolerance = tolerance
    return proxy


view = simple.CreateRenderView(ViewSize=[400, 400])
view.OrientationAxesVisibility = 0


def picture(proxy, kind, colors, name):
    """(400 * 400, 3) int of what a proxy makes, as a volume or a surface, from above and aside."""
    display = simple.Show(proxy, view)
    display.SetRepresentationType(kind)
    simple.Render(view)
    simple.ColorBy(display, colors)
    if colors and colors[1] == "Gradient":
        high = 0.2 * float(VALUES.max())
        simple.GetColorTransferFunction("Gradient").RescaleTransferFunction(-high, high)
    view.CameraPosition = list(centre + 2.4 * size.max() * np.array([0.4, -0.6, 0.9]))
    view.CameraFocalPoint, view.CameraViewUp = list(centre), [0, 0, 1]
    simple.Render(view)
    file = str(FOLDER / f"tolerance_{name}.png")
    simple.SaveScreenshot(file, view, ImageResolution=[400, 400])
    simple.Hide(proxy, view)
    reader = vtkPNGReader()
    reader.SetFileName(file)
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int)


def contour(proxy):
    """The surface of the grey matter."""
    found = simple.Contour(Input=proxy)
    found.ContourBy = ["POINTS", scalars]
    found.Isosurfaces = [0.5 * VALUES.max()]
    return found


def face(proxy):
    """That surface without the void: it ends at the smooth face."""
    found = simple.Clip(Input=contour(proxy))
    found.ClipType = "Scalar"
    found.Scalars = ["POINTS", "VoidDistance"]
    found.Value = 0.0
    found.Invert = 0
    return found


# How it is shown: by what, as what, by which colours; and properties of the filter.
LOOKS = {
    "volume": (lambda proxy: proxy, "Volume", ("POINTS", scalars), {}),
    "surface": (contour, "Surface", None, {}),
    "light": (contour, "Surface", ("POINTS", "Gradient", "X"), {"GradientArray": scalars}),
}
OF_CUTS = {
    "face": (face, "Surface", None, {"HideVoid": 0, "VoidValues": "continued"}),
}

for cut in CUTS:
    # the map
    for kind in ("rigid", "polynomial"):
        fields = [data(made(simple.MLSDisplacementField, cut, t, Kind=kind)) for t in (None, 0)]
        default, exact = (array(each, "BackwardDisplacement") for each in fields)
        error = np.linalg.norm((default - exact) / image.GetSpacing(), axis=-1)
        print(f"{cut}, {kind}: at most {error.max():.4f} of a voxel")
        assert 1e-5 < error.max() <= TOLERANCE, (cut, kind, error.max())
        if cut != "none":
            voids = [array(each, "Void") for each in fields]
            np.testing.assert_array_equal(*voids)
            assert 1e-4 < (voids[0] > 0).mean() < 0.5

    # nothing moves by a Blend of 0
    unmoved = data(made(simple.MLSDeform, cut, None, Blend=0))
    np.testing.assert_array_equal(
        array(unmoved, scalars), VALUES.reshape(image.GetDimensions()[::-1])
    )

    # what is seen
    for look, (seen, kind, colors, settings) in (
        LOOKS if cut == "none" else LOOKS | OF_CUTS
    ).items():
        found, expected = (
            picture(
                *(seen(made(simple.MLSDeform, cut, tolerance, **settings)), kind, colors),
                f"{cut}_{look}_{name}",
            )
            for name, tolerance in (("default", None), ("exact", 0))
        )
        levels = np.abs(found - expected).max(axis=1)
        print(f"{cut}, {look}: {np.percentile(levels, [99, 99.9])} levels, at most {levels.max()}")
        assert np.percentile(levels, 99.9) <= 2, (cut, look, levels.max())
        assert len(np.unique(expected, axis=0)) > 200, "the picture is blank"
