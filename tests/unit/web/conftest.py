"""One server for the tests of a file that change nothing of it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.unit.web.server import Running, running


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    """A server that shows a damped actuator."""
    with running() as one:
        yield one
