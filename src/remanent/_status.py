"""What became of a trajectory: one integer, one meaning."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """The outcome of one trajectory; the values are part of the public interface."""

    NOT_COMPUTED = 0
    OK = 1
    HORIZON = 2
    ESCAPED = 3
    INVALID = 4
    DIVERGED = 5
    SINGULAR = 6
    MAX_STEPS = 7
    TIMEOUT = 8

    @property
    def meaning(self) -> str:
        """The CF flag meaning, for example ``max-steps``."""
        return self.name.lower().replace("_", "-")
