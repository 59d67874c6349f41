"""Renders the frame that mitsuba.toml reads: a mirror of a floor with a ball on it, in Mitsuba 3.

    python mitsuba_scene.py FOLDER [--size 160x90] [--samples 64]

needs `pip install mitsuba` (tried with 3.9.1). It writes `frame.exr` with depth, normals, places and the index of the shape,
and `lit.exr`, the light without reflections: the same scene with a floor that reflects nothing. `full.exr` is what Mitsuba's
path tracer makes of the scene with its reflections, to compare.
"""

import argparse
import os

import mitsuba as mi

mi.set_variant("scalar_rgb")

EYE, TARGET = [2.5, 1.6, -5.0], [0.0, 0.6, 0.0]


def camera(size, samples):
    look = mi.ScalarTransform4f().look_at(origin=EYE, target=TARGET, up=[0, 1, 0])
    width, height = size
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
            "component_format": "float32", "rfilter": {"type": "box"}}
    return {"type": "perspective", "fov": 60.0, "fov_axis": "x", "near_clip": 0.5, "far_clip": 100.0,
            "to_world": look, "film": film,
            # A single sample goes through the middle of its pixel: an average over a pixel is the depth of no surface.
            "sampler": {"type": "stratified", "sample_count": samples, "jitter": samples > 1}}


def scene(size, samples, floor, integrator):
    turned = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(6)
    return mi.load_dict({
        "type": "scene",
        "integrator": integrator,
        "sensor": camera(size, samples),
        "floor": {"type": "rectangle", "to_world": turned, "bsdf": floor},
        "ball": {"type": "sphere", "center": [0.0, 0.9, 0.0], "radius": 0.9,
                 "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.15, 0.1]}}},
        "sun": {"type": "directional", "direction": [-0.5, -1.0, 0.6], "irradiance": {"type": "rgb", "value": 2.0}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.3, 0.45, 0.7]}},
    })


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder")
    arguments.add_argument("--size", default="160x90")
    arguments.add_argument("--samples", type=int, default=64)
    options = arguments.parse_args()
    size = [int(side) for side in options.size.split("x")]
    os.makedirs(options.folder, exist_ok=True)
    aovs = {"type": "aov", "aovs": "depth:depth,normal:sh_normal,place:position,shape:shape_index"}
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
    mirror = {"type": "roughconductor", "material": "none", "alpha": 0.01,
              "specular_reflectance": {"type": "rgb", "value": 0.8}}
    rendered = [
        ("frame.exr", scene(size, 1, black, aovs)),
        ("lit.exr", scene(size, options.samples, black, {"type": "path", "max_depth": 4})),
        ("full.exr", scene(size, options.samples, mirror, {"type": "path", "max_depth": 4})),
    ]
    for name, made in rendered:
        image = mi.render(made)
        made.sensors()[0].film().bitmap().write(os.path.join(options.folder, name))
        print(name, image.shape)


main()
