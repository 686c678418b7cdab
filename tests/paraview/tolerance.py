"""ParaView's default tolerance of the map changes no picture visibly.

Arguments: a folder for pictures, and the file of a volume of a head.
"""

import sys
from pathlib import Path

import numpy as np
from paraview import simple
from scene import array, control_points, data, screenshot
from vtkmodules.util.numpy_support import vtk_to_numpy

FOLDER, HEAD = Path(sys.argv[1]), sys.argv[2]
TOLERANCE = 0.02
CUTS = {"none": {}, "half-plane": {"CutNormal": [1, 0.1, 0], "CutInward": [0, 0, 1]}}

source = simple.XMLImageDataReader(FileName=[HEAD])
image = data(source)
scalars = image.GetPointData().GetScalars().GetName()
VALUES = vtk_to_numpy(image.GetPointData().GetScalars())
bounds = np.reshape(image.GetBounds(), (3, 2))
center, size = bounds.mean(axis=1), np.ptp(bounds, axis=1)


def hard_handles(is_cut):
    """Random handles with large drags, in close pairs; or pulled apart at a cut."""
    rng = np.random.default_rng(7)
    rest = center + rng.uniform(-0.4, 0.4, (24, 3)) * size
    deformed = rest + rng.uniform(-0.05, 0.05, (24, 3)) * size
    if is_cut:
        side = np.sign(rest[:, :1] - center[0])
        return rest, rest + side * [[0.08 * size[0], 0, 0]] * (rest[:, 2:] > center[2])
    deformed[1::2] = deformed[::2] + 0.5 * np.array(image.GetSpacing()) * [[0.6, 0.64, -0.48]]
    return rest, deformed


def filter_of(kind, cut, tolerance, **settings):
    """A filter with ParaView's default tolerance or another."""
    proxy = kind(Input=source, ControlPoints=control_points(*hard_handles(cut != "none")))
    assert proxy.MapTolerance == proxy.GetClientSideObject().GetMapTolerance() == TOLERANCE
    proxy.CutType = cut
    if cut != "none":
        proxy.CutOrigin = list(center)
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
    """Colors (n, 3) of a proxy's output, as a volume or a surface."""
    display = simple.Show(proxy, view)
    display.SetRepresentationType(kind)
    simple.Render(view)
    simple.ColorBy(display, colors)
    if colors and colors[1] == "Gradient":
        high = 0.2 * float(VALUES.max())
        simple.GetColorTransferFunction("Gradient").RescaleTransferFunction(-high, high)
    view.CameraPosition = list(center + 2.4 * size.max() * np.array([0.4, -0.6, 0.9]))
    view.CameraFocalPoint, view.CameraViewUp = list(center), [0, 0, 1]
    simple.Render(view)
    pixels = screenshot(view, FOLDER / f"tolerance_{name}.png")
    simple.Hide(proxy, view)
    return pixels.reshape(-1, 3)


def contour(proxy):
    """The surface of the gray matter."""
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


# Filters on top, representation, colors, and properties of the filter.
PICTURES = {
    "volume": (lambda proxy: proxy, "Volume", ("POINTS", scalars), {}),
    "surface": (contour, "Surface", None, {}),
    "light": (contour, "Surface", ("POINTS", "Gradient", "X"), {"GradientArray": scalars}),
}
CUT_PICTURES = {
    "face": (face, "Surface", None, {"HideVoid": 0, "VoidValues": "continued"}),
}

for cut in CUTS:
    # the map
    for kind in ("rigid", "polynomial"):
        fields = [
            data(filter_of(simple.MLSDisplacementField, cut, t, Kind=kind)) for t in (None, 0)
        ]
        default, exact = (array(field, "BackwardDisplacement") for field in fields)
        error = np.linalg.norm((default - exact) / image.GetSpacing(), axis=-1)
        print(f"{cut}, {kind}: at most {error.max():.4f} of a voxel")
        assert 1e-5 < error.max() <= TOLERANCE, (cut, kind, error.max())
        if cut != "none":
            voids = [array(field, "Void") for field in fields]
            np.testing.assert_array_equal(*voids)
            assert 1e-4 < (voids[0] > 0).mean() < 0.5

    # Blend 0 is the identity
    unmoved = data(filter_of(simple.MLSDeform, cut, None, Blend=0))
    np.testing.assert_array_equal(
        array(unmoved, scalars), VALUES.reshape(image.GetDimensions()[::-1])
    )

    # the pictures
    for name, (build, kind, colors, settings) in (
        PICTURES if cut == "none" else PICTURES | CUT_PICTURES
    ).items():
        found, expected = (
            picture(
                *(build(filter_of(simple.MLSDeform, cut, tolerance, **settings)), kind, colors),
                f"{cut}_{name}_{accuracy}",
            )
            for accuracy, tolerance in (("default", None), ("exact", 0))
        )
        levels = np.abs(found - expected).max(axis=1)
        print(f"{cut}, {name}: {np.percentile(levels, [99, 99.9])} levels, at most {levels.max()}")
        assert np.percentile(levels, 99.9) <= 2, (cut, name, levels.max())
        assert len(np.unique(expected, axis=0)) > 200, "the picture is blank"
