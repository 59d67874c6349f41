"""Scenes whose reflections have an exact truth: a mirror or rough floor among unlit boxes and walls.

Each scene is a list of coloured quads. `write` makes of it a glTF file, a JSON file for programs that build their own meshes,
and the truth: what each floor pixel's ray meets, followed in double precision, and whether the camera sees that place.
"""

import base64
import json
import math
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 480, 270
XI = 0.244  # the share of a lobe outside its cone (docs/definitions.md, "Surfaces")
LOBE_RAYS = 256  # rays of a pixel of a rough floor
FLOOR = "floor"


@dataclass
class Scene:
    """Quads and a camera, in metres and right-handed axes with +y up."""

    name: str
    title: str
    eye: tuple
    look_at: tuple
    fov_y: float  # radians
    roughness: float = 0.0  # of the floor, as glTF has it
    colors: dict = field(default_factory=dict)  # material -> sRGB, 8 bits
    quads: list = field(default_factory=list)  # (material, four corners, normal)

    def quad(self, material, corners, normal):
        """Adds a quad. Its four corners run counter-clockwise around the normal."""
        self.quads.append((material, np.array(corners, float), np.array(normal, float)))

    def box(self, low, high, material, under=None):
        """Adds a box between two corners. `under` is the material of its lower side, which only a box that floats shows."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.quad(material, [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)], (0, 0, 1))
        self.quad(material, [(x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)], (0, 0, -1))
        self.quad(material, [(x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)], (1, 0, 0))
        self.quad(material, [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)], (-1, 0, 0))
        self.quad(material, [(x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)], (0, 1, 0))
        if under:
            self.quad(under, [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)], (0, -1, 0))

    def floor(self, x0, x1, z0, z1):
        """Adds the reflecting floor at y = 0."""
        self.quad(FLOOR, [(x0, 0, z1), (x1, 0, z1), (x1, 0, z0), (x0, 0, z0)], (0, 1, 0))


def boxes(name="boxes", title="boxes, two of which float", roughness=0.0):
    """Boxes before a wall, two of which float above the floor."""
    scene = Scene(name, title, (0, 1.6, 5), (0, 0.6, 0), 0.9, roughness)
    scene.colors = {
        "red": (210, 40, 40), "green": (40, 170, 60), "blue": (50, 80, 220), "yellow": (225, 200, 50),
        "cyan": (40, 190, 200), "magenta": (200, 60, 190), "orange": (240, 140, 30), "lime": (130, 230, 120),
        "wall": (110, 120, 150),
    }  # fmt: skip
    scene.floor(-4, 4, -4, 4)
    scene.quad("wall", [(-14, -2, -4.2), (14, -2, -4.2), (14, 9, -4.2), (-14, 9, -4.2)], (0, 0, 1))
    scene.box((-2.2, 0, -0.6), (-1.5, 0.6, 0.1), "red")
    scene.box((-0.75, 0, -1.6), (-0.15, 1.9, -1.0), "green")
    scene.box((0.55, 0, 0.3), (1.15, 0.9, 0.9), "blue")
    scene.box((2.0, 0, -2.2), (2.8, 1.35, -1.5), "yellow")
    scene.box((-1.4, 0.75, 0.6), (-0.5, 1.05, 1.4), "cyan", "orange")
    scene.box((1.3, 1.0, -1.2), (2.3, 1.3, -0.3), "magenta", "lime")
    return scene


def poles():
    """A corridor with poles that are two pixels wide and less."""
    scene = Scene("poles", "a corridor with thin poles", (0.2, 1.5, 6), (0, 0.9, 0), 0.9)
    scene.colors = {
        "left": (150, 110, 90), "right": (90, 130, 110), "end": (120, 120, 160), "ceiling": (200, 200, 190),
        "a": (230, 60, 50), "b": (60, 90, 230), "c": (240, 210, 60),
    }  # fmt: skip
    scene.floor(-2, 2, -8, 6)
    scene.quad("left", [(-2, -1, 6), (-2, -1, -8), (-2, 3, -8), (-2, 3, 6)], (1, 0, 0))
    scene.quad("right", [(2, -1, -8), (2, -1, 6), (2, 3, 6), (2, 3, -8)], (-1, 0, 0))
    scene.quad("end", [(-2, -1, -8), (2, -1, -8), (2, 3, -8), (-2, 3, -8)], (0, 0, 1))
    scene.quad("ceiling", [(-2, 3, -8), (2, 3, -8), (2, 3, 6), (-2, 3, 6)], (0, -1, 0))
    for n in range(14):
        x, z, half = -1.7 + 3.4 * ((n * 5) % 14) / 13, 2.5 - 0.7 * n, 0.012 + 0.004 * (n % 3)
        scene.box((x - half, 0, z - half), (x + half, 1.2 + 0.1 * (n % 4), z + half), "abc"[n % 3])
    return scene


def stair():
    """A stair behind the floor, which is seen at a grazing angle."""
    scene = Scene("stair", "a stair at grazing angles", (0.4, 0.35, 5), (0, 0.45, 0), 0.8)
    scene.colors = {
        "even": (200, 160, 110), "odd": (120, 80, 60), "wall": (100, 130, 160), "red": (210, 50, 50), "blue": (60, 90, 220),
    }  # fmt: skip
    scene.floor(-5, 5, -1, 4.5)
    for n in range(6):
        scene.box((-2.2, 0, -1.4 - 0.4 * n), (2.2, 0.16 * (n + 1), -1.0 - 0.4 * n), "even" if n % 2 == 0 else "odd")
    scene.quad("wall", [(-14, -2, -5), (14, -2, -5), (14, 9, -5), (-14, 9, -5)], (0, 0, 1))
    scene.box((-2.9, 0, 0.2), (-2.5, 1.4, 0.6), "red")
    scene.box((2.4, 0, -0.6), (3.0, 0.5, 0.0), "blue")
    return scene


def all_scenes():
    """Returns the scenes of the league."""
    return [boxes(), poles(), stair(), boxes("rough", "the boxes over a rough floor", 0.14)]


def basis(scene):
    """Returns the camera's unit vectors to the right, up and forward."""
    forward = np.subtract(scene.look_at, scene.eye).astype(float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def trace(scene, names, origin, direction, skip=None):
    """Traces rays to the nearest quad that shows its front. Returns the distance and the index of the material in `names`.

    `origin` and `direction` (of unit length) have shape (n, 3). Without a hit, the distance is infinite and the index 0. Quads of
    the material `skip` are passed.
    """
    best, who = np.full(len(origin), np.inf), np.zeros(len(origin), int)
    for material, corners, normal in scene.quads:
        if material == skip:
            continue
        towards = direction @ normal
        with np.errstate(all="ignore"):
            t = ((corners[0] - origin) @ normal) / towards
            place = origin + t[:, None] * direction - corners[0]
            along, up = corners[1] - corners[0], corners[3] - corners[0]
            u, v = place @ along / (along @ along), place @ up / (up @ up)
            is_hit = (towards < 0) & (t > 1e-9) & (t < best) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        best[is_hit], who[is_hit] = t[is_hit], names.index(material)
    return best, who


def exponent(roughness):
    """Returns the exponent of the cosine lobe that stands for a roughness of glTF (docs/definitions.md, "glTF")."""
    return math.log(0.5) / math.log(math.cos(2 * math.atan(roughness**2))) - 1


def truth(scene):
    """Returns the true picture (sRGB, 8 bits), and three masks of its pixels.

    `floor` marks pixels of the floor, `edge` pixels with a neighbour that shows another material, and `known` pixels whose
    reflected ray ends at a place that the camera sees.
    """
    names = ["nothing", FLOOR, *scene.colors]
    right, up, forward = basis(scene)
    half_y = math.tan(scene.fov_y / 2)
    half = np.array([half_y * WIDTH / HEIGHT, half_y])
    j, i = np.mgrid[0:HEIGHT, 0:WIDTH]
    across, along = ((i + 0.5) / WIDTH * 2 - 1) * half[0], (1 - (j + 0.5) / HEIGHT * 2) * half[1]
    direction = (forward + across[..., None] * right + along[..., None] * up).reshape(-1, 3)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    eye = np.array(scene.eye, float)
    far, first = trace(scene, names, np.broadcast_to(eye, direction.shape), direction)
    floor = first == names.index(FLOOR)
    start = eye + far[floor, None] * direction[floor]
    start[:, 1] = 0.0
    mirror = direction[floor] * (1.0, -1.0, 1.0)
    length, end = trace(scene, names, start, mirror, FLOOR)
    label = first.copy()
    label[floor] = end
    # The camera sees an end that projects to the screen and that its own ray meets first.
    place = start + np.where(np.isfinite(length), length, 0.0)[:, None] * mirror
    seen = place - eye
    z = seen @ forward
    distance = np.linalg.norm(seen, axis=1)
    nearest, met = trace(scene, names, np.broadcast_to(eye, seen.shape), seen / distance[:, None])
    with np.errstate(all="ignore"):
        inside = (z > 0) & (abs(seen @ right / z) < half[0]) & (abs(seen @ up / z) < half[1])
    known = np.zeros(WIDTH * HEIGHT, bool)
    known[floor] = (end > 0) & inside & (abs(nearest - distance) < 1e-6 * distance) & (met == end)
    palette = np.array([(0, 0, 0), (0, 0, 0), *scene.colors.values()], np.uint8)
    picture = palette[label].reshape(HEIGHT, WIDTH, 3)
    grid = label.reshape(HEIGHT, WIDTH)
    padded, edge = np.pad(grid, 1, mode="edge"), np.zeros(grid.shape, bool)
    for dy in range(3):
        for dx in range(3):
            edge |= padded[dy : dy + HEIGHT, dx : dx + WIDTH] != grid
    if scene.roughness > 0:
        picture[floor.reshape(grid.shape)] = rough(scene, names, palette, start, mirror)
        edge[:] = False
    shape = grid.shape
    return {"picture": picture, "floor": floor.reshape(shape), "edge": edge, "known": known.reshape(shape)}


def linear(color):
    """Converts sRGB from 0 to 255 to linear values from 0 to 1."""
    color = np.asarray(color, float) / 255
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def encoded(color):
    """Converts linear values from 0 to 1 to sRGB from 0 to 255."""
    color = np.clip(color, 0, 1)
    return np.round(255 * np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055))


