"""The gallery shows what the examples make: pictures, page and notebooks are theirs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

from docs.make_gallery import (
    EXAMPLES,
    IN_NOTEBOOKS,
    NOTEBOOKS,
    PAGE,
    PARTS,
    PICTURES,
    gallery_page,
    notebook,
    read_example,
    small_picture,
)

NAMES = [name for part in PARTS.values() for name in part]
#: Largest file of a picture.
MAX_PICTURE_BYTES = 80_000
#: Largest mean difference of two renderings of one picture, of 255 levels.
MAX_MEAN_DIFFERENCE = 1.5
#: Share of the width where that is asked of each point.  Beyond it are points of a loose run,
#: which magnifies the rounding of a processor: only how many there are can be compared.
PART_THAT_IS_CONVERGED = {"tolerance": 0.5}


def test_each_script_is_in_one_part() -> None:
    """Law: the page shows all scripts of the folder, each once, and one picture of each."""
    assert sorted(NAMES) == sorted(path.stem for path in EXAMPLES.glob("*.py"))
    assert sorted(NAMES) == sorted(path.stem for path in PICTURES.glob("*.png"))
    assert len(set(NAMES)) == len(NAMES)


def test_the_page_is_made_from_the_scripts() -> None:
    """Law: the page in the repository is the one that the scripts give."""
    assert PAGE.read_text("utf-8") == gallery_page()


@pytest.mark.parametrize("name", NAMES)
def test_an_example_says_what_it_shows(name: str) -> None:
    """It begins with a question, and names its figure and its source; its picture is small."""
    example = read_example(name)
    assert "?" in example.question
    assert example.answer
    assert example.caption.endswith(".")
    assert example.source.endswith(".")
    assert (PICTURES / f"{name}.png").stat().st_size <= MAX_PICTURE_BYTES


@pytest.mark.parametrize("name", IN_NOTEBOOKS)
def test_notebooks_are_made_from_the_scripts(name: str) -> None:
    """Law: a notebook is valid, without outputs, and its cells are the code of its script."""
    path = NOTEBOOKS / f"{name}.ipynb"
    written = nbformat.read(path, as_version=4)
    nbformat.validate(written)
    assert written == notebook(name)
    cells = [cell for cell in written.cells if cell.cell_type == "code"]
    assert not any(cell.outputs for cell in cells)
    code = "\n".join(cell.source for cell in cells).split()
    assert code == read_example(name).code.split()


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_an_example_still_makes_its_picture(name: str, tmp_path: Path) -> None:
    """Run from an empty folder, a script writes the picture that the page shows."""
    finished = subprocess.run(
        [sys.executable, "-W", "error", EXAMPLES / f"{name}.py"],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
    made = np.asarray(small_picture(tmp_path / f"{name}.png").convert("RGB"), dtype=float)
    with Image.open(PICTURES / f"{name}.png") as picture:
        shown = np.asarray(picture.convert("RGB"), dtype=float)
    assert made.shape == shown.shape, "run `python docs/make_gallery.py` and look at the picture"
    compared = round(PART_THAT_IS_CONVERGED.get(name, 1.0) * shown.shape[1])
    assert abs(made - shown)[:, :compared].mean() < MAX_MEAN_DIFFERENCE
    assert abs(made.mean() - shown.mean()) < MAX_MEAN_DIFFERENCE


@pytest.mark.slow
@pytest.mark.parametrize("name", IN_NOTEBOOKS)
def test_notebooks_run(name: str, tmp_path: Path) -> None:
    """A kernel runs all cells of a notebook without an error."""
    client = NotebookClient(
        notebook(name), timeout=300, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    assert (tmp_path / f"{name}.png").exists()
