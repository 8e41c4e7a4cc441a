"""How Sphinx builds the site."""

from importlib.metadata import version as installed_version

project = "Remanent"
author = "The Remanent developers"
copyright = "2026, The Remanent developers"
release = installed_version("remanent")
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
exclude_patterns = ["_build"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_class_signature = "mixed"
autodoc_default_options = {
    "exclude-members": "checked_options, choices, invalid, piece_parameters, rules, structure"
}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"Remanent {release}"
copybutton_exclude = ".linenos, .gp, .go"
