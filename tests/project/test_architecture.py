"""The rooms of the package are layers: a module imports its own room and the rooms below."""

import ast
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Deformation, Grid
from vtk_mls.filters import MLSDeform

PACKAGE = Path(__file__).parents[2] / "vtk_mls"
KERNELS = PACKAGE.parent / "opencl"
CONDITIONAL = re.compile(r"^\s*#\s*(?:if|ifdef|ifndef|elif|else)\b", re.M)

# Rooms from the bottom up, with the packages from outside that each may import. A folder is a room;
# the modules beside the folders are rooms of their own.
ROOMS = {
    "base": {"numpy"},
    "model": {"numpy", "vtkmodules"},
    "cuts": set(),
    "queries": {"numpy"},
    "reference": {"numpy"},
    "engine": {"numpy", "pyopencl"},
    "deformation": {"numpy"},
    "transforms": {"numpy"},
    "landmarks": {"numpy"},
    "__init__": set(),
    "vtk": {"numpy", "vtkmodules"},
    "files": {"SimpleITK", "meshio", "nibabel", "numpy", "tifffile", "vtkmodules", "zarr"},
    "blocks": {"dask", "distributed", "numpy", "zarr"},
    "dask": set(),
    "napari": {"magicgui", "napari", "numpy"},
    "filters": {"numpy", "vtkmodules"},
    "io": {"numpy", "vtkmodules"},
    "rendering": {"numpy", "vtkmodules"},
    "editor": {"numpy", "vtkmodules"},
    "pyvista": {"numpy", "pyvista", "vtkmodules"},
    "web": {"aiohttp", "numpy", "trame", "trame_client", "vtkmodules"},
    "paraview": {"numpy", "paraview", "vtkmodules"},
    "commands": {"numpy", "vtkmodules"},
    "__main__": set(),
}
LAYERS = [*ROOMS]
MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
NAMES = {name.removesuffix(".__init__") for name in MODULES}


def imports(text):
    """Dotted names of all imports in a module, without those that only type checkers see."""
    todo = [ast.parse(text)]
    while todo:
        node = todo.pop()
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            todo += node.orelse
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        else:
            todo += ast.iter_child_nodes(node)


def imported(text):
    """Modules of the package ("__init__" for public names), and packages outside it."""
    inside, outside = set(), set()
    for name in imports(text):
        first, _, rest = name.partition(".")
        if first != "vtk_mls":
            outside.add(first)
            continue
        while rest and rest not in NAMES:
            rest = rest.rpartition(".")[0]
        inside.add(rest or "__init__")
    return inside, outside - set(sys.stdlib_module_names) - {"__future__"}


@pytest.mark.parametrize("name", MODULES)
def test_imports_only_from_below(name):
    inside, outside = imported(MODULES[name].read_text())
    room = name.partition(".")[0]
    allowed = LAYERS[: LAYERS.index(room) + 1]
    rooms = {module.partition(".")[0] for module in inside}
    assert rooms <= {*allowed}, f"{name} imports a room above its own"
    assert outside <= ROOMS[room], f"{name} imports a package that `{room}` must not need"


def test_launches_know_no_map():
    for name in MODULES:
        if name.startswith("engine.launch."):
            inside, _ = imported(MODULES[name].read_text())
            assert not [module for module in inside if module.startswith("engine.map")], name


def test_no_circles_within_a_room():
    todo = {name: imported(path.read_text())[0] - {name} for name, path in MODULES.items()}
    todo = {name.removesuffix(".__init__"): needs for name, needs in todo.items()}
    todo["__init__"] = set()  # imports a module when its name is first used
    while todo:
        done = {name for name, needs in todo.items() if not (needs & todo.keys()) - {name}}
        assert done, f"these modules import each other: {', '.join(sorted(todo))}"
        todo = {name: needs for name, needs in todo.items() if name not in done}


def test_the_house_stays_small():
    """The budget. A change that needs more says why in the changelog, and raises it."""
    assert len([*PACKAGE.glob("*.py")]) <= 6
    assert len(ROOMS) <= 24
    assert floors() <= 14
    assert lines(PACKAGE, KERNELS) <= 50_000
    assert lines(PACKAGE.parent / "tests", endings=(".py",)) <= 42_000
    conditionals = [
        conditional for file in texts(KERNELS) for conditional in CONDITIONAL.findall(file)
    ]
    assert len(conditionals) <= 140
    assert not CONDITIONAL.findall((KERNELS / "base" / "weights.cl").read_text())


def texts(*folders, endings=(".py", ".cl", ".h", ".md", ".css", ".js", ".svg")):
    """The contents of files that people write."""
    files = (file for folder in folders for file in folder.rglob("*.*"))
    return [file.read_text(encoding="utf-8") for file in files if file.suffix in endings]


def lines(*folders, **options):
    return sum(text.count("\n") for text in texts(*folders, **options))


def floors():
    """The number of rooms above one another, from the first that imports none."""
    below = {room: set() for room in ROOMS}
    for name, path in MODULES.items():
        room = name.partition(".")[0]
        below[room] |= {module.partition(".")[0] for module in imported(path.read_text())[0]}
    heights = {}
    for room in ROOMS:
        heights[room] = 1 + max((heights[other] for other in below[room] - {room}), default=0)
    return max(heights.values())


def files_passed(call):
    """The number of files above `base` whose functions run during a call."""
    files = set()

    def note(frame, event, argument):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(PACKAGE):
            files.add(path.relative_to(PACKAGE).as_posix())

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return len([file for file in files if not file.startswith("base/")])


def test_a_deformation_passes_few_files():
    """A change that needs more raises the number."""
    rest = np.array([(0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4)])
    grid, values = Grid((5, 5, 5)), np.zeros((5, 5, 5), "f4")
    for x in (1, 2):  # the first time, devices and kernels are prepared
        passed = files_passed(lambda x=x: Deformation(rest, rest + x).resample([values], grid))
    assert passed <= 20
    image, deform = vtkImageData(), MLSDeform()
    image.SetDimensions(5, 5, 5)
    image.AllocateScalars(VTK_FLOAT, 1)
    deform.SetInputData(image)
    deform.SetRestPoints(rest)
    for x in (1, 2):
        deform.SetDeformedPoints(rest + x)
        passed = files_passed(deform.Update)
    assert passed <= 40
