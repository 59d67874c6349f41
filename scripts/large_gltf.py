#!/usr/bin/env python3
"""Writes a large glTF scene: a million triangles and 64 images of 2048 x 2048 texels, a gigabyte once they are decoded.

    scripts/large_gltf.py FOLDER [--tiles 8] [--cells 89] [--side 2048]

The scene is a square floor of tiles under a sky, each with an image and a gently bumpy grid of its own. Its images are
noise, which no compression makes smaller. Needs nothing but Python.
"""

import argparse
import json
import math
import random
import struct
import zlib
from pathlib import Path


def png(side: int, seed: int) -> bytes:
    """Returns a picture of noise around one colour as the bytes of a PNG file. `side` is its width and height in texels."""
    noise = random.Random(seed)
    # Five bits of noise are added to one random colour of the picture, so that pictures can be told apart.
    tables = [bytes(base * 7 // 8 + (n >> 3) for n in range(256)) for base in noise.randbytes(3)]
    rows = bytearray()
    for _ in range(side):
        row = bytearray(3 * side)
        for channel, table in enumerate(tables):
            row[channel::3] = noise.randbytes(side).translate(table)
        rows += b"\0" + row

    def chunk(kind: bytes, data: bytes) -> bytes:
        """Returns a chunk of a PNG file: length, kind, data and checksum."""
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def grid(cells: int, x0: float, z0: float, side: float) -> tuple[bytes, bytes]:
    """Returns the vertices (position, normal, texture coordinates) and the indices of one tile, both as bytes.

    The tile begins at (x0, z0) and is `side` metres wide. It has `cells` squares of two triangles along each side.
    """
    vertices, indices = bytearray(), bytearray()
    for j in range(cells + 1):
        for i in range(cells + 1):
            u, v = i / cells, j / cells
            x, z = x0 + side * u, z0 + side * v
            y = 0.05 * math.sin(2.0 * x) * math.cos(1.5 * z)
            slope_x = 0.10 * math.cos(2.0 * x) * math.cos(1.5 * z)
            slope_z = -0.075 * math.sin(2.0 * x) * math.sin(1.5 * z)
            length = math.sqrt(1.0 + slope_x * slope_x + slope_z * slope_z)
            normal = (-slope_x / length, 1.0 / length, -slope_z / length)
            vertices += struct.pack("<8f", x, y, z, *normal, u, v)
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i
            b = a + cells + 1
            indices += struct.pack("<6I", a, b, a + 1, a + 1, b, b + 1)
    return bytes(vertices), bytes(indices)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("folder", type=Path)
    options.add_argument("--tiles", type=int, default=8, help="along a side of the floor")
    options.add_argument("--cells", type=int, default=89, help="along a side of a tile, of two triangles each")
    options.add_argument("--side", type=int, default=2048, help="texels along a side of an image")
    given = options.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)

    width = 4.0
    half = 0.5 * width * given.tiles
    buffer = bytearray()
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
             "materials": [], "textures": [], "images": [], "accessors": [], "bufferViews": [], "buffers": []}

    def view(data: bytes, stride: int | None = None) -> int:
        """Appends data to the buffer, and returns the index of its view. `stride` is the bytes from vertex to vertex."""
        section = {"buffer": 0, "byteOffset": len(buffer), "byteLength": len(data)}
        if stride:
            section["byteStride"] = stride
        buffer.extend(data)
        scene["bufferViews"].append(section)
        return len(scene["bufferViews"]) - 1

    def accessor(buffer_view: int, offset: int, component: int, count: int, kind: str, **bounds: list[float]) -> int:
        """Adds an accessor to a view, and returns its index. `component` is glTF's number of the type of a component."""
        scene["accessors"].append({"bufferView": buffer_view, "byteOffset": offset, "componentType": component,
                                   "count": count, "type": kind, **bounds})
        return len(scene["accessors"]) - 1

    for k in range(given.tiles**2):
        x0, z0 = k % given.tiles * width - half, k // given.tiles * width - half
        vertices, indices = grid(given.cells, x0, z0, width)
        count = (given.cells + 1) ** 2
        vertex_view = view(vertices, 32)
        bounds = {"min": [x0, -0.05, z0], "max": [x0 + width, 0.05, z0 + width]}
        attributes = {"POSITION": accessor(vertex_view, 0, 5126, count, "VEC3", **bounds),
                      "NORMAL": accessor(vertex_view, 12, 5126, count, "VEC3"),
                      "TEXCOORD_0": accessor(vertex_view, 24, 5126, count, "VEC2")}
        of_indices = accessor(view(indices), 0, 5125, 6 * given.cells**2, "SCALAR")
        scene["meshes"].append({"primitives": [{"attributes": attributes, "indices": of_indices, "material": k}]})
        scene["nodes"].append({"mesh": k})
        scene["scenes"][0]["nodes"].append(k)
        (given.folder / f"tile-{k}.png").write_bytes(png(given.side, k))
        scene["images"].append({"uri": f"tile-{k}.png"})
        scene["textures"].append({"source": k})
        scene["materials"].append({"name": f"tile-{k}", "pbrMetallicRoughness": {
            "baseColorTexture": {"index": k}, "metallicFactor": 0.5, "roughnessFactor": 0.1}})
    scene["buffers"].append({"uri": "scene.bin", "byteLength": len(buffer)})
    (given.folder / "scene.bin").write_bytes(buffer)
    (given.folder / "scene.gltf").write_text(json.dumps(scene))
    print(f"{2 * given.cells**2 * given.tiles**2} triangles, {given.tiles**2} images of {given.side} x {given.side}")


if __name__ == "__main__":
    main()
