"""Modules of JavaScript joined into one, so that a page needs no second file."""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from remanent._errors import FAULT, RemanentError

_NAME: Final = r"[A-Za-z_$][\w$]*"
#: ``import { a, b as c } from "./file.js";``, also over several lines.
_IMPORT: Final = re.compile(r'^import\s*\{([^{}]*)\}\s*from\s*"(\.[^"]+)";[ \t]*$', re.M)
#: ``import * as name from "./file.js";``
_IMPORT_ALL: Final = re.compile(
    rf'^import\s*\*\s*as\s+({_NAME})\s+from\s*"(\.[^"]+)";[ \t]*$', re.M
)
#: ``import "./file.js";``
_IMPORT_FOR_EFFECT: Final = re.compile(r'^import\s*"(\.[^"]+)";[ \t]*$', re.M)
#: ``export function name``, ``export const name`` and the like, at the start of a line.
_EXPORT: Final = re.compile(
    rf"^export\s+((?:async\s+)?function\*?\s+({_NAME})|class\s+({_NAME})|const\s+({_NAME}))", re.M
)
#: ``export { a, b as c };``
_EXPORT_LIST: Final = re.compile(r"^export\s*\{([^{}]*)\};[ \t]*$", re.M)
#: Anything else that begins a line so.
_LEFT_OVER: Final = re.compile(r"^[ \t]*(?:import\b(?!\s*\()|export\b).*$", re.M)
#: A comment that begins a line: its words are no statements.
_COMMENT: Final = re.compile(r"^[ \t]*/\*.*?\*/[ \t]*\n?", re.M | re.S)
#: A module that is asked for while the page runs.
_DYNAMIC: Final = re.compile(r"\bimport\(")
_PAIR: Final = re.compile(rf"({_NAME})(?:\s+as\s+({_NAME}))?")
#: The function in place of ``import(...)``: modules are found by their address.
_LOADER: Final = """\
const joinedModules = new Map();
const importJoined = async (address) => {
  if (!joinedModules.has(address)) {
    throw new Error(`This page holds no module ${address}.`);
  }
  return joinedModules.get(address);
};"""


@dataclass(frozen=True)
class _Module:
    """One module, without what it imports and exports.

    Attributes
    ----------
    body
        Its statements.
    imports
        For each module that it needs, the lines that take names from it.
    exports
        Its names, by those under which others know them.
    """

    body: str
    imports: tuple[tuple[str, str], ...]
    exports: Mapping[str, str]


def joined_modules(sources: Mapping[str, str], entry: str, further: Mapping[str, str]) -> str:
    """Modules as the text of one, which behaves as they do together.

    Parameters
    ----------
    sources : mapping of str to str
        Texts by path; modules import each other by relative paths.
    entry : str
        The path of the one that is run.
    further : mapping of str to str
        Modules without imports that are asked for by ``import(address)``, by their address.

    Returns
    -------
    str
        Each module is a function that gives its names, those that others need first.

    Raises
    ------
    RemanentError
        A form of import or export that modules of the page do not have, a path that is not there,
        or modules that need each other in a circle.
    """
    modules: dict[str, _Module] = {}
    _collect(sources, entry, (), modules)
    numbers = {path: f"module{k}" for k, path in enumerate(modules)}
    *needed, last = modules
    parts = [_LOADER, *(_function(numbers[path], modules[path], numbers) for path in needed)]
    for k, (address, source) in enumerate(further.items()):
        module = _read(source, address)
        if module.imports:
            raise _refused(address, "imports another module")
        parts.append(_function(f"further{k}", module, numbers))
        parts.append(f"joinedModules.set({json.dumps(address)}, further{k});")
    return "\n".join([*parts, _function(numbers[last], modules[last], numbers)]) + "\n"


def _collect(
    sources: Mapping[str, str], path: str, above: tuple[str, ...], found: dict[str, _Module]
) -> None:
    """Read a module and all that it needs, these first."""
    if path in above:
        raise _refused(path, f"needs itself, by {' and '.join(above[above.index(path) :])}")
    if path in found:
        return
    if path not in sources:
        raise _refused(path, f"is not there, and {above[-1] if above else 'the page'} needs it")
    module = _read(sources[path], path)
    for needed, _ in module.imports:
        _collect(sources, needed, (*above, path), found)
    found[path] = module


def _read(source: str, path: str) -> _Module:
    imports: list[tuple[str, str]] = []
    exports: dict[str, str] = {}

    def address(relative: str) -> str:
        return posixpath.normpath(posixpath.join(posixpath.dirname(path), relative))

    def names(match: re.Match[str]) -> str:
        pairs = _pairs(match[1], path)
        taken = ", ".join(one if one == own else f"{one}: {own}" for one, own in pairs)
        imports.append((address(match[2]), f"const {{ {taken} }} = {{}};"))
        return ""

    def all_names(match: re.Match[str]) -> str:
        imports.append((address(match[2]), f"const {match[1]} = {{}};"))
        return ""

    def effect(match: re.Match[str]) -> str:
        imports.append((address(match[1]), ""))
        return ""

    def declared(match: re.Match[str]) -> str:
        name = match[2] or match[3] or match[4]
        exports[name] = name
        return match[1]

    def listed(match: re.Match[str]) -> str:
        exports.update({shown: own for own, shown in _pairs(match[1], path)})
        return ""

    body = _IMPORT.sub(names, _COMMENT.sub("", source))
    body = _IMPORT_ALL.sub(all_names, body)
    body = _IMPORT_FOR_EFFECT.sub(effect, body)
    body = _EXPORT_LIST.sub(listed, _EXPORT.sub(declared, body))
    left = _LEFT_OVER.search(body)
    if left is not None:
        raise _refused(path, f"has a form that is not joined: {left[0].strip()[:60]!r}")
    if "import.meta" in body:
        raise _refused(path, "asks for its own address")
    return _Module(_DYNAMIC.sub("importJoined(", body), tuple(imports), exports)


def _pairs(text: str, path: str) -> list[tuple[str, str]]:
    """Names in braces, each with what it is called on the other side."""
    entries = [entry.strip() for entry in text.split(",") if entry.strip()]
    found = [_PAIR.fullmatch(entry) for entry in entries]
    if None in found:
        raise _refused(path, f"has a list of names that is not read: {text.strip()[:60]!r}")
    return [(one[1], one[2] or one[1]) for one in found if one is not None]


def _function(name: str, module: _Module, numbers: Mapping[str, str]) -> str:
    """A module as a function that is run at once and gives its names."""
    taken = [line.replace("{};", f"{numbers[path]};") for path, line in module.imports if line]
    given = ", ".join(one if one == own else f"{one}: {own}" for one, own in module.exports.items())
    lines = [
        f"const {name} = await (async () => {{",
        *taken,
        module.body.strip("\n"),
        f"return Object.freeze({{ {given} }});",
        "})();",
    ]
    return "\n".join(lines)


def _refused(path: str, what: str) -> RemanentError:
    return RemanentError(f"The module {path} of the page {what}. {FAULT}")
