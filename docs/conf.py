"""How Sphinx builds the site."""

import re
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import reference_pages

sys.path.append(str(Path(__file__).parent / "extensions"))

project = "Remanent"
author = "The Remanent developers"
copyright = "2026, The Remanent developers"
release = installed_version("remanent")
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_click",
    "sphinx_copybutton",
    "mathml",
    "pictures",
]
# Fragments in results are included by pages.
exclude_patterns = ["_build", "results/*.md"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_class_signature = "mixed"
autodoc_default_options = {
    # What the parts of the package tell one another.
    "exclude-members": "checked_fields, structural_fields, where_invalid, parameter_rules, parts, "
    "piece_parameter_names, rules, scales, equation_structure, warn_if_implausible, with_parameter"
}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_type_aliases = {
    name: name for name in ("ArrayLike", "BoolArray", "FloatArray", "OverArgument")
}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
# Names in text lead somewhere; the types of arguments, which are in words, need not.
nitpicky = True
nitpick_ignore_regex = [("py:class", ".*")]
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88

html_theme = "furo"
html_math_renderer = "mathml"
html_domain_indices = False
html_static_path = ["_static/site.css"]
html_css_files = ["site.css"]
#: What `make docs` lays beside the pages: the explorer's saved page, which the gallery links.
EXTRA = Path(__file__).parent / "_build" / "extra"
html_extra_path = [str(EXTRA)] if EXTRA.exists() else []
html_title = f"Remanent {release}"
copybutton_selector = "div:not(.highlight-output) > div.highlight pre"
copybutton_exclude = ".linenos, .gp, .go"


def plain_aliases(_app, _what, _name, _obj, _options, signature, returns):
    """Show an alias kept by `autodoc_type_aliases` by its name, in unions too."""
    return tuple(
        text and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", text)
        for text in (signature, returns)
    )


def made_parts(_app, page, source):
    """Put public names and tables into the pages of the reference."""
    if page.startswith("reference"):
        source[0] = reference_pages.filled(source[0])


def setup(app):
    """Called by Sphinx."""
    if (EXTRA / "explorer.html").exists():
        app.tags.add("explorer_page")
    app.connect("source-read", made_parts)
    app.connect("autodoc-process-signature", plain_aliases)
