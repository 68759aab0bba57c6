"""Settings of the documentation's site; CONTRIBUTING.md has the command that builds it."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "site"))

from pythonreference import VERSION  # noqa: E402

project = "openmm-chaintree"
author = "the openmm-chaintree developers"
copyright = f"2026, {author}"
version = release = VERSION

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "breathe",
    "sphinx_argparse_cli",
    "sphinx_copybutton",
    # docs/site
    "commandparsers",
    "headers",
    "mathematics",
    "pythonreference",
    "repositorylinks",
    "tables",
]
exclude_patterns = ["site"]
nitpicky = True
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = ["site/static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
pygments_style = "default"
highlight_language = "none"  # default of blocks: formulas and output
# Do not copy prompts.
copybutton_prompt_text = ">>> "

# ---- Markdown ----

myst_enable_extensions = ["colon_fence", "attrs_block", "dollarmath"]
myst_heading_anchors = 4

# ---- Formulas ----

html_math_renderer = "mathml"

# ---- Python ----

autodoc_member_order = "bysource"
maximum_signature_line_length = 80
# Types in docstrings are prose ("array of shape (n, 3) or Quantity"), not references.
napoleon_use_param = False
napoleon_use_rtype = False
default_role = "chaintree-name"

# ---- C and C++ ----

breathe_default_project = "headers"
breathe_domain_by_extension = {"h": "cpp"}
breathe_show_include = False
breathe_show_define_initializer = True
breathe_show_enumvalue_initializer = True
cpp_maximum_signature_line_length = c_maximum_signature_line_length = 80

# Names documented elsewhere.
nitpick_ignore_regex = [
    ("py:.*", r"(openmm|numpy|np|npt|collections|os|typing|unit|app)(\..*)?|ArrayLike|CoilTables|Quantity|Residue"),
    ("cpp:identifier", r"(std|OpenMM)(::.*)?"),
    ("cpp:identifier", "NoHydrogenBond"),  # a default, which Sphinx loses when it builds a page again
    ("(c|cpp):identifier", r"u?int(8|64)_t|size_t|bool"),
]

# ---- Links elsewhere: sphinx-build -b linkcheck docs build/links ----

linkcheck_timeout = 20
linkcheck_workers = 2
