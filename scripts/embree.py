#!/usr/bin/env python3
"""Holds the walk of `traced` against Embree's on one core: the mirror rays of a view, each to its nearest triangle.

    scripts/embree.py SSCT OUT [--scene museum] [--view NAME] [--size 480x270] [--rounds 5] [--samples 5]

SSCT is the program. Both run by turns, as often as there are rounds, on one thread each: Embree's closest hit alone, by the package
embreex; the pass of `traced` for mirrors without what colours a hit; and the whole pass. The pass is timed by the device's time stamps
on lavapipe with one thread, where they are that thread's time as long as nothing else runs. OUT/embree.csv gets a row for each
round, and OUT/embree.txt the medians. Needs embreex and numpy (`make embree` installs them).
"""

import argparse
import csv
import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

SHADERS = Path(__file__).resolve().parent.parent / "shaders-glsl"
# The statement in the shader that colours a hit, and the statement that replaces it. The replacement writes the hit's distance
# and weights, so that the image shows where each ray hit.
COLORED = "vec3 color = HitColor(ray, hit, width);"
WALKED = "vec3 color = vec3(hit.t, hit.weight);"


def run(command, **environment):
    """Returns the standard output of a command, or ends the script with the command's error."""
    try:
        done = subprocess.run(list(map(str, command)), env=os.environ | environment, capture_output=True, text=True)
    except OSError as error:
        sys.exit(f"embree: {command[0]}: {error.strerror}")
    if done.returncode:
        sys.exit(f"embree: {command[0]} ended with status {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def triangles(folder):
    """Returns the corners of every triangle of an export as an array of shape (n, 3, 3), in the order of the meshes."""
    corners = []
    for path in sorted((folder / "meshes").glob("*.ply")):
        header, body = path.read_bytes().split(b"end_header\n", 1)
        counts = [int(line.split()[2]) for line in header.splitlines() if line.startswith(b"element")]
        vertices = np.frombuffer(body, np.dtype("<f4"), 8 * counts[0]).reshape(-1, 8)[:, :3]
        faces = np.frombuffer(body[32 * counts[0] :], np.dtype([("n", "u1"), ("v", "<i4", 3)]), counts[1])["v"]
        corners.append(vertices[faces])
    return np.concatenate(corners)


def mirror_rays(folder):
    """Returns the origins and the directions of the export's mirror rays, each of shape (n, 3), and the mesh that each ray
    meets in double precision, or -1."""

    def array(name):
        return np.load(folder / f"{name}.npy")

    normal, incoming = array("receiver_normal"), array("receiver_incoming")
    direction = incoming - 2 * np.sum(normal * incoming, axis=1, keepdims=True) * normal
    start = json.loads((folder / "truth.json").read_text())["ray_start_m"]
    return (array("receiver_position") + start * direction).astype(np.float32), direction.astype(np.float32), array("mirror_mesh")


def follow(arguments, view, shaders):
    """Times `traced` with the shaders of a folder. Returns the record, and the median time in milliseconds of the pass that
    follows the mirror rays."""
    command = [arguments.ssct, "time", *view, "--method", "traced", "--samples", arguments.samples, "--json"]
    record = json.loads(run(command, LP_NUM_THREADS="1", SSCT_SHADERS=str(shaders)))[0]
    if record["device"]["type"] != "CPU":
        sys.exit(f"embree: {record['device']['name']} is no driver on a CPU; VK_DRIVER_FILES names lavapipe's file")
    times = [p["median_ms"] for p in record["passes"] if p["name"] == "trace/mirrors"]
    if not times:
        sys.exit(f"embree: {arguments.scene} {record['view']} has no mirrors")
    return record, times[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ssct", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scene", default="museum")
    parser.add_argument("--view")
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--samples", type=int, default=5)
    arguments = parser.parse_args()
    view = ["--scene", arguments.scene, "--size", arguments.size, "--roughness", "0"]
    view += ["--view", arguments.view] if arguments.view else []
    arguments.out.mkdir(parents=True, exist_ok=True)

    export = arguments.out / "export"
    run([arguments.ssct, "truth", "export", *view, "--samples", "2", "-o", export])
    origins, directions, meets = mirror_rays(export)
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, triangles(export))

    walk = arguments.out / "walk"
    shutil.rmtree(walk, ignore_errors=True)
    shutil.copytree(SHADERS, walk)
    among = walk / "triangles/among.glsl"
    text = among.read_text()
    if text.count(COLORED) != 1:
        sys.exit(f"embree: {SHADERS}/triangles/among.glsl colours its hits otherwise than by '{COLORED}'")
    among.write_text(text.replace(COLORED, WALKED))

    rows = []
    for index in range(arguments.rounds):
        begin = time.process_time()
        met = scene.run(origins, directions)
        embree = time.process_time() - begin
        record, alone = follow(arguments, view, walk)
        _, whole = follow(arguments, view, SHADERS)
        rows.append(
            {
                "round": index,
                "rays": len(origins),
                "embree_per_s": len(origins) / embree,
                "walk_per_s": 1e3 * len(origins) / alone,
                "shaded_per_s": 1e3 * len(origins) / whole,
            }
        )

    with open(arguments.out / "embree.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)

    def summary(values):
        """Returns the median, the least and the greatest of the rounds as a text."""
        return f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})"

    agree = np.mean((met >= 0) == (meets >= 0))
    lines = [
        f"{record['device']['name']} ({record['device']['driver']}), {record['commit']}",
        f"{arguments.scene} {record['view']}, {arguments.size}: {len(origins)} mirror rays; Embree meets a triangle where the "
        f"reference does for {agree:.5f} of them",
        "rays a second on one thread, median (least to greatest) of " f"{arguments.rounds} rounds",
        f"  Embree, closest hit alone     {summary([r['embree_per_s'] for r in rows])}",
        f"  traced, walk alone            {summary([r['walk_per_s'] for r in rows])}",
        f"  traced, with what it shows    {summary([r['shaded_per_s'] for r in rows])}",
        f"  walk over Embree              {summary([r['walk_per_s'] / r['embree_per_s'] for r in rows])}",
        f"  with what it shows, too       {summary([r['shaded_per_s'] / r['embree_per_s'] for r in rows])}",
    ]
    text = "\n".join(lines) + "\n"
    (arguments.out / "embree.txt").write_text(text)
    print(text, end="")


main()
