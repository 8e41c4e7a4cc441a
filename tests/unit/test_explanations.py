"""Tables on the pages under explanation are what the code in the repository makes of its data."""

from __future__ import annotations

import importlib
import json
import re
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TABLES = DOCS / "results"
PAGES = [DOCS / "model.md", *sorted((DOCS / "explanation").glob("*.md"))]


@pytest.fixture(scope="module")
def made() -> Any:
    """The module that makes pictures and tables."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(DOCS))
        return importlib.import_module("make_explanations")


@pytest.fixture(scope="module")
def audit() -> Any:
    """What the audit of the article found, as it is kept."""
    return json.loads((TABLES / "audit.json").read_text("utf-8"))


def text_of(name: str) -> str:
    return (TABLES / f"{name}.md").read_text("utf-8")


def test_the_tables_of_the_article_are_those_of_the_audit(made: Any, audit: Any) -> None:
    """Every claim stands in the table of its verdict; `test_report.py` makes the audit anew."""
    tables = made.audit_tables(audit)
    assert tables == {name: text_of(name) for name in tables}
    listed = [text.count("\n: ") for name, text in tables.items() if name != "audit-resonances"]
    assert sum(listed) == len(audit["claims"])
    assert len(tables["audit-resonances"].splitlines()) == 2 + len(audit["resonances"])


def test_claims_that_the_page_explains_have_the_verdict_that_it_says(audit: Any) -> None:
    """The numbers in brackets under "What does not hold" are contradicted."""
    text = (DOCS / "explanation" / "article.md").read_text("utf-8")
    section = text.partition("## What does not hold")[2].partition("\n## ")[0]
    named = re.findall(r"\d+[a-z]?", " ".join(re.findall(r"\* \(([^)]*)\):", section)))
    verdicts = {claim["id"]: claim["verdict"] for claim in audit["claims"]}
    assert len(named) > 5
    assert {verdicts[number] for number in named} == {"contradicted"}


def test_what_the_model_leaves_out_is_computed(made: Any) -> None:
    """The table of the page about the model."""
    head = ("left out", "measured by", "value", "in the package")
    assert made.as_table(head, made.neglected()) == text_of("limits")


def test_coverage_is_that_of_the_study(made: Any) -> None:
    """The table of the page about the error bound, from the kept results."""
    assert made.coverage_table() == text_of("error-bound")


def test_every_page_shows_what_was_computed() -> None:
    """Tables and pictures that pages show are there, and each is made by a script."""
    for name in ("magnetisation", "tolerance", "error-bound", "regimes", "article", "model"):
        (page,) = [path for path in PAGES if path.stem == name]
        text = page.read_text("utf-8")
        shown = re.findall(r"\{(?:include|figure)\} (\S+)", text)
        assert len(shown) >= 2
        assert all((page.parent / path).exists() for path in shown)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("picture", "tables"),
    [
        ("limits", ("limits", "limits-frequency")),
        ("magnetisation", ("magnetisation",)),
        ("tolerance", ("tolerance",)),
    ],
)
def test_tables_beside_pictures_are_computed_anew(
    picture: str, tables: tuple[str, ...], made: Any, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The numbers beside a picture are those that the code behind it gives."""
    monkeypatch.setattr(made, "TABLES", tmp_path)
    made.plt.close(made.PICTURES[picture]())
    for name in tables:
        assert (tmp_path / f"{name}.md").read_text("utf-8") == text_of(name)
