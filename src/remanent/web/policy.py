"""The headers of every answer, with what the page may load, as the documentation lists it."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from types import MappingProxyType

from remanent.page.files import PLOTLY_STYLES


def content_security_policy() -> Mapping[str, str]:
    """What the page may load, by the kind of what is loaded."""
    hashes = " ".join(f"'sha256-{_digest(style)}'" for style in PLOTLY_STYLES)
    return MappingProxyType(
        {
            "default-src": "'self'",
            "img-src": "'self' data: blob:",  # the pixels of a chart, and of one that is saved
            "style-src-attr": f"'unsafe-hashes' {hashes}",
            "base-uri": "'none'",
            "form-action": "'none'",
            "frame-ancestors": "'none'",
            "object-src": "'none'",
        }
    )


def security_headers() -> tuple[tuple[bytes, bytes], ...]:
    """Headers of every answer, names and values."""
    rules = content_security_policy().items()
    headers = {
        "content-security-policy": "; ".join(f"{kind} {sources}" for kind, sources in rules),
        "x-content-type-options": "nosniff",
        "referrer-policy": "no-referrer",
        "x-frame-options": "DENY",
        "cross-origin-resource-policy": "same-origin",
        "cross-origin-opener-policy": "same-origin",
    }
    return tuple((name.encode(), value.encode()) for name, value in headers.items())


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
