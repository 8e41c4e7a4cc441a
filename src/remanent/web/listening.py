"""The address at which the server listens."""

from __future__ import annotations

import errno
import socket as sockets
from typing import Final

from remanent._errors import InputError, error_sentence

#: Milliseconds for which a client may leave what was sent to it, before it is cut off.
_STUCK_MILLISECONDS: Final = 60_000
#: Connections that may wait to be accepted.
_BACKLOG: Final = 64


def listening_socket(host: str, port: int) -> sockets.socket:
    """A socket at an address, from now on.

    Parameters
    ----------
    host : str
    port : int
        0 for one that is free.

    Raises
    ------
    InputError
        The port is taken, or the address is none of this machine.
    """
    family = sockets.AF_INET6 if ":" in host else sockets.AF_INET
    listener = sockets.socket(family, sockets.SOCK_STREAM)
    try:
        listener.setsockopt(sockets.SOL_SOCKET, _address_option(), 1)
        if hasattr(sockets, "TCP_USER_TIMEOUT"):  # connections inherit it
            listener.setsockopt(sockets.IPPROTO_TCP, sockets.TCP_USER_TIMEOUT, _STUCK_MILLISECONDS)
        listener.bind((host, port))
        listener.listen(_BACKLOG)
    except OSError as error:
        listener.close()
        shown = f"[{host}]" if ":" in host else host
        if error.errno == errno.EADDRINUSE:
            raise InputError(
                "--port",
                must="be free",
                got=port,
                why=f"Another program listens there, perhaps an explorer: open http://{shown}:{port}/.",
                fix="Pass --port 0 for a port that is free.",
            ) from None
        raise InputError(
            "--port" if error.errno == errno.EACCES else "--host",
            must="be one at which this program may listen",
            got=f"{shown}:{port}",
            why=error_sentence(error),
            fix="Leave out --host and --port for the usual address.",
        ) from None
    return listener


def _address_option() -> int:
    """The option by which an address is taken at once after its last owner, and by one alone.

    On Windows ``SO_REUSEADDR`` would let a second program take a port that is in use.
    """
    return int(getattr(sockets, "SO_EXCLUSIVEADDRUSE", sockets.SO_REUSEADDR))
