"""The code of the pages runs, prints and draws what they show; no other block is left out."""

from __future__ import annotations

import os
import re
import shlex
import sys
from pathlib import Path

import click
import dask.config
import numpy as np
import pytest
from scipy.io import loadmat

import remanent as rm
from docs import pages
from remanent.cli.main import commands
from tests.contracts.tools import require_program, run_octave, run_program
from tests.repetitions import fast_and_slow

ROOT = Path(__file__).parents[2]
STATIC = ROOT / "docs" / "_static"
TEXTS = {page: (ROOT / page).read_text("utf-8") for page in pages.page_names()}
LISTED = [(page, block) for page, text in TEXTS.items() for block in pages.blocks_of(text)]
#: Pages that take seconds each, most of it to compile; the slow tests run them.
LONG = {
    *(f"docs/how-to/{name}.md" for name in (
        "basins", "coming-from-dynamicalsystems", "commands", "fitting", "materials", "orbits",
        "own-systems", "resonance", "sensitivity", "uncertainty",
    )),
    *(f"docs/explanation/{name}.md" for name in ("balloon", "heat", "two-directions", "viscosity")),
}  # fmt: skip
RUNNING = pages.pages_with_code()


def blocks_of(page: str, language: str) -> list[pages.Block]:
    """The blocks of a page in one language."""
    return [block for block in pages.blocks_of(TEXTS[page]) if block.language == language]


@pytest.mark.parametrize("page", fast_and_slow(RUNNING, slow=LONG))
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
    for block in blocks_of(page, "matlab"):
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
        ("a b", "a\nb", False),
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
    (
        "docs/design.md",
        "parameters → energies, equations of motion → vector field → trajectories",
    ): ("a sketch"),
    (
        "docs/reference/explorer-security.md",
        "Content-Security-Policy: default-src 'self'; img-src",
    ): ("shortened; the headers are those of tests/faults/test_explorer_access.py"),
    ("docs/how-to/export.md", "$ octave"): "Octave at its prompt; the script runs below",
    ("docs/how-to/export.md", "$ auto-07p"): (
        "AUTO at its prompt; tests/contracts/test_continued_by_auto.py runs such files"
    ),
    ("docs/how-to/export.md", "$ export AUTO_DIR="): "the same without Python",
    ("docs/how-to/slurm.md", "from dask_jobqueue import SLURMCluster"): "needs Slurm",
    (
        "docs/how-to/slurm.md",
        "from dask_kubernetes.operator import KubeCluster",
    ): "needs Kubernetes",
}
#: Languages whose blocks are looked at by a test of this file.
CHECKED = {"python", "output", "console", "toml", "bash", "yaml", "c", "javascript", "matlab"}


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
        key
        for key in NOT_RUN
        if not any(p == key[0] and b.text.startswith(key[1]) for p, b in LISTED)
    }
    assert not unused
    # Each line that opens or closes a block is one that was seen.
    fences = sum(len(re.findall(r"^\s*(?:```|~~~)", text, re.M)) for text in TEXTS.values())
    assert fences == 2 * len(LISTED)


@pytest.mark.parametrize("page", [p for p, text in TEXTS.items() if "```output" in text])
def test_every_output_has_its_block(page: str) -> None:
    """An output stands directly under the Python that prints it."""
    shown = [block for _, block in pages.outputs_of(TEXTS[page]) if block]
    assert shown == blocks_of(page, "output")


#: Pictures that are not drawn by the page that shows them, and what draws them.
DRAWN_BY = {
    "balloon-resonances.png": "docs/make_balloon.py",
    "balloon-statics.png": "docs/make_balloon.py",
    "balloon-viscosity.png": "docs/make_balloon.py",
    "heat.png": "docs/make_explanations.py",
    "viscosity.png": "docs/make_explanations.py",
    "two-directions.png": "docs/make_explanations.py",
    "error-bound.png": "docs/make_explanations.py",
    "limits.png": "docs/make_explanations.py",
    "magnetisation.png": "docs/make_explanations.py",
    "regimes.png": "docs/make_explanations.py",
    "tolerance.png": "docs/make_explanations.py",
    "explorer.png": "a screenshot",
    "pendulum-regimes.png": "docs/how-to/own-systems.md, on the finer grid that it names",
}


