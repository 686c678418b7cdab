"""Broken files of every format, one after the other, through `vtk-mls`.

    PYTHONPATH=tests python tests/files/hostile_files.py SEED COUNT [FORMAT...]

Each must end in a deformed or moved file, or in one sentence with the file's name. Others are
printed and copied to hostile-files/.
"""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter
from contextlib import redirect_stderr
from functools import partial
from io import StringIO
from pathlib import Path

import numpy as np
from file_fixtures import MESHES, NRRD, NRRD_DATA
from mesh_fixtures import rectilinear
from pipelines import control_points, update
from test_mesh_files import collection, many_blocks, write_tetrahedra
from test_point_files import ANTS, BIGWARP, ELASTIX, IDAV, MINC, SLICER, TRANSFORMIX
from vtk_fixtures import DEFORMED, REST, add_array, make_image
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import io
from vtk_mls.commands import series, supervision
from vtk_mls.files import control_point_files, formats, vtk_io
from vtk_mls.files.block_files import blocks
from vtk_mls.vtk.objects import configured, output_of

FAILED = Path("hostile-files")
MEMORY, SECONDS = 3 << 30, 60
WORDS = b"0 -1 1e400 nan 99999999999 4294967295 300 None < \xff\xfe".split()
XML = {"vti": "ImageData", "vtp": "PolyData", "vtu": "UnstructuredGrid"}
XML |= {"vts": "StructuredGrid", "vtr": "RectilinearGrid"}


def _datasets():
    image = make_image((5, 4, 3))
    add_array(image.GetPointData(), "values", np.arange(60.0))
    add_array(image.GetCellData(), "cells", np.arange(24.0))
    image.GetPointData().SetActiveScalars("values")
    sphere = output_of(vtkSphereSource(), ThetaResolution=5, PhiResolution=5)
    grids = {"vtu": MESHES[".vtu"](), "vts": MESHES[".vts"](), "vtr": rectilinear()}
    return {"vti": image, "vtp": sphere, **grids}


def _write(writer, dataset, name, **settings):
    writer = vtk_io.create(f"vtkIO{writer}Writer")
    configured(writer, InputData=dataset, FileName=name, **settings).Write()


