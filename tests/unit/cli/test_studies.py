"""Stores: a researcher's path, from a new study to its picture and its file."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr
from distributed import LocalCluster

import remanent as rm
from remanent.cli import main
from remanent.studies.sweep.study_file import read_study

#: A process that is started in the background is born deaf to interrupts.
_INTERRUPTIBLE = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from remanent.cli import main; main()"
)


def remanent(*arguments: str, folder: Path) -> subprocess.Popen[str]:
    """The command, in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", _INTERRUPTIBLE, *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip


def done(*arguments: str, folder: Path) -> tuple[int, str]:
    """Its exit status and what it said."""
    process = remanent(*arguments, folder=folder)
    out, err = process.communicate(timeout=300)
    return process.returncode, out + err


def broken_off(number: signal.Signals, folder: Path) -> tuple[int, str, float]:
    """A run that is sent a signal once it tells how far it is; how long it took to end."""
    process = remanent("run", "mine.toml", folder=folder)
    assert process.stderr is not None
    first = process.stderr.readline()
    begin = time.monotonic()
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    return process.returncode, first + out + err, time.monotonic() - begin


@pytest.mark.parametrize(
    ("number", "expected"),
    [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow)],
)
def test_from_a_new_file_to_netcdf(number: signal.Signals, expected: int, tmp_path: Path) -> None:
    """The numbers in the file at the end are those of the verb, whatever happened on the way."""
    code, told = done("new", "mine", folder=tmp_path)
    assert code == 0, told
    file = tmp_path / "mine.toml"
    text = file.read_text()
    assert re.search(r"count = \d+", text)
    assert "periods = 200" in text
    text = re.sub(r"count = \d+", "count = 45", text).replace("periods = 200", "periods = 100")
    file.write_text(text)

    code, told = done("run", "mine.toml", "--dry-run", folder=tmp_path)
    assert code == 0, told
    assert "2,025 points" in told
    assert list(tmp_path.iterdir()) == [file]

    code, told, seconds = broken_off(number, tmp_path)
    assert code == expected, told
    assert "the same command goes on from there" in told
    assert seconds < 5.0
    code, told = done("verify", "mine.zarr", folder=tmp_path)
    assert code == 3, told

    code, told = done("run", "mine.toml", folder=tmp_path)
    assert code == 0, told
    code, told = done("verify", "mine.zarr", folder=tmp_path)
    assert (code, told) == (0, "whole and complete: 5 of 5 chunks\n")

    code, told = done("show", "mine.zarr", "--out", "mine.pdf", folder=tmp_path)
    assert code == 0, told
    assert (tmp_path / "mine.pdf").read_bytes().startswith(b"%PDF")

    loaded = rm.load(tmp_path / "mine.zarr")
    rows = slice(15, 30)  # of three chunks
    again = read_study(file).study.result_of((rows, slice(None)))
    xr.testing.assert_equal(loaded.isel(b=rows), again)
    rm.save(loaded, tmp_path / "mine.nc")
    xr.testing.assert_equal(rm.load(tmp_path / "mine.nc"), loaded)


@pytest.mark.slow
def test_a_running_scheduler_computes_a_study(tmp_path: Path) -> None:
    """Whose workers are elsewhere, and see the same folder."""
    assert done("new", "mine", folder=tmp_path)[0] == 0
    with LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0",
        silence_logs=50,
    ) as cluster:  # fmt: skip
        address = cluster.scheduler_address
        code, told = done("run", "mine.toml", "--scheduler", address, folder=tmp_path)
    assert code == 0, told
    study = read_study(tmp_path / "mine.toml").study
    xr.testing.assert_equal(rm.load(tmp_path / "mine.zarr"), study.result_of(study.grid.whole))


def test_what_is_wrong_with_a_command_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a traceback, with the rule."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["remanent", "new", "mine"])
    main()
    cases = {
        ("run", "mine.toml", "--part", "5/4"): "with I from 1 to N",
        ("run", "mine.toml", "--workers", "1000"): "be from 1 to",
        ("run", "mine.toml", "--workers", "1", "--scheduler", "tcp://127.0.0.1:1"): "not both",
        ("run", "mine.toml", "--out", "mine.toml"): "be a folder, or not exist yet",
        ("run", "mine.toml", "--out", "."): "There are other files in it",
        ("verify", "."): "be a store of a study",
        ("show", "."): "end in one of",
    }
    for arguments, words in cases.items():
        monkeypatch.setattr(sys, "argv", ["remanent", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code not in (0, 130), arguments
        told = capsys.readouterr().err
        assert words in told, (arguments, told)
