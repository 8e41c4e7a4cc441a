"""What the README and the pages of the site show is true: names, files and figures.

That their code runs and prints what they show is in `test_pages.py`.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm
from docs import pages
from remanent._extras import PACKAGES_OF_EXTRA
from remanent.results.schema import DESCRIPTIONS
from remanent.studies.sweep.study_file import read_study

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def blocks_of(page: Path, language: str) -> list[str]:
    """The blocks of a page in one language."""
    blocks = pages.blocks_of(page.read_text("utf-8"))
    return [block.text for block in blocks if block.language == language]


#: Study files of the pages; those without a verb change some tables of the first.
STUDY_BLOCKS = [
    text for name in ("studies", "slurm") for text in blocks_of(DOCS / f"how-to/{name}.md", "toml")
]


def tables_of(text: str) -> dict[str, str]:
    """Tables of a study file by the first part of their names, and what stands above them."""
    tables: dict[str, str] = {}
    for part in re.split(r"^(?=\[)", text, flags=re.MULTILINE):
        name = re.match(r"\[(\w+)", part)
        key = name[1] if name else ""
        if part:
            tables[key] = tables.get(key, "") + part
    return tables


@pytest.mark.parametrize("number", range(len(STUDY_BLOCKS)))
def test_study_files_are_read(number: int, tmp_path: Path) -> None:
    """Each study file of a page, and the first with tables replaced, is one without faults."""
    block = STUDY_BLOCKS[number]
    tables = tables_of(block) if "verb" in block else tables_of(STUDY_BLOCKS[0]) | tables_of(block)
    file = tmp_path / "study.toml"
    file.write_text("".join(tables.values()), encoding="utf-8")
    assert read_study(file).study.grid.point_count > 1


def test_the_message_about_a_study_file_is_that_of_the_guide(tmp_path: Path) -> None:
    """Law: what the page says of two mistakes is what is said."""
    text = (DOCS / "how-to" / "studies.md").read_text("utf-8")
    shown = re.search(r"^```text\n(.*?)\n```$", text, re.MULTILINE | re.DOTALL)
    assert shown
    wrong = STUDY_BLOCKS[0].replace("periods = 500", "periods = 50")
    wrong = wrong.replace("omega = 1.25", "omega = 1.25\nomgea = 1.25")
    file = tmp_path / "chart.toml"
    file.write_text(wrong, encoding="utf-8")
    with pytest.raises(rm.RemanentError) as raised:
        read_study(file)
    assert str(raised.value) == shown[1]


def test_every_public_name_belongs_to_a_family() -> None:
    """The reference is made from the families of the stub: each public name is in one."""
    stub = Path(str(rm.__file__)).with_suffix(".pyi").read_text("utf-8")
    listed = re.findall(r"^from \S+ import (\w+) as \1$", stub.split("# Family: ", 1)[1], re.M)
    assert sorted(listed) == sorted(set(rm.__all__) - {"plot", "__version__"})


def test_makefile_commands_of_the_readme_exist() -> None:
    """Every ``make`` target that the README names is in the Makefile."""
    readme = (ROOT / "README.md").read_text("utf-8")
    named = set(re.findall(r"(?:^|`)make ([a-z-]+)", readme, re.M))
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    assert named
    assert named <= targets


def test_verbs_without_over_are_listed() -> None:
    """The page names exactly the verbs of a system that do not take ``over``."""
    text = (DOCS / "how-to" / "many-parameters.md").read_text("utf-8")
    listed = re.search(r"do not take `over`:\n((?:\|.*\n|\n)+)", text)
    named = set(re.findall(r"^\| `(\w+)` \|", listed[1] if listed else "", re.M))
    verbs = {name: getattr(rm, name) for name in rm.__all__}
    signatures = {n: inspect.signature(f) for n, f in verbs.items() if inspect.isfunction(f)}
    of_systems = {
        name
        for name, signature in signatures.items()
        if next(iter(signature.parameters), "") in ("actuator", "system")
    }
    without = {name for name in of_systems if "over" not in signatures[name].parameters}
    assert len(of_systems) > 20
    assert named == without


def test_the_window_of_instability_is_found() -> None:
    """The two doublings that the page on orbits gives are in the response diagram."""
    text = (DOCS / "how-to" / "orbits.md").read_text("utf-8")
    window = re.search(r"window of\s+instability between ω = (0\.\d+) and (0\.\d+)", text)
    assert window
    diagram = rm.response_diagram(
        rm.Actuator(temperature=350), rm.SineSquared(b=0.4, omega=1.0), (0.87, 0.9)
    )
    assert diagram.special_kind.values.tolist() == ["period doubling"] * 2
    found = np.sort(diagram.special_omega.values)
    assert found == pytest.approx([float(window[1]), float(window[2])], abs=5e-7)


#: Laws by name, with the test files that hold them.
LAWS = {
    section.split("\n", 1)[0]: re.findall(r"`(tests/[\w/]+\.py)`", section)
    for section in re.split(r"^## ", (DOCS / "explanation/laws.md").read_text("utf-8"), flags=re.M)
    if "*Held by:*" in section
}


@pytest.mark.parametrize("law", LAWS)
def test_laws_are_held_by_the_tests_listed(law: str) -> None:
    """The files listed for a law are those that cite it by its name."""
    cited = re.compile(rf'"""{law}:|# Law: {law}\b|[Ll]aws?: (?:[\w\' ]+, )*{law}\b')
    citing = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "tests").rglob("*.py")
        if path != Path(__file__) and cited.search(path.read_text("utf-8"))
    }
    assert citing == set(LAWS[law])