def _make_files():
    """Good files: (role for the command, file names with the main one first) of each."""
    datasets, jobs = _datasets(), []
    for suffix in ("mha", "mhd", "nii", "nii.gz", "nrrd", "nhdr"):
        io.write_dataset(datasets["vti"], f"a.{suffix}")
        beside = {"mhd": ["a.raw"], "nhdr": ["a.raw.gz"]}.get(suffix, [])
        jobs.append(("vti", [f"a.{suffix}", *beside]))
    for kind, dataset in datasets.items():
        output = "vts" if kind == "vtr" else kind
        for mode in range(3):  # text, base64, appended
            name = f"{kind}{mode}.{kind}"
            _write(f"XML.vtkXML{XML[kind]}", dataset, name, DataMode=mode, EncodeAppendedData=False)
            jobs.append((output, [name]))
        for version in (42, 51):
            for file_type in (1, 2):
                name = f"{kind}{version}{file_type}.vtk"
                _write("Legacy.vtkDataSet", dataset, name, FileType=file_type, FileVersion=version)
                jobs.append((output, [name]))
    for suffix, kind in (("stl", "Geometry.vtkSTL"), ("ply", "PLY.vtkPLY")):
        for file_type in (1, 2):
            _write(kind, datasets["vtp"], f"{file_type}.{suffix}", FileType=file_type)
            jobs.append(("vtp", [f"{file_type}.{suffix}"]))
    _write("Geometry.vtkOBJ", datasets["vtp"], "a.obj")
    jobs.append(("vtp", ["a.obj"]))
    for encoding in ("raw", "ascii"):
        header = NRRD.replace("encoding: raw", f"encoding: {encoding}")
        data = NRRD_DATA if encoding == "raw" else b"1 2\n3 400\n"
        Path(f"{encoding}.nrrd").write_bytes(header.encode() + b"\n" + data)
        Path(f"{encoding}.nhdr").write_text(f"{header}data file: {encoding}.raw\n")
        Path(f"{encoding}.raw").write_bytes(data)
        jobs.append(("vti", [f"{encoding}.nrrd"]))
        jobs.append(("vti", [f"{encoding}.nhdr", f"{encoding}.raw"]))
    for suffix in formats.endings(reads=(formats.POINTS,)):
        control_point_files.write(f"handles{suffix}", REST, DEFORMED)
        jobs.append(("handles", [f"handles{suffix}"]))
    tables = {"bigwarp.csv": BIGWARP, "slicer.csv": SLICER, "ants.csv": ANTS}
    for name, text in {**tables, "elastix.txt": ELASTIX, "transformix.txt": TRANSFORMIX}.items():
        Path(name).write_text(text)
        jobs += [(role, [name]) for role in ("handles", "landmarks")]
    Path("idav.pts").write_text(IDAV)
    Path("minc.tag").write_text(MINC)
    jobs += [("landmarks", [name]) for name in ("idav.pts", "minc.tag")]
    for suffix in (".fcsv", ".mrk.json", ".pts"):
        jobs += [(role, [f"handles{suffix}"]) for role in ("landmarks", "deformed")]
    control_point_files.write("rest.fcsv", REST, REST)
    handles = control_points(weights=[1.0] * len(REST))
    _write("XML.vtkXMLPolyData", update(handles), "handles.vtp", DataMode=0)
    shutil.copy("1.stl", "cut.stl")
    jobs += [("handles", ["handles.vtp"]), ("cut", ["cut.stl"]), ("cut", ["vtp0.vtp"])]
    jobs += _make_blocks() + _make_simulations()
    control_point_files.write("good.csv", REST, DEFORMED)
    io.write_dataset(datasets["vti"], "good.vti")
    return jobs


def _make_blocks():
    """As `_make_files`: files that name others."""
    jobs = []
    pieces = {
        "vtm": io.write_dataset,
        "vtpc": io.write_dataset,
        "pvtu": partial(_write, "ParallelXML.vtkXMLPUnstructuredGrid"),
        "pvti": partial(_write, "ParallelXML.vtkXMLPImageData"),
    }
    together = many_blocks()
    data = {"vtm": together, "vtpc": collection(*blocks(together))}
    data["pvtu"], data["pvti"] = blocks(together)[:2]
    for suffix, write in pieces.items():
        name = f"blocks_{suffix}.{suffix}"
        write(data[suffix], name)
        files = [str(path) for path in Path().rglob(f"blocks_{suffix}*") if path.is_file()]
        role = {"pvtu": "vtu", "pvti": "vti"}.get(suffix, suffix)
        jobs.append((role, [name, *sorted(set(files) - {name})]))
    with series.writing("series.pvd", (0, 1)) as write:
        write(data["pvtu"])
        write(data["pvti"])
    files = sorted(str(path) for path in Path("series").iterdir())
    jobs.append(("pvd", ["series.pvd", *files]))
    names = [{"name": name, "time": time} for time, name in enumerate(files)]
    Path("in.series").write_text(json.dumps({"files": names}))
    jobs.append(("pvd", ["in.series", *files]))
    return jobs


def _make_simulations():
    """As `_make_files`: formats of simulation programs."""
    suffixes = (".vtkhdf", ".cgns", ".e", ".xdmf", ".case", ".msh", ".inp", ".bdf", ".vol", ".su2")
    jobs = []
    for suffix in suffixes:
        name = write_tetrahedra(suffix)
        beside = sorted(map(str, Path().glob("in.0.0*"))) if suffix == ".case" else []
        jobs.append(("vtm" if suffix in (".cgns", ".e", ".case") else "vtu", [name, *beside]))
    return jobs


