"""The proxies of the plugin: filters and sources as ParaView shows them.

ParaView imports this module by its name when a proxy is made, on the server.
"""

from paraview.util.vtkAlgorithm import smhint, smproperty, smproxy

from vtk_mls import filters
from vtk_mls.base.errors import InputError
from vtk_mls.paraview import image_reader, panels
from vtk_mls.paraview.result_checks import ChecksResults, producers

_MENU = smhint.xml('<ShowInMenu category="MLS Deformation"/>')
_SHORT_HELP = smhint.xml('<ShowProxyDocumentationInPanel type="short_help"/>')


def _panel(elements):
    """A decorator that gives a proxy a panel, with its short help, and a place in the menu."""
    properties = smproperty.xml("".join(elements))
    return lambda cls: _MENU(_SHORT_HELP(properties(cls)))


class _Recovers:
    """An algorithm whose failures do not stop the updates of ParaView's views.

    After a failed update, ParaView never updates the view again, even after a change. So a failed
    execution is reported once, its empty output counts as up to date, and algorithms downstream do
    not report their empty input.
    """

    _failure = None  # time of the pipeline and error text, if the last execution failed

    def RequestData(self, request, inInfo, outInfo):
        result = super().RequestData(request, inInfo, outInfo)
        self._failure = None
        return result

    def has_failed(self):
        """Whether the output is empty because of an error."""
        time = self.GetExecutive().GetPipelineMTime()
        return self._failure is not None and self._failure[0] == time

    def _fail(self, out_info, error):
        self._empty(out_info)
        if isinstance(error, InputError):
            is_connected = self.GetNumberOfInputPorts() > 1 and self.GetNumberOfInputConnections(1)
            error = error.renamed(panels.names_in_errors(self.PROPERTIES, is_connected))
        failure = self.GetExecutive().GetPipelineMTime(), str(error)
        sources = [source for source in producers(self) if isinstance(source, _Recovers)]
        if failure != self._failure and not any(source.has_failed() for source in sources):
            self._report(error)
        self._failure = failure
        return 1


@smproxy.filter(name="MLSDeform", label="MLS Deform", support_reload=False)
@_panel(panels.DEFORM)
class MLSDeform(_Recovers, ChecksResults, filters.MLSDeform):
    """`vtk_mls.filters.MLSDeform` as a ParaView filter."""

    def GetAutomaticBackground(self):
        """It is on by default: scripts and states that only set Background keep their value."""
        return super().GetAutomaticBackground() and not self.GetBackground()

    def SetGradientArray(self, name):
        """The drop-down list has "none" for no array."""
        super().SetGradientArray("" if name == "none" else name)


@smproxy.filter(name="MLSDisplacementField", label="MLS Displacement Field", support_reload=False)
@_panel(panels.DISPLACEMENT_FIELD)
class MLSDisplacementField(_Recovers, ChecksResults, filters.MLSDisplacementField):
    """`vtk_mls.filters.MLSDisplacementField` as a ParaView filter."""


@smproxy.filter(name="MLSLandmarkReport", label="MLS Landmark Report", support_reload=False)
@_panel(panels.LANDMARK_REPORT)
class MLSLandmarkReport(_Recovers, filters.MLSLandmarkReport):
    """`vtk_mls.filters.MLSLandmarkReport` as a ParaView filter."""


@smproxy.source(name="MLSControlPoints", label="MLS Control Points", support_reload=False)
@_panel(panels.CONTROL_POINTS)
class MLSControlPoints(_Recovers, filters.MLSControlPoints):
    """`vtk_mls.filters.MLSControlPoints` as a ParaView source."""


@smproxy.source(name="MLSImageReader", label="MLS Image Reader", support_reload=False)
@smproperty.xml("".join(panels.IMAGE_READER))
class MLSImageReader(_Recovers, image_reader.MLSImageReader):
    """`vtk_mls.paraview.image_reader.MLSImageReader` as a ParaView source."""
