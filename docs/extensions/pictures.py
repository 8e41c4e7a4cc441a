"""Pictures at one scale on every page, each a link to itself at full size."""

import imagesize
from docutils import nodes

#: Pixels of the page for an inch of the figure: its letters of 8 pt are then as large as the text.
PER_INCH = 144
#: Inches from which on a figure is too wide to be read when it is shrunk to the width of a phone.
WIDE = 5


def inches(path):
    """Width of a picture on paper; one that does not say it is taken to be a view of a screen."""
    width, _ = imagesize.get(path)
    resolution, _ = imagesize.getDPI(path)
    default = 96 if path.suffix == ".svg" else PER_INCH
    return width / (resolution if resolution > 0 else default)


def set_width(app, doctree):
    """Give every picture its width; Sphinx links pictures with a width to their files."""
    for image in doctree.findall(nodes.image):
        path = app.srcdir / image["uri"]
        if path.is_file():
            width = inches(path)
            image["width"] = f"{PER_INCH * width:.0f}px"
            image["classes"] += ["wide"] if width > WIDE else []


def setup(app):
    """Called by Sphinx."""
    app.connect("doctree-read", set_width)
