"""The files of the page, and the library that draws."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Final

from remanent._errors import RemanentError

#: Style attributes that plotly.js writes: of the pixels of a chart, and of words in its titles.
PLOTLY_STYLES: Final = (
    "",
    "image-rendering: optimizeSpeed; image-rendering: -moz-crisp-edges; "
    "image-rendering: -o-crisp-edges; image-rendering: -webkit-optimize-contrast; "
    "image-rendering: optimize-contrast; image-rendering: crisp-edges; "
    "image-rendering: pixelated; ",
    "font-style:italic",
    "font-weight:bold",
    "font-size:70%",
)


def assets_folder() -> Path:
    """The folder of the page's own files."""
    return Path(__file__).with_name("assets")


def module_sources() -> dict[str, str]:
    """The text of every module of the page, by its path within the folder."""
    folder = assets_folder()
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*.js"))
    }


def plotly_script() -> Path:
    """plotly.js in the package plotly, found without importing that.

    Raises
    ------
    RemanentError
        The package is not installed.
    """
    spec = find_spec("plotly")
    if spec is None or not spec.submodule_search_locations:
        raise RemanentError(
            "The page draws with plotly.js, which is in the package plotly. Install it with "
            "`pip install 'remanent[web]'`."
        )
    return Path(spec.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
