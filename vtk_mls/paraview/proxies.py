"""The proxies of the plugin: filters and sources as ParaView shows them.

ParaView imports this module by its name when a proxy is made, on the server.
"""

from __future__ import annotations

from paraview.util.vtkAlgorithm import smhint, smproperty, smproxy

from vtk_mls import filters
from vtk_mls.paraview import frame_check, image_reader, panels
from vtk_mls.paraview.recovery import Recovers

_MENU = smhint.xml('<ShowInMenu category="MLS Deformation"/>')

_SAYS_WHAT_THE_MOUSE_DOES = smhint.xml('<ShowProxyDocumentationInPanel type="short_help"/>')


def _panel(elements):
    return smproperty.xml("".join(elements))


class _ChecksFrames:
    """A filter that says so if handles are on the wrong side of the head."""

    def RequestData(self, request, inInfo, outInfo):
        if sentence := frame_check.mixed(self, inInfo):
            self._warn(sentence)
        return super().RequestData(request, inInfo, outInfo)


@smproxy.filter(name="MLSDeform", label="MLS Deform", support_reload=False)
@_MENU
@_SAYS_WHAT_THE_MOUSE_DOES
@_panel(panels.DEFORM)
class MLSDeform(Recovers, _ChecksFrames, filters.MLSDeform):
    """`vtk_mls.filters.MLSDeform` as a ParaView filter."""

    def SetGradientArray(self, name):
        """The list says "none" for no array."""
        super().SetGradientArray("" if name == "none" else name)


@smproxy.filter(name="MLSDisplacementField", label="MLS Displacement Field", support_reload=False)
@_MENU
@_SAYS_WHAT_THE_MOUSE_DOES
@_panel(panels.DISPLACEMENT_FIELD)
class MLSDisplacementField(Recovers, _ChecksFrames, filters.MLSDisplacementField):
    """`vtk_mls.filters.MLSDisplacementField` as a ParaView filter."""


@smproxy.source(name="MLSControlPoints", label="MLS Control Points", support_reload=False)
@_MENU
@_SAYS_WHAT_THE_MOUSE_DOES
@_panel(panels.CONTROL_POINTS)
class MLSControlPoints(Recovers, filters.MLSControlPoints):
    """`vtk_mls.filters.MLSControlPoints` as a ParaView source."""


@smproxy.source(name="MLSImageReader", label="MLS Image Reader", support_reload=False)
@_panel(panels.IMAGE_READER)
class MLSImageReader(Recovers, image_reader.MLSImageReader):
    """`vtk_mls.paraview.image_reader.MLSImageReader` as a ParaView source."""
