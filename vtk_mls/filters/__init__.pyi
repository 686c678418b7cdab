"""Written by `python docs/properties_page.py` from the tables of properties."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.grid import Grid
from vtk_mls.cuts import Cut
from vtk_mls.handles.handle_set import Handle
from vtk_mls.limits import FixedFace, Mask
from vtk_mls.queries.transform import Transform

class _DeformingFilter(VTKPythonAlgorithmBase):
    def __init__(self) -> None: ...
    def SetKind(self, value: Literal["affine", "rigid", "similarity", "polynomial"]) -> None:
        """How the space between the control points follows them: rigid keeps sizes and angles as
        well as it can, similarity allows a change of size, affine allows shear, polynomial
        bends most freely.

        One of "affine", "rigid", "similarity", "polynomial"; default: "rigid".
        """

    def GetKind(self) -> str: ...
    def SetDegree(self, value: int) -> None:
        """Degree of the polynomials: 1 is the affine kind; 2 and 3 need more control points.

        An integer; default: 2.
        """

    def GetDegree(self) -> int: ...
    def SetAlpha(self, value: float) -> None:
        """How local the influence of a control point is: its weight at distance r is 1 / r^(2
        alpha). Take 1.5 to 2 for a few handles to drag, 3 for many landmarks with the affine
        kind or polynomials of degree 2. Up to 1.5 the influence of far control points does not
        fade in space; 1 is the paper's. Must be greater than 0.

        A number; default: 2.0.
        """

    def GetAlpha(self) -> float: ...
    def SetSmoothing(self, value: float) -> None:
        """Length in world units: weights are 1 / (r^2 + smoothing^2)^alpha. 0 meets the control
        points exactly; above 0 the deformation passes close to them, for noisy landmarks.

        A number; default: 0.0.
        """

    def GetSmoothing(self) -> float: ...
    def SetSteps(self, value: int) -> None:
        """Steps in which the control points go from p to q, each with its own map: many small
        steps do not fold. 1 is the single map of the paper; auto, or 0, takes as many as
        needed, up to 256. Polynomials of degree 2 and 3 may fold in any steps.

        `Deformation.steps_used` and `smallest_determinant` tell what was found.

        An integer; default: 1.
        """

    def GetSteps(self) -> int: ...
    def SetBlend(self, value: float) -> None:
        """Fraction of the displacement from p to q that is applied: 0 leaves everything exactly as
        it was.

        A number; default: 1.0.
        """

    def GetBlend(self) -> float: ...
    def SetCutType(self, value: Literal["none", "plane", "half-plane"]) -> None:
        """A cut through the volume beside those of the input Cuts: a plane divides everything; a
        half-plane has an edge through its origin, and begins there.

        One of "none", "plane", "half-plane"; default: "none".
        """

    def GetCutType(self) -> str: ...
    def SetCutOrigin(self, *values: float | Sequence[float]) -> None:
        """A point of the plane, or of the edge of the half-plane. While CutFrame is rest, the cut
        in the view stays at the undeformed volume, where it was laid, and the material takes
        the cut itself along.

        (x, y, z), world coordinates; default: (0.0, 0.0, 0.0).
        """

    def GetCutOrigin(self) -> tuple[float, ...]: ...
    def SetCutNormal(self, *values: float | Sequence[float]) -> None:
        """Normal of the plane or half-plane.

        Its length does not count.

        (x, y, z), world coordinates; default: (1.0, 0.0, 0.0).
        """

    def GetCutNormal(self) -> tuple[float, ...]: ...
    def SetCutInward(self, *values: float | Sequence[float]) -> None:
        """Direction in which the half-plane extends from its edge, which goes through the origin
        at a right angle to it and to the normal; the view shows all of the plane.

        Its part along the normal does not count.

        (x, y, z), world coordinates; default: (0.0, 0.0, 1.0).
        """

    def GetCutInward(self) -> tuple[float, ...]: ...
    def AddCut(self, value: Cut) -> None:
        """Cuts beside those of CutType and of input port 2.

        Each a `vtk_mls.Plane`, `HalfPlane` or `Surface`; default: none.
        """

    def ClearCuts(self) -> None: ...
    def GetCuts(self) -> tuple[Cut, ...]: ...
    def SetCutFrame(self, value: Literal["rest", "deformed"]) -> None:
        """Where cuts are: rest, in the undeformed volume, and the material takes them along;
        deformed, in the deformed space, where they stay, and material that is moved through
        them is lost.

        The paper's are in the deformed space.

        One of "rest", "deformed"; default: "rest".
        """

    def GetCutFrame(self) -> str: ...
    def SetNu(self, value: float) -> None:
        """How fast the influence of control points behind a cut falls with the length of the
        detour around it. Must be greater than 1.

        The damping exponent of Eq. 28.

        A number; default: 2.0.
        """

    def GetNu(self) -> float: ...
    def SetDeformedPoints(self, values: ArrayLike) -> None:
        """Positions q to which the handles are dragged, with the mouse in the view or here. Those
        that are not dragged hold the material where it is.

        Without any, q = p. Unused where input port 1 is connected.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetDeformedPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfDeformedPoints(self, count: int) -> None: ...
    def GetNumberOfDeformedPoints(self) -> int: ...
    def SetDeformedPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetRestPoints(self, values: ArrayLike) -> None:
        """Positions p of the handles in the undeformed space, one for each of those dragged; to
        begin with a lattice over the bounds of the input.

        That lattice is ParaView's: without it there are none, and nothing moves. Those that
        rest on the cut of CutType belong to neither of its sides and do not count: they would
        hold it shut. Unused where input port 1 is connected.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetRestPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfRestPoints(self, count: int) -> None: ...
    def GetNumberOfRestPoints(self) -> int: ...
    def SetRestPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetWeights(self, values: ArrayLike) -> None:
        """A positive factor for each handle; empty: all count alike.

        (n,) array_like; default: none.
        """

    def GetWeights(self) -> tuple[float, ...]: ...
    def SetNumberOfWeights(self, count: int) -> None: ...
    def GetNumberOfWeights(self) -> int: ...
    def SetWeight(self, index: int, weight: float) -> None: ...
    def SetHandleShapes(self, value: Literal["points", "cells"]) -> None:
        """What the input ControlPoints is: points, each a handle; or cells: vertices, and points
        without a cell, are points, lines are curves, and closed surfaces are rigid regions.

        Curves are carried along their whole length. Each connected surface moves by the
        rotation and translation that its points have in common; cells with a volume count by
        their outer faces. Weights and paths are those of points.

        One of "points", "cells"; default: "points".
        """

    def GetHandleShapes(self) -> str: ...
    def AddHandle(self, value: Handle) -> None:
        """Handles beside those of input port 1, or of RestPoints.

        Each a `vtk_mls.CurveHandle` or `RegionHandle`; default: none.
        """

    def ClearHandles(self) -> None: ...
    def GetHandles(self) -> tuple[Handle, ...]: ...
    def SetMaskBall(self, *values: float | Sequence[float]) -> None:
        """Ball in the deformed space in which the deformation acts: center, radius, and the
        distance over which it fades to nothing outside of the ball. All 0: no ball.

        (x, y, z, radius, falloff), world coordinates; default: (0.0, 0.0, 0.0, 0.0, 0.0).
        """

    def GetMaskBall(self) -> tuple[float, ...]: ...
    def SetMask(self, value: Mask | vtkImageData | None) -> None:
        """Image in the deformed space by which displacements are multiplied, from 0 to 1; of
        integers, as of labels, what is not 0 counts as 1. Outside of the image nothing moves.

        Or input port 3.

        A vtkImageData, or a `vtk_mls.BallMask`, `BoxMask` or `ImageMask`; default: None.
        """

    def GetMask(self) -> Mask | vtkImageData | None: ...
    def SetFixedPlanes(self, values: ArrayLike) -> None:
        """Planes that stay where they are: a point, a normal, and the distance from the plane over
        which the deformation grows to its whole.

        Rows (x, y, z, nx, ny, nz, falloff), world coordinates; default: none.
        """

    def GetFixedPlanes(self) -> tuple[tuple[float, ...], ...]: ...
    def SetNumberOfFixedPlanes(self, count: int) -> None: ...
    def GetNumberOfFixedPlanes(self) -> int: ...
    def SetFixedPlane(self, index: int, *row: float) -> None: ...
    def SetSlidingPlanes(self, values: ArrayLike) -> None:
        """Planes along which material slides, as at a plane of symmetry: a point, a normal, and
        the distance from the plane over which displacements along the normal grow to their
        whole.

        Rows (x, y, z, nx, ny, nz, falloff), world coordinates; default: none.
        """

    def GetSlidingPlanes(self) -> tuple[tuple[float, ...], ...]: ...
    def SetNumberOfSlidingPlanes(self, count: int) -> None: ...
    def GetNumberOfSlidingPlanes(self) -> int: ...
    def SetSlidingPlane(self, index: int, *row: float) -> None: ...
    def AddConstraint(self, value: FixedFace) -> None:
        """Faces beside those of FixedPlanes and SlidingPlanes.

        Each a `vtk_mls.FixedFace` or `SlidingFace`; default: none.
        """

    def ClearConstraints(self) -> None: ...
    def GetConstraints(self) -> tuple[FixedFace, ...]: ...
    def SetInitialTransform(self, value: Transform | str | PathLike[str] | None) -> None:
        """Transform that moves the material first, so that the handles correct it: a file of ITK,
        ANTs or 3D Slicer with an affine transform or a displacement field that resamples
        images. Handles at rest, and cuts in the rest frame, are in the space that it leads to.

        Images are resampled once, by both; points of meshes are moved by both.

        The path of a file, or a `vtk_mls.Affine`, `Field`, `Chain` or `Deformation`; default:
        "".
        """

    def GetInitialTransform(self) -> Transform | str | PathLike[str]: ...
    def SetGenerateOverlap(self, value: bool) -> None:
        """Whether to make the point array Overlap of an image, which is 1 where material from both
        sides of a cut has come to the same place and only one can be shown, and the field array
        OverlappingPoints with the number of such points.

        With CutFrame deformed there is none: what comes to a cut is gone. Meshes keep both
        sides. If the output is made in pieces, it is the number of each piece.

        True or False; default: False.
        """

    def GetGenerateOverlap(self) -> bool: ...
    def SetGenerateJacobian(self, value: bool) -> None:
        """Whether to make the point array Jacobian with 9 components: component 3 i + j is the
        derivative of G_j in the direction i, where G(v) is the point that the material now at v
        came from. It takes gradients of the input to those of the output.

        It is (I + J_D)^T of Eq. 29, row by row.

        True or False; default: False.
        """

    def GetGenerateJacobian(self) -> bool: ...
    def SetGenerateJacobianDeterminant(self, value: bool) -> None:
        """Whether to make the point array JacobianDeterminant, zero or negative where space is
        folded, and the field array FoldedVoxels with the number of such points.

        The void does not count. Of a mesh the field arrays are InvertedCells, the number of
        cells that the deformation has inverted, and UncheckedCells, the number of cells without
        a result. If the output is made in pieces, each piece has its own numbers, without ghost
        cells.

        True or False; default: False.
        """

    def GetGenerateJacobianDeterminant(self) -> bool: ...
    def SetMapTolerance(self, value: float) -> None:
        """How far displacements on grids may be off, in spacings of the grid: above 0 they are
        found faster, from fewer points. The default of Python and the shell, 0, finds each
        point's own; that of ParaView and the editor, 0.02, is too small to see. Next to cuts
        all are exact.

        A number; default: 0.0.
        """

    def GetMapTolerance(self) -> float: ...
    def SetDevice(self, value: str | None) -> None:
        """Where to compute: empty for the first GPU, else the CPU by its fastest driver; cpu; gpu;
        platform:device as in 0:1; reference for the slow float64 specification in numpy.

        A text; default: "".
        """

    def GetDevice(self) -> str: ...
    def GetOutput(self) -> Any: ...
    def SetInputData(self, *port_and_data) -> Any: ...
    def DisconnectControlPoints(self) -> Any: ...
    def DisconnectCuts(self) -> Any: ...
    def DisconnectMask(self) -> Any: ...
    def DisconnectDeformedControlPoints(self) -> Any: ...
    def updated_deformation(self, info=None) -> Any: ...

class MLSControlPoints(VTKPythonAlgorithmBase):
    def __init__(self) -> None: ...
    def SetMode(self, value: Literal["points", "lattice", "file"]) -> None:
        """points: the rest positions are listed; lattice: they fill a box regularly; file: they
        are read from one.

        One of "points", "lattice", "file"; default: "points".
        """

    def GetMode(self) -> str: ...
    def SetFileName(self, value: str | None) -> None:
        """File with control points: markups of 3D Slicer (.fcsv, .mrk.json) and other landmarks,
        which are p; or pairs, as of px,py,pz,qx,qy,qz[,weight] (.csv, .txt) and of BigWarp. The
        list of deformed positions goes first, if it is not empty.

        The path of a file; default: "".
        """

    def GetFileName(self) -> str: ...
    def SetDeformedFileName(self, value: str | None) -> None:
        """File with the positions q that control points were moved to, such as markups; or none.
        They are matched with their p by labels, or else by order.

        The path of a file; default: "".
        """

    def GetDeformedFileName(self) -> str: ...
    def SetSpace(self, value: Literal["lps", "ras"]) -> None:
        """Frame of files that do not say theirs: markups do. What comes out is in LPS (x to the
        patient's left, y to the back, z to the head), as from MLS Image Reader.

        One of "lps", "ras"; default: "lps".
        """

    def GetSpace(self) -> str: ...
    def SetDeformedPoints(self, values: ArrayLike) -> None:
        """Positions q to which the control points are dragged, with the mouse in the view or here,
        one for each; none: they stay at rest.

        They count in every mode.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetDeformedPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfDeformedPoints(self, count: int) -> None: ...
    def GetNumberOfDeformedPoints(self) -> int: ...
    def SetDeformedPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetRestPoints(self, values: ArrayLike) -> None:
        """Positions p of the control points in the undeformed space.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetRestPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfRestPoints(self, count: int) -> None: ...
    def GetNumberOfRestPoints(self) -> int: ...
    def SetRestPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetLatticeDimensions(self, *values: float | Sequence[float]) -> None:
        """Number of control points in each direction of the lattice.

        A single one lies in the middle.

        (nx, ny, nz); default: (3, 3, 3).
        """

    def GetLatticeDimensions(self) -> tuple[int, ...]: ...
    def SetBounds(self, *values: float | Sequence[float]) -> None:
        """Box of the lattice: xmin, xmax, ymin, ymax, zmin, zmax.

        (xmin, xmax, ymin, ymax, zmin, zmax), world coordinates; default: (-1.0, 1.0, -1.0, 1.0,
        -1.0, 1.0).
        """

    def GetBounds(self) -> tuple[float, ...]: ...
    def SetWeights(self, values: ArrayLike) -> None:
        """A positive factor for each control point; empty: all count alike.

        They count in every mode.

        (n,) array_like; default: none.
        """

    def GetWeights(self) -> tuple[float, ...]: ...
    def SetNumberOfWeights(self, count: int) -> None: ...
    def GetNumberOfWeights(self) -> int: ...
    def SetWeight(self, index: int, weight: float) -> None: ...
    def GetOutput(self) -> Any: ...

class MLSDeform(_DeformingFilter):
    def __init__(self) -> None: ...
    def SetInterpolation(self, value: Literal["nearest", "linear", "cubic"]) -> None:
        """How values between the points of the input are interpolated.

        One of "nearest", "linear", "cubic"; default: "linear".
        """

    def GetInterpolation(self) -> str: ...
    def AddLabelArray(self, value: str) -> None:
        """Arrays with labels, whose values must not be mixed: they are sampled nearest whatever
        the interpolation is.

        So are those that the input itself names in its field data LabelArrays, as the images of
        segmentations do that `vtk_mls.io` reads.

        Names; default: none.
        """

    def ClearLabelArrays(self) -> None: ...
    def GetLabelArrays(self) -> tuple[str, ...]: ...
    def SetBackground(self, value: float) -> None:
        """Value where the deformed image has no material.

        That is outside of the input and, unless values are continued there, in the void; in the
        array vtkGhostType it is 0. An array whose type does not have the value gets the nearest
        that it has (integers 0 for NaN), with a warning.

        A number; default: 0.0.
        """

    def GetBackground(self) -> float: ...
    def SetOutputGrid(self, value: Literal["input", "fitted", "given"]) -> None:
        """Grid of the output: that of the input; fitted, with the input's spacing but large enough
        for the deformed volume; or given by dimensions, spacing and origin.

        For "fitted" control points and cuts are updated in RequestInformation; "given" has the
        directions of the input.

        One of "input", "fitted", "given"; default: "input".
        """

    def GetOutputGrid(self) -> str: ...
    def SetOutputDimensions(self, *values: float | Sequence[float]) -> None:
        """Number of points of the output in each direction.

        (nx, ny, nz); default: (64, 64, 64).
        """

    def GetOutputDimensions(self) -> tuple[int, ...]: ...
    def SetOutputSpacing(self, *values: float | Sequence[float]) -> None:
        """Distance of the output's points in each direction.

        (x, y, z), world units; default: (1.0, 1.0, 1.0).
        """

    def GetOutputSpacing(self) -> tuple[float, ...]: ...
    def SetOutputOrigin(self, *values: float | Sequence[float]) -> None:
        """Position of the output's first point.

        (x, y, z), world coordinates; default: (0.0, 0.0, 0.0).
        """

    def GetOutputOrigin(self) -> tuple[float, ...]: ...
    def SetReference(self, value: Grid | vtkImageData | None) -> None:
        """Image whose grid the output of an image has, with its directions; only the place of its
        points counts.

        Or input port 5, which does not count then. OutputGrid does not count with either. A
        warning says if nothing of the input arrives there. Meshes are an error.

        A vtkImageData or a `vtk_mls.Grid`; default: None.
        """

    def GetReference(self) -> Grid | vtkImageData | None: ...
    def SetHideVoid(self, value: bool) -> None:
        """Whether the void that a cut opens is hidden (by the array vtkGhostType). Turn it off to
        clip or contour by VoidDistance at 0, which gives a smooth face.

        True or False; default: True.
        """

    def GetHideVoid(self) -> bool: ...
    def SetSplitCells(self, value: bool) -> None:
        """Whether the cells of a mesh are split along a cut, so that it opens. Otherwise cells
        that are torn are kept, marked in the cell array Void, and hidden.

        True or False; default: True.
        """

    def GetSplitCells(self) -> bool: ...
    def SetVoidValues(self, value: Literal["background", "continued"]) -> None:
        """What arrays hold in the void: the background; or continued, as if the material of each
        side went on behind the face of the cut. Turn HideVoid off, contour or slice that and
        clip the result by VoidDistance at 0: it ends at the face without steps.

        One of "background", "continued"; default: "background".
        """

    def GetVoidValues(self) -> str: ...
    def SetGradientArray(self, value: str | None) -> None:
        """Point scalars whose gradient in the deformed volume is wanted, as the point array
        Gradient, for shading: it follows the deformation exactly.

        Three floats, per world unit: J_G^T (grad f)(G(v)), and across the face on the face of
        the void unless values are continued behind it.

        A name; default: "".
        """

    def GetGradientArray(self) -> str: ...
    def AddGradientVectorArray(self, value: str) -> None:
        """Arrays of the input that are gradients, and are transformed as such (covariantly). So
        are the active normals, without being named.

        Names; default: none.
        """

    def ClearGradientVectorArrays(self) -> None: ...
    def GetGradientVectorArrays(self) -> tuple[str, ...]: ...
    def SetNormalizeGradient(self, value: bool) -> None:
        """Whether gradients get length 1.

        True or False; default: False.
        """

    def GetNormalizeGradient(self) -> bool: ...
    def AddPushForwardArray(self, value: str) -> None:
        """Arrays of vectors that move with the material, as velocities do, and are transformed as
        such (contravariantly).

        Names; default: none.
        """

    def ClearPushForwardArrays(self) -> None: ...
    def GetPushForwardArrays(self) -> tuple[str, ...]: ...
    def SetGenerateCellQuality(self, value: bool) -> None:
        """Whether to make the cell arrays CellQuality and CellQualityBefore of a mesh: VTK's
        scaled Jacobian of the deformed cells, and of the same cells at rest. It is 1 for
        regular cells, and 0 or less for cells that are inverted or, of quads, concave.

        NaN for cells that are no triangles, quads, tetrahedra, hexahedra, wedges or pyramids.
        That a triangle or quad is turned over shows in InvertedCells only.

        True or False; default: False.
        """

    def GetGenerateCellQuality(self) -> bool: ...
    def SetGenerateLargestBlend(self, value: bool) -> None:
        """Whether to make the field array LargestBlend of a mesh: the largest Blend, up to that of
        the filter, at which no cell is inverted.

        Where cells are inverted, it is found by bisection and rounded down to a multiple of
        0.01: no cell is inverted there, and some cell is at 0.01 more. The mesh is moved about
        eight times for that. If the output is made in pieces, it is the blend of each piece.

        True or False; default: False.
        """

    def GetGenerateLargestBlend(self) -> bool: ...
    def DisconnectReference(self) -> Any: ...
    def has_reference(self) -> Any: ...
    def output_geometry(self, source, make_deformation) -> Any: ...

class MLSDisplacementField(_DeformingFilter):
    def __init__(self) -> None: ...
    def SetInverse(self, value: bool) -> None:
        """Whether to make the displacement to where the material goes, which moves points, instead
        of the one to where it came from, which resamples images.

        True or False; default: False.
        """

    def GetInverse(self) -> bool: ...
    def SetSampleDimensions(self, *values: float | Sequence[float]) -> None:
        """Number of points in each direction where the input is not an image.

        (nx, ny, nz); default: (32, 32, 32).
        """

    def GetSampleDimensions(self) -> tuple[int, ...]: ...

class MLSLandmarkReport(VTKPythonAlgorithmBase):
    def __init__(self) -> None: ...
    def SetDevice(self, value: str | None) -> None:
        """Where to compute: empty for the first GPU, else the CPU by its fastest driver; cpu; gpu;
        platform:device as in 0:1; reference for the slow float64 specification in numpy.

        A text; default: "".
        """

    def GetDevice(self) -> str: ...
    def GetOutput(self) -> Any: ...
    def SetInputData(self, *port_and_data) -> Any: ...
    def DisconnectDeformedControlPoints(self) -> Any: ...
