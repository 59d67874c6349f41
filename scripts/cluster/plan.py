#!/usr/bin/env python3
"""Turns a plan into the time and memory that a task asks Slurm for.

    ssct COMMAND --plan TASKS --json | scripts/cluster/plan.py CPUS

Prints the time limit in minutes and the memory in MiB, each if the plan predicts it.
"""

import json
import math
import sys

MIB = 1 << 20
# A prediction may be half of the real time, and a node may be slower than the measured machine. A task that is stopped
# at its limit goes on with its journal: too little time costs another turn in the queue, too much delays the start.
TIME_FACTOR, TIME_MORE_S = 2, 600
# The driver and the allocator round up.
MEMORY_FACTOR, MEMORY_MORE_MIB = 1.5, 512


def resources(plan, cpus):
    """Minutes and MiB; None for each that is not predicted. Without measured cells, neither is."""
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
    [plan] = json.load(sys.stdin)
    print(*(value for value in resources(plan, int(sys.argv[1])) if value is not None))
