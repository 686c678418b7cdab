"""MLS Deform, a scripted module of 3D Slicer: drag control points, and a grid transform follows.

The window is here; everything else is `MLSDeformLib.deform_logic`, which needs no Qt.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import slicer

try:
    from slicer.parameterNodeWrapper import parameterNodeWrapper
    from slicer.ScriptedLoadableModule import (
        ScriptedLoadableModule,
        ScriptedLoadableModuleLogic,
        ScriptedLoadableModuleWidget,
    )
    from slicer.util import VTKObservationMixin
except ImportError:  # slicer-core, without the application
    ScriptedLoadableModule = ScriptedLoadableModuleWidget = ScriptedLoadableModuleLogic = type(
        "NoApplication", (), {}
    )
    VTKObservationMixin = type("VTKObservationMixin", (), {})

    def parameterNodeWrapper(of: Any) -> Any:
        return of


class MLSDeform(ScriptedLoadableModule):
    """What Slicer's list of modules shows."""

    def __init__(self, parent):
        super().__init__(parent)
        parent.title = "MLS Deform"
        parent.categories = ["Registration"]
        parent.dependencies = ["Markups", "Transforms"]
        parent.contributors = ["the authors of vtk_mls"]
        parent.helpText = (
            "Deforms volumes, models and segmentations by control points that are dragged: a grid "
            "transform follows them while they move."
        )
        parent.acknowledgementText = (
            "E. Tejada et al.: Interactive Moving Least-Squares Volume Deformation."
        )


@parameterNodeWrapper
class MLSDeformParameterNode:
    """What the window shows; a deformation itself is on its transform node."""

    transform: slicer.vtkMRMLGridTransformNode


class MLSDeformLogic(ScriptedLoadableModuleLogic):
    """Holds the parameter node."""

    def getParameterNode(self):
        wrapper: Any = MLSDeformParameterNode  # the decorator gives it an argument
        return wrapper(super().getParameterNode())


class MLSDeformWidget(ScriptedLoadableModuleWidget, VTKObservationMixin):
    """The panel. Each button calls one method of the logic."""

    def __init__(self, parent=None):
        ScriptedLoadableModuleWidget.__init__(self, parent)
        VTKObservationMixin.__init__(self)
        self.deform: Any = None  # a DeformLogic
        self.parameters: Any = None

    def setup(self):
        super().setup()
        if not installed():
            slicer.util.errorDisplay(
                "MLS Deform works when vtk-mls is installed. Reload the module."
            )
            return
        from MLSDeformLib.deform_logic import KINDS, DeformLogic

        panel = slicer.util.loadUI(self.resourcePath("UI/MLSDeform.ui"))
        panel.setMRMLScene(slicer.mrmlScene)
        self.layout.addWidget(panel)
        self.ui = slicer.util.childWidgetVariables(panel)
        self.deform = DeformLogic(slicer.mrmlScene, self.show_message)
        self.logic = MLSDeformLogic()
        self.parameters = self.logic.getParameterNode()
        self.ui.kind.addItems(KINDS)
        self.ui.transform.connect("currentNodeChanged(vtkMRMLNode*)", self.on_transform)
        for name in ("create", "addHandle", "addBone", "addCut", "remove", "apply", "report"):
            getattr(self.ui, name).connect("clicked()", getattr(self, f"on_{name.lower()}"))
        self.ui.kind.connect("currentTextChanged(QString)", self.on_options)
        for name in ("alpha", "smoothing", "steps"):
            getattr(self.ui, name).connect("valueChanged(double)", self.on_options)
        self.addObserver(slicer.mrmlScene, slicer.mrmlScene.EndCloseEvent, self.on_scene_closed)
        self.show()

    def cleanup(self):
        if self.deform is not None:
            self.deform.unfollow()
        self.removeObservers()

    def on_scene_closed(self, *_):
        self.parameters = self.logic.getParameterNode()
        self.show()

    @property
    def transform(self):
        return self.parameters.transform

    def on_create(self):
        data = self.ui.data.currentNode()
        if data is None:
            self.ui.message.text = "Choose a volume, a model or a segmentation first."
            return
        self.ui.transform.setCurrentNode(self.deform.create(data))

    def on_transform(self, node):
        self.parameters.transform = node
        self.deform.follow(node)
        self.show()

    def on_addhandle(self):
        self._with_transform(
            lambda t: self.deform.add_handle(
                t, self.ui.rest.currentNode(), self.ui.moved.currentNode()
            ),
            self.ui.rest,
        )

    def on_addbone(self):
        self._with_transform(
            lambda t: self.deform.add_bone(t, self.ui.bone.currentNode()), self.ui.bone
        )

    def on_addcut(self):
        self._with_transform(
            lambda t: self.deform.add_cut(t, self.ui.cut.currentNode()), self.ui.cut
        )

    def on_remove(self):
        row = self.ui.parts.currentRow
        if self.transform is not None and row >= 0:
            self.deform.remove(self.transform, self._parts()[row])
            self.show()

    def on_apply(self):
        self._with_transform(
            lambda t: self.deform.data(t).SetAndObserveTransformNodeID(t.GetID()), self.ui.transform
        )

    def on_report(self):
        def report(transform):
            table = slicer.vtkMRMLTableNode()
            table.SetName("Landmarks")
            self.deform.report(transform, table)
            slicer.mrmlScene.AddNode(table)
            selection = slicer.app.applicationLogic().GetSelectionNode()
            selection.SetActiveTableID(table.GetID())
            slicer.app.applicationLogic().PropagateTableSelection()

        self._with_transform(report, self.ui.transform)

    def on_options(self, *_):
        if self.transform is not None:
            self.deform.set_options(
                self.transform,
                kind=self.ui.kind.currentText,
                alpha=self.ui.alpha.value,
                smoothing=self.ui.smoothing.value,
                steps=int(self.ui.steps.value),
            )

    def show_message(self):
        """Show what does not fit, also while a point is dragged."""
        self.ui.message.text = self.deform.message

    def _with_transform(self, act, selector):
        """Do what a button is for, and show the sentence of what does not fit."""
        if self.transform is None or selector.currentNode() is None:
            self.ui.message.text = "Choose a transform, and what to add to it."
            return
        try:
            act(self.transform)
        except (ValueError, TypeError) as error:
            self.ui.message.text = str(error)
        else:
            self.show()

    def _parts(self):
        moved = [moved for _, moved in self.deform.handles(self.transform)]
        return [*moved, *self.deform.bones(self.transform), *self.deform.cuts(self.transform)]

    def show(self):
        """Show the chosen transform."""
        self.ui.transform.setCurrentNode(self.transform)
        self.ui.parts.clear()
        if self.transform is not None:
            self.ui.parts.addItems([node.GetName() for node in self._parts()])
            options = self.deform.options(self.transform)
            for name in ("alpha", "smoothing", "steps"):
                was = getattr(self.ui, name).blockSignals(True)
                getattr(self.ui, name).value = options[name]
                getattr(self.ui, name).blockSignals(was)
            was = self.ui.kind.blockSignals(True)
            self.ui.kind.currentText = options["kind"]
            self.ui.kind.blockSignals(was)
        self.show_message()


def installed():
    """Whether the package vtk_mls is there; if not, ask to install it."""
    if find_spec("vtk_mls") is None and slicer.util.confirmOkCancelDisplay(
        "MLS Deform needs the Python package vtk-mls, numpy and an OpenCL driver for the CPU "
        "(a download of some 300 MB). Install them now?"
    ):
        slicer.util.pip_install("vtk-mls[cpu]")
    return find_spec("vtk_mls") is not None
