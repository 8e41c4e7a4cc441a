"""Run the code of the pages; write what it prints and draws back into them.

``python -m docs.pages docs/tutorial.md`` runs a page, ``python -m docs.pages`` all of them.

A fenced block of Python that prints is followed by a block ``output``, which holds what it
printed; a line ``...`` stands there for any lines that are left out.  What agrees already stays
as it is.  A picture ``_static/PAGE/name.png`` is the file ``name.png`` that the page called PAGE
saves.  The tests use the same functions, so that they and this command mean the same by "agrees".
"""

from __future__ import annotations

import contextlib
import io
import itertools
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"

_FENCE = re.compile(r"^(`{3,})(\S*)[ ]*\S*\n(.*?)^\1[ ]*$\n?", re.MULTILINE | re.DOTALL)
_PICTURE = re.compile(r"!\[[^]]*\]\((?P<link>[^)]*_static/(?P<page>[\w-]+)/(?P<name>[\w.-]+))\)")

#: A line that stands for any lines of an output.
_LEFT_OUT = re.compile(r"^[ ]*\.\.\.[ ]*$", re.MULTILINE)
#: A number as Python and NumPy write it, which is not part of a word or of a version.
_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:e[-+]?\d+)?(?![\w]|\.\d)")

#: Numbers below the first are rounding; below the second they are errors and residuals, of which
#: rounding may be a part; others are results.
ROUNDING, SMALL = 1e-11, 1e-4
#: How far results on two kinds of processors may be apart, relative to their size.
RESULTS_AGREE = 1e-6


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the line of its text, the text, where it begins and ends."""

    language: str
    line: int
    text: str
    begin: int
    end: int


def page_names() -> list[str]:
    """The pages, as paths from the top of the repository."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
    return [path.relative_to(ROOT).as_posix() for path in pages if "_build" not in path.parts]


def blocks_of(text: str) -> list[Block]:
    """The fenced blocks of a page, in order."""
    return [
        Block(m[2], text.count("\n", 0, m.start(3)) + 1, m[3], m.start(), m.end())
        for m in _FENCE.finditer(text)
    ]


def outputs_of(text: str) -> list[tuple[Block, Block | None]]:
    """Each block of Python, and the block of output directly after it, if there is one."""
    blocks = blocks_of(text)
    found = []
    for block, after in itertools.zip_longest(blocks, blocks[1:]):
        if block.language == "python":
            shown = after is not None and after.language == "output"
            adjacent = shown and not text[block.end : after.begin].strip()
            found.append((block, after if adjacent else None))
    return found


def output_agrees(shown: Block | None, printed: str) -> bool:
    """Whether a block is followed by what it prints, and by nothing if it prints nothing."""
    if shown is None:
        return not printed.strip()
    return bool(printed.strip()) and texts_agree(shown.text, printed)


def run_blocks(page: str, blocks: Sequence[Block], folder: Path) -> list[str]:
    """Run blocks in order, in one namespace and in a folder; return what each printed.

    A warning is an error.  Each block is compiled with the page's name and its own line, so that
    tracebacks and warnings point into the page.
    """
    import matplotlib.pyplot as plt

    printed = []
    shared = {"__name__": "__main__"}
    with contextlib.chdir(folder), plt.rc_context(), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            for block in blocks:
                out = io.StringIO()
                try:
                    with contextlib.redirect_stdout(out):
                        text = "\n" * (block.line - 1) + block.text
                        code = compile(text, page, "exec", dont_inherit=True)
                        exec(code, shared)  # noqa: S102
                except BaseException as error:
                    error.add_note(f"the block at {page}:{block.line} failed")
                    raise
                printed.append(out.getvalue())
        finally:
            plt.close("all")
    return printed


def texts_agree(shown: str, printed: str) -> bool:
    """Whether a shown output is what was printed, as far as processors agree.

    Words and whole numbers are the same, line by line, spaces aside.  Other numbers
    agree to `RESULTS_AGREE`, or to one unit of the last digit where three digits or more are
    shown; numbers below `SMALL` agree to a factor of two, and numbers below `ROUNDING` are
    alike.  A line ``...`` stands for any lines.
    """
    parts = [part.strip("\n").splitlines() for part in re.split(_LEFT_OUT, shown)]
    lines = printed.strip("\n").splitlines()
    if len(parts) == 1:
        return _same_lines(parts[0], lines)
    first, *middle, last = parts
    place, end = len(first), len(lines) - len(last)
    if not _same_lines(first, lines[:place]):
        return False
    for part in middle:
        while place + len(part) <= end and not _same_lines(part, lines[place : place + len(part)]):
            place += 1
        place += len(part)
    return place <= end and _same_lines(last, lines[end:])


