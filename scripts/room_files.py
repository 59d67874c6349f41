"""Writes a glTF scene as people's tools would: as OBJ, as OBJ with PBR extensions, with copies by EXT_mesh_gpu_instancing, and as a
G-buffer by Cycles.

    python room_files.py ROOM.glb FOLDER [--size 480x270] [--samples 32]

needs `pip install bpy==5.2.3 numpy` and Python 3.13. Roughness and metalness of a combined image become images of their own, as
OBJ needs them. It writes map.toml for the G-buffer, and a scene file for each OBJ file with the view and the lights that the glTF file
has, exposed as ssct exposes them.
"""

import argparse
import json
import math
import os
import struct

import bpy
import numpy as np
from mathutils import Vector

AOVS = [("roughness", "VALUE", "Roughness"), ("metallic", "VALUE", "Metallic"), ("base color", "COLOR", "Base Color")]
# Lumens per watt: the factor by which Blender's glTF exporter converts watts to candela.
LUMENS = 683.0
MAP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples", "gbuffer-maps", "blender.toml")


def separate(material, channel, socket, folder):
    """Copies a channel of a combined image into an image of its own, and connects it with an input of the shader.

    `channel` is the index of the channel, and `socket` the name of the input. The image is saved in the folder.
    An input without such a combined image stays as it is.
    """
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    links = shader.inputs[socket].links
    if not links or links[0].from_node.type != "SEPARATE_COLOR":
        return
    source = links[0].from_node.inputs[0].links[0].from_node.image
    pixels = np.array(source.pixels[:]).reshape(-1, 4)
    grey = np.repeat(pixels[:, channel : channel + 1], 4, axis=1)
    grey[:, 3] = 1
    made = bpy.data.images.new(f"{material.name}-{socket.lower()}", *source.size)
    made.colorspace_settings.name = "Non-Color"
    made.pixels = grey.ravel().tolist()
    made.filepath_raw, made.file_format = os.path.join(folder, made.name + ".png"), "PNG"
    made.save()
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = made
    material.node_tree.links.new(node.outputs["Color"], shader.inputs[socket])


def add_aovs(material):
    """Makes the render write the values of three inputs of the shader as AOVs (arbitrary output variables)."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    for name, kind, socket in AOVS:
        output = nodes.new("ShaderNodeOutputAOV")
        output.aov_name = name
        fed = shader.inputs[socket].links
        if fed:
            source = fed[0].from_socket
        else:
            node = nodes.new("ShaderNodeValue" if kind == "VALUE" else "ShaderNodeRGB")
            node.outputs[0].default_value = shader.inputs[socket].default_value
            source = node.outputs[0]
        links.new(source, output.inputs["Value" if kind == "VALUE" else "Color"])


def render(folder, samples):
    """Renders the scene by Cycles to room.exr, with a filter of nearly no width, so that a pixel shows its centre."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", samples
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    layer = scene.view_layers[0]
    for name in ["z", "normal", "diffuse_direct", "diffuse_indirect", "diffuse_color", "emit", "environment"]:
        setattr(layer, f"use_pass_{name}", True)
    for name, kind, _ in AOVS:
        aov = layer.aovs.add()
        aov.name, aov.type = name, kind
    image = scene.render.image_settings
    image.media_type, image.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    image.color_depth, image.exr_codec = "32", "ZIP"
    scene.render.filepath = os.path.join(folder, "room.exr")
    bpy.ops.render.render(write_still=True)


def write_map(folder):
    """Writes map.toml: the map of the examples with the camera of this scene."""
    lens, place = bpy.context.scene.camera.data, bpy.context.scene.camera.matrix_world
    text = open(MAP).read()
    begin, end = text.index("focal-length-mm"), text.index("[depth]")
    rows = ", ".join(str(list(row)) for row in place)
    camera = (f"focal-length-mm = {lens.lens}\nsensor-height-mm = {lens.sensor_height}\nnear = {lens.clip_start}\n"
              f"far = {lens.clip_end}\nview-to-world = [{rows}]\n\n")
    open(os.path.join(folder, "map.toml"), "w").write(text[:begin] + camera + text[end:])


def ours(vector):
    """Converts a vector from Blender's axes (right-handed, z up) to the axes of scene files (right-handed, y up)."""
    return [round(float(v), 5) for v in (vector[0], vector[2], -vector[1])]


