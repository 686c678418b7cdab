"""Algorithms that work again in ParaView's views once what was wrong is mended."""

from __future__ import annotations

from vtk_mls.paraview import frame_check


class Recovers:
    """An algorithm whose failures do not end the updates of ParaView's views.

    Where an update has failed, ParaView never updates the view again, not even after a change. So a
    failed execution is reported once, its empty output counts as made, and algorithms downstream do
    not add that their input is empty.
    """

    _failure = None  # the pipeline's time and the sentence, unless the last execution was good

    def RequestData(self, request, inInfo, outInfo):
        answer = super().RequestData(request, inInfo, outInfo)
        self._failure = None
        return answer

    def has_failed(self):
        """Whether the output is empty because of an error."""
        time = self.GetExecutive().GetPipelineMTime()
        return self._failure is not None and self._failure[0] == time

    def _fail(self, out_info, sentence):
        self._empty(out_info)
        failure = self.GetExecutive().GetPipelineMTime(), sentence
        if failure != self._failure and not any(map(_has_failed, frame_check.producers(self))):
            self._report(sentence)
        self._failure = failure
        return 1


def _has_failed(producer):
    return isinstance(producer, Recovers) and producer.has_failed()
