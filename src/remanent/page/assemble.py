"""The page as one file: everything within it, and nothing asked of a network."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

from remanent._errors import FAULT, RemanentError
from remanent.page.files import PLOTLY_STYLES, assets_folder, module_sources, plotly_script
from remanent.page.joined import joined_modules
from remanent.page.model import PageModel, page_model_of_spec
from remanent.page.reproduction import reproduction
from remanent.page.spec import read_spec
from remanent.studies.export.export import export

#: The module that is run, and where it and the other files stand in the page of the server.
_ENTRY: Final = "app/main.js"
_ROOT: Final = "/assets/"
#: What stands in the page for a file of its own, and for the library.
_STYLE: Final = re.compile(r'<link rel="stylesheet" href="(/assets/[\w./-]+)">\n?')
_ICON: Final = re.compile(r'<link rel="icon" href="(/assets/[\w./-]+)">\n?')
_SCRIPT: Final = re.compile(r'<script\b[^>]*\bsrc="[^"]*"[^>]*></script>\n?')
_TITLE: Final = re.compile(r"<title>.*?</title>", re.S)
#: Anything that is still asked for from elsewhere.
_ELSEWHERE: Final = re.compile(r'\b(?:src|href)="(?!#|data:)[^"]*"')
#: Languages of the equations that are kept in the file: those that are written at once.
_LANGUAGES: Final = ("python", "matlab", "julia", "c", "javascript")


def saved_page(
    model: PageModel,
    results: Mapping[str, Any] | None = None,
    *,
    languages: Sequence[str] = _LANGUAGES,
    presets: Sequence[Mapping[str, Any]] = (),
) -> str:
    """The page of a model as one file that works alone, from a disk, without a network.

    Parameters
    ----------
    model : PageModel
        What it begins with.  Numbers move in it, kinds of parts do not.
    results : mapping of str to dict, optional
        What the engine found, by the names of the jobs: plain data that the page draws.
    languages : sequence of str
        Those in which the file holds the equations.
    presets : sequence of mapping
        What can be chosen in it besides, as :func:`~remanent.page.presets.presets` has it: each
        with its equations, without results of the engine.

    Returns
    -------
    str
        HTML.  It may load nothing, and run only the scripts in it, by their digests.

    Raises
    ------
    RemanentError
        The package plotly is not installed.
    """
    others = [page_model_of_spec(preset["spec"]) for preset in presets]
    fields = {_address(one): one.field_source for one in (model, *others)}
    script = _script(joined_modules(module_sources(), _ENTRY, fields))
    library = _script(plotly_script().read_text(encoding="utf-8"))
    text = (assets_folder() / "index.html").read_text(encoding="utf-8")
    styles = "\n".join(_file(path) for path in _STYLE.findall(text))
    if re.search(r"</style", styles, re.I):
        raise RemanentError(f"A style of the page has the end of a style in it. {FAULT}")
    text = _ICON.sub(lambda found: _icon(found[1]), _SCRIPT.sub("", _STYLE.sub("", text)))
    title = f"<title>{html.escape(model.description['title'])}</title>"
    head = f"{_policy([library, script], [styles, ''])}\n{title}\n<style>{styles}</style>"
    text = _TITLE.sub(lambda _: head, text, count=1)
    start = _start(model, results, languages) | {
        "presets": [_preset(*pair) for pair in zip(presets, others, strict=True)]
    }
    tail = (
        f'<script type="application/json" id="start">{data_text(start)}'
        f'</script>\n<script>{library}</script>\n<script type="module">{script}</script>\n'
    )
    before, end, after = text.rpartition("</body>")
    left = _ELSEWHERE.search(text)
    if not end or left is not None:
        raise RemanentError(
            f"The page cannot be one file, for {left[0] if left else 'want of a body'}. {FAULT}"
        )
    return f"{before}{tail}{end}{after}"


def _address(model: PageModel) -> str:
    """Under which its equations are asked for, as in the page of the server."""
    return f"/fields/{model.id}.js"


def _start(
    model: PageModel, results: Mapping[str, Any] | None, languages: Sequence[str]
) -> dict[str, Any]:
    """What the page begins with."""
    system, drive, _ = read_spec(model.spec)
    return {
        "version": _version(),
        "model": model.description,
        "field": _address(model),
        "results": dict(results or {}),
        "reproduction": reproduction(model.spec),
        "exports": {one: export(system, drive, one) for one in languages},
        "store": None,
    }


def _preset(preset: Mapping[str, Any], model: PageModel) -> dict[str, Any]:
    """A preset with all that the page needs to show it."""
    length = {name: preset["view"].get(name) for name in ("periods", "duration")}
    return {
        **preset,
        "spec": model.spec,
        "model": model.description,
        "field": _address(model),
        "reproduction": reproduction(model.spec, **length),
    }


def data_text(data: object) -> str:
    r"""Plain data as JSON that may stand within a script: no text in it can end that.

    Examples
    --------
    >>> data_text({"title": "</script><!--"})
    '{"title": "\\u003c/script\\u003e\\u003c!--"}'
    """
    text = json.dumps(data, allow_nan=False)
    for mark in "<>&":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return text


def _script(text: str) -> str:
    """A script as it may stand within a page: nothing in it ends or comments it."""
    text = text.replace("\r\n", "\n")
    if re.search(r"</script|<!--", text, re.I):
        raise RemanentError("A script of the page has the end of a script in it.")
    return text


def _file(path: str) -> str:
    return (assets_folder() / path.removeprefix(_ROOT)).read_text(encoding="utf-8")


def _icon(path: str) -> str:
    encoded = base64.b64encode(_file(path).encode()).decode()
    return f'<link rel="icon" href="data:image/svg+xml;base64,{encoded}">\n'


def _policy(scripts: Sequence[str], styles: Sequence[str]) -> str:
    """What the page may do: run and look as its own text says, draw pictures, nothing else."""
    rules = (
        "default-src 'none'",
        f"script-src {' '.join(map(_digest, scripts))}",
        f"style-src {' '.join(map(_digest, styles))}",
        f"style-src-attr 'unsafe-hashes' {' '.join(map(_digest, PLOTLY_STYLES))}",
        "img-src data: blob:",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return f'<meta http-equiv="Content-Security-Policy" content="{"; ".join(rules)}">'


def _digest(text: str) -> str:
    found = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return f"'sha256-{found}'"


def _version() -> str:
    try:
        return version("remanent")
    except PackageNotFoundError:
        return "(not installed)"
