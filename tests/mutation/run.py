"""Does a level of the tests find what is wrong? Faults go in, one at a time; a test must fail.

    python tests/mutation/run.py --level check
    python tests/mutation/run.py --level test --only cuts

Works in a git worktree of its own, of the last commit, and leaves this one alone. First comes the
test that found the fault the last time, then files that are likely to, then all of the level. Exit
status 1 says that a fault was found by nothing.

The device's own proof is put aside: kernels with a fault are taken for proven, so that what finds
them is a test of what they compute.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from faults import FAULTS

PROJECT = Path(__file__).resolve().parents[2]
SCRATCH = PROJECT / ".cache/mutation"
LEVELS = {  # folders, and marked tests that are left out, as in the Makefile
    "check": (["tests/core", "tests/engine", "tests/filters", "tests/project"], ["long", "matrix"]),
    "test": (["tests"], ["matrix"]),
}
_SECONDS = 1800  # what takes longer hangs
_OF_THE_LIST = "tests/project/test_mutation.py"  # it fails with every fault
_FOUND = re.compile(r"^(?:FAILED|ERROR) (\S.*?)(?: - .*)?$", re.MULTILINE)
# Keeps the verdicts of the kernels without faults under the name of those with one.
_PROVE = """
import dataclasses, json, sys, time
from vtk_mls.engine import device, proof, records
found, file = device.list_devices(), sys.argv[1]
if sys.argv[2] == "ask":
    verdicts = [dataclasses.asdict(verdict) for verdict in proof.verdicts(found)]
    open(file, "w").write(json.dumps(verdicts))
for each, verdict in zip(found, json.load(open(file))):
    kept = {"device": str(each), **verdict, "time": time.time()}
    records.write(records.name(proof.identity(each)), kept)
"""


def main():
    options = _options()
    tree = SCRATCH / "tree"
    chosen = [fault for fault in FAULTS if options.only in f"{fault.file} {fault.breaks}"]
    known_file = Path(__file__).with_name(f"found_by_{options.level}.json")
    with _worktree(tree, options.commit):
        for fault in chosen:
            _check_applies(tree, fault)
        _prove(tree, "ask")
        known = json.loads(known_file.read_text()) if known_file.exists() else {}
        results = {}
        for number, fault in enumerate(chosen, 1):
            with _applied(tree, fault):
                _prove(tree, "keep")
                start = time.monotonic()
                found = _search(tree, fault, options, known.get(fault.breaks))
                seconds = time.monotonic() - start
            results[fault] = found, seconds
            print(f"{number}/{len(chosen)} {fault.breaks}: {found} ({seconds:.0f} s)", flush=True)
            if found and "::" in found:
                known[fault.breaks] = found
            known_file.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")
        sound = _passes(tree, [found for found, _ in results.values() if found and "::" in found])
    print(_table(results))
    survivors = [fault.breaks for fault, (found, _) in results.items() if not found]
    print(f"{len(results) - len(survivors)} of {len(results)} faults found")
    if not sound:
        print("tests that found them fail without a fault, too", file=sys.stderr)
    return 1 if survivors or not sound else 0


def _options():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--level", choices=LEVELS, default="check")
    parser.add_argument("--only", default="", help="faults whose file or name has this in it")
    parser.add_argument("--commit", default="HEAD", help="whose code and tests")
    parser.add_argument("--quick", action="store_true", help="try likely files only")
    return parser.parse_args()


@contextmanager
def _worktree(tree, commit):
    """A checkout of `commit` for as long as the context lasts."""
    git = ["git", "-C", str(PROJECT)]
    subprocess.run([*git, "worktree", "prune"], check=True)
    shutil.rmtree(tree, ignore_errors=True)
    tree.parent.mkdir(parents=True, exist_ok=True)
    (tree.parent / ".gitignore").write_text("*\n")
    add = [*git, "worktree", "add", "--quiet", "--force", "--detach", str(tree), commit]
    subprocess.run(add, check=True)
    try:
        yield
    finally:
        subprocess.run([*git, "worktree", "remove", "--force", str(tree)], check=True)


def _check_applies(tree, fault):
    file = tree / fault.file
    count = file.read_text().count(fault.old) if file.is_file() else 0
    if count != 1:
        sys.exit(
            f"the fault `{fault.breaks}` no longer applies: its old text is {count} times in "
            f"{fault.file}; adapt it in tests/mutation/faults.py"
        )


@contextmanager
def _applied(tree, fault):
    file = tree / fault.file
    text = file.read_text()
    file.write_text(text.replace(fault.old, fault.new))
    try:
        yield
    finally:
        file.write_text(text)


def _prove(tree, how):
    command = [sys.executable, "-c", _PROVE, str(tree.parent / "verdicts.json"), how]
    subprocess.run(command, env=_environment(tree), cwd=tree, check=True)


def _environment(tree):
    kept = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    cache = str(tree.parent / "cache")
    own = {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1", "XDG_CACHE_HOME": cache}
    return {**kept, **own}


def _search(tree, fault, options, known):
    """The test that finds a fault, or None."""
    places, left_out = LEVELS[options.level]
    marks = ["-m", " and ".join(f"not {mark}" for mark in left_out)]
    first = [each for each in (known, *fault.likely) if each and each.startswith(tuple(places))]
    tries = [[each] for each in first if (tree / each.partition("::")[0]).is_file()]
    if not options.quick:
        tries.append(["--numprocesses", "auto", "--ignore", "tests/paraview", *places])
    for arguments in tries:
        found = _failure(tree, [*marks, *arguments])
        if found:
            return found
    return None


def _failure(tree, arguments):
    """The first test that fails, None if none does."""
    try:
        done = _pytest(tree, "--exitfirst", *arguments)
    except subprocess.TimeoutExpired:
        return "a test that hangs"
    if done.returncode in (0, 4, 5):  # 4 and 5: what found it the last time is not there any more
        return None
    found = _FOUND.search(done.stdout)
    return found[1] if found else f"a crash ({done.returncode})"


def _passes(tree, tests):
    """Whether tests pass without a fault."""
    return not tests or _pytest(tree, *dict.fromkeys(tests)).returncode == 0


def _pytest(tree, *arguments):
    command = [sys.executable, "-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider"]
    command += ["--ignore", _OF_THE_LIST]
    return subprocess.run(
        [*command, *arguments],
        cwd=tree,
        env=_environment(tree),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        timeout=_SECONDS,
        check=False,
    )


def _table(results):
    rows = ["| fault | found by | s |", "|---|---|---|"]
    rows += [
        f"| {fault.breaks} | {found or '**nothing**'} | {seconds:.0f} |"
        for fault, (found, seconds) in results.items()
    ]
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
