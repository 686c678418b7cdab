"""What pages say of time, size and error was measured, and the command that did it stands by."""

from __future__ import annotations

import re

import pytest
from test_documentation import FENCE, PAGES, named

NUMBER, UNITS = r"\d[\d,.]*", "ms|s|seconds?|minutes?|hours?|KB|MB|GB|GiB|%|million|times|frames"
MEASURED = re.compile(
    rf"(?<![\w.^/-]){NUMBER}(?: (?:to|and|or) {NUMBER})?\s*(?:{UNITS})(?!\w)"
    r"|\b\d(?:\.\d+)?e-\d+\b"
)
# A command, a module that holds the number, or the program that says it.
TOLD = re.compile(
    r"`(?:time |[A-Z_]+=\S+ )?(?:make|python|vtk-mls|pip|\.ci/run|pytest)\b[^`]*`"
    r"|`[\w/.]+\.(?:py|cl|sh|yml)`|\]\([\w/.]+\.(?:py|cl)\)|as pip says"
)


def untold(text):
    """The paragraphs with numbers that were measured, and nothing that says by what.

    It may stand in the paragraph before, as that of a table does, or in the first of the page.
    """
    blocks = [each for each in re.split(r"\n\s*\n", FENCE.sub("", text)) if each.strip()]
    opening = [each for each in blocks if not each.startswith(("#", "!", ":"))][:1]
    return [
        block
        for before, block in zip([""] + blocks, blocks)
        if MEASURED.search(block)
        and not any(map(TOLD.search, [*opening, before, block]))
        and not block.startswith("#")
    ]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_numbers_name_their_command(page):
    assert not untold(page.read_text(encoding="utf-8"))


CLAIMS = "takes 12 ms", "good to 3e-5 of it", "by 40 % less", "10 to 20 minutes", "2.5 GB large"


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_number_of_nowhere_is_found(claim):
    text = f"# Speed\n\nIt is quick.\n\nIt {claim}.\n"
    assert untold(text) == [f"It {claim}.\n"]
    assert untold(text.replace("It is", "By `make bench` it is")) == []
    assert untold(text.replace(".\n\nIt", ".\n\n## More\n\nAs `make bench` says, it")) == []
