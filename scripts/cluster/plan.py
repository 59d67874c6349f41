#!/usr/bin/env python3
"""What a task asks Slurm for, from what `ssct COMMAND --plan TASKS --json` predicts, which it reads.

    scripts/cluster/plan.py CPUS     prints the time limit in minutes, and the memory in MiB, where they are predicted
"""

import json
import math
import sys

MIB = 1 << 20
# A prediction may be off by half, and a node may be slower than what was measured. A task that is stopped at its limit goes
# on with its journal, so that too little costs a turn in the queue, and too much a later begin.
TIME_FACTOR, TIME_MORE_S = 2, 600
# The driver and the allocator round up.
MEMORY_FACTOR, MEMORY_MORE_MIB = 1.5, 512


def resources(plan, cpus):
    """Minutes and MiB; None for what is not predicted. Where no cell was measured, nothing is."""
    if plan["costs"]["cells"] == 0:
        return None, None
    seconds = plan["makespan_s"] * max(max(plan["costs"]["threads"]) / cpus, 1)
    minutes = math.ceil((TIME_FACTOR * seconds + TIME_MORE_S) / 60)
    if plan["memory_bytes"] is None:
        return minutes, None
    return minutes, math.ceil(MEMORY_FACTOR * plan["memory_bytes"] / MIB) + MEMORY_MORE_MIB


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    [of_the_tasks] = json.load(sys.stdin)
    print(*(value for value in resources(of_the_tasks, int(sys.argv[1])) if value is not None))
