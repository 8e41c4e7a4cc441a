"""The explorer and those who ask for too much, too slowly, or go away."""

from __future__ import annotations

import json
import os
import signal
import socket as sockets
import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from remanent.web.guard import MAX_BODY_BYTES
from tests.unit.web.server import (
    LONG,
    PATIENCE,
    SPEC,
    Running,
    eventually,
    is_gone,
    next_message,
    result_of,
    running,
)


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    with running() as one:
        yield one


def exchange(socket: ClientConnection, message: Any) -> Any:
    """Send a message, and what comes back."""
    socket.send(message)
    return socket.recv(timeout=PATIENCE)


def is_free(server: Running) -> bool:
    """Whether a job is taken and answered."""
    with server.socket() as socket:
        answer = result_of(socket, "equilibria")
    return bool(answer.get("kind") == "equilibria")


@pytest.mark.parametrize("path", ["/api/model", "/api/data", "/api/store/point", "/nothing"])
def test_a_large_body_is_refused(server: Running, path: str) -> None:
    """Law: more than a megabyte gets 413, whether its length is declared or not."""
    body = b'{"spec": {}, "x": "' + b"x" * MAX_BODY_BYTES + b'"}'
    with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
        lines = f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
        lines += f"Origin: {server.origin}\r\nContent-Type: application/json\r\n"
        raw.sendall(f"{lines}Content-Length: {len(body)}\r\n\r\n".encode())
        assert raw.recv(100).split()[1] == b"413"
    if path == "/nothing":  # its body is never read
        return
    with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
        raw.sendall(f"{lines}Transfer-Encoding: chunked\r\n\r\n".encode())
        for start in range(0, len(body), 50_000):
            piece = body[start : start + 50_000]
            try:
                raw.sendall(b"%x\r\n%s\r\n" % (len(piece), piece))
            except OSError:  # the answer is there already, and the connection closed
                break
        assert raw.recv(100).split()[1] == b"413"


