"""Sphinx: `make docs` builds the documentation, and runs its figures and gallery."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS.parent), str(DOCS)]
# pictures without a display
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
if sys.platform == "linux" and "DISPLAY" not in os.environ:
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import command_page  # noqa: E402

import vtk_mls  # noqa: E402

project = "vtk_mls"
author = "The vtk_mls authors"
copyright = author
version = release = vtk_mls.__version__

extensions = [
    "matplotlib.sphinxext.plot_directive",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.githubpages",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "gallery/*.ipynb", "gallery/*.py"]
# a checkout may lie in a folder with a space in its name; links to the scripts are right
suppress_warnings = ["sphinx_gallery.space_in_filename"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
add_module_names = False
toc_object_entries_show_parents = "hide"  # beside the page there is no room for them

plot_formats = [("png", 160)]
plot_html_show_formats = False
plot_html_show_source_link = True
plot_basedir = str(DOCS)
plot_rcparams = {"figure.constrained_layout.use": True, "font.size": 10}
plot_apply_rcparams = True

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "ignore_pattern": r"paraview_deform",
    "image_scrapers": ("gallery_pictures.written",),
    "reset_modules": (),
    "capture_repr": (),
    "default_thumb_file": str(DOCS / "void.png"),
    "download_all_examples": False,
    "remove_config_comments": True,
    "write_computation_times": False,
    "show_signature": False,
    "abort_on_example_error": True,
    "within_subsection_order": "gallery_pictures.Order",
}

html_theme = "pydata_sphinx_theme"
html_title = f"vtk_mls {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_context = {
    "default_mode": "auto"
}  # of light and dark: a script of the theme complains of none
html_theme_options = {
    "logo": {"text": "vtk_mls"},
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
}
html_sidebars = {"index": [], "install": []}
copybutton_prompt_text = r"^\$ "


# Pages that are files of the project.
FILES = {
    "changelog": "CHANGELOG.md",
    "contributing": "CONTRIBUTING.md",
    "kernels": "opencl/README.md",
}
LINKS = {r"\]\(docs/": "](", r"\]\(opencl/README\.md\)": "](kernels.md)"} | {
    rf"\]\({file}\)": f"]({page}.md)" for page, file in FILES.items()
}


def read(app, name, source):
    """A page's text; of those that are files, with links as from here."""
    if name in FILES:
        text = (DOCS.parent / FILES[name]).read_text(encoding="utf-8")
        for link, here in LINKS.items():
            text = re.sub(link, here, text)
        source[0] = re.sub(r"\]\((?=(?:vtk_mls|opencl)/)", "](../", text)


def setup(app):
    """Write the page of the command before sources are read."""
    app.connect("builder-inited", lambda app: command_page.write(Path(app.srcdir)))
    app.connect("source-read", read)
