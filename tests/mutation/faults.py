"""Deliberate faults: each is a mistake that someone could make, and that a test must find.

The old text must be in the file exactly once. Where code has moved on, adapt the fault to it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """One text of one file replaced by another.

    Attributes
    ----------
    breaks : str
        What goes wrong then, which is also the fault's name.
    file : str
        From the project's folder on.
    old, new : str
    likely : tuple of str
        Files of tests that are tried first, of those that the level has; without the rest of
        the level nothing is proven, so that comes next.
    """

    breaks: str
    file: str
    old: str
    new: str
    likely: tuple[str, ...]


def _in(file, *likely):
    """Adds faults of one file: what breaks, the old text, the new one."""

    def add(breaks, old, new, *first):
        FAULTS.append(Fault(breaks, file, old, new, (*first, *likely)))

    return add


FAULTS = []
ENGINE, PROPERTIES = "tests/engine/test_engine.py", "tests/core/test_properties.py"
FUNCTIONS, CUTS = "tests/engine/test_kernel_functions.py", "tests/core/test_cuts.py"
REST_FRAME = "tests/core/test_rest_frame.py"
TOLERANCE = "tests/core/test_map_tolerance.py"
FORWARD, RESAMPLE = "tests/core/test_forward.py", "tests/core/test_resample.py"
PARTS, DEVICE = "tests/core/test_parts.py", "tests/engine/test_device.py"
GRADIENT = "tests/engine/test_gradient_kernel.py"
VOID_DISTANCE = "tests/core/test_void_distance.py"
DEFORMATION, PROOF = "tests/core/test_deformation.py", "tests/engine/test_proof.py"
DEFORM, ERRORS = "tests/filters/test_deform.py", "tests/filters/test_errors.py"
CUT_IMAGES, CUT_MESHES = "tests/filters/test_cut_images.py", "tests/filters/test_cut_meshes.py"
MESHES, ARRAYS = "tests/filters/test_meshes.py", "tests/filters/test_arrays.py"
PIECES, FIELD = "tests/filters/test_pieces.py", "tests/filters/test_displacement_field.py"
OWN, LABELS = "tests/filters/test_own_handles.py", "tests/files/test_labels.py"
FRAMES, FORMATS = "tests/files/test_frames.py", "tests/files/test_image_formats.py"
LANDMARKS, CLI = "tests/files/test_landmarks.py", "tests/commands/test_cli.py"
SCRIPTS, GUI = "tests/paraview/test_scripts.py", "tests/paraview/test_gui.py"

# Kernels: the map

add = _in("opencl/weights.cl", ENGINE, PROPERTIES)
add(
    "weights: the share of the nearest control point",
    "pivot.r = power(first / pivot.e2, map->numbers.alpha);",
    "pivot.r = 1.001f * power(first / pivot.e2, map->numbers.alpha);",
)
add(
    "weights: the slope of a weight",
    "vec_scale(2 * map->numbers.alpha / most(d2, 1e-30f), vec_sub(q, view->v))",
    "vec_scale(1.99f * map->numbers.alpha / most(d2, 1e-30f), vec_sub(q, view->v))",
)
add(
    "weights: lanes do not look up a nearest control point of their own",
    "LANE(pivot.u.y, l) = nearest->u[1];",
    "",
)

add = _in("opencl/coarse_map.cl", TOLERANCE)
add(
    "map tolerance: the layer is of the first points of the cells",
    "STORE(between(tap, k, slope_along == 2)",
    "STORE(between(tap, 0, slope_along == 2)",
)
add(
    "map tolerance: slabs begin a point late",
    "max(max((long)0, -begin), (long)x - grid->start[0])",
    "max(max((long)0, 1 - begin), (long)x - grid->start[0])",
)
add(
    "map tolerance: cells that a plane goes through are left out",
    "inside &= side * plane_height(plane, index) + reach >= 0;",
    "inside &= side * plane_height(plane, index) >= 0;",
)
add = _in("opencl/coarse_check.cl", TOLERANCE)
add(
    "map tolerance: nothing is off",
    "select((integer)(OFF), (integer)(0), dot3(off, off) <= check.limit2)",
    "(integer)(0)",
)
add(
    "map tolerance: cells with a cut are interpolated",
    "found = select(found, (integer)(OFF), parted);",
    "",
)
add = _in("opencl/coarse_displacement.cl", TOLERANCE)
add(
    "map tolerance: other regions' points are overwritten",
    "kept &= in_region(&map.cuts, indices_in(&row, n));",
    "",
)
add = _in("opencl/coarse_source_index.cl", TOLERANCE)
add(
    "map tolerance: derivatives are of indices, not of the world",
    "transformed(coarse.to_slopes, by_index)",
    "by_index",
)
add = _in("vtk_mls/engine/coarse_map.py", TOLERANCE)
add(
    "map tolerance: cells beside those that are off",
    "far = _beside(off) |",
    "far = off[1:-1, 1:-1, 1:-1] |",
)
add(
    "map tolerance: parts do not look at cells beside theirs",
    "np.maximum(first - 1, 0), np.minimum(first + cells + 1, most)",
    "first, first + cells",
)
add = _in("opencl/searches.cl", REST_FRAME)
add(
    "searches: a lane keeps the point that has ended",
    "LANE_INT(at, l) = min(next++, stop - 1);",
    "LANE_INT(at, l) = min(next, stop - 1);",
)
add(
    "searches: void distances are stored as displacements",
    "to[3 * count] = LANE(nothing, l);",
    "to[2 * count] = LANE(nothing, l);",
)

add = _in("opencl/powers.cl", FUNCTIONS, ENGINE)
add("powers: a coefficient of exp2 for vectors", "0.240221197f", "0.240251197f")
add("powers: alpha 1.5 without its root", "return x * sqrt(x);", "return x;")

add = _in("opencl/rotation.cl", ENGINE, PROPERTIES, FUNCTIONS)
add(
    "rotation: a minor of the eigenvector's matrix",
    "m13 = a12 * a33 - a23 * a13,",
    "m13 = a12 * a33 + a23 * a13,",
)
add("rotation: help for close roots", "#define CLOSE_ROOTS 0.5f", "#define CLOSE_ROOTS 0.0f")
add(
    "rotation: a line turned by exactly 180 degrees",
    "q.x = select(q.x, (real)(flip_axis.x), opposite);",
    "q.x = select(q.x, (real)(1), opposite);",
)
add(
    "rotation: reflections have roots of the other sign",
    "fma(2 * det, root + 1, cof2)",
    "fma(2 * fabs(det), root + 1, cof2)",
)

add = _in("opencl/fit_rotation.cl", ENGINE, PROPERTIES)
add(
    "rotation: the twist where two control points outweigh all others",
    "#define DOUBTFUL 0.3f",
    "#define DOUBTFUL 0.0f",
)
add(
    "similarity: the spread is not about the mean",
    "fit->spread = sums.spread - dot3(q, sums.q);",
    "fit->spread = sums.spread;",
)
add(
    "Jacobian: of the rotation of a line",
    "vec da = vec_scale(strength * dot3(q, b)",
    "vec da = vec_scale(0.9f * strength * dot3(q, b)",
)
add(
    "Jacobian: stretch of the similarity kind",
    "real stretch = dot3(p, rotated) - mu * dot3(q, q);",
    "real stretch = dot3(p, rotated) - dot3(q, q);",
)

add = _in("opencl/basis.cl", ENGINE, PROPERTIES)
add("polynomial: a cubic monomial", "q.z * q.z * x.y);", "q.z * q.z * x.x);")
add(
    "polynomial: the slope of a cubic monomial",
    "+ v.x * v.y * ez;",
    "+ v.x * v.x * ez;",
)

add = _in("opencl/fit_polynomial.cl", ENGINE, PROPERTIES)
add(
    "polynomial: the last group of control points",
    "w[b] = first + b < stop ?",
    "w[b] = first + b <= stop ?",
)
add(
    "polynomial: functions that the set cannot tell, in double",
    "? 1e-6f : 1e-13f)",
    "? 1e-6f : 1e-6f)",
)
add(
    "Jacobian: the residual of a polynomial",
    "residual = sum_madd(-f, c[j], residual);",
    "residual = sum_madd(-0.9f * f, c[j], residual);",
)

# Kernels: cuts

add = _in("opencl/cuts.cl", CUTS)
add(
    "cuts: the slope of damping does not know nu",
    "return vec_scale((real)(cuts->numbers.nu), slope);",
    "return vec_scale((real)(2), slope);",
)
add(
    "cuts: points of a grid on a plane are on the other side",
    "vload4(0, cuts->planes[i].index_plane), index) < 0;",
    "vload4(0, cuts->planes[i].index_plane), index) <= 0;",
    PARTS,
)
add(
    "cuts: what a closed surface keeps apart",
    "unreachable |= blocked & (length2 < 0);",
    "",
)
add = _in("opencl/cut_half_plane.cl", CUTS)
add(
    "cuts: what a half-plane is in the way of",
    "(fma(a.h, fabs(b.s), b.h * fabs(a.s)) > 0)",
    "(a.h + b.h > 0)",
)
add = _in("opencl/cut_surface.cl", CUTS)
add(
    "cuts: the way round an edge bends elsewhere",
    "real share = r_v / most(",
    "real share = r_q / most(",
)
add("cuts: slips through corners of a surface", "fabs(side) <= blur)", "fabs(side) < 0)")
add(
    "cuts: the detour round a surface is not squared",
    "select(path * path, (real)(NO_DETOUR)",
    "select(path, (real)(NO_DETOUR)",
)
add(
    "cuts: the distance to a triangle is that to its plane",
    "return select(border, fabs(dot3(vec_sub(x, a), normal)), inside);",
    "return fabs(dot3(vec_sub(x, a), normal));",
)
add = _in("vtk_mls/regions.py", CUTS)
add(
    "cuts: the inverse ends on the other side of a plane",
    "ON_PLANE = 1e-6",
    "ON_PLANE = 1.0",
    FORWARD,
)

# Kernels: inverse

# Cuts in the rest frame

add = _in("opencl/rest_frame.cl", REST_FRAME)
add(
    "rest frame: a search that ends behind a cut is not begun anew",
    "retries = behind & !searches->second;",
    "retries = behind & searches->second;",
)
add(
    "rest frame: a step through a cut sees it from the other side at once",
    "search->passed ^= select((integer)(0), crossed(cuts, search->x, x), going);",
    "",
)
add(
    "rest frame: the search ends too early",
    "#define FORESEEN 3e-8f",
    "#define FORESEEN 3e-4f",
)
add(
    "rest frame: of two places behind cuts the deeper counts",
    "(searches->first_depth < depth)",
    "(searches->first_depth > depth)",
)
add(
    "rest frame: the Jacobian of material that stays the same",
    "by_x_less.a[i] = -by_x.a[i];",
    "by_x_less.a[i] = 0;",
)
_in("opencl/node_cell.cl", REST_FRAME)(
    "rest frame: a cell gives guesses where the map bends",
    "#define FORESIGHT 0.01f",
    "#define FORESIGHT 1.0f",
)
_in("opencl/node_origin.cl", REST_FRAME)(
    "rest frame: a guess is taken for the place itself",
    "real slope = select(sqrt(slope2), (real)(-1), fit.view.passed != 0);",
    "real slope = select((real)(0), (real)(-1), fit.view.passed != 0);",
)
_in("opencl/point_origin.cl", REST_FRAME)(
    "rest frame: a guess at many points is taken for the place itself",
    "is_foreseen(&start, x));",
    "start.slope < 1e14f);",
)
_in("vtk_mls/engine/origin_nodes.py", REST_FRAME)(
    "rest frame: the last layer of nodes that a slab needs",
    "max(high // NODE_STEP + 1,",
    "max(high // NODE_STEP,",
)
_in("opencl/weights.cl", REST_FRAME)(
    "rest frame: cuts see control points where they were moved to",
    "return origin_of(&map->cuts, point_of(at), (vec){at->u[0], at->u[1], at->u[2]});",
    "return point_of(at);",
)
add = _in("opencl/on_grid.cl", REST_FRAME)
add(
    "rest frame: a rival takes all points of other regions on a grid",
    "item.kept = !item.kept & (load_plane(rivals.at, item.count, item.at) < 0);",
    "item.kept = !item.kept;",
)
add(
    "rest frame: a rival that is more void wins on a grid",
    "item->kept &= here > load_plane(to.at, item->count, item->at);",
    "",
)
_in("vtk_mls/rest_frame.py", REST_FRAME)(
    "rest frame: void distances of the specification do not know what was passed",
    "np.where(passed, -distance, distance)",
    "distance",
)
_in("vtk_mls/regions.py", REST_FRAME)(
    "rest frame: a moved plane has lost its height",
    "return Plane(-plane.height(offset) / size * normal, normal)",
    "return Plane(0 * normal, normal)",
)

_in("opencl/types.cl", FORWARD, ENGINE)(
    "inverse: Newton's matrix lacks the identity",
    "1 + j->a[4], j->a[5]};",
    "j->a[4], j->a[5]};",
)
_in("opencl/point_forward.cl", FORWARD)(
    "inverse: the mean displacement has another sign",
    "LANE(displacement.y, l), -world.mean_displacement[1])",
    "LANE(displacement.y, l), world.mean_displacement[1])",
)
_in("opencl/local_points.cl", FORWARD, ENGINE)(
    "local frame: digits of large coordinates",
    "- frame.centre[1]) - frame.centre_rest[1])",
    "- frame.centre[1]))",
)

# Kernels: grids and images

add = _in("opencl/taps.cl", RESAMPLE, DEFORM)
add("resample: the half voxel at the border", "(x <= axis->size - 0.5f)", "(x <= axis->size - 1)")
add("resample: nearest", "within(axis, x) + 0.5f", "within(axis, x) + 0.4f")
add("resample: linear", "taps->weight[1] = t;", "taps->weight[1] = 0.999f * t;")
add("resample: cubic", "fma((real)(3), t, (real)(-5))", "fma((real)(3.1f), t, (real)(-5.1f))")
add("resample: taps that are not there", "(taps->first <= axis->there - TAPS)", "1")
add("resample: taps without weight", "whole &= taps->weight[tap] != 0", "")
add(
    "resample: NaN of a tap without weight",
    "select(point, nearest, taps->weight[tap] == 0)",
    "point",
)
_in("opencl/linear.cl", RESAMPLE, ARRAYS)(
    "resample: values of many components lie side by side",
    "if (box->step_x == 1) {",
    "if (1) {",
)
add = _in("opencl/resample.cl", RESAMPLE, DEFORM)
add("resample: on a point to the bit", "if (LANE_INT(on_point, l))", "if (0)")
add(
    "resample: lanes of the last work item",
    "int lanes = (int)min((long)LANES, count - first);",
    "int lanes = (int)min((long)LANES, count - first - 1);",
)
_in("opencl/resample.cl", RESAMPLE, ARRAYS, ENGINE)(
    "gradients: turned by J, not by its transpose",
    "n = transposed_mat_vec(&j, n);",
    "n = mat_vec(&j, n);",
)
_in("opencl/types.cl", ENGINE, PROPERTIES, FORWARD)(
    "points: lanes of the last work item",
    "for (int l = 0; l < (int)(count - first); ++l) plane[first + l]",
    "for (int l = 0; l < (int)(count - first) - 1; ++l) plane[first + l]",
)
_in("opencl/grid.cl", ENGINE, PARTS)(
    "grid: lanes that go on in the next slice",
    "k = select(k, k + 1, over);",
    "",
)
_in("opencl/grid_jacobian.cl", ENGINE)(
    "Jacobian on a grid: transposed",
    "LANE(j.a[3 * column + row], l)",
    "LANE(j.a[3 * row + column], l)",
)
_in("opencl/source_index.cl", CUT_IMAGES, CUTS)(
    "void: nothing is there where values are to continue",
    "if (!source->continued)",
    "if (source->continued)",
)

# Engine

add = _in("vtk_mls/engine/engine.py", ENGINE, DEVICE, RESAMPLE, PARTS)
add(
    "engine: two threads launch the same kernel", "        with self._lock:\n", "        if True:\n"
)
add(
    "engine: points of several regions",
    "return part.start + np.flatnonzero(here)",
    "return np.flatnonzero(here)",
    CUTS,
)
add = _in("vtk_mls/engine/array_types.py", ENGINE, DEVICE, RESAMPLE, PARTS)
add("engine: 64-bit index", 'array.size < 2**31 else "long"', 'array.size < 2**40 else "long"')
add = _in("vtk_mls/engine/differences.py", GRADIENT)
add("gradient: the slices beside a slab", "max(start - _REACH, 0)", "max(start - 1, 0)")
add = _in("opencl/gradient.cl", GRADIENT)
add("gradient: of second order beside the border", "|| i == n - 2) return", ") return")
add("gradient: the last voxels of a row", "i + LANES <= nx - 2", "i + LANES <= nx")
add = _in("opencl/grid_source_index.cl", VOID_DISTANCE)
add("cuts: the void distance beside an image", "if (void_distance) store", "if (0) store")
add = _in("vtk_mls/engine/sampler.py", ENGINE, DEVICE, RESAMPLE, PARTS)
add("engine: the last slice that a slab needs", "int(z.max()) + 2)", "int(z.max()))")
add = _in("vtk_mls/engine/launcher.py", ENGINE, DEVICE, RESAMPLE, PARTS)
add("engine: slabs do not fit the memory", "self.memory.limit / 4 / bytes_per_item,", "1e18,")
add(
    "engine: double where the device has none",
    "self.sums(self.device.has_float64 and kind.needs_float64(alpha))",
    "self.sums(False)",
    PROPERTIES,
)
add = _in("vtk_mls/engine/memory.py", ENGINE, DEVICE, RESAMPLE, PARTS)
add(
    "engine: short of device memory it gives up",
    "if self.limit < _LEAST:",
    "if self.limit:",
)
add = _in("vtk_mls/engine/inverse.py", FORWARD)
add("inverse: what is not found counts as found", "= 5e-6, 1e-5\n", "= 5e-3, 1e-2\n")
add("inverse: no second start", "_STARTS = 4 ", "_STARTS = 0 ")

# The device's proof

add = _in("vtk_mls/engine/self_test.py", PROOF)
add("proof: a device that computes NaN passes", "if not error <= bound:", "if error > bound:")
add(
    "proof: the inverse is not tested",
    '    yield "rigid inverse, cut", lambda: (of_the_inverse(rigid), 1e-4)\n',
    "",
)
add = _in("vtk_mls/engine/proof.py", PROOF)
add("proof: doubts are kept for ever", "(doubtful and old)", "(doubtful and False)")
add(
    "proof: kernels that have changed are not tested",
    "_processor(), _kernels()))",
    "_processor()))",
)

# Specification and core

add = _in("vtk_mls/control_points.py", PROPERTIES, DEFORMATION)
add("core: coincident control points have no weights", "weights * c)", "c)")
add(
    "core: a set that moves as one",
    "rest[0] - deformed[0]).all()",
    "rest[0] - deformed[0]).all() * 0",
)
add("core: a set in one position moves as its first", "if alike:  #", "if count == 1:  #")
_in("vtk_mls/kinds/polynomials.py", PROPERTIES, DEFORMATION)(
    "core: rank of a set that is nearly flat", "RANK_TOLERANCE = 1e-5", "RANK_TOLERANCE = 1e-12"
)
_in("vtk_mls/kinds/rotations.py", PROPERTIES, DEFORMATION)(
    "core: twist of a set that is nearly a line", "TWIST_TOLERANCE = 1e-5", "TWIST_TOLERANCE = 1e-1"
)
_in("vtk_mls/regions.py", CUTS, FORWARD)(
    "core: a point on a plane", "(plane.height(points) < 0)", "(plane.height(points) <= 0)"
)
add = _in("vtk_mls/grid.py", PARTS, DEFORMATION, RESAMPLE)
add("core: parts of parts", "int(a) + int(b) for a, b", "int(b) for a, b")
add("core: grids on a common lattice", "< 1e-7, whole, values)", "< 0, whole, values)")
add = _in("vtk_mls/interpolation.py", RESAMPLE)
add("core: integers are cut off, not rounded", "np.rint(np.nan_to_num(", "np.floor(np.nan_to_num(")
add("core: 64-bit integers overflow", "np.where(rounded > high, limits.max, inner)", "inner")
add = _in("vtk_mls/arguments.py", RESAMPLE)
add("arrays of the other byte order", 'array.dtype.newbyteorder("=")', "array.dtype")
add = _in("vtk_mls/deformation.py", DEFORMATION, CUTS)
add("validation: nu", "np.isfinite(nu) and nu > 1", "np.isfinite(nu) and nu > 0")
add("validation: alpha", "np.isfinite(alpha) and alpha > 0", "alpha > 0")
_in("vtk_mls/kinds/rotations.py", PROPERTIES, CUTS)(
    "specification: the best factor of a similarity",
    "np.divide(self.r_max, self.spread, out=self.factor",
    "np.divide(self.r_max, 1.01 * self.spread, out=self.factor",
)
_in("vtk_mls/weights.py", PROPERTIES, CUTS)(
    "specification: a detour that is shorter than the way",
    "np.maximum(path**2 / d2, 1)",
    "path / np.sqrt(d2)",
)
add = _in("vtk_mls/cuts/surface.py", CUTS)
add("specification: a segment slips through corners", "np.abs(side) <= blur", "np.abs(side) < 0")
add("specification: of many triangles only some count", "odd ^= np.logic", "odd = np.logic")

# Filters

add = _in("vtk_mls/filters/algorithm.py", ERRORS, DEFORM)
add(
    "filters: a property that changes nothing",
    "            setattr(self, name, value)\n            self.Modified()\n",
    "            setattr(self, name, value)\n",
)
add(
    "filters: an error leaves the old output",
    "            info.Get(vtkDataObject.DATA_OBJECT()).Initialize()\n            info.Set(",
    "            info.Set(",
)
add(
    "filters: abort is an error",
    "        except Aborted:\n            self._discard(outInfo)\n            return 1\n",
    "        except Aborted:\n            self._discard(outInfo)\n            return 0\n",
)
add(
    "filters: after an error it does not try again",
    "            info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)\n",
    "",
)
add = _in("vtk_mls/filters/extents.py", PIECES)
add("filters: cells need their last corner", "highest + corner)", "highest)")
add(
    "filters: how far interpolation reaches",
    "reach = _REACH[sampling.interpolation] + more",
    "reach = more",
)
add = _in("vtk_mls/filters/resampling.py", DEFORM, LABELS)
add(
    "filters: labels are interpolated",
    "if array.GetName() in self.labels:",
    "if False:",
)
add(
    "filters: ghosts outside are blanked",
    'return "nearest", 0.0',
    'return "nearest", self.wanted.GetBackground()',
)
add = _in("vtk_mls/filters/warping.py", MESHES)
add(
    "meshes: what has no inverse",
    'arrays.add(points, "NoInverse", ~field.found)',
    'arrays.add(points, "NoInverse", field.found)',
)
add("meshes: split meshes are kept though the mesh changed", "kept[1] != state:", "False:")
_in("vtk_mls/filters/orientation.py", MESHES, CUT_MESHES)(
    "meshes: inverted wedges", "_WEDGE = [(0, 1, 2, 5)", "_WEDGE = [(0, 2, 1, 5)"
)
add = _in("vtk_mls/filters/splitting.py", CUT_MESHES)
add("splitting: points near a cut count as on it", "_ON_CUT = 1e-6 ", "_ON_CUT = 1e-2 ")
add("splitting: tetrahedra inside out", "corners[wrong, :2] = corners[wrong, 1::-1]", "pass")
_in("vtk_mls/filters/parallel.py", "tests/paraview/test_mpi.py", PIECES)(
    "MPI: what all processes have counts as often",
    "different = list(dict.fromkeys(part for part in parts if part is not None))",
    "different = [part for part in parts if part is not None]",
)
_in("vtk_mls/filters/displacement_field.py", FIELD)(
    "field: the samples do not reach the end of the bounds",
    "steps = np.maximum(dimensions - 1, 1)",
    "steps = np.maximum(dimensions, 1)",
)
_in("vtk_mls/filters/own_control_points.py", OWN, "tests/filters/test_control_points.py")(
    "handles: lists of different lengths", "if len(values) not in (0, len(rest)):", "if False:"
)
_in("vtk_mls/filters/deforming.py", DEFORM, OWN)(
    "filters: a blend of the handles",
    "rest + blend * (deformed - rest)",
    "deformed + blend * (deformed - rest)",
)

# Files

add = _in("vtk_mls/files/nifti.py", FRAMES, FORMATS)
add("NIfTI: the origin stays in RAS", "        _RAS * affine[:, 3],\n", "        affine[:, 3],\n")
add("NIfTI: displacements stay in RAS", "scaled = scaled * _RAS.astype(scaled.dtype)", "pass")
add("NIfTI: the qform counts for less", "handed = -1 if header", "handed = 1 if header")
add = _in("vtk_mls/files/nrrd.py", FRAMES, FORMATS)
add("NRRD: every space is LPS", "return frames.signs(space)\n", "return np.ones(3)\n")
add("NRRD: values at the corners of cells", '0.0 if center == "node" else 0.5', "0.0")
add = _in("vtk_mls/files/markups.py", LANDMARKS, "tests/files/test_slicer_markups.py")
add("markups: the number of a frame", '{"0": "RAS", "1": "LPS"', '{"0": "LPS", "1": "LPS"')
add(
    "markups: written in another frame than the file says",
    "positions[number + i] * factors)",
    "positions[number + i])",
)
add = _in("vtk_mls/files/replacing.py", "tests/files/test_replacing.py")
add("replacing: permissions of the old file", "shutil.copymode(old, file)", "pass")
add(
    "replacing: the file that names the others comes first",
    "files.sort(key=lambda file: file == folder",
    "files.sort(key=lambda file: file != folder",
)
_in(
    "vtk_mls/files/volumes.py",
    FORMATS,
    "tests/files/test_hostile_files.py",
    "tests/files/test_io.py",
)("broken files: a data file anywhere", 'or ".." in path.parts', "")
_in("vtk_mls/files/mesh_frames.py", "tests/files/test_mesh_frames.py")(
    "mesh files: normals stay in RAS",
    "attributes.GetVectors(), attributes.GetNormals(),",
    "attributes.GetVectors(),",
)
_in("vtk_mls/files/meta_image.py", FORMATS)(
    "MetaImage: the matrix is written transposed",
    "(volume.steps / spacing).T.ravel()",
    "(volume.steps / spacing).ravel()",
)

# Plugin and ParaView

add = _in("vtk_mls/paraview/undo.py", GUI)
add(
    "ParaView: undo does it again",
    "before if stack.GetInUndo() else after",
    "after if stack.GetInUndo() else before",
)
add = _in("vtk_mls/paraview/handle_panel.py", SCRIPTS, "tests/project/test_architecture.py")
add(
    "ParaView: the lattice of handles is not over the input",
    '("min", "mid", "max")[step]',
    '("min", "mid", "mid")[step]',
)
add = _in("vtk_mls/paraview/property_xml.py", SCRIPTS)
add("ParaView: lists never get shorter", 'set_number_command=f"SetNumberOf{each.name}",', "")

# The page, and PyVista

_in("vtk_mls/web/preparation.py", "tests/web/test_preparation.py")(
    "page: kernels of other kinds are built first",
    "for each in (kind, *others):",
    "for each in (*others, kind):",
)
_in("vtk_mls/pyvista/readers.py", "tests/pyvista/test_pyvista_datasets.py")(
    "PyVista: all tables are read as control points",
    'ENDINGS = (".fcsv",)',
    'ENDINGS = (".fcsv", ".csv")',
)

# Command line

add = _in("vtk_mls/commands/map_options.py", "tests/commands/test_points.py", CLI)
add("command line: the exponent of damping", '        "nu": options.nu,\n', "")
add("command line: too few numbers for a cut", "if len(values) != 3 * count:", "if not values:")
add("command line: far control points are not told", "(high - low).max() / 2", "np.inf")
add = _in("vtk_mls/commands/supervision.py", "tests/commands/test_supervision.py")
add("command line: a crash after the work counts", "    if status >= 0 and", "    if")

# Faces of cuts

add = _in("vtk_mls/void_cells.py", "tests/core/test_void_cells.py")
add("void cells: a single layer is known", "if np.any(dimensions == 2):", "if False:")
add(
    "void cells: corners that lie alike are far",
    "beside(high - low), least)",
    "beside(high - low), 0)",
)
add("void cells: those that are not known stay as they are", "unknown] |= ", "unknown] &= ")
add("void cells: of slabs behind the first", "grid.cells, first + unknown", "grid.cells, unknown")
_LISTED = "tests/engine/test_listed_points.py"
add = _in("opencl/grid.cl", _LISTED)
add("listed points: all of a work item", "numbers[min(at + l, count - 1)]", "numbers[at]")
add(
    "listed points: of a part", "row / grid->ny);\n  }\n  return", "row / grid->nx);\n  }\n  return"
)
_in("vtk_mls/engine/launcher.py", _LISTED)(
    "listed points: guesses are of other layers",
    "slice(numbers[0], numbers[-1] + 1)",
    "slice(0, len(numbers))",
)

# Memory of results

add = _in("vtk_mls/recycled.py", "tests/core/test_recycled.py")
add("memory: views do not hold it", "np.asarray(_Owner(memory))", "(_Owner(memory), memory)[1]")
add(
    "memory: it is kept without end",
    "while sum(memory.array.nbytes for memory in _kept) > _MOST:",
    "if 0:",
)
add("memory: what nobody wants stays", "each.patience > 0]", "each.array.nbytes > 0]")
add = _in("vtk_mls/linear_algebra.py", "tests/core/test_blas_threads.py")
add(
    "BLAS: its threads wait for products with many points",
    'np.einsum("ij,...j->...i", matrix, vectors)',
    "vectors @ matrix.T",
)
_in("vtk_mls/filters/property_tables.py", "tests/editor/test_saving.py", SCRIPTS)(
    "map tolerance: the editor and ParaView begin exactly",
    "replace(MAP_TOLERANCE, default=UNSEEN)",
    "MAP_TOLERANCE",
)
add = _in("vtk_mls/rendering/map_layers.py", "tests/rendering/test_map_layers.py")
add("live: cuts that cross share their sides", "_MOST_GROUPS = 3", "_MOST_GROUPS = 1")
add(
    "live: layers of other sides are not filled",
    "for layer in range(1, len(values)):",
    "for layer in ():",
)
add("live: corners between cuts are missed", "_ROUNDS = 8", "_ROUNDS = 0")
add = _in("vtk_mls/files/point_tables.py", "tests/files/test_control_point_files.py")
add("tables: decimal commas", 'cell.replace(",", ".")', "cell")

# Clusters

add = _in("vtk_mls/clusters.py", "tests/core/test_clusters.py")
add(
    "clusters: stand-ins do not move as their control points",
    "dq, dp = (axes * spread[:, None, :]) @ corners, motion @ corners",
    "dq, dp = (axes * spread[:, None, :]) @ corners, 0 * motion @ corners",
)
add(
    "clusters: those of any size count, however near",
    "is_far = level.radius2[cube] < size2[box] * distance2",
    "is_far = level.radius2[cube] < 9 * distance2",
)
add(
    "clusters: what is open ends at its first cube",
    "cube, owner = _ranges(level.child[cube], level.child[cube + 1])",
    "cube, owner = _ranges(level.child[cube], level.child[cube] + 1)",
)
add = _in("vtk_mls/engine/clustered_map.py", "tests/core/test_clusters.py")
add(
    "clusters: blocks that are off keep their lists",
    "is_close = errors <= 1\n",
    "is_close = errors <= 1e9\n",
)
add(
    "clusters: they count at folds and jumps, too",
    "np.flatnonzero(self._steepness(grid, exact) <= _STEEPEST)",
    "np.flatnonzero(self._steepness(grid, exact) <= 1e9)",
)
add(
    "clusters: blocks have the lists of the first that are found at a time",
    "spans.append(own + np.array([length, 0], np.int32))",
    "spans.append(own)",
)
add(
    "clusters: layers have the lists of those before",
    "if self._last is None or self._last[:2] != (grid, layers):",
    "if self._last is None:",
)
