"""The exceptions that this package raises, one family."""

from __future__ import annotations


class RemanentError(Exception):
    """Base of every exception this package raises on purpose."""


class InputError(RemanentError, ValueError):
    """An argument breaks a rule.

    The message names the argument, states the rule, the value received, the
    reason for the rule and the remedy, in this order.
    """

    def __init__(self, name: str, rule: str, value: object, reason: str, remedy: str) -> None:
        self.name, self.rule, self.value = name, rule, value
        super().__init__(f"`{name}` must {rule}; got {value}. {reason} {remedy}")


class InputWarning(UserWarning):
    """An argument is allowed but looks like a mistake."""