def rough(scene, names, palette, start, mirror):
    """Returns the colour of each floor pixel in sRGB: the mean over its lobe around the mirror direction, by stratified rays.

    `start` and `mirror` have shape (n, 3). A ray below the floor counts as black.
    """
    random, power = np.random.default_rng(1), exponent(scene.roughness)
    colors, total = linear(palette), np.zeros(start.shape)
    side = int(math.sqrt(LOBE_RAYS))
    helper = np.cross(mirror, (0.0, 0.0, 1.0))
    helper /= np.linalg.norm(helper, axis=1)[:, None]
    other = np.cross(mirror, helper)
    for n in range(side * side):
        u = (n % side + random.random(len(start))) / side
        turn = 2 * np.pi * (n // side + random.random(len(start))) / side
        cosine = (1 - u) ** (1 / (power + 1))
        sine = np.sqrt(1 - cosine**2)
        ray = cosine[:, None] * mirror + sine[:, None] * (np.cos(turn)[:, None] * helper + np.sin(turn)[:, None] * other)
        _, end = trace(scene, names, start, ray, FLOOR)
        total += np.where(ray[:, 1:2] > 0, colors[end], 0.0)
    return encoded(total / (side * side))


def write(scene, folder):
    """Writes NAME.gltf, NAME.json and NAME.npz (the truth) to an existing folder."""
    folder = Path(folder)
    np.savez(folder / f"{scene.name}.npz", **truth(scene))
    right, up, forward = basis(scene)
    plain = {
        "name": scene.name, "width": WIDTH, "height": HEIGHT, "eye": scene.eye, "lookAt": scene.look_at,
        "fovY": scene.fov_y, "near": 0.1, "far": 50, "roughness": scene.roughness,
        "quads": [
            {"material": m, "corners": c.tolist(), "normal": n.tolist(), "color": list(scene.colors.get(m, (255, 255, 255)))}
            for m, c, n in scene.quads
        ],
    }  # fmt: skip
    (folder / f"{scene.name}.json").write_text(json.dumps(plain))
    (folder / f"{scene.name}.gltf").write_text(json.dumps(gltf(scene, np.stack([right, up, -forward], 1))))


def gltf(scene, axes):
    """Returns a scene as a glTF document. The columns of `axes` are the camera's right, up and backward vectors."""
    data, views, accessors, meshes, materials = b"", [], [], [], []

    def add(values, form, target, component, kind, bounds=False):
        """Packs values into the buffer by a form of `struct`, and returns the index of their accessor."""
        nonlocal data
        packed = b"".join(struct.pack(form, *v) for v in values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed), "target": target})
        data += packed + bytes(-len(packed) % 4)
        accessor = {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
        if bounds:
            rounded = np.array(values, np.float32)
            accessor |= {"min": rounded.min(0).tolist(), "max": rounded.max(0).tolist()}
        accessors.append(accessor)
        return len(accessors) - 1

    for name in [FLOOR, *scene.colors]:
        own = [(c, n) for m, c, n in scene.quads if m == name]
        corners = [tuple(p) for c, _ in own for p in c]
        normals = [tuple(n) for _, n in own for _ in range(4)]
        indices = [(4 * q + k,) for q in range(len(own)) for k in (0, 1, 2, 0, 2, 3)]
        attributes = {
            "POSITION": add(corners, "<3f", 34962, 5126, "VEC3", True),
            "NORMAL": add(normals, "<3f", 34962, 5126, "VEC3"),
        }
        is_floor = name == FLOOR
        color = [1.0, 1.0, 1.0] if is_floor else linear(scene.colors[name]).tolist()
        material = {
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [*color, 1.0],
                "metallicFactor": 1.0 if is_floor else 0.0,
                "roughnessFactor": scene.roughness if is_floor else 0.9,
            },
        }
        if not is_floor:
            material["extensions"] = {"KHR_materials_unlit": {}}
        primitive = {
            "attributes": attributes,
            "indices": add(indices, "<H", 34963, 5123, "SCALAR"),
            "material": len(materials),
        }
        materials.append(material)
        meshes.append({"name": name, "primitives": [primitive]})
    nodes = [{"name": m["name"], "mesh": k} for k, m in enumerate(meshes)]
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = axes, scene.eye
    nodes.append({"name": "camera", "camera": 0, "matrix": placed.T.flatten().tolist()})
    lens = {"yfov": scene.fov_y, "aspectRatio": WIDTH / HEIGHT, "znear": 0.1, "zfar": 50.0}
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [
            {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
        ],
        "cameras": [{"type": "perspective", "perspective": lens}],
    }