def write_scene_file(folder, name):
    """Writes a scene file for an OBJ file, with the view and the lights of Blender's scene.

    The energies are relative to the light that is brightest at the centre of the scene.
    """
    corners = np.array([thing.matrix_world @ Vector(corner) for thing in bpy.data.objects if thing.type == "MESH"
                        for corner in thing.bound_box])
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    lights = []
    for thing in (thing for thing in bpy.data.objects if thing.type == "LIGHT"):
        place, along = thing.matrix_world.translation, -thing.matrix_world.col[2]
        if thing.data.type == "SUN":
            lux = LUMENS * thing.data.energy
            lights.append((lux, lux, f'kind = "directional"\ndirection = {ours(along)}'))
        else:
            candela = LUMENS * thing.data.energy / (4 * math.pi)
            lux = candela / max(np.linalg.norm(np.array(place) - centre), 1.0) ** 2
            lights.append((lux, candela, f'kind = "point"\nposition = {ours(place)}'))
    brightest = max(lux for lux, _, _ in lights)
    camera = bpy.context.scene.camera
    eye, forward = camera.matrix_world.translation, -camera.matrix_world.col[2].to_3d()
    fov = math.degrees(2 * math.atan(camera.data.sensor_height / 2 / camera.data.lens))
    text = f'name = "room"\n[[mesh]]\nfile = "{name}.obj"\n'
    for _, strength, kind in lights:
        text += f"[[light]]\n{kind}\nenergy = {strength / brightest:.6f}\n"
    text += f"[camera]\nfov_y_deg = {fov:.5f}\nnear = {camera.data.clip_start}\nfar = {camera.data.clip_end}\n"
    text += f"[view.camera]\neye = {ours(eye)}\nlook_at = {ours(eye + 5 * forward)}\n"
    open(os.path.join(folder, name + ".scene.toml"), "w").write(text)


def instanced(source, target):
    """Copies a binary glTF file, and moves the transform of every node with a mesh into EXT_mesh_gpu_instancing."""
    data = open(source, "rb").read()
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20 : 20 + length]), bytearray(data[28 + length :])
    for node in (node for node in document["nodes"] if "mesh" in node):
        attributes = {}
        for name, key, kind in [("TRANSLATION", "translation", "VEC3"), ("ROTATION", "rotation", "VEC4"), ("SCALE", "scale", "VEC3")]:
            if key not in node:
                continue
            values = node.pop(key)
            document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
            binary += struct.pack(f"<{len(values)}f", *values)
            document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": 1, "type": kind})
            attributes[name] = len(document["accessors"]) - 1
        if attributes:
            node.setdefault("extensions", {})["EXT_mesh_gpu_instancing"] = {"attributes": attributes}
    document.setdefault("extensionsUsed", []).append("EXT_mesh_gpu_instancing")
    document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + bytes(binary)
    open(target, "wb").write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("room")
    arguments.add_argument("folder")
    arguments.add_argument("--size", default="480x270")
    arguments.add_argument("--samples", type=int, default=32)
    options = arguments.parse_args()
    folder = os.path.abspath(options.folder)
    os.makedirs(folder, exist_ok=True)
    instanced(options.room, os.path.join(folder, "instanced.glb"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(options.room))
    size = [int(side) for side in options.size.split("x")]
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = size
    bpy.context.scene.camera = next(thing for thing in bpy.data.objects if thing.type == "CAMERA")
    # The importer sets the field of view of glTF, which is vertical, with the sensor's height.
    assert bpy.context.scene.camera.data.sensor_fit == "VERTICAL"
    for image in [image for image in bpy.data.images if image.size[0]]:
        image.filepath_raw, image.file_format = os.path.join(folder, image.name.split(".")[0] + ".png"), "PNG"
        image.save()
    materials = [made for made in bpy.data.materials if made.users]
    for material in materials:
        separate(material, 1, "Roughness", folder)
        separate(material, 2, "Metallic", folder)
    for name, has_pbr in [("plain", False), ("pbr", True)]:
        bpy.ops.wm.obj_export(filepath=os.path.join(folder, name + ".obj"), export_pbr_extensions=has_pbr)
        write_scene_file(folder, name)
    for material in materials:
        add_aovs(material)
    render(folder, options.samples)
    write_map(folder)


main()