def _broken(content, rng):
    """A content that is cut off, or has wrong bits, bytes or words, or a part less or twice."""
    content, damage = bytearray(content), rng.integers(7)
    start, length = rng.integers(len(content)), rng.integers(1, 64)
    if damage == 0:
        return bytes(content[:start])
    if damage == 1:
        for place in rng.integers(len(content), size=rng.integers(1, 8)):
            content[place] ^= 1 << rng.integers(8)
    elif damage == 2:
        for place in rng.integers(len(content), size=rng.integers(1, 20)):
            content[place] = rng.integers(256)
    elif damage == 3:
        del content[start : start + length]
    elif damage == 4:
        content[start:start] = content[rng.integers(len(content)) :][:length]
    else:
        pattern = rb"[-+]?\d[-+.\w]*" if damage == 5 else rb"[-+.\w]+"
        words = list(re.finditer(pattern, bytes(content[:3000])))
        if words:
            word = words[rng.integers(len(words))]
            near = (
                str(int(word[0][:9]) + rng.integers(-3, 4)).encode() if word[0].isdigit() else b""
            )
            choices = [*WORDS, near]
            content[word.start() : word.end()] = choices[rng.integers(len(choices))]
    return bytes(content)


def _deform(arguments):
    """Exit status and stderr of the command, in a process with little memory and time."""
    with tempfile.TemporaryFile() as errors, tempfile.TemporaryDirectory() as folder:
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            os.dup2(errors.fileno(), 2)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            supervision.MIN_SECONDS = SECONDS / 4
            signal.alarm(SECONDS)
            try:
                supervision.work(folder, "vtk_mls.commands.cli:run", arguments)
            except SystemExit as ended:
                status = ended.code
            except BaseException:
                traceback.print_exc()
                status = 99
            sys.stderr.flush()
            os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        text = StringIO()
        with redirect_stderr(text):
            status = supervision.report(status, child, folder)
        errors.seek(0)
        return status, errors.read().decode(errors="replace") + text.getvalue()


def _is_fine(status, text, names):
    if status == 0:
        is_empty = re.fullmatch("vtk-mls: `out.*`: nothing of .* is in the output, for .*\n", text)
        return text == "" or is_empty is not None
    is_sentence = text.startswith("vtk-mls: ") and text.count("\n") == 1 and len(text) < 600
    return status == 1 and is_sentence and any(name in text for name in names)


def main(seed, count, *formats):
    """Number of broken files that did not end well."""
    home = Path.cwd()
    rng = np.random.default_rng(seed)
    results, failures = Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        jobs = _make_files()
        jobs = [job for job in jobs if not formats or job[1][0].endswith(formats)]
        good = {name: Path(name).read_bytes() for _, names in jobs for name in names}
        for number in range(count):
            role, names = jobs[rng.integers(len(jobs))]
            for name in names:
                Path(name).write_bytes(good[name])
            broken_name = names[rng.integers(len(names))]
            Path(broken_name).write_bytes(_broken(good[broken_name], rng))
            suffix = names[0].partition(".")[2]
            arguments = {
                "handles": ["deform", "good.vti", names[0], "out.vti"],
                "deformed": ["deform", "good.vti", "rest.fcsv", "out.vti", "--deformed", names[0]],
                "landmarks": ["points", names[0], "good.csv", f"out.{suffix}"],
                "cut": ["deform", "good.vti", "good.csv", "out.vti", "--cut-surface", names[0]],
            }.get(role, ["deform", names[0], "good.csv", f"out.{role}"])
            status, text = _deform([*arguments, "--device", "reference"])
            results["deformed" if status == 0 else "crash" if "crash" in text else "sentence"] += 1
            if not _is_fine(status, text, names):
                failures += 1
                print(f"{number}: {names[0]} ended with {status} and {text[-600:]!r}")
                (home / FAILED).mkdir(exist_ok=True)
                for name in names:
                    shutil.copy(name, home / FAILED / f"{seed}-{number}-{Path(name).name}")
        os.chdir(home)
    print(f"{count} broken files: {dict(results)}, {failures} ended badly")
    return failures


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3]), *sys.argv[3:]) > 0)
