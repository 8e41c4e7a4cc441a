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
_INSTRUCTIONS_PER_FUNCTION = 20


@dataclass(frozen=True)
class WorkSizes:
    """Sizes of chunks and segments; no result depends on them.

    Attributes
    ----------
    fine_steps_per_chunk : float
        Fine steps of all trajectories in a chunk: about a tenth of a second.
    min_groups_per_chunk, max_groups_per_chunk : int
        Groups of trajectories in a chunk: enough to be worth its overhead, and few enough that
        what they take fits into the processor's cache.
    instructions_per_segment : int
        Instructions of all trajectories in a segment: hundredths of a second, so that calls of
        a kernel cost little and a run is cancelled within a fifth of a second.
    recorded_fine_steps_per_segment : int
        Fine steps of all trajectories in a segment whose states are all recorded: memory.
    min_fine_steps_per_segment, max_fine_steps_per_segment : int
        Fine steps of one trajectory in a segment.
    samples_per_block : int
        Samples between steps that are computed together: few enough to stay in the
        processor's cache.
    """

    fine_steps_per_chunk: float = 2.0**23
    min_groups_per_chunk: int = 4
    max_groups_per_chunk: int = 256
    instructions_per_segment: int = 2**28
    recorded_fine_steps_per_segment: int = 2**17
    min_fine_steps_per_segment: int = 64
    max_fine_steps_per_segment: int = 2**15
    samples_per_block: int = 8192

    def trajectories_per_chunk(self, steps: float, lane_count: int) -> int:
        """How many trajectories make a chunk, if each takes so many fine steps."""
        groups = np.clip(
            self.fine_steps_per_chunk / (steps * lane_count),
            self.min_groups_per_chunk,
            self.max_groups_per_chunk,
        )
        return int(groups) * lane_count

    def fine_steps_per_segment(self, kernel: Kernel, trajectories: int, *, recorded: bool) -> int:
        """Fine steps of each of so many trajectories in a segment."""
        code = kernel.field.rates.instructions
        cost = sum(
            1 if operation in BINARY_OPERATOR_OF_OPERATION else _INSTRUCTIONS_PER_FUNCTION
            for operation, *_ in code
        )
        steps = self.instructions_per_segment // max(kernel.method.evaluations_per_step * cost, 1)
        padded = -(-trajectories // kernel.lane_count) * kernel.lane_count
        if recorded:
            steps = min(steps, self.recorded_fine_steps_per_segment)
        return int(
            np.clip(
                steps // padded, self.min_fine_steps_per_segment, self.max_fine_steps_per_segment
            )
        )


#: Sizes that suit a processor of today.
DEFAULT_WORK_SIZES = WorkSizes()
