"""The command ``remanent``: parse, call one verb, present."""

from remanent.cli.main import commands, main
from remanent.cli.new import new

commands.add_command(new)

__all__ = ["main"]
