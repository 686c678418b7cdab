"""Libraries that map landmarks, measured on the same sets: prints the tables of docs/comparison.md.

    python tests/benchmarks/libraries.py

60 landmarks lie in a box of 160 of a smooth warp (`tests/landmarks/landmark_pairs.py`). The map of
each library leads from their target positions to the moving ones, as images are resampled. Columns:

- median error at 300 held-out places, without noise and with noise of 0.5 at the landmarks;
- largest error at the landmarks themselves, without noise;
- share of folded places (a determinant not above 0) where 15 landmarks are moved wildly;
- error of the inverse: the distance after there and back again;
- milliseconds to set up the map of 60 landmarks and evaluate it at 32^3 places.

Medians over 5 sets. The second table has median errors, and those of 9 of 10 places, for other
numbers of landmarks, and for a fifth of published pairs: those of the package flybrains, at most
1,300 of each file. The third counts scenes of tests/fuzz/folds.py that fold. Libraries that are not
installed are left out: pip install antspyx flybrains itk-filtering itk-registration libigl molesq
scipy SimpleITK; on Debian apt-get install plastimatch.
"""

from __future__ import annotations

import csv
import importlib
import importlib.metadata
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import peers

sys.path.insert(0, str(Path(__file__).parents[1] / "landmarks"))
sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))

import folds
from landmark_pairs import NOISE, smooth_warp

import vtk_mls

HALF, LANDMARKS, HELD_OUT, SETS = 80.0, 60, 300, 5
MOST_PUBLISHED = 1300
KEPT = "FAFB14_maleCNS", "maleCNS_BANC"  # for checks
COMPARED = (
    'vtk_mls, `kind="auto"`',
    "scipy, `RBFInterpolator`, linear",
    "scipy, thin_plate_spline",
    "scipy, cubic",
    "Gaussian process, Matern 5/2",
    "Gaussian process, squared exponential",
    "ANTsPy, paired points, `bspline`",
)
WILD = 15, 40.0  # landmarks, and the standard deviation of their moves
SIDE = 32
FOLDING_GRID = vtk_mls.Grid([48] * 3, [-HALF] * 3, [2 * HALF / 47] * 3)


def automatic(q, p):
    """Ours for landmarks."""
    d = vtk_mls.Deformation(p, q, "auto")
    return d.backward, d.forward


def rigid(q, p, grid=None, **options):
    """Ours; automatic steps are checked at the voxels of a grid, then with the map in float64."""
    d = vtk_mls.Deformation(p, q, **options)
    if grid:
        d.displacement_field(grid)
        used = replace(d, steps=d.steps_used, path=d.path_used, device="reference")
        return d.backward, used.backward
    return d.backward, d.forward


def vtk(q, p):
    spline = peers.spline(p, q)
    return tuple(
        lambda x, of=of: np.array([of.TransformPoint(point) for point in x])
        for of in (spline, spline.GetInverse())
    )


def itk_kernel(name, stiffness=0.0):
    """A kernel transform of ITK; a stiffness above 0 approximates."""

    def fit(q, p):
        import itk

        transform = getattr(itk, name)[itk.D, 3].New()
        transform.SetStiffness(stiffness)
        peers.set_landmarks(transform, q, p)
        return lambda x: np.array([list(transform.TransformPoint(y)) for y in x.tolist()]), None

    return fit


def simpleitk(q, p):
    import SimpleITK as sitk

    image = sitk.Image([SIDE] * 3, sitk.sitkUInt8)
    image.SetOrigin([-1.1 * HALF] * 3)
    image.SetSpacing([2.2 * HALF / (SIDE - 1)] * 3)
    transform = sitk.LandmarkBasedTransformInitializer(
        sitk.BSplineTransform(3, 3), q.ravel().tolist(), p.ravel().tolist(), [], image, 8
    )
    return lambda x: np.array([transform.TransformPoint(y) for y in x.tolist()]), None


def ants(q, p, side=SIDE, **options):
    import ants

    middle, size = (q.min(axis=0) + q.max(axis=0)) / 2, np.ptp(q, axis=0).max() / (2 * HALF)
    p, q = (p - middle) / size, (q - middle) / size
    domain = ants.make_image([side] * 3, origin=[-1.1 * HALF] * 3)
    domain.set_spacing([2.2 * HALF / (side - 1)] * 3)
    options = {"transform_type": "bspline", "enforce_stationary_boundary": False, **options}
    # its transforms lead from fixed to moving points
    transform = ants.fit_transform_to_paired_points(
        p, q, domain_image=domain, number_of_fitting_levels=6, **options
    )

    def there(x):
        places = [transform.apply_to_point(y) for y in ((x - middle) / size).tolist()]
        return middle + size * np.array(places)

    return there, None


