"""Who may ask: hosts, origins and tokens."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from remanent.web.access import Access, host_name


@pytest.mark.parametrize(
    "host",
    [
        "127.0.0.1",
        "127.0.0.1:8766",
        "localhost",
        "LOCALHOST:80",
        "[::1]",
        "[::1]:8766",
        "127.8.8.8",
    ],
)
def test_names_of_this_machine_are_allowed(host: str) -> None:
    """Law: whatever stands for the loopback interface is let in, with any port."""
    assert Access().allows_host(host)


@pytest.mark.parametrize(
    "host",
    [
        "", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "evil.localhost",
        "192.168.0.7", "0.0.0.0", "127.0.0.1:80:80", "127.0.0.1:x", "[::1", "[::1]x", "::1",
        "127.0.0.1 ", "127.0.0.1/", "user@127.0.0.1", "2130706433", "127.1", "localhost.",
    ],
)  # fmt: skip
def test_other_names_are_refused(host: str) -> None:
    """Law: a name that a name server may point here is refused, so that no page rebinds."""
    assert not Access().allows_host(host)


def test_addresses_are_allowed_where_they_were_asked_for() -> None:
    """Law: with a token, addresses and the host that was given are let in, other names are not."""
    access = Access("lab.example", 8766, "secret")
    assert access.allows_host("lab.example:8766")
    assert access.allows_host("192.168.0.7:8766")
    assert not access.allows_host("evil.example:8766")


def test_a_token_is_made_where_others_can_reach_the_page() -> None:
    """Law: loopback needs none, any other address gets a new one each time, in its address."""
    assert Access.at("127.0.0.1", 1).token == Access.at("::1", 1).token == ""
    first, second = (Access.at("0.0.0.0", 1) for _ in range(2))
    assert len(first.token) >= 32
    assert first.token != second.token
    assert first.token in first.address
    assert first.allows_token(first.token)
    assert not first.allows_token(second.token)
    assert not first.allows_token("")


@given(st.text(max_size=40))
def test_any_header_is_understood_or_refused(text: str) -> None:
    """Law: no text raises, and a name that is found is the text without its port."""
    name = host_name(text)
    assert name is None or text.lower().lstrip("[").startswith(name)
    Access("a", 1, "secret").allows_token(text)


def test_only_the_same_origin_is_allowed() -> None:
    """Law: scheme, host and port are those of the request."""
    access = Access()
    assert access.allows_origin("http://127.0.0.1:8766", "127.0.0.1:8766")
    for origin in ("null", "", "http://127.0.0.1:80", "https://127.0.0.1:8766", "http://evil"):
        assert not access.allows_origin(origin, "127.0.0.1:8766")
