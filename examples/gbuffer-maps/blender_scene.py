"""Renders the scene for which the camera in blender.toml stands, with the passes that the map reads.

    python blender_scene.py cycles.exr --engine CYCLES --samples 64

needs Blender 5.2 as a Python module (`pip install bpy==5.2.3`, Python 3.13); inside Blender, `blender -b -P blender_scene.py --`
stands before the arguments. It prints the camera's numbers as blender.toml has them.
"""

import argparse
import os
import sys

import bpy
from mathutils import Vector

PASSES = ["z", "position", "normal", "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct",
          "glossy_indirect", "glossy_color", "emit", "environment"]


def material(name, base, metallic, roughness):
    """A Principled BSDF whose base color, metallic and roughness are also written as AOVs."""
    made = bpy.data.materials.new(name)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*base, 1.0)
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Roughness"].default_value = roughness
    for name, kind, socket, value in [
        ("roughness", "ShaderNodeValue", "Value", roughness),
        ("metallic", "ShaderNodeValue", "Value", metallic),
        ("base color", "ShaderNodeRGB", "Color", (*base, 1.0)),
    ]:
        source, output = nodes.new(kind), nodes.new("ShaderNodeOutputAOV")
        source.outputs[0].default_value = value
        output.aov_name = name
        links.new(source.outputs[0], output.inputs[socket])
    return made


def build(scene):
    """A mirror of rough metal with a cube, a ball and a post on it, under a sun and a blue sky."""
    mesh, add = bpy.ops.mesh, lambda m: bpy.context.object.data.materials.append(m)
    mesh.primitive_plane_add(size=12)
    add(material("floor", (0.8, 0.8, 0.8), 1.0, 0.1))
    mesh.primitive_cube_add(size=2, location=(0, 0, 1), rotation=(0, 0, 0.5))
    add(material("cube", (0.8, 0.1, 0.05), 0.0, 0.5))
    mesh.primitive_uv_sphere_add(radius=0.9, location=(-2.4, -0.5, 0.9), segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()
    add(material("ball", (0.1, 0.3, 0.8), 0.0, 0.3))
    mesh.primitive_cylinder_add(radius=0.5, depth=3, location=(2.5, 0.5, 1.5))
    add(material("post", (0.9, 0.7, 0.1), 0.0, 0.4))
    bpy.ops.object.light_add(type="SUN", location=(4, 1, 6), rotation=(0.6, 0.3, 0.2))
    bpy.context.object.data.energy = 3
    scene.world = bpy.data.worlds.new("sky")
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.3, 0.5, 0.9, 1.0)
    bpy.ops.object.camera_add(location=(5.5, -6.5, 2.6))
    camera = bpy.context.object
    towards = Vector((-0.2, 0, 0.7)) - camera.location
    camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    return camera


def add_file_output(scene, path):
    """A File Output node that writes the passes of the map beside the render, as NAME-node.exr."""
    tree = bpy.data.node_groups.new("passes", "CompositorNodeTree")
    scene.compositing_node_group = tree
    layers, output = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
    layers.scene = scene
    output.format.media_type, output.format.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    output.format.color_depth, output.format.exr_codec = "32", "ZIP"
    output.directory = os.path.dirname(path)
    output.file_name = os.path.splitext(os.path.basename(path))[0] + "-node"
    kinds = {"VALUE": "FLOAT", "RGBA": "RGBA", "VECTOR": "VECTOR"}
    wanted = ["Depth", "Normal", "Diffuse Direct", "Diffuse Indirect", "Diffuse Color", "Emission", "Environment",
              "roughness", "metallic", "base color"]
    for name in wanted:
        source = layers.outputs[name]
        output.file_output_items.new(kinds[source.type], name)
        tree.links.new(source, output.inputs[name])


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("output")
    arguments.add_argument("--engine", default="CYCLES", help="CYCLES or BLENDER_EEVEE")
    arguments.add_argument("--samples", type=int, default=64)
    arguments.add_argument("--size", default="160x90")
    arguments.add_argument("--codec", default="ZIP", help="ZIP, PIZ, DWAA, …")
    arguments.add_argument("--half", action="store_true")
    arguments.add_argument("--interleave", action="store_true", help="one part in the place of many")
    arguments.add_argument("--stereo", action="store_true", help="a view for each eye")
    arguments.add_argument("--pixel-aspect", type=float, default=1.0, help="width of a pixel over its height")
    arguments.add_argument("--crop", action="store_true", help="the right upper quarter alone, as a border render with crop")
    arguments.add_argument("--file-output", action="store_true", help="by the compositor's node, beside the output")
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    options = arguments.parse_args(own)

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = build(scene)
    scene.render.engine = options.engine
    scene.cycles.samples = options.samples
    scene.render.resolution_x, scene.render.resolution_y = map(int, options.size.split("x"))
    layer = scene.view_layers[0]
    for name in PASSES:
        setattr(layer, f"use_pass_{name}", True)
    for name, kind in [("roughness", "VALUE"), ("metallic", "VALUE"), ("base color", "COLOR")]:
        aov = layer.aovs.add()
        aov.name, aov.type = name, kind
    image = scene.render.image_settings
    image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER"
    image.color_depth = "16" if options.half else "32"
    image.exr_codec = options.codec
    image.use_exr_interleave = options.interleave
    scene.render.use_multiview, scene.render.views_format = options.stereo, "STEREO_3D"
    image.views_format = "MULTIVIEW" if options.stereo else "INDIVIDUAL"
    scene.render.pixel_aspect_x = options.pixel_aspect
    scene.render.use_border = scene.render.use_crop_to_border = options.crop
    scene.render.border_min_x, scene.render.border_min_y = 0.5, 0.5
    if options.file_output:
        add_file_output(scene, os.path.abspath(options.output))
    # An absolute path, since Blender resolves others against the folder of the .blend file, and there is no such file.
    scene.render.filepath = os.path.abspath(options.output)
    bpy.ops.render.render(write_still=True)
    lens = camera.data
    print("focal-length-mm =", lens.lens)
    print("sensor-width-mm =", lens.sensor_width)
    print("near =", lens.clip_start)
    print("far =", lens.clip_end)
    print("view-to-world =", [list(row) for row in camera.matrix_world])


main()
