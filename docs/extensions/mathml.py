"""Formulas as MathML, which browsers draw by themselves, in a font that goes with the site.

The markup is written while the site is built. A page therefore needs neither a script nor a server
to show a formula, a screen reader can read it, and it takes the colour of the text around it.
"""

from importlib.resources import files

from docutils import nodes
from math_core import LatexToMathML
from sphinx.util.math import get_node_equation_number

#: It has the table of sizes and distances that formulas need, which few fonts of a system have.
FONT = files("ziamath") / "fonts" / "STIXTwoMath-Regular.ttf"

#: The source of a formula goes along with it, so that it can be copied.
CONVERTER = LatexToMathML(annotation=True, fancy_error=False)


def mathml(node, *, displaystyle):
    """MathML of a formula; one that is not understood ends the build."""
    return CONVERTER.convert_with_local_state(node.astext().strip(), displaystyle=displaystyle)


def visit_inline(writer, node):
    """Write a formula in a line of text."""
    writer.body.append(mathml(node, displaystyle=False))
    raise nodes.SkipNode


def visit_block(writer, node):
    """Write a formula on lines of its own, with its number if it has one."""
    writer.body.append(writer.starttag(node, "div", CLASS="math"))
    writer.body.append(mathml(node, displaystyle=True))
    if node["number"]:
        writer.body.append(f'<span class="eqno">({get_node_equation_number(writer, node)})</span>')
    writer.body.append("</div>\n")
    raise nodes.SkipNode


def take_font_along(_app, config):
    """Put the font beside the style sheets that name it."""
    config.html_static_path.append(str(FONT))


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    app.connect("config-inited", take_font_along)
