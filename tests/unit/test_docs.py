"""What the README and the pages of the site show is true: names, files, figures and code."""

from __future__ import annotations

import dataclasses
import inspect
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from scipy.io import loadmat

import remanent as rm
from docs import pages
from remanent.cli.main import commands
from remanent.results.schema import DESCRIPTIONS
from remanent.studies.sweep.study_file import read_study

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: Pages by their path; the parts that CONTRIBUTING.md adds run in `tests/contracts/test_new_parts.py`.
TEXTS = {page: (ROOT / page).read_text("utf-8") for page in pages.page_names()}
OWN_TESTS = {"CONTRIBUTING.md": "tests/contracts/test_new_parts.py"}
PAGES = [ROOT / page for page in TEXTS if page not in OWN_TESTS]


def blocks_of(page: Path, language: str = "python") -> list[pages.Block]:
    """The blocks of a page in one language."""
    return [b for b in pages.blocks_of(page.read_text("utf-8")) if b.language == language]


@pytest.mark.parametrize(
    "page", [p for p, text in TEXTS.items() if pages.outputs_of(text) and p not in OWN_TESTS]
)
def test_code_runs(page: str, tmp_path: Path) -> None:
    """The Python blocks of a page run in order, in an empty folder, without a warning.

    What is shown under a block is what it prints, and nothing that it prints is left out; the
    pictures that the page shows as its own are those that it draws; what it gives to MATLAB holds
    the names that its lines of MATLAB use.
    """
    text = TEXTS[page]
    printed = pages.run_blocks(page, [block for block, _ in pages.outputs_of(text)], tmp_path)
    for (block, shown), out in zip(pages.outputs_of(text), printed, strict=True):
        what = f"`python -m docs.pages {page}` writes what {page}:{block.line} prints:\n{out}"
        assert pages.output_agrees(shown, out), what
    for picture, name in pages.pictures_of(page, text).items():
        difference = pages.difference_of(picture, tmp_path / name)
        assert difference <= pages.PICTURES_AGREE, f"`python -m docs.pages {page}` draws {name}"
    for block in blocks_of(ROOT / page, "matlab"):
        for file in re.findall(r'load\("([\w.-]+)"\)', block.text):
            lines = re.sub(r'"[^"]*"|\'[^\']*\'|%.*', "", block.text)
            assert set(re.findall(r"[a-z]\w*", lines)) <= MATLAB | set(loadmat(tmp_path / file))


#: Functions of MATLAB on pages that also load a result.
MATLAB = {"load", "plot", "xlabel", "ylabel"}


def test_a_failing_block_is_named(tmp_path: Path) -> None:
    """The error says at which line the block starts; the traceback, which line failed."""
    blocks = pages.blocks_of("\n```python\nx = 1\n```\n\n\n```python\ny = x\nz = y / 0\n```\n")
    with pytest.raises(ZeroDivisionError) as raised:
        pages.run_blocks("page.md", blocks, tmp_path)
    assert raised.value.__notes__ == ["the block at page.md:8 failed"]
    assert raised.traceback[-1].lineno == 8
    assert str(raised.traceback[-1].path).endswith("page.md")


@pytest.mark.parametrize(
    ("shown", "printed", "agree"),
    [
        ("a 1.2345678", "a  1.2345679\n", True),  # to 1e-6
        ("a 1.2345678", "a 1.2345778", False),
        ("1.25", "1.26", True),  # one unit of the last of three digits
        ("1.25", "1.27", False),
        ("1.2", "1.3", False),
        ("3", "4", False),
        ("3", "3.0", False),
        ("3.1e-08", "5.9e-08", True),  # an error, to a factor of two
        ("3.1e-08", "6.9e-08", False),
        ("3.1e-08", "-3.1e-08", False),
        ("-2e-14 stable", "3e-16 stable", True),  # rounding
        ("-2e-14 stable", "3e-16 saddle", False),
        ("[1.5 nan]", "[1.5 1.5]", False),
        ("0.1.0", "0.1.1", False),  # a version
        ("a\n...\nd", "a\nb\nc\nd", True),
        ("a\n...\nd", "a\nb\nc", False),
        ("a\n...\nc\n...\nd", "a\nb\nc\nd", True),
        ("a\n...\ne\n...\nd", "a\nb\nc\nd", False),
        ("a b", "a", False),
        ("", "a", False),
    ],
)
def test_when_outputs_agree(shown: str, printed: str, agree: bool) -> None:
    """Words and whole numbers are equal, results to six digits, errors to a factor of two."""
    assert pages.texts_agree(shown, printed) is agree


