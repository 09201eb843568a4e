"""How Sphinx builds the manual: `sphinx-build -W --keep-going docs docs/_build`."""

from __future__ import annotations

import os
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
# The manual documents the checkout it lies in, in this process, in commands and in notebooks.
for folder in (HERE.parent, HERE / "_ext"):
    sys.path.insert(0, str(folder))
os.environ["PYTHONPATH"] = str(HERE.parent)
os.environ["COLUMNS"] = "88"

import warprock  # noqa: E402

project = "warprock"
author = "the authors of warprock"
version = release = warprock.__version__
html_title = f"warprock {version}"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_copybutton",
    "commands",
    "mathml",
    "registries",
]
exclude_patterns = ["_build", "_made", "jupyter_execute"]

myst_enable_extensions = ["deflist", "dollarmath", "attrs_block", "attrs_inline"]
myst_heading_anchors = 3
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 60
nb_merge_streams = True

# Docstrings write names between single backticks.
default_role = "code"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_math_renderer = "mathml"
html_theme = "furo"
# Those of the theme, and a link to other versions.
html_sidebars = {
    "**": [
        *(f"sidebar/{name}.html" for name in ("brand", "search", "scroll-start", "navigation")),
        "versions.html",
        *(f"sidebar/{name}.html" for name in ("scroll-end", "variant-selector")),
    ]
}
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_copy_source = False
copybutton_prompt_text = "$ "
copybutton_selector = ".highlight-sh pre, .highlight-toml pre, .cell_input pre"
