"""How large the portions are into which work is divided.

One word stands for each level.  A *batch* is what fits into memory (made by the verbs), a
*chunk* the task of a thread, a *segment* one call of a kernel, and a *piece* a stretch of time
in which the load is smooth.  Results do not depend on the sizes of the first three.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._field import BINARY_OPERATOR_OF_OPERATION
from remanent.integrate.kernel.compile import Kernel

#: Instructions that a function such as ``exp`` stands for.
_FUNCTION_COST = 20


@dataclass(frozen=True)
class WorkSizes:
    """Sizes of chunks and segments; no result depends on them.

    Attributes
    ----------
    chunk_steps : float
        Fine steps of all trajectories in a chunk: about a tenth of a second.
    fewest_groups, most_groups : int
        Groups of trajectories in a chunk: enough to be worth its overhead, and few enough that
        what they take fits into the processor's cache.
    segment_work : int
        Instructions of all trajectories in a segment: hundredths of a second, so that calls of
        a kernel cost little and a run is cancelled within a fifth of a second.
    segment_records : int
        Fine steps of all trajectories in a segment whose states are all recorded: memory.
    fewest_steps, most_steps : int
        Fine steps of one trajectory in a segment.
    samples : int
        Samples between steps that are computed together: few enough to stay in the
        processor's cache.
    """

    chunk_steps: float = 2.0**23
    fewest_groups: int = 4
    most_groups: int = 256
    segment_work: int = 2**28
    segment_records: int = 2**17
    fewest_steps: int = 64
    most_steps: int = 2**15
    samples: int = 8192

    def trajectories_per_chunk(self, steps: float, width: int) -> int:
        """How many trajectories make a chunk, if each takes so many fine steps."""
        groups = np.clip(self.chunk_steps / (steps * width), self.fewest_groups, self.most_groups)
        return int(groups) * width

    def steps_per_segment(self, kernel: Kernel, trajectories: int, *, recorded: bool) -> int:
        """Fine steps of each of so many trajectories in a segment."""
        code = kernel.field.rates.instructions
        cost = sum(
            1 if operation in BINARY_OPERATOR_OF_OPERATION else _FUNCTION_COST
            for operation, *_ in code
        )
        steps = self.segment_work // max(kernel.method.evaluations * cost, 1)
        padded = -(-trajectories // kernel.width) * kernel.width
        if recorded:
            steps = min(steps, self.segment_records)
        return int(np.clip(steps // padded, self.fewest_steps, self.most_steps))


#: Sizes that suit a processor of today.
DEFAULT_SIZES = WorkSizes()