def scipy(kernel):
    def fit(q, p):
        from scipy.interpolate import RBFInterpolator

        return RBFInterpolator(q, p, kernel=kernel, degree=1), None

    return fit


def gaussian_process(q, p, smoothness=2.5):
    """Kriging with an affine mean: length and noise of a Matern kernel by restricted likelihood.

    `smoothness` is infinite for the squared exponential kernel.
    """
    from scipy.linalg import cho_factor, cho_solve
    from scipy.optimize import minimize
    from scipy.spatial.distance import cdist

    center = q.mean(axis=0)
    scale = np.abs(q - center).max()

    def local(x):
        return (x - center) / scale

    def kernel(distance, length):
        r = distance / length
        if np.isinf(smoothness):
            return np.exp(-(r**2) / 2)
        r = 5**0.5 * r
        return (1 + r + r * r / 3) * np.exp(-r)

    def affine(x):
        return np.column_stack([np.ones(len(x)), local(x)])

    basis = np.linalg.qr(affine(q))[0]
    apart, u = cdist(local(q), local(q)), (p - q) / scale

    def residual(values):
        """`values` (n, k) less their affine part."""
        return values - basis @ (basis.T @ values)

    data = residual(u)
    freedom = data.size - basis.shape[1] * 3

    def system(logarithms):
        """The factors of the covariance of the residuals; affine functions have 1 instead of 0."""
        length, noise = np.exp(logarithms)
        matrix = residual(residual(kernel(apart, length)).T) + basis @ basis.T
        return cho_factor(matrix + (noise + 1e-12) * np.eye(len(matrix)))

    def cost(logarithms):
        try:
            factor = system(logarithms)
        except np.linalg.LinAlgError:
            return 1e10
        squares = (data * cho_solve(factor, data)).sum()
        return freedom * np.log(squares / freedom) + 6 * np.log(np.diag(factor[0])).sum()

    starts = [np.log([0.5, 1e-3]), np.log([1.0, 1e-6])]
    options = {"maxiter": 60}
    found = [minimize(cost, start, method="Nelder-Mead", options=options) for start in starts]
    best = min(found, key=lambda result: result.fun).x
    length, noise = np.exp(best)
    c = residual(cho_solve(system(best), data))
    a = np.linalg.lstsq(affine(q), u - kernel(apart, length) @ c - noise * c, rcond=None)[0]

    def there(x):
        return x + scale * (affine(x) @ a + kernel(cdist(local(x), local(q)), length) @ c)

    return there, None


def molesq(q, p):
    from molesq import Transformer

    return Transformer(q, p).transform, None


def plastimatch(q, p):
    """A thin-plate spline, read as a displacement field."""
    import SimpleITK as sitk

    with tempfile.TemporaryDirectory() as folder:
        files = {name: f"{folder}/{name}" for name in ("fixed", "moving", "field.mha", "image.mha")}
        for name, points in (("fixed", q), ("moving", p)):
            ras = points * [-1, -1, 1]
            lines = [f"p{i},{x:.9g},{y:.9g},{z:.9g},1,1" for i, (x, y, z) in enumerate(ras)]
            files[name] += ".fcsv"
            Path(files[name]).write_text("\n".join(lines) + "\n")
        image = sitk.Image([SIDE] * 3, sitk.sitkFloat32)
        image.SetOrigin([-1.1 * HALF] * 3)
        image.SetSpacing([2.2 * HALF / (SIDE - 1)] * 3)
        sitk.WriteImage(image, files["image.mha"])
        command = ["plastimatch", "lm-warp", "-a", "tps", "-f", files["fixed"]]
        command += ["-m", files["moving"], "-F", files["image.mha"], "-I", files["image.mha"]]
        subprocess.run([*command, "-V", files["field.mha"]], check=True, capture_output=True)
        field = sitk.ReadImage(files["field.mha"], sitk.sitkVectorFloat64)
    transform = sitk.DisplacementFieldTransform(field)
    return lambda x: np.array([transform.TransformPoint(y) for y in x.tolist()]), None


def arap(q, p):
    """As rigid as possible, of a tetrahedral lattice; between vertices linear."""
    import igl
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import Delaunay

    axis = np.linspace(-1.1 * HALF, 1.1 * HALF, 9)
    lattice = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    lattice = lattice + np.random.default_rng(0).normal(0, 1e-3, lattice.shape)
    vertices = np.concatenate([q, lattice])
    mesh = Delaunay(vertices)
    handles = np.arange(len(q))
    data = igl.ARAPData()
    data.max_iter = 50
    igl.arap_precomputation(vertices, mesh.simplices, 3, handles, data)
    moved = igl.arap_solve(p, data, vertices.copy())
    return LinearNDInterpolator(mesh, moved), None


