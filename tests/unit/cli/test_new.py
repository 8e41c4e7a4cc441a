"""`remanent new` writes a file that is a study, small enough to be run at once."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from remanent._errors import InputError
from remanent.cli import main
from remanent.cli.main import commands
from remanent.studies.sweep.study_file import read_study


def new(*arguments: str) -> Result:
    return CliRunner().invoke(commands, ["new", *arguments])


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "file"),
    [((), "study.toml"), (("chart",), "chart.toml"), (("chart.toml",), "chart.toml")],
)
def test_the_file_is_a_study(arguments: tuple[str, ...], file: str) -> None:
    """It reads back without a fault, stores beside itself, and every point has a regime."""
    result = new(*arguments)
    assert result.exit_code == 0
    assert file in result.output
    found = read_study(file)
    assert found.store == Path(file).with_suffix(".zarr")
    assert found.study.grid.point_count == 384
    regimes = found.study.result_over(found.study.over)
    assert (regimes["status"] != 0).all()


def test_what_is_commented_out_is_a_study_too() -> None:
    """The alternatives in the comments are sound where they are put in place."""
    new()
    text = Path("study.toml").read_text("utf-8")
    written = re.sub(r"^# ((?:\[|\w+ =|\"[\w.]+\" =).*)$", r"\1", text, flags=re.MULTILINE)
    written = re.sub(r"^c = .*\n", "", written, flags=re.MULTILINE)
    assert tomllib.loads(written) != tomllib.loads(text)
    box = "ranges = { b = [0.2, 1.0], omega = [0.8, 2.0] }"
    assert box in written
    written = written.replace(box, "ranges = { phase = [0.0, 1.0] }")
    Path("study.toml").write_text(written, "utf-8")
    found = read_study("study.toml").study
    assert {*found.over} >= {"b", "omega", "dissipation.0.eta", "temperature", "prestress", "phase"}


def test_nothing_is_written_over() -> None:
    """A second call is refused, and the first file stays as it is."""
    new("chart")
    Path("chart.toml").write_text("mine", "utf-8")
    result = new("chart")
    assert isinstance(result.exception, InputError)
    assert "free" in str(result.exception)
    assert Path("chart.toml").read_text("utf-8") == "mine"


@pytest.mark.parametrize("name", ['a"b', "a\\b", "a\nb"])
def test_names_that_break_the_file_are_refused(name: str, tmp_path: Path) -> None:
    """The name of the store stands in quotes in the file."""
    assert isinstance(new(name).exception, InputError)
    assert not list(tmp_path.iterdir())


def test_failures_are_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command says what is wrong on standard error and exits with 1."""
    new("chart")
    monkeypatch.setattr("sys.argv", ["remanent", "new", "chart"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    assert capsys.readouterr().err.startswith("remanent: `NAME` must be a name that is free")
