"""What a notebook shows in place of the text of a value."""

from __future__ import annotations

from importlib import import_module


class ShownInNotebook:
    """A value whose formulas and numbers a notebook shows typeset."""

    def _repr_markdown_(self) -> str:
        # Units and SymPy belong to layers above this one, and are loaded when a notebook asks.
        markdown: str = import_module("remanent.results.notebook").markdown(self)
        return markdown
