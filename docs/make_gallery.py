"""The gallery, made from the scripts in ``examples``.

``python docs/make_gallery.py`` runs every example and writes its picture into
``docs/_static/gallery``, then the page ``docs/gallery.md`` and the notebooks in
``examples/notebooks``.  Names of examples as arguments run these only.

The pictures are committed: running all examples takes a minute, which each build of the
documentation would have to wait for.  A test runs the examples and compares.
"""

from __future__ import annotations

import ast
import os
import re
import runpy
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import nbformat
from nbformat import NotebookNode
from PIL import Image

ROOT: Final = Path(__file__).parents[1]
#: The scripts.
EXAMPLES: Final = ROOT / "examples"
#: Notebooks of the main ones.
NOTEBOOKS: Final = EXAMPLES / "notebooks"
#: Their pictures.
PICTURES: Final = ROOT / "docs" / "_static" / "gallery"
#: The page.
PAGE: Final = ROOT / "docs" / "gallery.md"
#: Pixels per inch and number of colours of the pictures, so that each stays small.
RESOLUTION_DPI: Final = 150
COLOUR_COUNT: Final = 128
#: What examples save at.
SAVED_RESOLUTION_DPI: Final = 300

#: Headings of the page, each with its examples in order.
PARTS: Final[Mapping[str, Sequence[str]]] = MappingProxyType(
    {
        "The actuator in a field": (
            "constant_field",
            "published_resonances",
            "tolerance",
            "isothermal",
            "film_in_si",
            "passing_magnet",
            "warm_magnet",
            "energy_balance",
        ),
        "Resonances, branches and jumps": (
            "damping_and_folds",
            "hysteresis",
            "basins",
            "period_doubling",
            "backbone",
            "viscoelastic_resonances",
        ),
        "Bodies": (
            "viscous_loss",
            "self_heating",
            "limiting_chains",
            "unequal_stretches",
            "two_shapes",
        ),
        "Commands, measurements and uncertainty": (
            "command_shaping",
            "ring_down",
            "uncertain_step",
            "sobol",
        ),
        "Systems of one's own": (
            "duffing_exact",
            "pendulum",
            "van_der_pol",
            "melnikov",
            "lorenz",
            "balloon_burst",
        ),
        "Many runs and other tools": ("study", "another_tool"),
    }
)
#: Examples that are notebooks too.
IN_NOTEBOOKS: Final = (
    "published_resonances",
    "tolerance",
    "hysteresis",
    "command_shaping",
    "ring_down",
    "pendulum",
    "balloon_burst",
)


@dataclass(frozen=True)
class Example:
    """A script, by its parts.

    Attributes
    ----------
    name : str
        Of its file, without the ending.
    question, answer, caption, source : str
        What its docstring says.
    code : str
        All below the docstring.
    first_line : int
        Number of the first line of the code.
    """

    name: str
    question: str
    answer: str
    caption: str
    source: str
    code: str
    first_line: int


def read_example(name: str) -> Example:
    """Take an example apart."""
    text = (EXAMPLES / f"{name}.py").read_text("utf-8")
    tree = ast.parse(text)
    first_line = tree.body[1].lineno
    question, *answer, caption, source = (ast.get_docstring(tree) or "").split("\n\n")
    return Example(
        name=name,
        question=" ".join(question.split()),
        answer="\n\n".join(answer),
        caption=" ".join(caption.removeprefix("Figure: ").split()),
        source=source.removeprefix("Source: "),
        code="".join(text.splitlines(keepends=True)[first_line - 1 :]),
        first_line=first_line,
    )


