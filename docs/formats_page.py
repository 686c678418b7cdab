"""Writes docs/formats.md from the table of formats: python docs/formats_page.py"""

from __future__ import annotations

from pathlib import Path

from vtk_mls.files import formats

SECTIONS = {
    "Images": (formats.IMAGE, formats.MEDICAL),
    "Displacement fields, as transforms": (formats.FIELD,),
    "Meshes": (formats.MESH, formats.POLYDATA, formats.STRUCTURED, formats.UNSTRUCTURED),
    "Blocks, pieces and time steps": (formats.BLOCKS,),
    "Control points and landmarks": (formats.POINTS, formats.POINT_DATA),
    "Surfaces of cuts": (formats.SURFACE,),
}
HEAD = """# Formats of files

What `vtk-mls`, `vtk_mls.io` and ParaView's dialogs know. Data in memory are in LPS; where a file
says another frame, it is taken to LPS and written in its own again ([Left is left](frames.md)).
Made by `python docs/formats_page.py` from `vtk_mls/files/formats.py`.
"""
SERIES = "`.pvd`, `.series` and patterns in quotes (`'beat_*.vti'`) are series of all of these.\n"


def page() -> str:
    """The text of docs/formats.md."""
    parts = [HEAD]
    for title, words in SECTIONS.items():
        parts.append(f"## {title}\n\n| format | ending | read | written | frame |")
        parts.append("|---|---|---|---|---|")
        parts += [_row(line, words) for line in formats.TABLE if _is_of(line, words)]
        parts.append("")
        if title.startswith("Blocks"):
            parts.append(SERIES)
    return "\n".join(parts)


def _is_of(line, words):
    return bool({*line.reads, *line.writes} & {*words})


def _row(line, words):
    endings = " ".join(f"`{each}`" for each in line.endings.split())
    name = f"{line.name} (`pip install {line.needs}`)" if line.needs else line.name
    # one mesh may be read as blocks
    same = [each for each in formats.TABLE if each.endings == line.endings]
    reads = "yes" if any(each.reads for each in same) else ""
    writes = "yes" if {*line.writes} & {*words} else ""
    return f"| {name} | {endings} | {reads} | {writes} | {line.frame} |"


if __name__ == "__main__":
    Path(__file__).with_name("formats.md").write_text(page())
