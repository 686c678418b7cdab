"""The reference page of the properties is what its program writes today."""

import importlib.util
from pathlib import Path

PROGRAM = Path(__file__).parents[2] / "docs" / "properties_page.py"


def test_the_page_is_up_to_date():
    spec = importlib.util.spec_from_file_location("properties_page", PROGRAM)
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    written = program.PAGE.read_text(encoding="utf-8")
    assert written == program.page(), "docs/properties.md is old: python docs/properties_page.py"