def test_every_picture_is_drawn_by_something() -> None:
    """Pictures in `_static` are drawn by the page in whose folder they are, or are listed."""
    files = {p.relative_to(STATIC).as_posix() for p in STATIC.rglob("*.png")}
    drawn = {
        picture.relative_to(STATIC).as_posix()
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


#: A study like that of the page, with fewer points.
FEWER = {"count = 200": "count = 4", "periods = 500": "periods = 100"}


@pytest.mark.slow
def test_the_array_script_fills_one_store(tmp_path: Path) -> None:
    """Jobs of the script, one after the other, make the store that one run makes."""
    (study,) = blocks_of("docs/how-to/slurm.md", "toml")
    (script,) = blocks_of("docs/how-to/slurm.md", "bash")
    text = study.text
    for many, few in FEWER.items():
        assert many in text
        text = text.replace(many, few)
    for name, content in {
        "chart.toml": text,
        "whole.toml": text.replace("chart.zarr", "whole.zarr"),
        "chart.sh": script.text,
        "venv/bin/activate": "",
        "bin/srun": '#!/bin/sh\nexec "$@"\n',
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    (tmp_path / "bin/srun").chmod(0o755)
    programs = f"{tmp_path / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    array = {"PATH": programs, "SLURM_CPUS_PER_TASK": "1", "SLURM_ARRAY_TASK_MAX": "3"}
    for job in ("2", "3", "1"):
        run_program(["bash", "chart.sh"], tmp_path, SLURM_ARRAY_TASK_ID=job, **array)
    run_program(["remanent", "verify", "chart.zarr"], tmp_path, **array)
    run_program(["remanent", "run", "whole.toml"], tmp_path, **array)
    assert rm.load(tmp_path / "chart.zarr").identical(rm.load(tmp_path / "whole.zarr"))


def test_settings_of_dask_exist() -> None:
    """The page sets what Dask has under these names."""
    (block,) = blocks_of("docs/how-to/slurm.md", "yaml")
    import distributed  # noqa: F401  # adds its settings

    assert block.text.split("\n")[0] == "distributed:"
    assert dask.config.get("distributed.worker.profile.enabled") is True
    assert "MALLOC_TRIM_THRESHOLD_" in dask.config.get("distributed.nanny.pre-spawn-environ")
    assert "worker: {profile: {enabled: false}}" in block.text
    assert "nanny: {pre-spawn-environ: {MALLOC_TRIM_THRESHOLD_: null}}" in block.text


@pytest.mark.slow
def test_other_tools_run_what_the_export_guide_shows(tmp_path: Path) -> None:
    """C, JavaScript and Octave, called as on the page, give the rates and the motion."""
    page = "docs/how-to/export.md"
    actuator = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.1))
    drive = rm.SineSquared(0.4, 1.25)
    for language in ("c", "javascript", "matlab"):
        for name, text in rm.export(actuator, drive, language).items():
            (tmp_path / name).write_text(text)
    for language, name in {"c": "main.c", "javascript": "main.mjs"}.items():
        (block,) = blocks_of(page, language)
        (tmp_path / name).write_text(block.text)
    shell = require_program("bash")
    lines = [line for place, line in command_lines() if place.startswith(page)]
    printed = [run_program([shell, "-c", line], tmp_path) for line in lines]
    rates = rm.rates(actuator, drive)(0.3, np.array([1.0, 0.0]))
    for text in (printed[0], printed[-1]):
        numbers = re.findall(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?", text)[-2:]
        assert [float(n) for n in numbers] == pytest.approx(rates.tolist(), abs=1e-12)
    (block,) = blocks_of(page, "matlab")
    (tmp_path / "guide.m").write_text(block.text + 'printf("%.17g %.17g\\n", y(end, :))\n')
    shown = [float(n) for n in run_octave("guide.m", tmp_path).split()[-2:]]
    warmer = rm.simulate(actuator.replace(temperature=330), drive, times=[20.0], initial=(1.1, 0.0))
    expected = [float(warmer.stretch[0]), float(warmer.stretch_rate[0])]
    assert shown == pytest.approx(expected, abs=1e-4)
