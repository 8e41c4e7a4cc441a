"""What became of a point of a result: one integer, one meaning."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """What became of one trajectory, orbit search, branch or point of a sweep.

    A status is stored as int8 with the CF attributes ``flag_values`` and ``flag_meanings``.
    The values are part of the public interface and never change.

    See Also
    --------
    InputError : What a single call raises where a point of a grid is ``invalid``.

    Examples
    --------
    >>> Status(2).meaning, Status.HORIZON.explanation
    ('horizon', 'The tolerance was met up to the horizon only; later values are NaN.')
    """

    NOT_COMPUTED = 0
    OK = 1
    HORIZON = 2
    ESCAPED = 3
    INVALID = 4
    DIVERGED = 5
    SINGULAR = 6
    MAX_STEPS = 7
    TIMEOUT = 8
    INCOMPLETE = 9
    FAILED = 10

    @property
    def meaning(self) -> str:
        """The CF flag meaning, for example ``max-steps``."""
        return self.name.lower().replace("_", "-")

    @property
    def explanation(self) -> str:
        """What it means, in a sentence."""
        return _EXPLANATION_OF_STATUS[self]


_EXPLANATION_OF_STATUS = {
    Status.NOT_COMPUTED: "It has not been computed yet.",
    Status.OK: "All that was asked for was computed within the tolerance.",
    Status.HORIZON: "The tolerance was met up to the horizon only; later values are NaN.",
    Status.ESCAPED: "The motion left every bound; nothing holds it.",
    Status.INVALID: "A value breaks a rule of its field, so nothing was computed.",
    Status.DIVERGED: "An iteration did not converge.",
    Status.SINGULAR: "The equations lose their meaning at this point.",
    Status.MAX_STEPS: "The tolerance was not met with the finest steps that are tried.",
    Status.TIMEOUT: "It took longer than the cap that the caller set.",
    Status.INCOMPLETE: "The search or branch stopped early; what it found is there, with a reason.",
    Status.FAILED: "The point crashed or ran out of memory three times.",
}