LIBRARIES = {
    'vtk_mls, `kind="auto"`': ("vtk_mls", automatic),
    "vtk_mls, rigid (default)": ("vtk_mls", rigid),
    'vtk_mls, rigid, `steps="auto"`': ("vtk_mls", partial(rigid, steps="auto")),
    "VTK, `vtkThinPlateSplineTransform` (r)": ("vtk", vtk),
    "ITK, `ThinPlateSplineKernelTransform`": ("itk", itk_kernel("ThinPlateSplineKernelTransform")),
    "ITK, the same with stiffness 0.5": ("itk", itk_kernel("ThinPlateSplineKernelTransform", 0.5)),
    "ITK, `ElasticBodySplineKernelTransform`": (
        "itk",
        itk_kernel("ElasticBodySplineKernelTransform"),
    ),
    "SimpleITK, B-spline of landmarks": ("SimpleITK", simpleitk),
    "ANTsPy, paired points, `bspline`": ("ants", ants),
    "scipy, `RBFInterpolator`, linear": ("scipy", scipy("linear")),
    "scipy, thin_plate_spline": ("scipy", scipy("thin_plate_spline")),
    "scipy, cubic": ("scipy", scipy("cubic")),
    "Gaussian process, Matern 5/2": ("scipy", gaussian_process),
    "Gaussian process, squared exponential": (
        "scipy",
        partial(gaussian_process, smoothness=np.inf),
    ),
    "molesq, `Transformer` (affine)": ("molesq", molesq),
    "plastimatch, `lm-warp` (tps)": ("plastimatch", plastimatch),
    "libigl, ARAP of a tetrahedral mesh": ("igl", arap),
}


def version(package):
    """The version of an installed package or program; None of another."""
    if package == "plastimatch":
        if not shutil.which(package):
            return None
        said = subprocess.run([package, "--version"], capture_output=True, text=True, check=False)
        return (said.stdout + said.stderr).split()[-1]
    try:
        module = importlib.import_module(package)
    except ImportError:
        return None
    names = {"ants": "antspyx", "igl": "libigl", "vtk": "vtk"}
    return getattr(module, "__version__", None) or importlib.metadata.version(
        names.get(package, package)
    )


def median_error(fit, noise):
    """Median errors at held-out places and largest errors at landmarks, medians over the sets."""
    errors, misses = [], []
    for seed in range(SETS):
        rng = np.random.default_rng(seed)
        warp = smooth_warp(rng)
        q = rng.uniform(-HALF, HALF, (LANDMARKS, 3))
        p = warp(q) + rng.normal(0, noise, q.shape)
        held_out = rng.uniform(-0.9 * HALF, 0.9 * HALF, (HELD_OUT, 3))
        there, _ = fit(q, p)
        errors.append(np.median(np.linalg.norm(there(held_out) - warp(held_out), axis=1)))
        misses.append(np.linalg.norm(there(q) - p, axis=1).max())
    return np.median(errors), np.median(misses)


def folded_and_inverse(fit):
    """Share of folded places of a wild set; largest error of the inverse of a smooth one."""
    rng = np.random.default_rng(0)
    count, deviation = WILD
    q = rng.uniform(-HALF, HALF, (count, 3))
    there, _ = fit(q, q + rng.normal(0, deviation, q.shape))
    places = rng.uniform(-HALF, HALF, (2000, 3))
    step = 0.05 * np.eye(3)
    slopes = np.stack([(there(places + e) - there(places - e)) / 0.1 for e in step], axis=-1)
    folded = np.mean(np.linalg.det(slopes) <= 0)
    warp = smooth_warp(rng)
    q = rng.uniform(-HALF, HALF, (LANDMARKS, 3))
    there, back = fit(q, warp(q))
    error = None
    if back:
        error = np.linalg.norm(back(there(places)) - places, axis=1).max()
    return folded, error


def milliseconds(fit):
    rng = np.random.default_rng(0)
    q = rng.uniform(-HALF, HALF, (LANDMARKS, 3))
    p = smooth_warp(rng)(q)
    places = vtk_mls.Grid([SIDE] * 3, [-HALF] * 3, [2 * HALF / (SIDE - 1)] * 3).points()
    fit(q, p)[0](places[:100])  # builds kernels and imports
    start = time.perf_counter()
    fit(q, p)[0](places)
    return 1000 * (time.perf_counter() - start)


