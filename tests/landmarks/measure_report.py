"""How many planted faults are found, and the error beside the thin-plate spline, for `report`.

python tests/landmarks/measure_report.py [SETS]: prints both tables; 100 sets take some minutes.
"""

import sys
import time
import warnings

import numpy as np
from landmark_pairs import NOISE, planted_pairs, smooth_warp
from scipy.interpolate import RBFInterpolator

from vtk_mls import Deformation
from vtk_mls.base.progress import SILENT
from vtk_mls.landmarks import left_out, pair_report
from vtk_mls.landmarks.left_out import PointPairs
from vtk_mls.landmarks.volume import Shape


def agreed(p, q):
    """The pairs, settings, outliers and predictions, without the rest of the report."""
    pairs = PointPairs(p, q, np.ones(len(p)))
    return pairs, *pair_report._agreed(pairs, Shape.of(pairs), SILENT)


def found_faults(seeds):
    """Numbers of sets with all bad pairs and with the swap found; share of good pairs accused."""
    complete = swaps = accused = good = 0
    for seed in seeds:
        p, q, off, swap = planted_pairs(np.random.default_rng(seed))
        pairs, _, is_outlier, predicted = agreed(p, q)
        partner = left_out.find_swapped(pairs, is_outlier, predicted)
        bad = np.concatenate([off, swap])
        complete += is_outlier[bad].all()
        swaps += bool(partner[swap[0]] == swap[1]) and bool((partner[off] < 0).all())
        accused += is_outlier.sum() - is_outlier[bad].sum()
        good += len(p) - len(bad)
    return complete, swaps, accused / good


def ratios(seed, count, noise):
    """Median error at 300 held-out places, by that of scipy's splines r^2 log r and r."""
    rng = np.random.default_rng(seed)
    warp = smooth_warp(rng)
    q = rng.uniform(-80, 80, (count, 3))
    p = warp(q) + rng.normal(0, noise, q.shape)
    held_out = rng.uniform(-75, 75, (300, 3))

    def error(places):
        return np.median(np.linalg.norm(places - warp(held_out), axis=1))

    best = next(iter(agreed(p, q)[1]))
    own = error(Deformation(p, q, device="reference", **best.options).backward(held_out))
    kernels = "thin_plate_spline", "linear"
    return [own / error(RBFInterpolator(q, p, kernel=k, degree=1)(held_out)) for k in kernels]


def main():
    warnings.simplefilter("ignore")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    complete, swaps, accused = found_faults(range(count))
    print(
        f"all faults found in {complete} of {count} sets, the swap in {swaps}; "
        f"{accused:.2%} of good pairs accused"
    )
    for pairs, seeds in ((20, 20), (200, 10), (2000, 3)):
        for noise in (0.0, NOISE):
            start = time.perf_counter()
            values = np.array([ratios(seed, pairs, noise) for seed in range(seeds)])
            for name, column in zip(("r^2 log r", "r"), values.T):
                print(
                    f"{pairs:5} pairs, noise {noise}: error / that of the spline {name}: median "
                    f"{np.median(column):.2f}, largest {column.max():.2f}, "
                    f"{np.mean(column <= 1.3):.0%} up to 1.3"
                )
            print(f"      {(time.perf_counter() - start) / seeds:.1f} s each")


if __name__ == "__main__":
    main()