def test_outputs_are_written_under_their_blocks() -> None:
    """A page is written only where an output is missing, differs, or is too much."""
    page = "```python\nprint(1.5)\n```\n\nText.\n\n```python\nx = 1\n```\n\n```output\nold\n```\n"
    once = pages.with_outputs(page, ["1.5\n", ""])
    assert once == (
        "```python\nprint(1.5)\n```\n\n```output\n1.5\n```\n\nText.\n\n```python\nx = 1\n```\n"
    )
    assert pages.with_outputs(once, ["1.5000001\n", ""]) == once


#: Blocks that no test runs or checks, by their page and first line, and why.
NOT_RUN = {
    ("docs/design.md", "parameters → energies, equations of motion → vector field → trajectories"): (
        "a sketch"
    ),
    ("docs/reference/explorer-security.md", "Content-Security-Policy: default-src 'self'; img-src"): (
        "shortened; the headers are those of tests/faults/test_explorer_access.py"
    ),
    ("docs/how-to/export.md", "$ octave"): "Octave at its prompt; the script is run below",
    ("docs/how-to/export.md", "$ auto-07p"): (
        "AUTO at its prompt; tests/contracts/test_continued_by_auto.py runs such files"
    ),
    ("docs/how-to/export.md", "$ export AUTO_DIR="): "the same without Python",
    ("docs/how-to/slurm.md", "from dask_jobqueue import SLURMCluster"): "needs Slurm",
    ("docs/how-to/slurm.md", "from dask_kubernetes.operator import KubeCluster"): "needs Kubernetes",
}
#: Languages whose blocks are looked at by a test of this file.
CHECKED = {"python", "output", "console", "toml", "bash", "yaml", "c", "javascript", "matlab"}
LISTED = [(page, block) for page, text in TEXTS.items() for block in pages.blocks_of(text)]


def is_not_run(page: str, block: pages.Block) -> bool:
    """Whether a block is one of those that no test looks at."""
    return any(page == name and block.text.startswith(line) for name, line in NOT_RUN)


def test_every_block_is_accounted_for() -> None:
    """Each block has a language that a test looks at, is one of Sphinx's, or is listed."""
    unlisted = [
        f"{page}:{block.line}"
        for page, block in LISTED
        if block.language not in CHECKED
        and not re.fullmatch(r"\{[a-z-]+\}", block.language)
        and not is_not_run(page, block)
        and not block.text.startswith("chart.toml has 2 faults")  # compared below
    ]
    assert len(LISTED) > 150
    assert not unlisted
    unused = {
        key for key in NOT_RUN if not any(p == key[0] and b.text.startswith(key[1]) for p, b in LISTED)
    }
    assert not unused
    # Each line that opens or closes a block is one that was seen.
    fences = sum(len(re.findall(r"^\s*(?:```|~~~)", text, re.M)) for text in TEXTS.values())
    assert fences == 2 * len(LISTED)


@pytest.mark.parametrize("page", [p for p, text in TEXTS.items() if "```output" in text])
def test_every_output_has_its_block(page: str) -> None:
    """An output stands directly under the Python that prints it."""
    shown = [block for _, block in pages.outputs_of(TEXTS[page]) if block]
    assert shown == blocks_of(ROOT / page, "output")


#: Pictures that are not drawn by the page that shows them, and what draws them.
DRAWN_BY = {
    "balloon-resonances.png": "docs/make_balloon.py",
    "balloon-statics.png": "docs/make_balloon.py",
    "balloon-viscosity.png": "docs/make_balloon.py",
    "heat.png": "docs/make_explanations.py",
    "viscosity.png": "docs/make_explanations.py",
    "two-directions.png": "docs/make_explanations.py",
    "explorer.png": "a screenshot",
    "pendulum.png": "",
    "pendulum-regimes.png": "",
}


def test_every_picture_is_drawn_by_something() -> None:
    """Pictures in `_static` are drawn by the page in whose folder they are, or are listed."""
    files = {p.relative_to(DOCS / "_static").as_posix() for p in (DOCS / "_static").rglob("*.png")}
    drawn = {
        picture.relative_to(DOCS / "_static").as_posix()
        for page, text in TEXTS.items()
        for picture in pages.pictures_of(page, text)
    }
    assert files == drawn | set(DRAWN_BY)


def command_lines() -> list[tuple[str, str]]:
    """Each line for a shell on a page, without prompt and comment."""
    return [
        (f"{page}:{block.line}", line.removeprefix("$ ").split("  #")[0].strip())
        for page, block in LISTED
        if block.language in ("console", "bash") and not is_not_run(page, block)
        for line in block.text.splitlines()
        if block.language == "bash" or line.startswith("$ ") or "$ " not in block.text
    ]


def parse_command(words: list[str]) -> None:
    """Parse a line of `remanent`, without running it."""
    with commands.make_context("remanent", words[1:2], allow_extra_args=True) as context:
        _, command, _ = commands.resolve_command(context, words[1:])
        assert command is not None
        command.make_context(words[1], words[2:], parent=context).close()