def run_example(name: str, folder: Path) -> dict[str, Any]:
    """Run an example in `folder`, where it writes its picture, and return its variables."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        return runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    finally:
        os.chdir(before)


def small_picture(picture: Path) -> Image.Image:
    """The picture of an example in the size and with the colours of the gallery."""
    with Image.open(picture) as image:
        size = [round(n * RESOLUTION_DPI / SAVED_RESOLUTION_DPI) for n in image.size]
        smaller = image.convert("RGB").resize((size[0], size[1]), Image.Resampling.LANCZOS)
    return smaller.quantize(COLOUR_COUNT, dither=Image.Dither.NONE)


def gallery_page() -> str:
    """Text of the page: thumbnails first, then every example with its code and figure."""
    lines = [_HEAD]
    for heading, names in PARTS.items():
        lines.append(f"**{heading}**\n\n````{{container}} gallery")
        lines += [_thumbnail(read_example(name)) for name in names]
        lines.append("````\n")
    lines.append(_EXPLORER_THUMBNAIL)
    for heading, names in PARTS.items():
        lines.append(f"## {heading}\n")
        lines += [_section(read_example(name)) for name in names]
    return "\n".join([*lines, _EXPLORER])


def notebook(name: str) -> NotebookNode:
    """A notebook of an example: its words, its code by paragraphs, without outputs."""
    example = read_example(name)
    words = f"# {example.question}\n\n{example.answer}\n\n*Source:* {example.source}"
    # A paragraph of code at the left margin, with the comments above it, is a cell.
    paragraphs = re.split(r"\n\n+(?=\S)", example.code.strip())
    cells = [nbformat.v4.new_markdown_cell(words)]
    cells += [nbformat.v4.new_code_cell(paragraph) for paragraph in paragraphs]
    for number, cell in enumerate(cells):
        cell.id = f"{name.replace('_', '-')}-{number}"  # the same whenever it is made
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return nbformat.v4.new_notebook(
        cells=cells, metadata={"kernelspec": kernel, "language_info": {"name": "python"}}
    )


def _target(example: Example) -> str:
    """Label of the section of an example."""
    return f"gallery-{example.name.replace('_', '-')}"


def _thumbnail(example: Example) -> str:
    """Markdown of a picture with its question, which lead to its section."""
    return f"[![](_static/gallery/{example.name}.png) {example.question}](#{_target(example)})"


def _section(example: Example) -> str:
    """Markdown of one example."""
    files = f"{{download}}`{example.name}.py <../examples/{example.name}.py>`"
    if example.name in IN_NOTEBOOKS:
        files += f", {{download}}`as a notebook <../examples/notebooks/{example.name}.ipynb>`"
    return f"""\
({_target(example)})=
### {example.question}

{example.answer}

![{example.caption}](_static/gallery/{example.name}.png)

```{{literalinclude}} ../examples/{example.name}.py
:lines: {example.first_line}-
```

*Figure:* {example.caption}

*Source:* {example.source}

{files}
"""


_HEAD: Final = """\
# Gallery

Each picture is one short script, which runs as it stands and writes the picture into the current
folder; click one to see its question, answer, code and source. The scripts are in the folder
`examples` of the repository, and a test checks the number behind each answer. Some are notebooks
too.

```{raw} html
<style>
.gallery p { display: grid; grid-template-columns: repeat(auto-fill, minmax(10rem, 1fr));
  gap: 1rem; align-items: end; }
.gallery a { font-size: 0.8rem; line-height: 1.25; text-decoration: none; align-self: stretch;
  display: flex; flex-direction: column; justify-content: space-between; }
.gallery img { width: 100%; margin: auto; background: white; padding: 0.2rem; }
</style>
```
"""

_EXPLORER_THUMBNAIL: Final = """\
**A live page**

````{container} gallery
[![](_static/explorer.png) Can a reader move the sliders?](#gallery-explorer)
````
"""

_EXPLORER: Final = """\
(gallery-explorer)=
## A live page

`remanent explore --save page.html` writes one file that works without a server: the motion follows
its sliders, and responses, branches, basins and charts are in it as they were computed. See
[](how-to/explore.md).

```{only} explorer_page
<a href="explorer.html">Open such a page.</a>
```

![The explorer: actuator, history, phase plane, potential and response](_static/explorer.png)
"""


def write_texts() -> None:
    """Write the page and the notebooks."""
    PAGE.write_text(gallery_page(), encoding="utf-8")
    NOTEBOOKS.mkdir(exist_ok=True)
    for name in IN_NOTEBOOKS:
        nbformat.write(notebook(name), NOTEBOOKS / f"{name}.ipynb")


def main(names: Sequence[str]) -> None:
    """Run examples, and write their pictures, the page and the notebooks."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            run_example(name, Path(folder))
            small_picture(Path(folder) / f"{name}.png").save(
                PICTURES / f"{name}.png", optimize=True
            )
    write_texts()


if __name__ == "__main__":
    os.environ["MPLBACKEND"] = "Agg"
    main(sys.argv[1:] or [name for names in PARTS.values() for name in names])
