"""Who may ask: hosts that are this machine, pages of this server, holders of its token."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

#: Names of this machine that no name server can give to another.
_LOOPBACK_NAMES: Final = frozenset({"localhost", "127.0.0.1", "::1"})
#: Where a browser of this machine finds a server that listens at all of its addresses.
_LOOPBACK_OF_ANY: Final = MappingProxyType({"0.0.0.0": "127.0.0.1", "::": "::1"})
#: Bytes of a token.
_TOKEN_BYTES: Final = 32


@dataclass(frozen=True)
class Access:
    """Who may ask.

    Attributes
    ----------
    host : str
        The address at which the server listens.
    port : int
    token : str
        What a client has to show; empty where the server listens to this machine alone.
    """

    host: str = "127.0.0.1"
    port: int = 0
    token: str = ""

    @classmethod
    def at(cls, host: str, port: int) -> Access:
        """At an address: with a new token where others can reach it."""
        token = "" if is_loopback(host) else secrets.token_urlsafe(_TOKEN_BYTES)
        return cls(host, port, token)

    @property
    def address(self) -> str:
        """What a browser is given, with the token."""
        name = _LOOPBACK_OF_ANY.get(self.host, self.host)
        host = f"[{name}]" if ":" in name else name
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    @property
    def cookie(self) -> str:
        """Name of the cookie that holds the token; cookies do not know ports."""
        return f"remanent-{self.port}"

    def allows_host(self, header: str) -> bool:
        """Whether a Host header names this machine, so that no foreign name leads here."""
        name = host_name(header)
        if name is None:
            return False
        if is_loopback(name):
            return True
        return bool(self.token) and (name == self.host.lower() or _is_address(name))

    def allows_origin(self, origin: str, host: str) -> bool:
        """Whether an Origin header is of a page that this server gave out."""
        return origin == f"http://{host}"

    def allows_token(self, token: str) -> bool:
        """Whether this is the token, found out in a time that tells nothing of it."""
        return not self.token or secrets.compare_digest(token.encode(), self.token.encode())


def is_loopback(name: str) -> bool:
    """Whether a name or an address stands for this machine alone."""
    if name.lower() in _LOOPBACK_NAMES:
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def host_name(header: str) -> str | None:
    """The name in a Host header, without its port; None where it has no such form."""
    name, port = header, ""
    if header.startswith("["):
        name, bracket, port = header[1:].partition("]")
        if not bracket or (port and not port.startswith(":")):
            return None
        port = port[1:]
    elif ":" in header:
        name, _, port = header.partition(":")
    if not name or (port and not (port.isascii() and port.isdigit())):
        return None
    return name.lower()


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
