"""The pages of the reference hold every name, variable, key and attribute that there is."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest
import zarr

import remanent as rm
from remanent.cli.main import commands
from remanent.results.schema import DESCRIPTIONS
from remanent.studies.sweep import si_sizes, study_file, values_over
from remanent.studies.sweep.study import verbs_of_studies

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS / "reference.md", *sorted((DOCS / "reference").glob("*.md"))]


def loaded() -> ModuleType:
    """The module beside the pages that fills them."""
    spec = importlib.util.spec_from_file_location("reference_pages", DOCS / "reference_pages.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MODULE = loaded()


@pytest.fixture(scope="module")
def filled() -> dict[str, str]:
    """The text of each page as it is built."""
    return {page.stem: MODULE.filled(page.read_text("utf-8")) for page in PAGES}


def test_each_family_and_table_has_one_place() -> None:
    """Nothing is left out and nothing stands twice."""
    text = "\n".join(page.read_text("utf-8") for page in PAGES)
    places = [f"{kind}: {name}" for kind, name in MODULE.PLACE.findall(text)]
    wanted = [f"Family: {name}" for name in MODULE.families()]
    wanted += [f"Table: {name}" for name in MODULE.TABLES]
    assert sorted(places) == sorted(wanted)


def test_every_page_is_in_the_contents() -> None:
    """The overview leads to each page, and to no other."""
    listed = re.findall(r"^reference/([\w-]+)$", PAGES[0].read_text("utf-8"), re.M)
    assert sorted(listed) == sorted(page.stem for page in PAGES[1:])


def test_every_public_name_is_documented_once(filled: dict[str, str]) -> None:
    """One directive for each public name; the overview names it too."""
    directives = re.findall(r"\.\. auto\w+:: remanent\.(\w+)$", "\n".join(filled.values()), re.M)
    public = set(rm.__all__) - {"plot", "__version__"}
    assert sorted(directives) == sorted([*public, "plots"])
    assert set(re.findall(r"`~remanent\.(\w+)`", filled["reference"])) == public


def test_summaries_are_words(filled: dict[str, str]) -> None:
    """Formulas are mathematics, below the summary; the table of names has none."""
    summaries = re.findall(r"^\| \{py:obj\}`~remanent\.\w+` \| (.*) \|$", filled["reference"], re.M)
    assert len(summaries) > 50
    assert not [text for text in summaries if re.search(r"\^| = |\w\\?\[", text)]


def test_every_variable_is_listed_once(filled: dict[str, str]) -> None:
    """Each row of the table of variables, with its meaning."""
    table = filled["variables"].partition("## The table")[2]
    rows = re.findall(r"^\| `([\w.]+)` \| .*? \| (.+?) \| ", table, re.M)
    assert sorted(rows) == sorted((row.name, row.long_name) for row in DESCRIPTIONS.values())


def test_statuses_are_listed(filled: dict[str, str]) -> None:
    """Each code once, with its flag and its sentence."""
    rows = re.findall(r"^\| (\d+) \| `([a-z-]+)` \| (.*) \|$", filled["results"], re.M)
    assert rows == [(str(s.value), s.meaning, s.explanation) for s in rm.Status]


def test_every_key_of_a_study_file_is_listed(filled: dict[str, str]) -> None:
    """The keys that the reader of study files knows, each with a meaning; and every verb."""
    text = filled["study-file"]
    models = (
        study_file._Top, si_sizes._sizes_table(), values_over.Values, values_over.SobolPoints,
    )  # fmt: skip
    for model in models:
        for name, field in model.model_fields.items():
            assert re.search(rf"^\| `{field.alias or name}` \| .* \| .{{10,}} \|", text, re.M)
    for verb in verbs_of_studies():
        assert f"`~remanent.{verb}`" in text


def test_the_page_of_the_store_lists_its_attributes(tmp_path: Path) -> None:
    """Those that a store has beside the attributes of the result, and what lies beside arrays."""
    path = tmp_path / "store.zarr"
    over = {"b": [0.3, 0.4]}
    result = rm.sweep(
        rm.Actuator(), rm.SineSquared(0.4, 1.25), over, "poincare_section", periods=2, store=path
    )
    own = set(zarr.open_group(path, mode="r").attrs) - set(result.attrs)
    text = (DOCS / "reference" / "store.md").read_text("utf-8")
    attributes = text.partition("## Attributes")[2].partition("## ")[0]
    # Those that say what the study is are among the result's too.
    of_the_study = {"study", "study_digest", "schema_version"}
    of_the_study |= {"code_sources", "code_versions", "code_processor"}
    listed = set(re.findall(r"`(\w+)`", re.sub(r"\|[^|]*\|$", "", attributes, flags=re.M)))
    assert own <= listed <= own | of_the_study
    files = {entry.name for entry in (path / "bookkeeping").iterdir()} - {"zarr.json"}
    assert files <= set(re.findall(r"`([\w.-]+)`", text))


def test_the_command_is_that_of_the_package(filled: dict[str, str]) -> None:
    """The page is made from the group of all commands."""
    assert ".. click:: remanent.cli.main:commands" in filled["command"]
    assert {"run", "verify", "show", "explore", "export", "new", "paper"} <= set(commands.commands)


def test_every_argument_of_a_command_is_described() -> None:
    """The page and `--help` say of each argument and option what it is, in a sentence."""
    described = {
        (name, parameter.name): getattr(parameter, "help", None) or ""
        for name, command in commands.commands.items()
        for parameter in command.params
    }
    assert ("explore", "source") in described
    assert {place for place, text in described.items() if not text.endswith(".")} == set()
