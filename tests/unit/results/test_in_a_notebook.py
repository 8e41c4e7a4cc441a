"""A notebook is run, and what its cells show is looked at."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

CELLS = (
    "import sys\nimport numpy as np\nimport remanent as rm\nbody = rm.Actuator()",
    "body",
    "rm.SineSquared(0.4, 1.25)",
    "rm.LagrangianSystem.example()",
    "rm.equations(body)",
    "grid = np.linspace(0.5, 2.0, 16)\n"
    "result = rm.frequency_response(body, rm.SineSquared(0.4, 1.0), grid, progress=True)",
    "rm.plot.overview(result);",
    "'ipywidgets' in sys.modules",
)


@pytest.fixture(scope="module")
def outputs() -> list[list[dict[str, Any]]]:
    """What each cell shows."""
    client = pytest.importorskip("nbclient", reason="nbclient runs notebooks")
    pytest.importorskip("ipykernel", reason="ipykernel runs notebooks")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(one) for one in CELLS])
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        patch.delenv("MPLBACKEND", raising=False)  # kernels choose their own
        warnings.simplefilter("ignore")  # of what runs the notebook, not of this package
        client.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    return [list(cell.outputs) for cell in notebook.cells]


@pytest.mark.slow
def test_systems_and_drives_show_formulas_and_numbers(
    outputs: list[list[dict[str, Any]]],
) -> None:
    """As Markdown, whose formulas every kind of notebook typesets."""
    for cell, formula, number in (
        (1, r"{\lambda''}", "| 293 | K |"),
        (2, r"\sin^{2}", "| 1.25 | rad |"),
        (3, r"\ddot{x}", "`delta`"),
    ):
        (shown,) = outputs[cell]
        assert formula in shown["data"]["text/markdown"]
        assert number in shown["data"]["text/markdown"]
    (equations,) = outputs[4]
    assert r"\begin{gathered}" in equations["data"]["text/latex"]


@pytest.mark.slow
def test_a_bar_is_one_display(outputs: list[list[dict[str, Any]]]) -> None:
    """It ends full, leaves no lines behind and needs no widgets."""
    (bar,) = outputs[5]
    assert 'value="1.00"' in bar["data"]["text/html"]
    (widgets,) = outputs[7]
    assert widgets["data"]["text/plain"] == "False"


@pytest.mark.slow
def test_a_result_shows_its_figure_in_one_call(outputs: list[list[dict[str, Any]]]) -> None:
    """A picture, and nothing else."""
    (figure,) = outputs[6]
    assert len(figure["data"]["image/png"]) > 5000