def held_out_sets():
    """Names, then q and p of landmarks and of held-out places."""
    for count in (20, 200, 2000):
        for noise in (0, NOISE):
            for seed in range(SETS if count < 2000 else 1):
                rng = np.random.default_rng(seed)
                warp = smooth_warp(rng)
                q = rng.uniform(-HALF, HALF, (count, 3))
                p = warp(q) + rng.normal(0, noise, q.shape)
                places = rng.uniform(-0.9 * HALF, 0.9 * HALF, (HELD_OUT, 3))
                yield f"{count:,} pairs, noise {noise:g}", q, p, places, warp(places)
    for path in sorted(published_pairs()):
        pairs = np.array([row for row in csv_numbers(path) if len(row) == 6])
        q, p = pairs[:, 3:], pairs[:, :3]
        _, rows = np.unique(q, axis=0, return_index=True)
        rows = np.random.default_rng(1).permutation(rows)[:MOST_PUBLISHED]
        out, rest = np.split(rows, [len(rows) // 5])
        yield f"{path.stem}, {len(rest):,}", q[rest], p[rest], q[out], p[out]


def published_pairs():
    """Files of the package flybrains, if it is installed."""
    spec = importlib.util.find_spec("flybrains")
    folder = Path(spec.origin).parent / "data" if spec else Path("nowhere")
    return [path for path in folder.glob("*landmarks*.csv") if not path.name.startswith(KEPT)]


def csv_numbers(path):
    """The last six numbers of each row that has them."""
    for row in csv.reader(path.read_text().splitlines()):
        with suppress(ValueError):
            yield [float(cell) for cell in row[-6:]]


def print_held_out():
    names = [name for name in COMPARED if version(LIBRARIES[name][0])]
    print("| | " + " | ".join(names) + " |")
    print("|---" * (len(names) + 1) + "|")
    sets = {}
    for title, *data in held_out_sets():
        sets.setdefault(title, []).append(data)
    for title, data in sets.items():
        cells = []
        for name in names:
            errors = []
            for q, p, places, images in data:
                there, _ = LIBRARIES[name][1](q, p)
                errors.append(np.linalg.norm(there(places) - images, axis=1))
            middle, high = np.median([np.quantile(e, (0.5, 0.9)) for e in errors], axis=0)
            cells.append(f"{middle:.3g}, {high:.3g}")
        print(f"| {title} | " + " | ".join(cells) + " |", flush=True)


def print_folds():
    """Of 10 hard scenes, in how many the map folds at a voxel's center, and the linear field."""
    ours = partial(rigid, grid=FOLDING_GRID, steps="auto")
    programs = {
        'vtk_mls, rigid, `steps="auto"`': ("vtk_mls", ours),
        'vtk_mls, spline, `steps="auto"`': ("vtk_mls", partial(ours, kind="spline")),
        "vtk_mls, rigid, one step": ("vtk_mls", partial(ours, steps=1)),
        "spline of BigWarp (scipy, thin_plate_spline)": ("scipy", scipy("thin_plate_spline")),
        "ANTsPy, `diffeo`": ("ants", partial(ants, side=48, transform_type="diffeo")),
    }
    points, centers = FOLDING_GRID.points(), FOLDING_GRID.cells.points()
    print("| | map folds | field folds | largest miss |\n|---|---|---|---|")
    for name, (package, fit) in programs.items():
        rng, counts, misses = np.random.default_rng(0), np.zeros(2, int), []
        for _ in range(10 if version(package) else 0):
            scene = folds.scene(rng, "rigid")
            q, p = (HALF * (2 * x - 1) for x in (scene.deformed, scene.rest))
            there, exactly = fit(q, p)
            moved = (there(points) - points).reshape(*FOLDING_GRID.shape, 3)
            field = vtk_mls.DisplacementField(moved, FOLDING_GRID)
            worst = centers[folds.difference_determinants(there, centers, 0.5).argsort()[:200]]
            least = folds.difference_determinants(exactly or there, worst, 1e-3).min()
            counts += least <= 0, folds.negative_tetrahedra(field).any()
            misses.append(np.linalg.norm(there(q) - p, axis=1).max())
        if misses:
            print(f"| {name} | {counts[0]} | {counts[1]} | {max(misses):.1e} |", flush=True)


def main():
    for table in (print_libraries, print_held_out, print_folds):
        table()
        print()


def print_libraries():
    print("| | version | held out | with noise | at landmarks | folded | inverse | ms |")
    print("|---|---|---|---|---|---|---|---|")
    for name, (package, fit) in LIBRARIES.items():
        if version(package) is None:
            continue
        exact, miss = median_error(fit, 0)
        noisy, _ = median_error(fit, NOISE)
        folded, inverse = folded_and_inverse(fit)
        print(
            f"| {name} | {version(package)} | {exact:.3f} | {noisy:.2f} | {miss:.1e} "
            f"| {100 * folded:.1f} % | {'none' if inverse is None else f'{inverse:.0e}'} "
            f"| {milliseconds(fit):.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