def _same_lines(shown: list[str], printed: list[str]) -> bool:
    """Whether two lists of lines agree, one by one and word by word."""
    words, others = ([line.split() for line in lines] for lines in (shown, printed))
    return [len(line) for line in words] == [len(line) for line in others] and all(
        map(_same_word, itertools.chain(*words), itertools.chain(*others))
    )


def _same_word(shown: str, printed: str) -> bool:
    if shown == printed:
        return True
    if _NUMBER.sub("0", shown) != _NUMBER.sub("0", printed):
        return False
    numbers = zip(_NUMBER.findall(shown), _NUMBER.findall(printed), strict=True)
    return all(_same_number(one, other) for one, other in numbers)


def _same_number(shown: str, printed: str) -> bool:
    if shown == printed:
        return True
    if re.fullmatch(r"[-+]?\d+", shown) or re.fullmatch(r"[-+]?\d+", printed):
        return False
    one, other = float(shown), float(printed)
    smaller, larger = sorted([abs(one), abs(other)])
    if larger < ROUNDING:
        return True
    if larger < SMALL:
        return one * other > 0.0 and larger <= 2.0 * smaller
    return abs(one - other) <= max(RESULTS_AGREE * larger, _last_digit(shown, printed))


def _last_digit(shown: str, printed: str) -> float:
    """One unit of the last digit, of numbers rounded to the same three digits or more."""
    (digits, power), (others, _) = ((t + "e0").split("e")[:2] for t in (shown, printed))
    decimals = len(digits.partition(".")[2])
    significant = len(digits.replace(".", "").lstrip("-+0"))
    if significant < 3 or decimals != len(others.partition(".")[2]):
        return 0.0
    return 1.001 * 10.0 ** (int(power) - decimals)


def with_outputs(text: str, printed: Sequence[str]) -> str:
    """A page with the output of each block of Python under it."""
    pieces, place = [], 0
    for (block, shown), out in zip(outputs_of(text), printed, strict=True):
        if not output_agrees(shown, out):
            lines = "\n".join(line.rstrip() for line in out.rstrip().splitlines())
            fence = f"\n```output\n{lines}\n```\n" if lines else ""
            pieces += [text[place : block.end], fence]
            place = shown.end if shown else block.end
    return "".join(pieces) + text[place:]


def pictures_of(page: str, text: str) -> dict[Path, str]:
    """Pictures that are shown and made by the code of a page: their files, by name."""
    here = (ROOT / page).parent
    return {
        (here / m["link"]).resolve(): m["name"]
        for m in _PICTURE.finditer(text)
        if m["page"] == Path(page).stem
    }


def difference_of(one: Path, other: Path) -> float:
    """Mean difference of two pictures between 0 and 1; 1 for those of different sizes."""
    import numpy as np
    from matplotlib.image import imread

    first, second = (imread(path)[..., :3] for path in (one, other))
    return float(np.abs(first - second).mean()) if first.shape == second.shape else 1.0


#: Pictures that differ by less are the same, drawn with another version of a font's library.
PICTURES_AGREE = 1e-3


#: Colours of the pictures on pages: these are lines and letters in few colours, and small files.
COLOUR_COUNT = 128


def copy_picture(made: Path, picture: Path) -> None:
    """Copy a picture in `COLOUR_COUNT` colours."""
    from PIL import Image

    with Image.open(made) as image:
        few = image.convert("RGB").quantize(COLOUR_COUNT, dither=Image.Dither.NONE)
    few.save(picture, optimize=True)


def pages_with_code() -> list[str]:
    """Pages whose Python runs by itself; what CONTRIBUTING adds needs files of its own."""
    return [
        page
        for page in page_names()
        if page != "CONTRIBUTING.md" and outputs_of((ROOT / page).read_text("utf-8"))
    ]


def update(page: str) -> None:
    """Run a page, and write its outputs and pictures where they do not agree."""
    path = ROOT / page
    text = path.read_text("utf-8")
    blocks = [block for block, _ in outputs_of(text)]
    if not blocks:  # the gallery's pictures are those of its scripts
        print(page, "has no code to run")
        return
    with tempfile.TemporaryDirectory() as name:
        printed = run_blocks(page, blocks, Path(name))
        for picture, file in pictures_of(page, text).items():
            made = Path(name) / file
            if not picture.exists() or difference_of(picture, made) > PICTURES_AGREE:
                picture.parent.mkdir(exist_ok=True)
                copy_picture(made, picture)
                print("drew", picture.relative_to(ROOT))
    new = with_outputs(text, printed)
    if new != text:
        path.write_text(new, encoding="utf-8")
        print("wrote", page)


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    named = [Path(name).resolve().relative_to(ROOT).as_posix() for name in sys.argv[1:]]
    for each in named or pages_with_code():
        update(each)