@pytest.mark.parametrize("page", ["docs/design.md", "docs/explanation/measurements.md"])
def test_files_that_pages_name_exist(page: str) -> None:
    """Paths in backticks are in the package or at the top of the repository."""
    text = (ROOT / page).read_text("utf-8")
    named = set(re.findall(r"`([\w./-]+(?:\.pyi?|\.md|/))`", text))
    assert named
    package = ROOT / "src" / "remanent"
    missing = [name for name in named if not ((package / name).exists() or (ROOT / name).exists())]
    assert not missing


def test_the_article_is_named() -> None:
    """Pages write the article's title or its key, not "the paper"."""
    vague = re.compile(r"\b[Tt]he paper\b")
    assert len(PAGES) > 10
    assert not [str(page) for page in PAGES if vague.search(page.read_text("utf-8"))]


#: Words in backticks that are neither public names, nor arguments, nor variables of results.
LABELS = {"stable", "unstable", "elliptic", "saddle", "undecided", "unbounded"}
LABELS |= {"periodic", "chaotic", "escaped", "invalid", "horizon", "incomplete", "timeout"}
LABELS |= {"failed"}
#: Languages, and names in exported text.
LABELS |= {
    "python",
    "matlab",
    "julia",
    "c",
    "auto07p",
    "javascript",
    "new",
    "breaks",
    "remanent_load",
}
LABELS |= {"remanent_parameters", "state_names", "remanent_run", "t", "y"}
#: Keys of study files, and attributes and variables of stores.
LABELS |= {"point_seconds", "flag_values", "flag_meanings", "orbit_length"}
OUTSIDE = {
    "sqrt",
    "exp",
    "log",
    "sin",
    "cos",
    "pi",
    "pint",
    "xarray",
    "from_si",
    "in_unit",
    "mixed",
    "ax",
    "dpi",
}


#: Words of Python, MATLAB and their packages that the tutorials explain.
LANGUAGES = {
    *("import", "print", "py", "python", "nan", "end", "try", "except", "catch", "struct"),
    *("dictionary", "plt", "np", "linspace", "plot", "saveas", "savefig", "xlabel", "legend"),
    *("isel", "sel", "film", "remanent", "cd", "k", "x", "venv", "q"),
}


def own_text_of(page: Path) -> str:
    """A page without what it prints, and without the words of other tools in its tables."""
    text = page.read_text("utf-8")
    text = re.sub(r"^```output\n.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    if page.name.startswith("tutorial"):
        return re.sub(r"^\|.*", "", text, flags=re.MULTILINE)
    is_about_others = page.name.startswith("coming-from-")
    return re.sub(r"^\|[^|]*", "", text, flags=re.MULTILINE) if is_about_others else text


def test_words_in_backticks_are_names() -> None:
    """Guides name what exists: public names, their arguments, variables, values of labels."""
    names = (
        LABELS
        | OUTSIDE
        | LANGUAGES
        | set(rm.__all__)
        | set(DESCRIPTIONS)
        | {f"{name}_error" for name in DESCRIPTIONS}
        | {name for name in dir(rm.Actuator) if not name.startswith("_")}
        | set(PACKAGES_OF_EXTRA)
    )
    values: list[Any] = [getattr(rm, name) for name in rm.__all__]
    for value in values:
        has_arguments = inspect.isfunction(value) or dataclasses.is_dataclass(value)
        if has_arguments:
            names |= set(inspect.signature(value).parameters)
    guides = [
        *(DOCS / "how-to").glob("*.md"),
        *DOCS.glob("tutorial*.md"),
        *(DOCS / f"{name}.md" for name in ("getting-started", "model")),
    ]
    code = "\n".join(text for page in guides for text in blocks_of(page, "python"))
    words = {word for page in guides for word in re.findall(r"`([a-z_]+)`", own_text_of(page))}
    assert len(words & names) > 50
    unknown = {word for word in words - names if not re.search(rf"^{word} = ", code, re.MULTILINE)}
    assert not unknown
