"""Random cases, in child processes that may crash without ending this one.

python tests/fuzz/run.py 10000              # seeds 0 to 9999
python tests/fuzz/run.py 1 --first 4711     # one case again, in this process
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import traceback
from collections import Counter
from functools import partial

_BATCH = 200  # cases of one child
_SECONDS = 20  # that a case may take, at most, on average in a batch


def main(arguments=None):
    """Run the cases that the command line says; the number of those that failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, help="number of cases")
    parser.add_argument("--first", type=int, default=0, help="seed of the first case")
    parser.add_argument("--device", default="", help="as of Deformation; the first if not given")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    wanted = parser.parse_args(arguments)
    if wanted.child or wanted.count == 1:
        return _run_here(wanted.first, wanted.count, wanted.device)
    failures = run(wanted.first, wanted.count, wanted.device, partial(print, flush=True))
    kinds = Counter(sentence.split(":")[0] for sentence in failures.values())
    print(f"{wanted.count} cases, {len(failures)} failed: {dict(kinds)}")
    return len(failures)


def run(first, count, device="", say=lambda sentence: None):
    """What failed, by seed."""
    failures, seed, end = {}, first, first + count
    while seed < end:
        size = min(_BATCH, end - seed)
        done, found, ending = _child(seed, size, device)
        seed = done + 1
        if ending:  # in the middle of a case
            found[seed] = ending
            seed += 1
        for number, sentence in found.items():
            say(f"seed {number}: {sentence}")
        failures.update(found)
    return failures


def _child(first, count, device):
    """The last seed that was done, failures by seed, and how the child ended, if not well."""
    command = [sys.executable, __file__, str(count), "--first", str(first), "--child"]
    try:
        ended = subprocess.run(
            [*command, "--device", device], capture_output=True, text=True, timeout=_SECONDS * count
        )
        output, ending = ended.stdout, f"the process ended with {ended.returncode}"
        ending = "" if ended.returncode == 0 else ending
    except subprocess.TimeoutExpired as hung:
        output, ending = (hung.stdout or b"").decode(), "the process hangs"
    done, failures = first - 1, {}
    for line in output.splitlines():
        word, _, rest = line.partition(" ")
        if word == "failed":
            seed, _, sentence = rest.partition(" ")
            failures[int(seed)] = sentence
        elif word == "done":
            done = int(rest)
    return done, failures, ending if done < first + count - 1 else ""


def _run_here(first, count, device):
    from checks import check

    failed = 0
    for seed in range(first, first + count):
        try:
            check(seed, device)
        except Exception as error:
            failed += 1
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = "" if isinstance(error, AssertionError) else f" ({where.name}, {where.lineno})"
            text = " ".join(str(error).split())[:600]
            print(f"failed {seed} {type(error).__name__}{place}: {text}", flush=True)
        print(f"done {seed}", flush=True)
    return 0 if count > 1 else failed


if __name__ == "__main__":
    sys.exit(min(1, main()))
