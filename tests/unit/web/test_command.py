"""`remanent explore`, as it is typed."""

from __future__ import annotations

import http.client
import json
import os
import re
import signal
import socket as sockets
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from click.testing import CliRunner
from websockets.sync.client import connect
from websockets.typing import Origin

from remanent._errors import InputError
from remanent.cli.main import commands
from tests.unit.web.server import (
    LONG,
    PATIENCE,
    SPEC,
    eventually,
    is_gone,
    next_message,
    processes_below,
)

STUDY = """
verb = "classify"
[actuator]
temperature = 320.0
[drive]
kind = "SineSquared"
b = 0.3
omega = 1.1
[over]
b = [0.2, 0.4]
[options]
periods = 100
"""


@contextmanager
def command(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """The command in a process of its own, which is gone after the block."""
    code = "import sys; from remanent.cli import main; sys.argv[0] = 'remanent'; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "explore", "--no-browser", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.communicate(timeout=PATIENCE)


def address_of(process: subprocess.Popen[str]) -> tuple[str, int, str]:
    """Host, port and query of the address that the command shows."""
    assert process.stdout is not None
    found = re.match(r"http://([^:/]+):(\d+)/(\S*)", process.stdout.readline())
    assert found is not None
    return found[1], int(found[2]), found[3]


def answer(port: int, path: str, **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    try:
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        return response.status, response.read()
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 128 + signal.SIGTERM)]
)
def test_it_serves_and_ends_with_all_it_started(number: signal.Signals, code: int) -> None:
    """Law: the page is at the address that is shown; Ctrl-C and SIGTERM leave nothing, with a page
    open and a job under way."""
    with command("--port", "0") as process:
        _, port, query = address_of(process)
        assert query == ""
        status, page = answer(port, "/")
        assert status == 200
        assert b"<!doctype html>" in page.lower()
        assert answer(port, "/plotly.js")[0] == answer(port, "/api/start")[0] == 200
        origin = f"http://127.0.0.1:{port}"
        with connect(f"ws://127.0.0.1:{port}/api/jobs", origin=Origin(origin)) as socket:
            socket.send(json.dumps({"id": "a", "job": "classify", "spec": SPEC}))
            assert next_message(socket, "result", "error")["type"] == "result"
            socket.send(json.dumps(LONG))
            next_message(socket, "progress")
            family = processes_below(process.pid)
            assert len(family) >= 2
            process.send_signal(number)
            _, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == code
        assert "Traceback" not in said
        assert eventually(lambda: all(map(is_gone, family)))


def test_a_killed_server_leaves_nothing() -> None:
    """Law: processes whose server is gone end by themselves."""
    with command("--port", "0") as process:
        _, port, _ = address_of(process)
        assert answer(port, "/api/start")[0] == 200
        family = processes_below(process.pid)
        process.kill()
        assert eventually(lambda: all(map(is_gone, family)))


def test_a_study_is_what_the_page_begins_with(tmp_path: Path) -> None:
    """Law: the first model is that of the study."""
    file = tmp_path / "mine.toml"
    file.write_text(STUDY, "utf-8")
    with command("--port", "0", str(file)) as process:
        _, port, _ = address_of(process)
        status, body = answer(port, "/api/start")
        assert status == 200
        assert b'"temperature":320.0' in body.replace(b" ", b"")


def test_another_host_wants_a_token() -> None:
    """Law: where other machines can reach the page, its address has a token, and it is needed."""
    with command("--host", "0.0.0.0", "--port", "0") as process:
        _, port, query = address_of(process)
        assert re.fullmatch(r"\?token=[\w-]{32,}", query)
        assert answer(port, "/")[0] == answer(port, "/api/start")[0] == 403
        assert answer(port, f"/{query}")[0] == 303


def test_a_port_that_is_taken_is_one_line() -> None:
    """Law: it says what to do, and no server is started."""
    with sockets.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with command("--port", str(port)) as process:
            _, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 1
        assert said.startswith("remanent: `--port` must be free")
        assert "--port 0" in said
        assert len(said.splitlines()) == 1


def test_an_address_of_another_machine_is_refused() -> None:
    """Law: an address at which nothing can listen is refused by name."""
    result = CliRunner().invoke(commands, ["explore", "--no-browser", "--host", "192.0.2.1"])
    assert isinstance(result.exception, InputError)
    assert "--host" in str(result.exception)


def test_missing_packages_are_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: without the extra the command says how to install it."""
    monkeypatch.setattr("remanent._extras.find_spec", lambda _: None)
    result = CliRunner().invoke(commands, ["explore"])
    assert result.exit_code == 1
    assert str(result.exception).endswith("`pip install 'remanent[web]'`.")
    assert len(str(result.exception).splitlines()) == 1


def test_faults_of_a_study_are_told_before_anything_starts(tmp_path: Path) -> None:
    """Law: a study file with faults is refused as `remanent run` refuses it."""
    file = tmp_path / "mine.toml"
    file.write_text(STUDY.replace("320.0", "-1.0"), "utf-8")
    result = CliRunner().invoke(commands, ["explore", "--no-browser", str(file)])
    assert "temperature" in str(result.exception)
    empty = CliRunner().invoke(commands, ["explore", "--no-browser", str(tmp_path)])
    assert "must be a store" in str(empty.exception)
