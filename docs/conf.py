"""Configure Sphinx for the site; `make docs` builds it, by way of docs/site, which brings the pages together."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

project = "Drillstring co-simulation"
author = "The drillstring-cosim authors"
copyright = author  # noqa: A001 - Sphinx asks for this name
version = release = version_of("drillstring-cosim")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx_design",
    "docs.site.extension",
]
nitpicky = False
default_role = "code"  # in docstrings a name between backticks is code

myst_enable_extensions = ["colon_fence", "dollarmath", "html_image"]
myst_fence_as_directive = ["math"]  # as the forge that hosts the sources writes formulas
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True  # as they are written, and not with paths of where the site is made
autodoc_typehints = "none"  # numpydoc's sections tell the types
autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

mathjax_path = "mathjax/tex-chtml.js"  # of the site itself
mathjax3_config = {
    "options": {"enableMenu": False},  # its dialogs fetch scripts
    "tex": {"tags": "none", "macros": {"sgn": "\\operatorname{sgn}"}},
}

html_theme = "pydata_sphinx_theme"
html_title = project
html_static_path: list[str] = []  # what docs.site brings together
html_css_files = ["formula.css", "site.css"]
html_extra_path: list[str] = []
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {"text": project},
    "navbar_align": "left",
    "navbar_center": ["navbar-nav"],
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 8,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": {"**": ["page-toc"], "index": []},
    "show_prev_next": True,
}
html_sidebars: dict[str, list[str]] = {"index": [], "gallery": [], "glossary": []}
