"""Commands whose packages are not installed say how to get them."""

from __future__ import annotations

import re
import sys
import tomllib
from importlib.util import find_spec as really_find
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import remanent as rm
from remanent import _extras
from remanent.cli.main import commands

ROOT = Path(__file__).parents[2]


def test_extras_are_those_of_the_installation() -> None:
    """Law: what is asked for by name is what the extra installs."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    for extra, packages in _extras.PACKAGES_OF_EXTRA.items():
        installed = [re.split(r"[^\w-]", text)[0] for text in extras[extra]]
        assert tuple(installed) == packages
    assert extras["all"] == [f"remanent[{','.join(sorted(_extras.PACKAGES_OF_EXTRA))}]"]


@pytest.mark.parametrize("extra", _extras.PACKAGES_OF_EXTRA)
def test_what_is_missing_is_named(extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the one command that mends it."""
    _extras.require_extra(extra, "this")
    gone = _extras.PACKAGES_OF_EXTRA[extra][0]

    def find(name: str) -> Any:
        return None if name == gone else really_find(name)

    monkeypatch.setattr(_extras, "find_spec", find)
    words = rf"^This needs {gone}\. Install it with `pip install 'remanent\[{extra}\]'`\.$"
    with pytest.raises(rm.RemanentError, match=words):
        _extras.require_extra(extra, "this")


#: Two points that take no time.
STUDY = """
verb = "cycle_losses"
store = "chart.zarr"
[actuator]
[drive]
kind = "Sine"
m = 0.1
omega = 1.2
[over]
temperature = [300.0, 350.0]
[options]
periods = 1
"""


def test_only_stores_need_what_writes_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A study is planned, and computed into memory, by the core alone."""
    monkeypatch.setitem(sys.modules, "zarr", None)
    monkeypatch.setattr(_extras, "find_spec", lambda name: None if name == "zarr" else name)
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(commands, ["new", "mine"]).exit_code == 0
    (tmp_path / "chart.toml").write_text(STUDY, "utf-8")
    assert CliRunner().invoke(commands, ["run", "chart.toml", "--dry-run"]).exit_code == 0
    run = CliRunner().invoke(commands, ["run", "chart.toml"])
    assert "A store needs zarr. Install it with `pip install 'remanent[studies]'`." in str(
        run.exception
    )
    computed = rm.sweep(rm.Actuator(), rm.Sine(0.1, 1.2), {"m": [0.1]}, "cycle_losses", periods=1)
    assert computed.sizes["m"] == 1
    (tmp_path / "chart.zarr").mkdir()
    (tmp_path / "chart.zarr" / "zarr.json").write_text("{}", "utf-8")
    with pytest.raises(rm.RemanentError, match="A store needs zarr"):
        rm.load(tmp_path / "chart.zarr")
