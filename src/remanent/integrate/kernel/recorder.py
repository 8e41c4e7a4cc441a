"""Keeps states of the fine solution after every so many steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from llvmlite import ir

from remanent.integrate.kernel.lanes import Lanes, Writer


@dataclass(frozen=True)
class Recorder:
    """Writes states of one group into the array ``(record, group, state, lane)``.

    Attributes
    ----------
    memory : ir.Value
        Pointer to the array.
    groups, group : ir.Value
        How many groups there are, and the number of this one.
    every : ir.Value
        Fine steps between records; 0 for none.
    """

    writer: Writer
    memory: ir.Value
    groups: ir.Value
    group: ir.Value
    every: ir.Value

    def note(self, count: ir.Value, y: Sequence[Lanes]) -> None:
        """Record the state after `count` fine steps of this call, if it is due."""
        b, w = self.writer.builder, self.writer
        # The remainder of an integer division by zero is undefined, so that `every` is
        # compared with zero before.
        with b.if_then(b.icmp_signed("!=", self.every, w.integer(0)), likely=False):
            due = b.icmp_signed("==", b.srem(count, self.every), w.integer(0))
            with b.if_then(due, likely=False):
                self._write(b.sub(b.sdiv(count, self.every), w.integer(1)), y)

    def _write(self, number: ir.Value, y: Sequence[Lanes]) -> None:
        b, w = self.writer.builder, self.writer
        base = b.add(b.mul(number, self.groups), self.group)
        base = b.mul(base, w.integer(len(y) * w.width))
        for i, y_i in enumerate(y):
            w.store(y_i, self.memory, b.add(base, w.integer(i * w.width)))
