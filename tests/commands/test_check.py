"""`vtk-mls check` reports on the pairs of files."""

import json

import numpy as np
import pytest

from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files
from vtk_mls.files.landmarks import Landmarks
from vtk_mls.landmarks import report


@pytest.fixture
def pairs(files):
    """p and q of 24 pairs in files; the labels `place 3` and `place 8` are swapped."""
    rng = np.random.default_rng(4)
    q = rng.uniform(-50, 50, (24, 3))
    p = q + 3 * np.sin(q[:, [1, 2, 0]] / 40)
    q[[3, 8]] = q[[8, 3]]
    labels = [f"place {i}" for i in range(24)]
    for name, points in (("p", p), ("q", q)):
        control_point_files.write_landmarks(
            f"{name}.mrk.json", Landmarks("", points, "LPS", labels)
        )
    control_point_files.write("pairs.csv", p, q)
    return p, q, labels


def test_the_report_of_two_files(pairs, files, capsys):
    p, q, labels = pairs
    outputs = ["--json", "r.json", "--html", "r.html"]
    assert main(["check", "p.mrk.json", "--deformed", "q.mrk.json", *outputs]) == 0
    expected = report(p, q, labels, device="reference")
    content = json.loads((files / "r.json").read_text())
    assert [pair["name"] for pair in content["pairs"]] == labels
    np.testing.assert_allclose([x["error"] for x in content["pairs"]], expected.error, atol=1e-9)
    assert content["pairs"][3]["swapped_with"] == "place 8"
    assert content["pairs"][8]["swapped_with"] == "place 3"
    assert "place 8" in (files / "r.html").read_text()
    text = capsys.readouterr().out
    lines = text.splitlines()
    assert {line.split("  ")[0] for line in lines[1:3]} == {"place 3", "place 8"}
    assert "labels that look swapped: place 3 and place 8" in lines
    assert f"take: {expected.recommended.flags}" in lines
    assert "the map" in lines[-1]


def test_the_options_to_take_are_those_of_deform(pairs, capsys):
    assert main(["check", "pairs.csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    flags = next(line for line in lines if line.startswith("take: "))[6:].split()
    control_point_files.write_landmarks("in.csv", Landmarks("", pairs[1][:3], "LPS"))
    command = ["points", "in.csv", "pairs.csv", "out.csv", "--inverse"]
    assert main([*command, *flags]) == 0


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        (["0,0,0,1,0,0"] * 1, "`few.csv` must have at least 4 pairs"),
        (["0,0,0,1,0,0", "0,0,0,2,0,0", "1,2,3,4,5,6", "3,2,1,5,5,5"], "p of `few.csv` must be"),
    ],
)
def test_wrong_pairs_are_one_sentence(files, refused, lines, sentence):
    (files / "few.csv").write_text("px,py,pz,qx,qy,qz\n" + "\n".join(lines) + "\n")
    assert refused("check", "few.csv").startswith(sentence)


def test_positions_without_partners(pairs, refused):
    assert "and not where they go" in refused("check", "p.mrk.json")
