"""`plotter.mls.edit(mesh)`: the editor in a window, or a notebook, of PyVista."""

from pathlib import Path

import numpy as np
import pyvista
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls.filters import map_inputs, property_tables
from vtk_mls.pyvista import options as arguments
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, WEIGHT, path_of

# Properties of filters that are options of the editor.
_OPTIONS = (
    *property_tables.MAP,
    *property_tables.CUT_OPTIONS,
    *property_tables.INTERACTIVE_COMPUTING,
)


class Editing:
    """Editors in a plotter.

    Parameters
    ----------
    plotter : pyvista.Plotter
    """

    def __init__(self, plotter):
        self._plotter, self._edit = plotter, None

    @arguments.takes(_OPTIONS)
    def edit(self, datasets, rest=None, deformed=None, weights=None, cuts=(), **options):
        """Deform datasets by the mouse, in this plotter's window.

        They are drawn as they move: images as volumes, all else as surfaces, on the editor's dark
        background unless another is set afterwards. Then call `show` of the plotter; the key H
        lists mouse and keys.

        Parameters
        ----------
        datasets : pyvista.DataSet or list of pyvista.DataSet
            The same handles move them all.
        rest, deformed, weights : optional
            Handles to begin with, as of `mesh.mls.deform`; a lattice over the data, if not given.
        cuts : Plane, HalfPlane, Surface or PolyData, or list of these
        {options}

        Returns
        -------
        Edit
            The edited state, also after the window is closed.

        Raises
        ------
        TypeError, ValueError
            Naming the argument; or if the plotter has several views, an editor, or is closed.
        """
        if self._plotter.render_window is None:
            raise ValueError("the plotter is closed; make a new one to edit in")
        if len(self._plotter.renderers) > 1:
            raise ValueError(
                f"an editor needs a plotter with one view, got {len(self._plotter.renderers)}"
            )
        if self._edit is not None:
            raise ValueError("this plotter has an editor; make another plotter for another one")
        state = _state((rest, deformed, weights), cuts, options)
        self._edit = Edit(self._plotter, datasets, state)
        return self._edit

    def __plotter_close__(self):
        if self._edit is not None:
            self._edit.close()


class Edit:
    """An edit in a plotter.

    Parameters
    ----------
    plotter : pyvista.Plotter
    datasets : pyvista.DataSet or list of pyvista.DataSet
    state : vtk_mls.editor.State

    Attributes
    ----------
    editor : vtk_mls.editor.Editor
        Its methods do what its keys do: `undo()`, `add(point)`, `delete()`, `change_cut()`, ...
    """

    def __init__(self, plotter, datasets, state):
        from vtk_mls.editor import Editor
        from vtk_mls.editor.scene import BOTTOM, TOP

        self._datasets, self._plotter = datasets, plotter
        self.editor = Editor(plotter.iren.interactor, datasets, state)
        self._is_open = True
        plotter.camera_set = True  # otherwise the first picture turns it
        plotter.set_background(BOTTOM, top=TOP)

    @property
    def state(self):
        """The `vtk_mls.editor.State` as it is now."""
        return self.editor.state

    @property
    def handles(self):
        """A PolyData of points p with the vectors "Displacement", q - p.

        Vertices are points, lines are curves, closed surfaces are rigid regions.
        """
        from vtk_mls.editor.handle_polydata import handle_polydata

        return pyvista.wrap(handle_polydata(self.state))

    @property
    def deformed(self):
        """The dataset, or the list of them, deformed by the filter."""
        if isinstance(self._datasets, (list, tuple)):
            return [self._run(dataset, "deform") for dataset in self._datasets]
        return self._run(self._datasets, "deform")

    @property
    def field(self):
        """The displacement field as an ImageData, over the first dataset."""
        is_one = not isinstance(self._datasets, (list, tuple))
        return self._run(self._datasets if is_one else self._datasets[0], "field")

    def save(self, folder):
        """Save handles, deformed data, displacement field, picture and a script, as the key S does.

        Parameters
        ----------
        folder : path

        Raises
        ------
        ValueError
            If something could not be saved, or the window is closed.
        """
        if not self._is_open:
            raise ValueError("the window is closed, and there is no picture of it to save")
        self.editor.saver.folder = Path(folder)
        if not self.editor.save():
            raise ValueError(self.editor.message)

    def close(self):
        """Detach the editor from the plotter; the edited state stays."""
        if self._is_open:
            self._is_open = False
            self.editor.detach()

    def _run(self, dataset, method):
        """The result of a method of `mesh.mls` with the edited state."""
        state = self.state
        options = {row.option: getattr(state, row.option) for row in _OPTIONS}
        options.update(cuts=state.cuts, mask=state.mask, handle_shapes="cells")
        return getattr(pyvista.wrap(dataset).mls, method)(self.handles, **options)


def _state(control_points, cuts, options):
    from vtk_mls.editor import State

    names = [row.option for row in _OPTIONS]
    unknown = options.keys() - set(names)
    if unknown:
        listed = ", ".join(names)
        raise TypeError(f"`{min(unknown)}` is no option of the editor; there are {listed}")
    shapes = []
    for cut in arguments.as_cuts(cuts):
        shapes += map_inputs.surfaces(cut) if isinstance(cut, vtkPolyData) else [cut]
    if all(argument is None for argument in control_points):
        state = State([(0, 0, 0)], [(1, 0, 0)], cuts=shapes, **options)
        state.deformation()  # raises errors now instead of at the first drag
        return state.with_handles_at(np.zeros((0, 3)))
    polydata = arguments.control_points(*control_points)
    weight = WEIGHT if polydata.GetPointData().HasArray(WEIGHT) else None
    rest, deformed, weights = arrays.control_points(polydata, DISPLACEMENT, weight)
    return State(rest, deformed, weights, cuts=shapes, path=path_of(polydata), **options)


pyvista.register_plotter_component("mls")(Editing)
