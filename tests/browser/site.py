"""The built site as a reader's browser finds it: what each page loads, and where its links lead."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: Elements that load a file as soon as a page is opened, and the attribute that names it.
LOADED = {"img": "src", "script": "src", "source": "src", "iframe": "src", "object": "data"}
#: Kinds of `link` that load nothing.
NOT_LOADED = {"author", "canonical", "index", "next", "prev", "search"}


@dataclass
class HtmlPage(HTMLParser):
    """What a page names: its anchors and links, what it loads, and its pictures with their text."""

    file: Path
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)
    pictures: list[tuple[str, str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Read the file."""
        super().__init__()
        self._link = ""
        self.feed(self.file.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what one element names."""
        named = {key: value or "" for key, value in attrs}
        self.anchors |= {named[key] for key in ("id", "name") if key in named}
        if tag == "a" and "href" in named:
            self._link = named["href"]
            self.links.append(self._link)
        elif tag == "link" and not NOT_LOADED & set(named["rel"].split()):
            self.loaded.append(named["href"])
        elif LOADED.get(tag) in named:
            self.loaded.append(named[LOADED[tag]])
        if tag == "img":
            self.pictures.append((named["src"], self._link, named.get("alt", "")))
        if "style" in named:
            self.loaded += addresses_in_style(named["style"])

    def handle_endtag(self, tag: str) -> None:
        """Leave a link."""
        if tag == "a":
            self._link = ""

    def place(self, address: str) -> tuple[Path, str]:
        """File and anchor to which an address of this site leads."""
        parts = urlsplit(address)
        path = self.file.parent / unquote(parts.path) if parts.path else self.file
        return path.resolve(), unquote(parts.fragment)


def is_elsewhere(address: str) -> bool:
    """Whether an address names another host; data within the page is here."""
    parts = urlsplit(address)
    return bool(parts.netloc) or parts.scheme not in ("", "data")


def addresses_in_style(text: str) -> list[str]:
    """Files that a style sheet loads."""
    quoted = r"""url\(\s*(?:"([^"]*)"|'([^']*)'|([^)"'\s]*))\s*\)|@import\s+["']([^"']+)"""
    return [next(filter(None, match), "") for match in re.findall(quoted, text)]


def addresses_loaded(pages: list[HtmlPage], site: Path) -> Iterator[tuple[Path, str]]:
    """Each file of the site with an address that it loads, style sheets included."""
    for page in pages:
        yield from ((page.file, address) for address in page.loaded)
    for sheet in site.rglob("*.css"):
        yield from ((sheet, one) for one in addresses_in_style(sheet.read_text("utf-8")))
