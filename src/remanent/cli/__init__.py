"""The command ``remanent``: parse, call one verb, present."""

from remanent.cli.main import main

__all__ = ["main"]
