"""The explorer and those who should not ask: foreign hosts, foreign pages, no token."""

from __future__ import annotations

import socket as sockets
from collections.abc import Iterator

import pytest
from websockets.exceptions import InvalidStatus

from tests.unit.web.server import SPEC, Running, next_message, result_of, running

#: Hosts of pages that want to reach this machine by a name of their own.
FOREIGN_HOSTS = ("evil.example", "127.0.0.1.evil.example:80", "192.168.0.7", "[::2]:8766", "")
#: Origins of other pages, and of files.
FOREIGN_ORIGINS = (
    "http://evil.example",
    "null",
    "http://127.0.0.1:1",
    "http://localhost",
    "file://",
)
#: Every address that the server has an answer for.
ADDRESSES = (
    ("GET", "/"), ("GET", "/plotly.js"), ("GET", "/assets/index.html"), ("GET", "/api/start"),
    ("GET", "/fields/none.js"), ("POST", "/api/model"), ("POST", "/api/reproduce"),
    ("POST", "/api/export"), ("POST", "/api/data"), ("GET", "/api/store"),
    ("POST", "/api/store/point"), ("GET", "/nothing"),
)  # fmt: skip


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    with running() as one:
        yield one


@pytest.fixture(scope="module")
def guarded() -> Iterator[Running]:
    """A server that wants a token."""
    with running(token="only-this-one") as one:
        yield one


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_a_foreign_host_is_refused_everywhere(server: Running, host: str) -> None:
    """Law: a request by another name than those of this machine gets 400 or 403."""
    for method, path in ADDRESSES:
        content = {"spec": SPEC} if method == "POST" else None
        answer = server.ask(method, path, content, {"Host": host, "Origin": f"http://{host}"})
        assert answer.status in (400, 403), (method, path)
    with pytest.raises(InvalidStatus) as refused:
        server.socket(additional_headers={"Host": host or "evil"}, origin=f"http://{host}")
    assert refused.value.response.status_code in (400, 403)


@pytest.mark.parametrize("origin", [*FOREIGN_ORIGINS, ""])
def test_a_foreign_page_is_refused(server: Running, origin: str) -> None:
    """Law: work is done only for a page of this server, which a browser names each time."""
    for method, path in ADDRESSES:
        if method == "POST" or origin:
            content = {"spec": SPEC} if method == "POST" else None
            answer = server.ask(method, path, content, {"Origin": origin})
            assert answer.status == 403, (method, path)
            assert answer.json["error"]["message"]
    with pytest.raises(InvalidStatus) as refused:
        server.socket(origin=origin or None)
    assert refused.value.response.status_code == 403


def test_two_hosts_are_none(server: Running) -> None:
    """Law: a request that says two hosts is refused, whichever is first."""
    for order in ((b"127.0.0.1", b"evil"), (b"evil", b"127.0.0.1")):
        with sockets.create_connection(("127.0.0.1", server.port), timeout=10) as raw:
            lines = b"".join(b"Host: %s\r\n" % host for host in order)
            raw.sendall(b"GET /api/start HTTP/1.1\r\n" + lines + b"Connection: close\r\n\r\n")
            assert raw.recv(100).split()[1] in (b"400", b"403")


def test_no_other_origin_may_read(server: Running) -> None:
    """Law: no answer has a header that lets another page read it, nor does a preflight."""
    answers = [server.ask(method, path) for method, path in ADDRESSES]
    answers.append(
        server.ask("OPTIONS", "/api/model", None, {
            "Origin": "http://evil.example", "Access-Control-Request-Method": "POST",
        })
    )  # fmt: skip
    assert answers[-1].status in (403, 405)
    for answer in answers:
        assert not [name for name in answer.headers if name.startswith("access-control")]


def test_every_answer_has_the_headers(server: Running) -> None:
    """Law: answers of every status say what a page may load, and that it is in no frame."""
    refused = server.ask("GET", "/", None, {"Host": "evil.example"})
    answers = [server.ask(method, path) for method, path in ADDRESSES]
    assert {answer.status for answer in answers} >= {200, 404, 422}
    for answer in [*answers, refused]:
        policy = answer.headers["content-security-policy"].split("; ")
        assert "default-src 'self'" in policy
        assert "frame-ancestors 'none'" in policy
        assert not [rule for rule in policy if "http" in rule or "*" in rule]
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_no_page_of_documentation_loads_from_elsewhere(server: Running) -> None:
    """Law: pages that would take their scripts from another server do not exist."""
    for path in ("/docs", "/redoc", "/openapi.json"):
        assert server.ask("GET", path).status == 404


def test_files_beside_the_assets_are_out_of_reach(server: Running) -> None:
    """Law: no way of writing a path leads out of the folder of the page."""
    for path in (
        "/assets/../model.py", "/assets/%2e%2e/model.py", "/assets/..%2fmodel.py",
        "/assets//etc/passwd", "/assets/%2fetc%2fpasswd", "/fields/../api/start.js",
        "/fields/..%2f..%2fetc%2fpasswd.js", "/assets/..\\model.py", "/assets/%00",
    ):  # fmt: skip
        answer = server.ask("GET", path)
        assert answer.status in (400, 404, 405, 422), path
        assert b"def " not in answer.body


def test_without_the_token_nothing_is_answered(guarded: Running) -> None:
    """Law: at another address than loopback only who has the token gets anything."""
    for kept in ("", "only-this-on", "only-this-onE", "only-this-one "):
        for method, path in ADDRESSES:
            cookie = f"{guarded.access.cookie}={kept}" if kept.strip() == kept else ""
            answer = guarded.ask(method, path, None, {"Cookie": cookie})
            assert answer.status == 403, (method, path)
    assert guarded.ask("GET", "/?token=wrong").status == 403
    with pytest.raises(InvalidStatus) as refused:
        guarded.socket()
    assert refused.value.response.status_code == 403


def test_the_address_with_the_token_opens_the_page(guarded: Running) -> None:
    """Law: the address that is shown leads to the page, by a cookie that scripts cannot read."""
    opened = guarded.ask("GET", "/?token=only-this-one&view=phase")
    assert opened.status == 303
    assert opened.headers["location"] == "/?view=phase"
    cookie, *rules = opened.headers["set-cookie"].split("; ")
    assert {"HttpOnly", "SameSite=Strict"} <= set(rules)
    assert guarded.ask("GET", "/api/start", None, {"Cookie": cookie}).status == 200
    with guarded.socket(additional_headers={"Cookie": cookie}) as socket:
        assert result_of(socket, "equilibria")["kind"] == "equilibria"
    with guarded.socket(additional_headers={"Cookie": cookie}) as socket:
        socket.send("{")
        assert next_message(socket, "error")["error"]["status"] == 400
