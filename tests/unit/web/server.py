"""A server on a free port of this machine, in a thread of the tests, with its processes."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from remanent.web.access import Access
from remanent.web.app import make_app
from remanent.web.explorer import Explorer, Opened
from remanent.web.guard import Guard
from remanent.web.listening import listening_socket
from remanent.web.serving import make_server

#: What the tests look at: damped, so that every job has something to say.
SPEC: dict[str, Any] = {
    "actuator": {"temperature": 350.0, "dissipation": [{"kind": "Rayleigh", "eta": 0.1}]},
    "drive": {"kind": "SineSquared", "b": 0.4, "omega": 1.25},
}
#: A job that takes longer than any test, but for a machine within its budget.
LONG: dict[str, Any] = {
    "id": "long", "job": "regime_chart", "spec": {**SPEC, "actuator": {}},
    "options": {"grid": {"omega": [0.6, 1.9], "b": [0.2, 1.2]}, "count": 64, "periods": 1000},
}  # fmt: skip
#: Seconds after which a test gives up waiting.
PATIENCE = 60.0


@dataclass(frozen=True)
class Answer:
    """A status, headers in small letters, a body."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        """The body as plain data."""
        return json.loads(self.body)


@dataclass(frozen=True)
class Running:
    """A server that runs."""

    port: int
    explorer: Explorer
    access: Access

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def ask(
        self,
        method: str,
        path: str,
        content: Any = None,
        headers: dict[str, str] | None = None,
        *,
        body: bytes | None = None,
    ) -> Answer:
        """An answer, to a request of the page itself unless the headers say something else."""
        own = {"Host": f"127.0.0.1:{self.port}", "Origin": self.origin, **(headers or {})}
        if content is not None:
            body = json.dumps(content).encode()
            own.setdefault("Content-Type", "application/json")
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in own.items():
                if value:  # an empty one is left out
                    connection.putheader(name, value)
            if body is not None:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders(body)
            response = connection.getresponse()
            names = {name.lower(): value for name, value in response.getheaders()}
            text = b""
            with suppress(ConnectionResetError):  # refused before all of it was sent
                text = response.read()
            return Answer(response.status, names, text)
        finally:
            connection.close()

    def socket(self, **changes: Any) -> AbstractContextManager[ClientConnection]:
        """A socket for jobs, closed after the block."""
        options: dict[str, Any] = {
            "origin": self.origin, "max_size": None, "open_timeout": PATIENCE, "close_timeout": 1.0,
            **changes,
        }  # fmt: skip
        opened: AbstractContextManager[ClientConnection] = connect(
            f"ws://127.0.0.1:{self.port}/api/jobs", **options
        )
        return opened


@contextmanager
def running(
    opened: Opened | None = None,
    *,
    token: str = "",
    port: int = 0,
    slots: int = 1,
    header_seconds: float = 10.0,
    **patience: float,
) -> Iterator[Running]:
    """A server while the block lasts; its processes are gone after it."""
    listener = listening_socket("127.0.0.1", port)
    port = int(listener.getsockname()[1])
    access = Access("127.0.0.1", port, token)
    explorer = Explorer(opened or Opened(SPEC), slots)
    server = make_server(Guard(make_app(explorer), access, **patience), header_seconds)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    try:
        yield Running(port, explorer, access)
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        explorer.close()
        assert not thread.is_alive()


def next_message(socket: ClientConnection, *kinds: str) -> dict[str, Any]:
    """The next message of one of these types; others are passed over."""
    while True:
        message: dict[str, Any] = json.loads(socket.recv(timeout=PATIENCE))
        if message["type"] in kinds:
            return message


def result_of(socket: ClientConnection, job: str, spec: Any = None, **options: Any) -> Any:
    """The result of a job, or its error."""
    asked = {"id": job, "job": job, "spec": SPEC if spec is None else spec, "options": options}
    socket.send(json.dumps(asked))
    message = next_message(socket, "result", "error")
    assert message["id"] == job
    return message[message["type"]]


def eventually(holds: Callable[[], bool]) -> bool:
    """Whether something comes to hold in a while."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.02)
    return holds()


def is_gone(process: int) -> bool:
    """Whether a process has ended, or only waits to be counted."""
    try:
        state = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return True
    return state == "Z"


def processes_below(process: int) -> list[int]:
    """The processes that a process has started, and those that these have."""
    tasks = Path(f"/proc/{process}/task")
    own = [int(one) for task in tasks.glob("*/children") for one in task.read_text().split()]
    return own + [below for one in own for below in processes_below(one)]
