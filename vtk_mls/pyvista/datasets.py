"""`mesh.mls`: the filters as methods of PyVista's datasets."""

import pyvista
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls.filters import MLSDeform, MLSDisplacementField, property_tables
from vtk_mls.filters.updating import update
from vtk_mls.pyvista import options as arguments

# PyVista's names of the attributes, and how to get them; and of its lists of arrays that VTK holds
# as uint8 and as pairs of floats.
_ATTRIBUTES = {"POINT": "GetPointData", "CELL": "GetCellData", "NONE": "GetFieldData"}
_BOOL, _COMPLEX = "_association_bitarray_names", "_association_complex_names"


class Deforming:
    """Deforms a dataset by control points, as `vtk_mls.filters.MLSDeform` does.

    Parameters
    ----------
    dataset : pyvista.DataSet or pyvista.MultiBlock
    """

    def __init__(self, dataset):
        self._dataset = dataset

    @arguments.takes(property_tables.DEFORM)
    def deform(self, rest=None, deformed=None, weights=None, cuts=(), **options):
        """Deform the dataset.

        Images are resampled, points of meshes are moved; both stay registered. Arrays keep their
        types; those of bool are taken from the nearest point of an image.

        Parameters
        ----------
        rest : (n, 3) array_like or dataset with points, world coordinates, optional with `handles`
            p: control points in the undeformed space. A dataset with point vectors "Displacement",
            q - p, needs no `deformed`: a PolyData that `vtk_mls.pyvista.read` makes of a file, or
            points that were extracted from a mesh (UnstructuredGrid, PointSet, ...). With
            `handle_shapes="cells"` its lines are curves, and its closed surfaces rigid regions.
        deformed : (n, 3) array_like or dataset with points, world coordinates, optional
            q: where they were dragged to.
        weights : (n,) array_like, optional
            A positive factor for each.
        cuts : Plane, HalfPlane, Surface or PolyData, or list of these
            Surfaces through which control points do not act.
        {options}

        Returns
        -------
        pyvista.DataSet or pyvista.MultiBlock
            Of the same type, but for a RectilinearGrid, which becomes a StructuredGrid, and cut
            grids, which become UnstructuredGrid.

        Raises
        ------
        TypeError, ValueError
            Naming the argument.
        """
        filter_ = MLSDeform()
        filter_.keeps_images = False  # numpy changes arrays without VTK's knowledge
        filter_.flags = _flags(self._dataset)
        result = self._run(filter_, (rest, deformed, weights), cuts, options)
        for dataset, output in _pairs(self._dataset, result):
            output.copy_meta_from(dataset, deep=True)
        _copy_types(self._dataset, result)
        return result

    @arguments.takes(property_tables.DISPLACEMENT_FIELD)
    def field(self, rest=None, deformed=None, weights=None, cuts=(), **options):
        """The displacement field, on the image's grid or over the bounds of a mesh.

        Parameters
        ----------
        rest, deformed, weights, cuts
            As of `deform`.
        {options}

        Returns
        -------
        pyvista.ImageData
            With the point array "BackwardDisplacement", how far away the material at each point
            came from; or "ForwardDisplacement".

        Raises
        ------
        TypeError, ValueError
            Naming the argument.
        """
        result = self._run(MLSDisplacementField(), (rest, deformed, weights), cuts, options)
        _copy_types(self._dataset, result)
        return result

    def _run(self, algorithm, control_points, cuts, options):
        algorithm.SetInputData(0, self._dataset)
        if options.get("handles") is None or control_points[0] is not None:
            algorithm.SetInputData(1, arguments.control_points(*control_points))
        for cut in arguments.as_cuts(cuts):
            if isinstance(cut, vtkPolyData):
                algorithm.AddInputDataObject(2, cut)
            else:
                algorithm.AddCut(cut)
        arguments.apply(algorithm, options)
        update(algorithm, names=arguments.argument_names(algorithm))
        return pyvista.wrap(algorithm.GetOutput())


def _flags(data):
    """`__this__` of the arrays of bool of a DataSet or MultiBlock: a set."""
    return {
        array.__this__
        for dataset, _ in _pairs(data, data)
        for key in _ATTRIBUTES
        for name in getattr(dataset, _BOOL).get(key, ())
        if (array := _array(dataset, key, name)) is not None
    }


def _copy_types(data, result):
    """Make arrays bool or complex if they are in `data` and have the same VTK type."""
    for dataset, output in _pairs(data, result):
        for kind in (_BOOL, _COMPLEX):
            for key, names in getattr(dataset, kind).items():
                same = {name for name in names if _has_same_type(dataset, output, key, name)}
                getattr(output, kind)[key] = same


def _pairs(data, result):
    """The datasets of `data`, each with the dataset at the same place of `result`."""
    if isinstance(data, pyvista.MultiBlock):
        for pair in zip(data, result):
            yield from _pairs(*pair)
    elif isinstance(data, pyvista.DataSet) and isinstance(result, pyvista.DataSet):
        yield data, result


def _has_same_type(dataset, output, key, name):
    old, new = _array(dataset, key, name), _array(output, key, name)
    if old is None or new is None or old.GetDataType() != new.GetDataType():
        return False
    return old.GetNumberOfComponents() == new.GetNumberOfComponents()


def _array(dataset, key, name):
    return getattr(dataset, _ATTRIBUTES[key])().GetArray(name)


for target in (pyvista.DataSet, pyvista.MultiBlock):
    pyvista.register_dataset_accessor("mls", target)(Deforming)
