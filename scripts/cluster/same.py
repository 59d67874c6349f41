#!/usr/bin/env python3
"""Checks that the records of two runs of the error study are equal except for their times.

    scripts/cluster/same.py A B     folders with an error.json each
"""

import json
import sys
from pathlib import Path

# The fields of a record that hold times.
TIMES = ("time_ms",)


def without_times(value):
    """Returns a record without its times, at every depth of nesting."""
    if isinstance(value, dict):
        return {name: without_times(part) for name, part in value.items() if name not in TIMES}
    if isinstance(value, list):
        return [without_times(part) for part in value]
    return value


def main(folders):
    """Compares the records of two folders. If they differ, ends with a message and status 1."""
    a, b = ([without_times(r) for r in json.loads((Path(f) / "error.json").read_text())] for f in folders)
    if not a:
        sys.exit(f"same: {folders[0]} has no records")
    if a != b:
        differing = [n for n, (one, other) in enumerate(zip(a, b)) if one != other]
        message = f"same: {folders[0]} has {len(a)} records, {folders[1]} {len(b)}; {len(differing)} differ"
        if differing:
            first = differing[0]
            message += f"; the first that differs is record {first}:\n{a[first]}\n{b[first]}"
        sys.exit(message)
    print(f"same: {len(a)} records, equal except for their times")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1:])
