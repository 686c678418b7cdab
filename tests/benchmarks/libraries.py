"""What libraries answer, tried: `python tests/benchmarks/libraries.py`, for docs/comparison.md.

Each maps 15 points of a box of 128 to where they were moved to. You will see, in millionths, how
far off each then is there, and how far its inverse leads from where a point came, if it has one;
and how long 256 points take until the first answers. What is not installed is left out (pip install
itk molesq scipy SimpleITK).
"""

from __future__ import annotations

import importlib
import importlib.metadata
import time

import numpy as np
import peers

import vtk_mls

SIZE, FEW, MANY = 128, 15, 256


def ours(p, q):
    """The map from p to q, and its inverse."""
    value = vtk_mls.Deformation(q, p)  # of which `backward` leads from p to q
    return value.backward, value.forward


def vtk(p, q):
    spline = peers.spline(q, p)
    maps = spline, spline.GetInverse()
    return [lambda x, of=of: np.array([of.TransformPoint(point) for point in x]) for of in maps]


def itk(p, q):
    spline = peers.itk_spline(q, p)
    assert spline.GetInverseTransform() is None
    return lambda x: np.array([list(spline.TransformPoint(point)) for point in x.tolist()]), None


def scipy(p, q):
    from scipy.interpolate import RBFInterpolator

    return RBFInterpolator(p, q, kernel="linear"), None  # which has no other method


def molesq(p, q):
    from molesq import Transformer

    return Transformer(p, q).transform, None


PEERS = {
    "vtk_mls, rigid": ("vtk_mls", ours),
    "VTK, `vtkThinPlateSplineTransform`": ("vtk", vtk),
    "ITK, `ThinPlateSplineKernelTransform`": ("itk", itk),
    "scipy, `RBFInterpolator`": ("scipy", scipy),
    "molesq, `Transformer` (affine)": ("molesq", molesq),
}


def version(package):
    """Of an installed package; None of another."""
    try:
        return importlib.import_module(package).__version__
    except ImportError:
        return None
    except AttributeError:
        return importlib.metadata.version(package)


def main():
    random = np.random.default_rng(1)
    p = random.uniform(0, SIZE, (MANY, 3))
    q = p + random.normal(0, SIZE / 40, p.shape)
    places = random.uniform(SIZE / 4, 3 * SIZE / 4, (20, 3))
    print("| | version | miss | miss of its inverse | ms until 256 points answer |")
    print("|---|---|---|---|---|")
    for name, (package, peer) in PEERS.items():
        if version(package) is None:
            continue
        there, back = peer(p[:FEW], q[:FEW])
        miss = 1e6 * np.abs(there(p[:FEW]) - q[:FEW]).max()
        lost = f"{1e6 * np.abs(back(there(places)) - places).max():.1f}" if back else "has none"
        start = time.perf_counter()
        peer(p, q)[0](places)
        took = 1000 * (time.perf_counter() - start)
        print(f"| {name} | {version(package)} | {miss:.1f} | {lost} | {took:.0f} |", flush=True)
    if version("SimpleITK"):
        import SimpleITK

        known = [name for name in dir(SimpleITK) if "Kernel" in name or "ThinPlate" in name]
        print(f"\nSimpleITK {version('SimpleITK')} has {known or 'no spline of landmarks'}.")


if __name__ == "__main__":
    main()
