"""The explorer and requests at random: each is answered or refused in words, none breaks it."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from itertools import islice
from random import Random
from typing import Any

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.core.result import Ok

from remanent.web.app import make_app
from remanent.web.limits import JOB_LIMITS
from tests.faults.study_file_mutations import files
from tests.unit.web.server import PATIENCE, SPEC, Running, next_message, result_of, running

#: Requests of the slow test, and of each of the two quick ones.
MANY, FEW = 10_000, 32
#: Addresses that take a spec, with what else their bodies need.
TAKING_SPECS: dict[str, dict[str, Any]] = {
    "/api/model": {}, "/api/reproduce": {}, "/api/export": {"language": "python"},
    "/api/data": {"periods": 2, "format": "csv"},
}  # fmt: skip
#: Numbers of lists within each other: near what the parsers and the writers of JSON bear.
DEPTHS = (100, 300, 500, 900, 950, 980, 1000, 2000)
#: Values that stand where others should.
ODD: tuple[Any, ...] = (
    None, True, -1, 0, 1e308, -1e-308, 1e16, 10**30, "", "x", "<script>", "\x00", "é" * 5000,
    "\ud800", [], {}, [[[[[[[[[[[[[[]]]]]]]]]]]]]], {"kind": "Rayleigh"}, {"kind": {}}, [0.1] * 300,
)  # fmt: skip


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    with running() as one:
        yield one


@pytest.fixture(scope="module")
def client(server: Running) -> Iterator[httpx.Client]:
    """What sends requests as the page does."""
    headers = {"Origin": server.origin}
    with httpx.Client(base_url=server.origin, headers=headers, timeout=PATIENCE) as one:
        yield one


def complaint(answer: httpx.Response) -> str:
    """What is wrong with an answer; empty where nothing is."""
    if answer.status_code >= 500:
        return f"status {answer.status_code}: {answer.text[:300]}"
    if "Traceback" in answer.text or 'File "' in answer.text:
        return f"a traceback: {answer.text[:300]}"
    if "content-security-policy" not in answer.headers:
        return "no policy"
    if answer.status_code >= 400:
        error = answer.json()["error"]
        if not error["message"] or error["status"] != answer.status_code:
            return f"no words: {error}"
    return ""


def operations(server: Running) -> list[Any]:
    """All operations of the server, as its own schema describes them."""
    schema = schemathesis.openapi.from_dict(make_app(server.explorer).openapi())
    return [result.ok() for result in schema.get_all_operations() if isinstance(result, Ok)]


def fuzz_by_schema(server: Running, client: httpx.Client, count: int) -> int:
    """Send about so many requests that fit the schema, or do not; how many were sent."""
    sent = 0
    known = operations(server)
    modes = (GenerationMode.POSITIVE, GenerationMode.NEGATIVE)
    for operation in known:
        for mode in modes:
            sent += fuzz_operation(operation, mode, client, count // (len(known) * len(modes)))
    return sent


def fuzz_operation(operation: Any, mode: GenerationMode, client: httpx.Client, count: int) -> int:
    """Send so many requests of one kind; 0 where there is none of it."""
    sent = 0

    @settings(
        max_examples=max(1, count), deadline=None, derandomize=True, database=None,
        phases=(Phase.generate,), suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(case=operation.as_strategy(generation_mode=mode))
    def send(case: Any) -> None:
        nonlocal sent
        sent += 1
        request = case.as_transport_kwargs()
        path = case.formatted_path
        answer = client.request(
            case.method, path, params=request.get("params"),
            json=request.get("json"), content=request.get("data"),
        )  # fmt: skip
        assert not complaint(answer), (case.method, path, request)

    try:
        send()
    except Unsatisfiable:  # a request without parts cannot be of another form
        return 0
    return sent


def spoilt_specs(seed: int) -> Iterator[dict[str, Any]]:
    """Bodies that are nearly sound: spoilt study files, and odd values in their tables."""
    rng = Random(seed)
    for content in files(seed):
        text = content.decode("utf-8", "replace")
        yield {"toml": text}
        try:
            document = tomllib.loads(text)
        except (ValueError, RecursionError):
            document = json.loads(json.dumps(SPEC))
        spec = {key: document[key] for key in document if key not in ("verb", "store", "over")}
        yield {"spec": spec}
        replace_one(rng, spec)
        yield {"spec": spec}


def replace_one(rng: Random, table: dict[str, Any]) -> None:
    """Put an odd value somewhere in a table."""
    while table:
        key = rng.choice(list(table))
        if not isinstance(table[key], dict) or rng.random() < 0.3:
            table[key] = rng.choice(ODD)
            return
        table = table[key]


def fuzz_by_specs(client: httpx.Client, seed: int, count: int) -> None:
    """Send so many bodies that are nearly sound."""
    rng = Random(seed)
    for body in islice(spoilt_specs(seed), count):
        path = rng.choice(list(TAKING_SPECS)) if "spec" in body else "/api/model"
        try:
            content = json.dumps(body | TAKING_SPECS[path], default=str)
        except (ValueError, RecursionError):  # no JSON can say this
            continue
        headers = {"Content-Type": "application/json"}
        answer = client.post(path, content=content.encode("utf-8", "replace"), headers=headers)
        assert not complaint(answer), (path, content[:2000])


def is_well(server: Running) -> bool:
    """Whether a sound request is answered as ever."""
    return server.ask("POST", "/api/model", {"spec": SPEC}).status == 200


def test_requests_of_the_schema(server: Running, client: httpx.Client) -> None:
    """Law: whatever fits the server's own description of itself, or does not, gets an answer of
    its kind, or a refusal in words."""
    assert len(operations(server)) == 8
    assert fuzz_by_schema(server, client, FEW) >= FEW // 2
    assert is_well(server)


def test_requests_that_are_nearly_sound(server: Running, client: httpx.Client) -> None:
    """Law: spoilt study files and specs are refused by what is wrong with them."""
    fuzz_by_specs(client, seed=1, count=FEW)
    assert is_well(server)


@pytest.mark.slow
def test_ten_thousand_requests(server: Running, client: httpx.Client) -> None:
    """Law: so are ten thousand of them."""
    sent = fuzz_by_schema(server, client, MANY // 2)
    fuzz_by_specs(client, seed=2, count=MANY - sent)
    assert is_well(server)


@pytest.mark.slow
@given(
    content=st.binary(max_size=200), kind=st.sampled_from(["application/json", "text/plain", ""])
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_bytes_at_random(client: httpx.Client, content: bytes, kind: str) -> None:
    """Law: bodies that are no JSON are refused in words, whatever they say they are."""
    for path in ("/api/model", "/api/export", "/api/store/point", "/nothing"):
        answer = client.post(path, content=content, headers={"Content-Type": kind})
        assert 400 <= answer.status_code < 500
        assert not complaint(answer)


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 100_000,
        b'{"spec":' * 50_000,
        *(b'{"spec": {"a": ' + b"[" * depth + b"]" * depth + b"}}" for depth in DEPTHS),
        *(b'{"a":' * depth + b"1" + b"}" * depth for depth in DEPTHS),
        b'{"spec": {"a": ' + b"9" * 5000 + b"}}",
        b'{"spec": {"actuator": {"temperature": 1e999}, "drive": {"kind": "Constant", "m": NaN}}}',
        b'{"spec": {"actuator": {"\\ud800": "\\udfff"}, "drive": {}}}',
        b'{"spec": {}, "\\ud800": 1}',
        b'{"spec": {}, "index": ["\\ud800"], "language": "\\ud800", "toml": "\\ud800"}',
        b'{"spec": {}, "spec": {}, "language": "\\u0000"}',
        b"\xff\xfe{\x00}\x00",
    ],
    ids=[
        "deep list",
        "deep table",
        *(f"list in {depth} others" for depth in DEPTHS),
        *(f"table in {depth} others" for depth in DEPTHS),
        "long number",
        "not finite",
        "surrogates",
        "surrogates in a key",
        "surrogates in text",
        "twice",
        "UTF-16",
    ],
)
def test_bodies_that_break_parsers(client: httpx.Client, body: bytes) -> None:
    """Law: what is deep, long, not finite or no text is refused in words."""
    for path in (*TAKING_SPECS, "/api/store/point"):
        answer = client.post(path, content=body, headers={"Content-Type": "application/json"})
        assert 400 <= answer.status_code < 500, path
        assert not complaint(answer)


def odd_messages(seed: int) -> Iterator[str]:
    """Messages for the socket: no JSON, of other forms, jobs with odd options and specs."""
    rng = Random(seed)
    yield from ("", "{", "[]", "null", "1e999", "[" * 100_000, '"job"', '{"id": 1}', "\u2028")
    while True:
        message: dict[str, Any] = {
            "id": f"job-{rng.random()}", "job": rng.choice([*JOB_LIMITS, "none"]),
            "spec": json.loads(json.dumps(SPEC)),
            "options": {"range": [1.0, 1.2], "count": 2, "periods": 100},
        }  # fmt: skip
        for _ in range(rng.randint(1, 3)):
            replace_one(rng, rng.choice([message, message["options"], message["spec"]])
                        if isinstance(message.get("options"), dict)
                        and isinstance(message.get("spec"), dict) else message)  # fmt: skip
        yield json.dumps(message)


def fuzz_socket(server: Running, seed: int, count: int) -> None:
    """Send so many messages, one after the other; each is answered on the same socket."""
    with server.socket() as socket:
        for text in islice(odd_messages(seed), count):
            socket.send(text)
            message = next_message(socket, "result", "error")
            if message["type"] == "error":
                error = message["error"]
                assert error["status"] != 500, (text[:2000], error)
                assert error["message"], text[:2000]
                assert "Traceback" not in error["message"]


@pytest.mark.parametrize("depth", DEPTHS)
def test_deep_messages(server: Running, depth: int) -> None:
    """Law: lists within lists are refused in words, however many, and cost no slot."""
    with server.socket() as socket:
        deep = "[" * depth + "]" * depth
        socket.send(f'{{"id": "a", "job": "classify", "spec": {{"a": {deep}}}}}')
        assert 400 <= next_message(socket, "error", "result")["error"]["status"] < 500
        assert result_of(socket, "equilibria")["kind"] == "equilibria"


def test_messages_at_random(server: Running) -> None:
    """Law: every message of the socket has an answer, and the socket lives on."""
    fuzz_socket(server, seed=3, count=60)


@pytest.mark.slow
def test_a_thousand_messages(server: Running) -> None:
    """Law: so have a thousand of them."""
    fuzz_socket(server, seed=4, count=1000)
