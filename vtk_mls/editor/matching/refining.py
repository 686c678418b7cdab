"""Landmarks of a `State`, refined by the images around them."""

from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import landmarks
from vtk_mls.rendering.transfer_functions import scalar_image
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def refined(state, datasets, rows, progress=None):
    """A `State` with refined landmarks `rows`, and the `landmarks.Refinement`.

    `datasets` are the moving one and the target, ValueError for a mesh; other errors and `progress`
    are as of `landmarks.refine`.
    """
    images = []
    for dataset, side in zip(datasets, ("moving data", "target")):
        if not isinstance(dataset, vtkImageData):
            raise ValueError(
                f"landmarks are refined by two images with gray values, and the {side} is a mesh"
            )
        image = scalar_image(dataset)
        scalars, grid = image.GetPointData().GetScalars(), ImageGeometry.of_image(image).grid
        images.append(landmarks.Image(arrays.to_numpy(scalars).reshape(grid.shape), grid))
    deformation = state.deformation() if state.enabled.any() else None
    pairs = state.rest[rows], state.deformed[rows]
    found = landmarks.refine(*images, *pairs, deformation=deformation, progress=progress)
    return state.moved(rows, found.deformed), found


def key_of(state, row):
    """Identifies a landmark by its places, whatever its row and name."""
    return state.rest[row].tobytes() + state.deformed[row].tobytes()
