"""The look of what MLS Deform makes: at first, that of its input."""

from __future__ import annotations

# Properties of a display, beside the representation.
_LOOK = (
    *("ColorArrayName", "LookupTable", "MapScalars", "InterpolateScalarsBeforeMapping"),
    *("UseSeparateColorMap", "ScalarOpacityFunction", "UseTransfer2D", "TransferFunction2D"),
    *("UseSeparateOpacityArray", "OpacityArrayName", "Opacity", "AmbientColor", "DiffuseColor"),
    *("EdgeColor", "LineWidth", "PointSize", "Interpolation", "Specular", "Shade", "BlendMode"),
    *("InterpolationType", "VolumeRenderingMode", "ScalarOpacityUnitDistance"),
    *("IsosurfaceValues", "Slice", "SliceMode"),
    # of blocks
    *("Assembly", "BlockSelectors", "BlockColors", "BlockColorsDistinctValues", "BlockOpacities"),
    *("BlockColorArrayNames", "BlockLookupTables", "BlockMapScalars", "BlockUseSeparateColorMaps"),
    "BlockInterpolateScalarsBeforeMappings",
)


def show_as_input(display, others):
    """Show the output of MLSDeform as its input is shown, if it is, in the same view."""
    deform = display.GetProperty("Input").GetProxy(0) if display.GetProperty("Input") else None
    if deform is None or deform.GetXMLName() != "MLSDeform":
        return
    source = deform.GetProperty("Input")
    wanted = source.GetProxy(0), source.GetOutputPortForConnection(0)
    for other in others:
        shown = other.GetProperty("Input")
        if shown and (shown.GetProxy(0), shown.GetOutputPortForConnection(0)) == wanted:
            for name in _LOOK:
                if display.GetProperty(name) and other.GetProperty(name):
                    display.GetProperty(name).Copy(other.GetProperty(name))
            display.UpdateVTKObjects()
            if display.GetProperty("Representation") and other.GetProperty("Representation"):
                display.SetRepresentationType(other.GetProperty("Representation").GetElement(0))
            return
