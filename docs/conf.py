"""How Sphinx builds the site."""

import inspect
import re
from importlib.metadata import version as installed_version
from pathlib import Path

import remanent

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
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88

html_theme = "furo"
#: What `make docs` lays beside the pages: the explorer's saved page, which the gallery links.
EXTRA = Path(__file__).parent / "_build" / "extra"
html_extra_path = [str(EXTRA)] if EXTRA.exists() else []
html_title = f"Remanent {release}"
copybutton_exclude = ".linenos, .gp, .go"


def plain_aliases(_app, _what, _name, _obj, _options, signature, returns):
    """Show an alias kept by `autodoc_type_aliases` by its name, in unions too."""
    return tuple(
        text and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", text)
        for text in (signature, returns)
    )


#: Stands in ``reference.md`` where the public names go.
PLACE = re.compile(r"<!-- The families of public names .*? -->")


def public_names(_app, page, source):
    """Put every public name into the reference, under the heading of its family."""
    if page == "reference":
        source[0] = PLACE.sub(lambda _: "\n".join(map(section, families())), source[0])


def families():
    """Heading and names of each family in the stub of the package, in order."""
    text = Path(remanent.__file__).with_suffix(".pyi").read_text("utf-8")
    for part in text.split("# Family: ")[1:]:
        heading, _, lines = part.partition("\n")
        yield heading, re.findall(r"^from \S+ import (\w+) as \1$", lines, re.M)


def section(family):
    """Markdown for one family."""
    heading, names = family
    entries = "\n\n".join(map(entry, names))
    return f"## {heading}\n\n```{{eval-rst}}\n{entries}\n```\n"


def entry(name):
    """The directive that documents one name."""
    value = getattr(remanent, name)
    if not inspect.isclass(value):
        return f".. autofunction:: remanent.{name}"
    if issubclass(value, BaseException):
        return f".. autoexception:: remanent.{name}"
    members = "\n   :members:" if name in ("Actuator", "Status") else ""
    return f".. autoclass:: remanent.{name}{members}"


def setup(app):
    """Called by Sphinx."""
    if (EXTRA / "explorer.html").exists():
        app.tags.add("explorer_page")
    app.connect("source-read", public_names)
    app.connect("autodoc-process-signature", plain_aliases)
