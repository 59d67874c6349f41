#!/usr/bin/env python3
"""Measures what the passes of a multilayer OpenEXR file of Blender mean, by comparison with its Position pass.

    python scripts/blender_passes.py MAP.toml FILE.exr…

prints JSON: how far Depth is from the distance along the view and from the distance along the ray, how far the Position pass is
from the centres of the pixels, the lengths of normals, and the depth of the background. The camera is that of MAP.toml, the map
of the files. Needs the Python packages OpenEXR and numpy.
"""

import json
import sys
import tomllib

import numpy
import OpenEXR


def channels(path):
    """Returns the channels of a file by their names, each as an array of floats of shape (height, width)."""
    with OpenEXR.File(path, separate_channels=True) as file:
        return {name: c.pixels.astype(float) for part in file.parts for name, c in part.channels.items()}


def passes(path, camera):
    """Returns the measurements of a file as a record. The camera is the table `camera` of the map."""
    arrays = channels(path)
    vector = lambda name: numpy.stack([arrays[f"ViewLayer.{name}.{axis}"] for axis in "XYZ"], -1)
    depth, normal = arrays["ViewLayer.Depth.Z"], vector("Normal")
    height, width = depth.shape
    there = depth < camera["far"]
    to_view = numpy.linalg.inv(numpy.array(camera["view-to-world"]))
    view = vector("Position") @ to_view[:3, :3].T + to_view[:3, 3]
    along, ray = -view[..., 2], numpy.linalg.norm(view, axis=-1)
    pixels = camera["focal-length-mm"] / camera["sensor-width-mm"] * width
    with numpy.errstate(divide="ignore", invalid="ignore"):
        x = view[..., 0] / along * pixels + width / 2 - 0.5
        y = height / 2 - 0.5 - view[..., 1] / along * pixels
    rows, columns = numpy.mgrid[0:height, 0:width]
    off = numpy.hypot(x - columns, y - rows)[there]
    length = numpy.linalg.norm(normal, axis=-1)[there]
    return {
        "file": path.rsplit("/", 1)[-1],
        "covered": float(there.mean()),
        "depth_m": [float(depth[there].min()), float(depth[there].max())],
        "depth_of_background": sorted({float(v) for v in depth[~there]})[:2],
        "off_view_z_m": float(numpy.abs(depth - along)[there].max()),
        "off_distance_m": float(numpy.abs(depth - ray)[there].max()),
        "position_off_centre_px": {"median": float(numpy.median(off)), "most": float(off.max())},
        "normal_length": {"least": float(length.min()), "p05": float(numpy.quantile(length, 0.05))},
    }


def main():
    with open(sys.argv[1], "rb") as file:
        camera = tomllib.load(file)["camera"]
    print(json.dumps([passes(path, camera) for path in sys.argv[2:]], indent=1))


main()
