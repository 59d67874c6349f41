#!/usr/bin/env python3
"""Computes the ratios of unified to ssct and hzct from the records that scripts/bars.sh made: median, least and
greatest over the views, for each roughness and size. Writes times.csv, errors.csv and bars.txt beside the records.
If a second folder is given, unified's error against the world is also divided by that in its errors.csv."""

import csv
import json
import statistics
import sys
from collections import defaultdict
from pathlib import Path


def ratios(values):
    """Returns the median, the least and the greatest of some ratios as a text."""
    if not values:
        return "-"
    return f"{statistics.median(values):.3f} ({min(values):.3f} … {max(values):.3f})"


def cell(record):
    """Returns the place of a record: scene, view, width, height and roughness."""
    return (record["scene"], record["view"], record["width"], record["height"], round(record["roughness"], 4))


def main():
    folder = Path(sys.argv[1])
    records = [r for f in sorted(folder.glob("*.json")) if f.stat().st_size for r in json.loads(f.read_text())]
    times, errors = defaultdict(dict), defaultdict(dict)
    for r in records:
        if r["kind"] == "time":
            times[cell(r)][r["method"]] = r["total"]
        elif r["kind"] == "error":
            errors[cell(r)][r["method"], r["against"]] = r

    lines = []
    groups = sorted({(c[4], c[2], c[3]) for c in times})
    if records:
        first = records[0]
        device, oracle = first["device"], first.get("oracle", 1)
        lines += [f"{device['name']} ({device['driver']}), version {first['version']}, {first['commit']}, oracle {oracle}", ""]
    if times:
        lines += ["time of the effect, unified over ssct and over hzct: median over the views (least … greatest)", ""]
    for roughness, width, height in groups:
        here = [t for c, t in times.items() if c[4] == roughness and c[2:4] == (width, height)]
        over = [ratios([t["unified"]["median_ms"] / t[m]["median_ms"] for t in here]) for m in ("ssct", "hzct")]
        lines.append(f"roughness {roughness:<5} {width}x{height}  {len(here):2} views  ssct {over[0]}  hzct {over[1]}")
    if times and errors:
        lines.append("")

    world_there = {}
    if len(sys.argv) > 2:
        with open(Path(sys.argv[2]) / "errors.csv", newline="") as file:
            for r in csv.DictReader(file):
                if (r["method"], r["against"]) == ("unified", "world"):
                    size = int(r["width"]), int(r["height"])
                    world_there[r["scene"], r["view"], *size, round(float(r["roughness"]), 4)] = float(r["rmse"])

    groups = sorted({(c[4], c[2], c[3]) for c in errors})
    if errors:
        lines += ["error: unified over ssct; RMSE with the reference's own variance taken off; and unified over the screen reference, both against the world", ""]
    for roughness, width, height in groups:
        here = [e for c, e in errors.items() if c[4] == roughness and c[2:4] == (width, height)]

        def rmse(e, method):
            """Returns a method's RMSE against the screen reference, without the part that the reference's noise adds."""
            r = e[method, "screen"]
            return max(r["rmse"] ** 2 - r["standard_error"] ** 2, 0.0) ** 0.5

        screen = [rmse(e, "unified") / rmse(e, "ssct") for e in here]
        world = [e["unified", "world"]["rmse"] / e["screen-reference", "world"]["rmse"] for e in here]
        line = f"roughness {roughness:<5} {width}x{height}  {len(here):2} views  screen {ratios(screen)}  world {ratios(world)}"
        if roughness == 0:
            hits = [e["unified", "oracle"]["hit_agreement"] for e in here]
            wrong = [(1 - e["unified", "world"]["hit_agreement"]) / (1 - e["ssct", "world"]["hit_agreement"]) for e in here]
            line += f"  hits at least {min(hits):.6f}  wrong in the world {ratios(wrong)}"
        cells = [c for c in errors if c[4] == roughness and c[2:4] == (width, height)]
        both = [errors[c]["unified", "world"]["rmse"] / world_there[c] for c in cells if c in world_there]
        if both:
            line += f"  world over {sys.argv[2]} {ratios(both)}"
        lines.append(line)

    text = "\n".join(lines) + "\n"
    (folder / "bars.txt").write_text(text)
    print(text, end="")

    def table(name, head, rows):
        """Writes a CSV file beside the records."""
        with open(folder / name, "w", newline="") as file:
            csv.writer(file).writerows([head, *rows])

    place = ["scene", "view", "width", "height", "roughness", "method"]
    table(
        "times.csv",
        [*place, "median_ms", "min_ms", "p95_ms", "samples"],
        [[*c, m, t["median_ms"], t["min_ms"], t["p95_ms"], t["samples"]] for c, ms in sorted(times.items()) for m, t in ms.items()],
    )
    fields = ["hit_agreement", "rmse", "flip", "standard_error"]
    table(
        "errors.csv",
        [*place, "against", *fields],
        [[*c, m, a, *[r[f] for f in fields]] for c, rs in sorted(errors.items()) for (m, a), r in rs.items()],
    )


main()
