"""Random tables of control points, written by pandas, are read correctly."""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from vtk_mls.files import control_point_files

_NAMES = (
    [*"abcdef"],
    ["px", "py", "pz", "qx", "qy", "qz"],
    ["x_moving", "y_moving", "z_moving", "x_fixed", "y_fixed", "z_fixed"],
    ["x", "y", "z", "x1", "y1", "z1"],
    ["X", "Y", "Z", "new_X", "new_Y", "new_Z"],
)
_AMBIGUITIES = "can be a header that counts", "the first of 7 columns has whole"


def check_table(rng):
    """A table is read as it was written, or refused if it is ambiguous."""
    if not find_spec("pandas"):
        return
    text, rest, deformed, is_ambiguous, description = _table(rng)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / str(rng.choice(["x.csv", "x.txt"]))
        path.write_text(text, encoding="utf-8")
        error = ""
        try:
            found = control_point_files.read_pairs(path)
        except ValueError as caught:
            error = str(caught)
    if error:
        assert any(words in error for words in _AMBIGUITIES), f"{error}: {description}"
        assert is_ambiguous, f"{error}, though it is unambiguous: {description}"
        return
    assert found.rest.shape == rest.shape, f"{len(found.rest)} of {len(rest)} points: {description}"
    np.testing.assert_allclose(found.rest, rest, rtol=1e-5, atol=1e-5, err_msg=description)
    np.testing.assert_allclose(found.deformed, deformed, rtol=1e-5, atol=1e-5, err_msg=description)


def _table(rng):
    """The text of a table, its p and q, and whether its header or index can be points."""
    import pandas

    numbers = rng.uniform(-100, 100, (int(rng.integers(2, 7)), 6))
    if rng.random() < 0.4:
        numbers = np.round(numbers)
    if rng.random() < 0.3:
        numbers[:, :3] = np.round(numbers[:, :3])
    rest, deformed = numbers[:, :3], numbers[:, 3:]
    frame = pandas.DataFrame(numbers)
    is_counted = rng.random() < 0.5
    if not is_counted:
        frame.columns = _NAMES[rng.integers(len(_NAMES))]
    has_names = frame.columns[0] not in (0, "a")
    if has_names and rng.random() < 0.5:
        frame = frame.iloc[:, rng.permutation(6)]
    if rng.random() < 0.3:
        frame = frame.convert_dtypes()  # columns of whole numbers become integers
    has_labels = rng.random() < 0.3
    if has_labels:
        frame.index = [f"point {i}" for i in range(len(frame))]
    sep = str(rng.choice([",", ";", "\t"]))
    decimal = "," if sep != "," and rng.random() < 0.5 else "."
    form = {
        "sep": sep,
        "decimal": decimal,
        "index": bool(rng.random() < 0.5),
        "header": has_names or bool(rng.random() < 0.7),
        "lineterminator": str(rng.choice(["\n", "\r\n"])),
        "quoting": int(rng.integers(0, 3)),
    }
    text = frame.to_csv(**form)
    if rng.random() < 0.2:
        text = f"# made by a test{form['lineterminator'] * 2}{text}"
    if rng.random() < 0.2:
        text = f"\ufeff{text}"
    has_bare_header = is_counted and form["header"] and not form["index"]
    has_bare_index = form["index"] and not has_labels and not form["header"]
    return text, rest, deformed, has_bare_header or has_bare_index, f"{form}\n{text}"