def test_a_large_frame_closes_the_socket(server: Running) -> None:
    """Law: a message of more than a megabyte ends the conversation, in one frame or in many."""
    for message in ("x" * (MAX_BODY_BYTES + 1), ["x" * (MAX_BODY_BYTES // 2)] * 3):
        with server.socket() as socket:
            with pytest.raises(ConnectionClosed) as closed:
                exchange(socket, message)
            # The frame that says so is lost where TCP resets what is still being sent.
            assert closed.value.rcvd is None or closed.value.rcvd.code == 1009
    assert is_free(server)


def test_a_binary_frame_is_refused(server: Running) -> None:
    """Law: messages are text; nothing is read from bytes."""
    with server.socket() as socket:
        socket.send(b"\x80\x04.")
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(timeout=PATIENCE)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1003


def test_slow_clients_are_let_go() -> None:
    """Law: a request that does not arrive in time ends, at its head and in its body."""
    with running(header_seconds=0.3, request_seconds=0.3) as server:
        head = f"POST /api/model HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
        with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
            assert raw.recv(100) == b""  # nothing is sent, and the server hangs up
        with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
            for byte in head.encode():  # ever on, a byte at a time
                try:
                    raw.sendall(bytes([byte]))
                except OSError:
                    break
                time.sleep(0.05)
            assert received(raw) == b""
        with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
            raw.sendall(f"{head}Origin: {server.origin}\r\nContent-Length: 9\r\n\r\n{{".encode())
            assert raw.recv(100).split()[1] == b"408"
        assert server.ask("POST", "/api/model", {"spec": SPEC}).status == 200


@pytest.mark.slow
def test_clients_that_do_not_read_are_let_go() -> None:
    """Law: an answer that is not taken in time is broken off, and others are served."""
    with running(answer_seconds=0.3) as server:
        whole = len(server.ask("GET", "/plotly.js").body)
        with sockets.socket() as raw:
            raw.setsockopt(sockets.SOL_SOCKET, sockets.SO_RCVBUF, 4096)
            raw.settimeout(PATIENCE)
            raw.connect(("127.0.0.1", server.port))
            head = f"GET /plotly.js HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n"
            raw.sendall(head.encode())
            time.sleep(2.0)  # longer than the server waits, which is all that matters
            taken = 0
            while piece := received(raw):
                taken += len(piece)
        assert taken < whole
        assert server.ask("GET", "/api/start").status == 200


def received(raw: sockets.socket) -> bytes:
    """What comes before the connection ends, in whichever way."""
    try:
        return raw.recv(65536)
    except ConnectionError:
        return b""


@pytest.mark.parametrize(
    ("job", "options"),
    [
        ("frequency_response", {"count": 2000, "duration": 1e6}),
        ("frequency_response", {"range": [1e-9, 1e-8], "sweeps": True}),
        ("frequency_response", {"duration": 1e300}),
        ("regime_chart", {"grid": {"b": [0.1, 1], "omega": [1, 2]}, "count": 128, "periods": 5000}),
        ("basins", {"grid": {"stretch": [0.5, 2], "stretch_rate": [-1, 1]}, "count": 128,
                    "periods": 5000}),
        ("response_diagram", {"range": [1e-7, 1e-6]}),
    ],
)  # fmt: skip
def test_work_over_the_budget_is_refused(
    server: Running, job: str, options: dict[str, object]
) -> None:
    """Law: what takes too long is refused with its estimate and a remedy before it begins."""
    with server.socket() as socket:
        socket.send(json.dumps({"id": "1", "job": job, "spec": SPEC, "options": options}))
        message = next_message(socket, "result", "error", "progress")
    assert message["type"] == "error"
    assert message["error"]["status"] == 422
    assert "are allowed" in message["error"]["message"]


def test_data_over_the_budget_are_refused(server: Running) -> None:
    """Law: so is a file."""
    slow = {**SPEC, "drive": {"kind": "SineSquared", "b": 0.4, "omega": 1e-6}}
    answer = server.ask("POST", "/api/data", {"spec": slow, "periods": 1000})
    assert answer.status == 422
    assert "are allowed" in answer.json["error"]["message"]


def test_work_that_is_too_much_at_once_is_refused(server: Running) -> None:
    """Law: as many jobs as there are slots go on, the next is told so; a file is a job too."""
    assert is_free(server)
    with server.socket() as first, server.socket() as second:
        first.send(json.dumps(LONG))
        next_message(first, "progress")
        assert result_of(second, "equilibria")["status"] == 429
        assert server.ask("POST", "/api/data", {"spec": SPEC, "periods": 3}).status == 429
        # What a page needs to follow a slider is no job.
        assert server.ask("POST", "/api/model", {"spec": SPEC}).status == 200
        first.send(json.dumps({"id": "long", "type": "cancel"}))
        assert next_message(first, "error", "result")["error"]["status"] == 499
    assert eventually(lambda: is_free(server))


def test_work_ends_when_its_page_goes(server: Running) -> None:
    """Law: a page that is closed leaves its place to others, whether it says so or vanishes."""
    for vanishes in (False, True):
        assert eventually(lambda: is_free(server))
        with server.socket() as socket:
            socket.send(json.dumps(LONG))
            next_message(socket, "progress")
            if vanishes:
                socket.socket.shutdown(sockets.SHUT_RDWR)
        assert eventually(lambda: is_free(server))


def test_a_file_that_nobody_waits_for_is_given_up(server: Running) -> None:
    """Law: a client that goes away leaves its place to others."""
    assert eventually(lambda: is_free(server))
    slow = {**SPEC, "drive": {"kind": "SineSquared", "b": 0.4, "omega": 1e-3}}
    body = json.dumps({"spec": slow, "duration": 3e6}).encode()
    head = f"POST /api/data HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
    head += f"Origin: {server.origin}\r\nContent-Type: application/json\r\n"
    with sockets.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as raw:
        raw.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body)
        assert eventually(lambda: not is_free(server))
    assert eventually(lambda: is_free(server))


@pytest.mark.slow
def test_a_cancelled_job_leaves_its_process_ready(server: Running) -> None:
    """Law: work that listens is broken off, and the same process does the next."""
    assert eventually(lambda: is_free(server))
    with server.socket() as socket:
        assert result_of(socket, "classify", periods=100)["kind"] == "classify"
        before = set(server.explorer.process_numbers)
        for _ in range(3):
            socket.send(json.dumps(LONG))
            next_message(socket, "progress")
            socket.send(json.dumps({"id": "long", "type": "cancel"}))
            assert next_message(socket, "error", "result")["error"]["status"] == 499
            assert result_of(socket, "equilibria")["kind"] == "equilibria"
        assert set(server.explorer.process_numbers) == before


def test_a_process_that_dies_is_replaced(server: Running) -> None:
    """Law: its job is told so, and the next one finds another process."""
    assert eventually(lambda: is_free(server))
    victim = server.explorer.process_numbers[-1]
    with server.socket() as socket:
        socket.send(json.dumps(LONG))
        next_message(socket, "progress")
        os.kill(victim, signal.SIGKILL)
        told = next_message(socket, "error", "result")["error"]
        assert "ended by itself" in told["message"]
        assert result_of(socket, "equilibria")["kind"] == "equilibria"
    assert victim not in server.explorer.process_numbers


@pytest.mark.slow
def test_a_process_that_does_not_listen_is_killed(server: Running) -> None:
    """Law: a cancelled job whose process hangs costs a process, not the slot."""
    assert eventually(lambda: is_free(server))
    victim = server.explorer.process_numbers[-1]
    with server.socket() as socket:
        socket.send(json.dumps(LONG))
        next_message(socket, "progress")
        os.kill(victim, signal.SIGSTOP)
        socket.send(json.dumps({"id": "long", "type": "cancel"}))
        assert next_message(socket, "error", "result")["error"]["status"] == 499
        assert eventually(lambda: is_gone(victim))
        assert result_of(socket, "equilibria")["kind"] == "equilibria"


def test_ids_are_used_once_at_a_time(server: Running) -> None:
    """Law: a second job with the id of one that goes on is refused, and the first goes on."""
    assert eventually(lambda: is_free(server))
    with server.socket() as socket:
        socket.send(json.dumps(LONG))
        next_message(socket, "progress")
        socket.send(json.dumps(LONG))
        assert next_message(socket, "error", "result")["error"]["status"] == 409
        next_message(socket, "progress")


def test_too_many_pages_are_refused(server: Running) -> None:
    """Law: there is an end to how many sockets are open at once."""
    with ExitStack() as open_ones:
        codes = []
        for _ in range(40):
            socket = open_ones.enter_context(server.socket())
            try:
                socket.send("{")
                next_message(socket, "error")
            except ConnectionClosed as closed:
                codes.append(closed.rcvd.code if closed.rcvd else None)
        assert codes
        assert set(codes) == {1013}
    assert eventually(lambda: is_free(server))


def test_nothing_is_left_when_the_server_ends() -> None:
    """Law: its processes end with it, also in the middle of a job."""
    with ExitStack() as page, running(slots=2) as server:
        socket = page.enter_context(server.socket())
        socket.send(json.dumps(LONG))
        next_message(socket, "progress")
        processes = server.explorer.process_numbers
        assert len(processes) == 3
    assert all(is_gone(process) for process in processes)