#: Programs of shells, of Python, of Slurm and of the export guide, which pages call.
OTHER_PROGRAMS = {"cd", "mkdir", "source", "python3", "py", "sbatch", "squeue", "cc", "cp", "node"}


@pytest.mark.parametrize(("place", "line"), command_lines())
def test_command_lines_are_understood(
    place: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Commands, targets, extras and options exist; nothing is run."""
    monkeypatch.chdir(tmp_path)
    for name in re.findall(r"\b[\w-]+\.(?:toml|zarr)\b", line):
        (tmp_path / name).mkdir() if name.endswith("zarr") else (tmp_path / name).touch()
    shares = {"$SLURM_ARRAY_TASK_ID": "3", "$SLURM_ARRAY_TASK_MAX": "32"}
    words = shlex.split(re.sub(r"\$\w+", lambda m: shares.get(m[0], m[0]), line), comments=True)
    if words[:1] == ["srun"]:
        words = words[1:]
    match words:
        case [] | ["export", _]:
            assert "bash" in place or place.startswith("docs/how-to/slurm.md")
        case ["remanent", *_]:
            parse_command(words)
        case ["make", target]:
            assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text("utf-8"), re.M)
        case ["pip", "install", what] | ["python", "-m", "pip", "install", what]:
            asked = re.search(r"\[(\w+)\]$", what)
            extras = re.findall(r"^(\w+) = \[", (ROOT / "pyproject.toml").read_text("utf-8"), re.M)
            assert asked is None or asked[1] in extras
        case ["python", file]:
            assert file.endswith(".py")
        case [program, *_]:
            assert program in OTHER_PROGRAMS or program.endswith("Activate.ps1"), place


def test_a_wrong_command_line_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An option that does not exist is refused."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chart.toml").touch()
    with pytest.raises(click.NoSuchOption):
        parse_command(["remanent", "run", "chart.toml", "--dry"])
    with pytest.raises(click.UsageError):
        parse_command(["remanent", "compute", "chart.toml"])


#: Study files by their page; those without a verb change some tables of the first.
STUDY_BLOCKS = [(p, b.text) for p, b in LISTED if b.language == "toml"]
FIRST_STUDY = next(text for page, text in STUDY_BLOCKS if page == "docs/how-to/studies.md")


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
    _, block = STUDY_BLOCKS[number]
    tables = tables_of(block) if "verb" in block else tables_of(FIRST_STUDY) | tables_of(block)
    file = tmp_path / "study.toml"
    file.write_text("".join(tables.values()), encoding="utf-8")
    assert read_study(file).study.grid.point_count > 1


def test_the_message_about_a_study_file_is_that_of_the_guide(tmp_path: Path) -> None:
    """Law: what the page says of two mistakes is what is said."""
    text = (DOCS / "how-to" / "studies.md").read_text("utf-8")
    shown = re.search(r"^```text\n(.*?)\n```$", text, re.MULTILINE | re.DOTALL)
    assert shown
    wrong = FIRST_STUDY.replace("periods = 500", "periods = 50")
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
    assert "<!-- The families of public names " in (DOCS / "reference.md").read_text("utf-8")


def test_reference_lists_every_status() -> None:
    """The table of status codes has each code once, with its flag and its sentence."""
    text = (DOCS / "reference.md").read_text("utf-8")
    rows = re.findall(r"^\| (\d+) \| `([a-z-]+)` \| (.*) \|$", text, re.M)
    assert rows == [(str(s.value), s.meaning, s.explanation) for s in rm.Status]


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


def own_text_of(page: Path) -> str:
    """A page without the first column of the tables that list the words of other tools."""
    text = page.read_text("utf-8")
    is_about_others = page.name.startswith("coming-from-")
    return re.sub(r"^\|[^|]*", "", text, flags=re.MULTILINE) if is_about_others else text


def test_words_in_backticks_are_names() -> None:
    """Guides name what exists: public names, their arguments, variables, values of labels."""
    names = (
        LABELS
        | OUTSIDE
        | set(rm.__all__)
        | set(DESCRIPTIONS)
        | {f"{name}_error" for name in DESCRIPTIONS}
    )
    values: list[Any] = [getattr(rm, name) for name in rm.__all__]
    for value in values:
        has_arguments = inspect.isfunction(value) or dataclasses.is_dataclass(value)
        if has_arguments:
            names |= set(inspect.signature(value).parameters)
    guides = [
        *(DOCS / "how-to").glob("*.md"),
        *(DOCS / f"{name}.md" for name in ("tutorial", "getting-started", "model")),
    ]
    code = "\n".join(block.text for page in guides for block in blocks_of(page))
    words = {word for page in guides for word in re.findall(r"`([a-z_]+)`", own_text_of(page))}
    assert len(words & names) > 50
    unknown = {word for word in words - names if not re.search(rf"^{word} = ", code, re.MULTILINE)}
    assert not unknown
