"""Written by `python docs/properties_page.py` from the tables of properties."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.grid import Grid
from vtk_mls.model.cuts import Cut
from vtk_mls.model.handles.handle_set import Handle
from vtk_mls.model.limits import FixedFace, Mask
from vtk_mls.queries.transform import Transform

class _DeformingFilter(VTKPythonAlgorithmBase):
    def __init__(self) -> None: ...
    def SetKind(self, value: Literal["affine", "rigid", "similarity", "polynomial"]) -> None:
        """How the space between the control points deforms. rigid keeps sizes and angles as well
        as it can, similarity allows a change of size, affine allows shear, and polynomial bends
        most freely.

        One of "affine", "rigid", "similarity", "polynomial"; default: "rigid".
        """

    def GetKind(self) -> str: ...
    def SetDegree(self, value: int) -> None:
        """Degree of the polynomials. 1 is the affine kind; 2 and 3 need more control points.

        An integer; default: 2.
        """

    def GetDegree(self) -> int: ...
    def SetAlpha(self, value: float) -> None:
        """How local the influence of a control point is. Its weight at distance r is 1 / r^(2
        alpha). Use 1.5 to 2 to drag a few handles, and 3 for many landmarks with the affine
        kind or polynomials of degree 2. Up to 1.5, the influence of far control points does not
        fade in space. The paper uses 1. Must be greater than 0.

        A number; default: 2.0.
        """

    def GetAlpha(self) -> float: ...
    def SetSmoothing(self, value: float) -> None:
        """Length in world units. Weights are 1 / (r^2 + smoothing^2)^alpha. 0 meets the control
        points exactly. Above 0, the deformation passes close to them, for noisy landmarks.

        A number; default: 0.0.
        """

    def GetSmoothing(self) -> float: ...
    def SetSteps(self, value: int) -> None:
        """Number of steps in which the control points go from p to q, each with its own map. Many
        small steps rarely fold. 1 is the single map of the paper. auto, or 0, doubles the
        number, up to 256, until no determinant at sampled points near the control points is
        below 0.1. The map can still fold between these points, and polynomials of degree 2 and
        3 may fold with any number of steps.

        `Deformation.steps_used` and `smallest_determinant` report what was found there.

        An integer; default: 1.
        """

    def GetSteps(self) -> int: ...
    def SetBlend(self, value: float) -> None:
        """Fraction of the displacement from p to q that is applied. 0 leaves everything exactly as
        it was.

        A number; default: 1.0.
        """

    def GetBlend(self) -> float: ...
    def SetCutType(self, value: Literal["none", "plane", "half-plane"]) -> None:
        """A cut in addition to those of the input Cuts. A plane divides everything. A half-plane
        ends at an edge through its origin.

        One of "none", "plane", "half-plane"; default: "none".
        """

    def GetCutType(self) -> str: ...
    def SetCutOrigin(self, *values: float | Sequence[float]) -> None:
        """A point of the plane, or of the edge of the half-plane. If CutFrame is rest, the plane
        in the view stays at the undeformed volume, while the cut itself moves with the
        material.

        (x, y, z), world coordinates; default: (0.0, 0.0, 0.0).
        """

    def GetCutOrigin(self) -> tuple[float, ...]: ...
    def SetCutNormal(self, *values: float | Sequence[float]) -> None:
        """Normal of the plane or half-plane.

        Its length is ignored.

        (x, y, z), world coordinates; default: (1.0, 0.0, 0.0).
        """

    def GetCutNormal(self) -> tuple[float, ...]: ...
    def SetCutInward(self, *values: float | Sequence[float]) -> None:
        """Direction in which the half-plane extends from its edge. The edge goes through the
        origin, at a right angle to this direction and to the normal. The view shows the whole
        plane.

        Its component along the normal is ignored.

        (x, y, z), world coordinates; default: (0.0, 0.0, 1.0).
        """

    def GetCutInward(self) -> tuple[float, ...]: ...
    def AddCut(self, value: Cut) -> None:
        """Cuts in addition to those of CutType and of input port 2.

        Each a `vtk_mls.Plane`, `HalfPlane` or `Surface`; default: none.
        """

    def ClearCuts(self) -> None: ...
    def GetCuts(self) -> tuple[Cut, ...]: ...
    def SetCutFrame(self, value: Literal["rest", "deformed"]) -> None:
        """Space of the cuts. rest: cuts lie in the undeformed volume and move with the material.
        deformed: cuts stay in place in the deformed space, and material that moves through them
        is lost.

        The paper uses deformed.

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
        """Positions q to which the handles are dragged, with the mouse or here. Handles that are
        not dragged hold the material in place.

        If empty, q = p. Ignored if input port 1 is connected.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetDeformedPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfDeformedPoints(self, count: int) -> None: ...
    def GetNumberOfDeformedPoints(self) -> int: ...
    def SetDeformedPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetRestPoints(self, values: ArrayLike) -> None:
        """Positions p of the handles in the undeformed space, one for each deformed point.
        ParaView starts with a lattice over the bounds of the input.

        Outside of ParaView there are no handles by default, and nothing moves. Handles that
        rest on the cut of CutType belong to neither side and are ignored, because they would
        hold it shut. Ignored if input port 1 is connected.

        (n, 3) array_like, world coordinates; default: none.
        """

    def GetRestPoints(self) -> tuple[tuple[float, float, float], ...]: ...
    def SetNumberOfRestPoints(self, count: int) -> None: ...
    def GetNumberOfRestPoints(self) -> int: ...
    def SetRestPoint(self, index: int, x: float, y: float, z: float) -> None: ...
    def SetWeights(self, values: ArrayLike) -> None:
        """A positive factor for each handle. If empty, all factors are 1.

        (n,) array_like; default: none.
        """

    def GetWeights(self) -> tuple[float, ...]: ...
    def SetNumberOfWeights(self, count: int) -> None: ...
    def GetNumberOfWeights(self) -> int: ...
    def SetWeight(self, index: int, weight: float) -> None: ...
    def SetHandleShapes(self, value: Literal["points", "cells"]) -> None:
        """Whether the points or the cells of the input ControlPoints are handles. With cells,
        vertices and points without a cell are points, lines are curves, and closed surfaces are
        rigid regions.

        Curves are moved along their whole length. Each connected surface moves by the rotation
        and translation of its points. Cells with a volume count by their outer faces. Weights
        and paths belong to points.

        One of "points", "cells"; default: "points".
        """

    def GetHandleShapes(self) -> str: ...
    def AddHandle(self, value: Handle) -> None:
        """Handles in addition to those of input port 1 or of RestPoints.

        Each a `vtk_mls.CurveHandle` or `RegionHandle`; default: none.
        """

    def ClearHandles(self) -> None: ...
    def GetHandles(self) -> tuple[Handle, ...]: ...
    def SetMaskBall(self, *values: float | Sequence[float]) -> None:
        """Ball in the deformed space in which the deformation acts: center, radius, and the
        distance outside the ball over which the deformation fades to zero. All 0: no ball.

        (x, y, z, radius, falloff), world coordinates; default: (0.0, 0.0, 0.0, 0.0, 0.0).
        """

    def GetMaskBall(self) -> tuple[float, ...]: ...
    def SetMask(self, value: Mask | vtkImageData | None) -> None:
        """Image in the deformed space by which displacements are multiplied, with values from 0 to
        1. In an image of integers, such as labels, every value except 0 counts as 1. Outside
        the image, nothing moves.

        Alternative: input port 3.

        A vtkImageData, or a `vtk_mls.BallMask`, `BoxMask` or `ImageMask`; default: None.
        """

    def GetMask(self) -> Mask | vtkImageData | None: ...
    def SetFixedPlanes(self, values: ArrayLike) -> None:
        """Planes that stay in place: a point, a normal, and the distance from the plane over which
        the deformation grows from zero to its full size.

        Rows (x, y, z, nx, ny, nz, falloff), world coordinates; default: none.
        """

    def GetFixedPlanes(self) -> tuple[tuple[float, ...], ...]: ...
    def SetNumberOfFixedPlanes(self, count: int) -> None: ...
    def GetNumberOfFixedPlanes(self) -> int: ...
    def SetFixedPlane(self, index: int, *row: float) -> None: ...
    def SetSlidingPlanes(self, values: ArrayLike) -> None:
        """Planes along which material slides, such as a plane of symmetry: a point, a normal, and
        a distance. Over this distance from the plane, displacements along the normal grow from
        zero to their full size.

        Rows (x, y, z, nx, ny, nz, falloff), world coordinates; default: none.
        """

    def GetSlidingPlanes(self) -> tuple[tuple[float, ...], ...]: ...
    def SetNumberOfSlidingPlanes(self, count: int) -> None: ...
    def GetNumberOfSlidingPlanes(self) -> int: ...
    def SetSlidingPlane(self, index: int, *row: float) -> None: ...
    def AddConstraint(self, value: FixedFace) -> None:
        """Faces in addition to those of FixedPlanes and SlidingPlanes.

        Each a `vtk_mls.FixedFace` or `SlidingFace`; default: none.
        """

    def ClearConstraints(self) -> None: ...
    def GetConstraints(self) -> tuple[FixedFace, ...]: ...
    def SetInitialTransform(self, value: Transform | str | PathLike[str] | None) -> None:
        """Transform that moves the material first, so that the handles correct it. It is a file of
        ITK, ANTs or 3D Slicer with an affine transform or a displacement field, as used to
        resample images. Handles at rest, and cuts in the rest frame, lie in the space after
        this transform.

        Images are resampled once, with both combined. Points of meshes are moved by both.

        The path of a file, or a `vtk_mls.Affine`, `Field`, `Chain` or `Deformation`; default:
        "".
        """

    def GetInitialTransform(self) -> Transform | str | PathLike[str]: ...
    def SetGenerateOverlap(self, value: bool) -> None:
        """Whether an image gets the point array Overlap and the field array OverlappingPoints.
        Overlap is 1 where material from both sides of a cut is at the same place. The image
        shows only one side there. OverlappingPoints is the number of such points.

        With CutFrame deformed, nothing overlaps, because material that reaches a cut is lost.
        Meshes keep both sides. If the output is made in pieces, each piece has its own number.

        True or False; default: False.
        """

    def GetGenerateOverlap(self) -> bool: ...
    def SetGenerateJacobian(self, value: bool) -> None:
        """Whether to write the point array Jacobian with 9 components. Component 3 i + j is the
        derivative of G_j in the direction i, where G(v) is the original position of the
        material now at v. It transforms gradients of the input to gradients of the output.

        It is (I + J_D)^T of Eq. 29, row by row.

        True or False; default: False.
        """

    def GetGenerateJacobian(self) -> bool: ...
    def SetGenerateJacobianDeterminant(self, value: bool) -> None:
        """Whether to write the point array JacobianDeterminant, which is zero or negative where
        space is folded, and the field array FoldedVoxels with the number of such points.

        The void does not count. A mesh gets the field arrays InvertedCells, the number of cells
        that the deformation has inverted, and UncheckedCells, the number of cells without a
        result. If the output is made in pieces, each piece has its own numbers, without ghost
        cells.

        True or False; default: False.
        """

    def GetGenerateJacobianDeterminant(self) -> bool: ...
    def SetMapTolerance(self, value: float) -> None:
        """Largest error of displacements on grids, in spacings of the grid. Above 0, they are
        interpolated from fewer points, which is faster. With 0, the default of Python and the
        shell, each point is computed. ParaView and the editor use 0.02, which is too small to
        see. Next to cuts, all points are computed.

        A number; default: 0.0.
        """

    def GetMapTolerance(self) -> float: ...
    def SetDevice(self, value: str | None) -> None:
        """Where to compute. Empty: the first GPU, or else the CPU with its fastest driver.
        Otherwise cpu, gpu, platform:device such as 0:1, or reference for the slow float64
        specification in numpy.

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
        """Source of the rest positions. points: a list. lattice: a regular lattice in a box. file:
        a file.

        One of "points", "lattice", "file"; default: "points".
        """

    def GetMode(self) -> str: ...
    def SetFileName(self, value: str | None) -> None:
        """File with control points. Markups of 3D Slicer (.fcsv, .mrk.json) and other landmarks
        are p. Tables px,py,pz,qx,qy,qz[,weight] (.csv, .txt) and files of BigWarp have pairs.
        DeformedPoints overrides the q of the file if it is not empty.

        The path of a file; default: "".
        """

    def GetFileName(self) -> str: ...
    def SetDeformedFileName(self, value: str | None) -> None:
        """File with the deformed positions q of the control points, such as markups. May be empty.
        They are paired with p by label, or else by order.

        The path of a file; default: "".
        """

    def GetDeformedFileName(self) -> str: ...
    def SetSpace(self, value: Literal["lps", "ras"]) -> None:
        """Frame of files that do not state their own, as markups do. The output is in LPS (x to
        the patient's left, y to the back, z to the head), like that of MLS Image Reader.

        One of "lps", "ras"; default: "lps".
        """

    def GetSpace(self) -> str: ...
    def SetDeformedPoints(self, values: ArrayLike) -> None:
        """Positions q to which the control points are dragged, with the mouse or here, one for
        each control point. If empty, they stay at rest.

        Used in every mode.

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

        A single one is in the middle of the box.

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
        """A positive factor for each control point. If empty, all factors are 1.

        Used in every mode.

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
        """Arrays with labels, whose values must not be mixed. The nearest value is taken, whatever
        the interpolation is.

        Arrays that the field data LabelArrays of the input names are also labels. `vtk_mls.io`
        sets it for segmentations.

        Names; default: none.
        """

    def ClearLabelArrays(self) -> None: ...
    def GetLabelArrays(self) -> tuple[str, ...]: ...
    def SetBackground(self, value: float) -> None:
        """Value where the deformed image has no material.

        This is outside the input and, unless VoidValues is continued, in the void. In the array
        vtkGhostType the value is 0. If the type of an array cannot hold the value, the nearest
        one is used (0 for NaN in integers), with a warning.

        A number; default: 0.0.
        """

    def GetBackground(self) -> float: ...
    def SetAutomaticBackground(self, value: bool) -> None:
        """Whether each array has its own Background, from the corners of the input: the median of
        the values at the eight corners (four of a slice), such as air around a CT. For labels
        it is 0.

        Of two middle values it is the lower. Each component has its own. NaN is ignored. At all
        times the value is that of the first time step. Background has no effect then. In
        ParaView it is on by default, and a Background other than 0 is used instead.

        True or False; default: False.
        """

    def GetAutomaticBackground(self) -> bool: ...
    def SetOutputGrid(self, value: Literal["input", "fitted", "given"]) -> None:
        """Grid of the output. input: the grid of the input. fitted: the spacing of the input, but
        large enough for the deformed volume. given: by dimensions, spacing and origin.

        With "fitted", control points and cuts are updated in RequestInformation. "given" has
        the directions of the input.

        One of "input", "fitted", "given"; default: "input".
        """

    def GetOutputGrid(self) -> str: ...
    def SetOutputDimensions(self, *values: float | Sequence[float]) -> None:
        """Number of points of the output in each direction.

        (nx, ny, nz); default: (64, 64, 64).
        """

    def GetOutputDimensions(self) -> tuple[int, ...]: ...
    def SetOutputSpacing(self, *values: float | Sequence[float]) -> None:
        """Distance between the output's points in each direction.

        (x, y, z), world units; default: (1.0, 1.0, 1.0).
        """

    def GetOutputSpacing(self) -> tuple[float, ...]: ...
    def SetOutputOrigin(self, *values: float | Sequence[float]) -> None:
        """Position of the output's first point.

        (x, y, z), world coordinates; default: (0.0, 0.0, 0.0).
        """

    def GetOutputOrigin(self) -> tuple[float, ...]: ...
    def SetReference(self, value: Grid | vtkImageData | None) -> None:
        """Image whose grid the output image gets, with its directions. The values of the image are
        not used.

        Alternative: input port 5, which is ignored if this is set. Both override OutputGrid. A
        warning says if no material of the input arrives there. Meshes are an error.

        A vtkImageData or a `vtk_mls.Grid`; default: None.
        """

    def GetReference(self) -> Grid | vtkImageData | None: ...
    def SetHideVoid(self, value: bool) -> None:
        """Whether the void that a cut opens is hidden (by the array vtkGhostType). Turn it off to
        clip or contour by VoidDistance at 0, for a smooth face.

        True or False; default: True.
        """

    def GetHideVoid(self) -> bool: ...
    def SetSplitCells(self, value: bool) -> None:
        """Whether the cells of a mesh are split along a cut, so that it opens. Otherwise, torn
        cells are kept, marked in the cell array Void, and hidden.

        True or False; default: True.
        """

    def GetSplitCells(self) -> bool: ...
    def SetVoidValues(self, value: Literal["background", "continued"]) -> None:
        """Values of arrays in the void. background: the value of Background. continued: as if the
        material of each side continued behind the face of the cut. For a smooth face, turn
        HideVoid off, contour or slice the continued array, and clip the result by VoidDistance
        at 0.

        One of "background", "continued"; default: "background".
        """

    def GetVoidValues(self) -> str: ...
    def SetGradientArray(self, value: str | None) -> None:
        """Point scalars whose gradient in the deformed volume becomes the point array Gradient,
        for shading. It follows the deformation exactly.

        Three floats, per world unit: J_G^T (grad f)(G(v)). On the face of the void, it is
        normal to the face unless VoidValues is continued.

        A name; default: "".
        """

    def GetGradientArray(self) -> str: ...
    def AddGradientVectorArray(self, value: str) -> None:
        """Arrays of the input that are gradients and are transformed as such (covariantly). Active
        normals are always transformed.

        Names; default: none.
        """

    def ClearGradientVectorArrays(self) -> None: ...
    def GetGradientVectorArrays(self) -> tuple[str, ...]: ...
    def SetNormalizeGradient(self, value: bool) -> None:
        """Whether gradients are scaled to length 1.

        True or False; default: False.
        """

    def GetNormalizeGradient(self) -> bool: ...
    def AddPushForwardArray(self, value: str) -> None:
        """Arrays of vectors that move with the material, such as velocities, and are transformed
        as such (contravariantly).

        Names; default: none.
        """

    def ClearPushForwardArrays(self) -> None: ...
    def GetPushForwardArrays(self) -> tuple[str, ...]: ...
    def SetGenerateCellQuality(self, value: bool) -> None:
        """Whether a mesh gets the cell arrays CellQuality and CellQualityBefore: VTK's scaled
        Jacobian of the deformed cells, and of the same cells at rest. It is 1 for regular
        cells, and 0 or less for inverted cells and concave quads.

        It is NaN for cells other than triangles, quads, tetrahedra, hexahedra, wedges and
        pyramids. Only InvertedCells shows that a triangle or quad is turned over.

        True or False; default: False.
        """

    def GetGenerateCellQuality(self) -> bool: ...
    def SetGenerateLargestBlend(self, value: bool) -> None:
        """Whether a mesh gets the field array LargestBlend: the largest Blend, up to that of the
        filter, at which no cell is inverted.

        If cells are inverted, it is found by bisection and rounded down to a multiple of 0.01.
        At this blend no cell is inverted, and at 0.01 more some cell is. This moves the mesh
        about eight times. If the output is made in pieces, each piece has its own blend.

        True or False; default: False.
        """

    def GetGenerateLargestBlend(self) -> bool: ...
    def DisconnectReference(self) -> Any: ...
    def has_reference(self) -> Any: ...
    def output_geometry(self, source, make_deformation) -> Any: ...

class MLSDisplacementField(_DeformingFilter):
    def __init__(self) -> None: ...
    def SetInverse(self, value: bool) -> None:
        """Whether to write the displacement to the new position of the material, which moves
        points, instead of the displacement to its original position, which resamples images.

        True or False; default: False.
        """

    def GetInverse(self) -> bool: ...
    def SetSampleDimensions(self, *values: float | Sequence[float]) -> None:
        """Number of points in each direction if the input is not an image.

        (nx, ny, nz); default: (32, 32, 32).
        """

    def GetSampleDimensions(self) -> tuple[int, ...]: ...

class MLSLandmarkReport(VTKPythonAlgorithmBase):
    def __init__(self) -> None: ...
    def SetDevice(self, value: str | None) -> None:
        """Where to compute. Empty: the first GPU, or else the CPU with its fastest driver.
        Otherwise cpu, gpu, platform:device such as 0:1, or reference for the slow float64
        specification in numpy.

        A text; default: "".
        """

    def GetDevice(self) -> str: ...
    def GetOutput(self) -> Any: ...
    def SetInputData(self, *port_and_data) -> Any: ...
    def DisconnectDeformedControlPoints(self) -> Any: ...
