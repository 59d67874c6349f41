#!/usr/bin/env python3
"""Checks an export of `ssct truth export` with Mitsuba 3, and exits with status 1 if a limit
is exceeded.

Independent of ssct: the sensor's rays, the reading of the meshes, every ray against them (Embree, in
32-bit floats), the directions of the lobe and their random numbers (PCG32), the sampling and the
decoding of albedo images. Not independent: the meshes and images themselves, the receivers of the
reflection (position, normal, roughness; the first hits that they come from are checked), and the
formulas for lit colour, normal maps and the lobe's exponent, which are written down a second time
below after docs/definitions.md.

The glossy integral is compared as Mitsuba's own tests compare images (src/render/tests/
test_renders.py): a z-test for each pixel and channel at a significance of 0.01 after Sidak's
correction, of which 99.75 % must pass. Two tests of the whole image stand beside it, since what is
small but everywhere the same would pass that one: the mean difference, and the difference along the
change that another roughness would make, both in units of their own standard deviation, at most 4.

Mitsuba's vectorised CPU variant compiles with the system's LLVM library, which Mesa's lavapipe needs
too (Debian: mesa-vulkan-drivers brings libllvm15); without it the import says that it is missing.

Usage: mitsuba_compare.py DIR [--samples N] [--seed S] [--json FILE]
"""

import argparse
import json
import math
import sys
from pathlib import Path

import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import drjit as dr  # noqa: E402  (after the variant)
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

SIGNIFICANCE = 0.01
SHARE_TO_PASS = 0.9975
# The least variance of a sample that a z-test assumes, as in Mitsuba's tests: a pixel whose samples
# all agree claims an error of 0.
LEAST_VARIANCE = 1e-4
XI = 0.244


class Truth:
    """The export, and the scene as Mitsuba loads it."""

    def __init__(self, folder):
        self.folder = folder
        self.info = json.loads((folder / "truth.json").read_text())
        self.scene = mi.load_file(str(folder / "scene.xml"), optimize=False)
        # Registry index of a shape in Mitsuba to the mesh of the export; 0 is no shape.
        shapes = self.scene.shapes()
        numbers = [int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0]) for shape in shapes]
        self.mesh_of = np.full(max(numbers) + 1, -1)
        for number, shape in zip(numbers, shapes):
            self.mesh_of[number] = int(shape.id().split("-")[1])
        self.indices = {
            self.mesh_of[number]: np.array(mi.traverse(shape)["faces"]).reshape(-1, 3)
            for number, shape in zip(numbers, shapes)
        }
        self.material_of = np.array(self.info["mesh_material"])
        self.tangents = self.array("vertex_tangent")
        self.first_vertex = self.array("mesh_first_vertex")
        self.images = {}

    def array(self, name):
        """Returns an array of the export by its name."""
        return np.load(self.folder / f"{name}.npy")

    def image(self, index):
        """Returns an image without decoding, as RGBA values from 0 to 1."""
        if index not in self.images:
            path = self.folder / self.info["textures"][index]["file"]
            self.images[index] = np.asarray(Image.open(path).convert("RGBA"), dtype=np.float64) / 255
        return self.images[index]

    def sample(self, index, uv):
        """Returns the RGBA values of an image at `uv`, of shape (n, 2). The lookup is bilinear and repeats the image, whose
        top left corner is (0, 0)."""
        image = self.image(index)
        size = np.array([image.shape[1], image.shape[0]])
        position = (uv % 1.0) * size - 0.5
        low = np.floor(position).astype(int)
        w = (position - low)[:, :, None]
        x0, y0 = (low % size).T
        x1, y1 = ((low + 1) % size).T
        top = image[y0, x0] * (1 - w[:, 0]) + image[y0, x1] * w[:, 0]
        bottom = image[y1, x0] * (1 - w[:, 0]) + image[y1, x1] * w[:, 0]
        return top * (1 - w[:, 1]) + bottom * w[:, 1]

    def trace(self, origin, direction):
        """Returns Mitsuba's hits as a dict of arrays, in which mesh -1 is a miss. Rays pass through the holes of alpha masks
        and through single-sided materials from behind."""
        origin, direction = (np.asarray(v, dtype=np.float64) for v in (origin, direction))
        hit = self.trace_once(origin, direction)
        for _ in range(64):
            holes = self.holes(hit, direction)
            if not holes.any():
                return hit
            beyond = hit["position"][holes] + 1e-4 * direction[holes]
            further = self.trace_once(beyond, direction[holes])
            for name, values in hit.items():
                values[holes] = further[name]
        raise RuntimeError("a ray passes more than 64 masked surfaces")

    def trace_once(self, origin, direction):
        """Returns the first hits as a dict of arrays, holes and single-sided materials included."""
        ray = mi.Ray3f(mi.Point3f(origin.T.astype(np.float32)), mi.Vector3f(direction.T.astype(np.float32)))
        si = self.scene.ray_intersect(ray)
        valid = np.array(si.is_valid())
        albedo = si.bsdf(ray).eval_diffuse_reflectance(si)
        bary = np.array(si_barycentrics(self.scene, ray)).T
        mesh = self.mesh_of[np.where(valid, np.array(dr.reinterpret_array(mi.UInt32, si.shape)), 0)]
        return {
            "mesh": np.where(valid, mesh, -1),
            "triangle": np.where(valid, np.array(si.prim_index).astype(int), -1),
            "position": np.array(si.p).T.astype(np.float64),
            "flat": np.array(si.n).T.astype(np.float64),
            "smooth": np.array(si.sh_frame.n).T.astype(np.float64),
            "uv": np.array(si.uv).T.astype(np.float64),
            "bary": bary,
            "albedo": np.array(albedo).T.astype(np.float64),
            "t": np.array(si.t).astype(np.float64),
        }

    def holes(self, hit, direction):
        """Returns for each hit whether the ray passes it."""
        holes = np.zeros(len(hit["mesh"]), bool)
        for index, material in enumerate(self.info["materials"]):
            if material["single_sided"]:
                mask = (hit["mesh"] >= 0) & (self.material_of[hit["mesh"]] == index)
                holes[mask] |= dot(hit["flat"], direction)[mask][:, 0] > 0
            if material["alpha_mask"] is not None:
                mask = (hit["mesh"] >= 0) & (self.material_of[hit["mesh"]] == index)
                holes[mask] |= self.sample(material["alpha_mask"], hit["uv"][mask])[:, 0] < 0.5
        return holes

    def normals(self, hit, direction):
        """Returns the normals of shading, computed as in `gbuffer.frag` and flipped to the visible side."""
        normal = unit(hit["smooth"])
        for index, material in enumerate(self.info["materials"]):
            deviation = material["normal_deviation"]
            rays = np.flatnonzero((hit["mesh"] >= 0) & (self.material_of[hit["mesh"]] == index))
            if material["normal_map"] is None or deviation <= 0 or not len(rays):
                continue
            n = normal[rays]
            along = np.zeros((len(rays), 4))
            for mesh in np.unique(hit["mesh"][rays]):
                here = hit["mesh"][rays] == mesh
                corners = self.first_vertex[mesh] + self.indices[mesh][hit["triangle"][rays][here]]
                along[here] = np.einsum("nkc,nk->nc", self.tangents[corners], hit["bary"][rays][here])
            tangent = along[:, :3] - n * dot(n, along[:, :3])
            usable = np.linalg.norm(tangent, axis=1) > 1e-6
            tangent = unit(tangent)
            bitangent = along[:, 3:] * np.cross(n, tangent)
            m = self.sample(material["normal_map"], hit["uv"][rays])[:, :3] * 2 - 1
            bumped = unit(tangent * m[:, :1] + bitangent * m[:, 1:2] + n * np.maximum(m[:, 2:], 1e-3))
            normal[rays[usable]] = unit(n * (1 - deviation) + bumped * deviation)[usable]
        return np.where(dot(hit["flat"], direction) > 0, -normal, normal)

    def lit(self, hit, direction):
        """Returns the lit colour albedo * mix(0.2, 1, min(sum of lights, 1)), with emission, or black without a hit."""
        normal = self.normals(hit, direction)
        shading = np.zeros((len(normal), 1))
        for light in self.info["lights"]:
            energy = light["energy"]
            if light["kind"] == "point":
                to_light = np.array(light["at"]) - hit["position"]
                d = np.linalg.norm(to_light, axis=1, keepdims=True)
                facing = np.maximum(dot(normal, to_light / np.maximum(d, 1e-6)), 0)
                shading += facing / (1 + d / energy + d * d / energy)
            else:
                shading += np.maximum(dot(normal, -np.array([light["along"]])), 0) * energy
        factor = np.array([material["albedo"] for material in self.info["materials"]])
        lit = 0.2 + 0.8 * np.minimum(shading, 1)
        lit += (1 - lit) * self.emission(hit)
        color = hit["albedo"] * factor[self.material_of[hit["mesh"]]] * lit
        return np.where((hit["mesh"] >= 0)[:, None], color, 0.0)

    def emission(self, hit):
        """Returns for each hit the share of the albedo that is emitted."""
        share = np.zeros((len(hit["mesh"]), 1))
        for index, material in enumerate(self.info["materials"]):
            mask = (hit["mesh"] >= 0) & (self.material_of[hit["mesh"]] == index)
            if material["emission"] > 0 and mask.any():
                albedo_map = material["albedo_map"]
                alpha = self.sample(albedo_map, hit["uv"][mask])[:, 3:] if albedo_map is not None else 1
                share[mask] = material["emission"] * alpha
        return share


def si_barycentrics(scene, ray):
    """Returns the weights of the triangle's vertices, from Mitsuba's own (u, v) of the primitive."""
    pi = scene.ray_intersect_preliminary(ray)
    u, v = pi.prim_uv.x, pi.prim_uv.y
    return mi.Vector3f(1 - u - v, u, v)


def dot(a, b):
    """Returns the scalar products of two arrays of vectors, as a column of shape (n, 1)."""
    return np.sum(a * b, axis=1, keepdims=True)


def unit(a):
    """Returns vectors of unit length."""
    return a / np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-300)


def check_geometry(truth, name, hit, near):
    """Compares Mitsuba's hits with the exported hits `name`: mesh, triangle, and the distance between the positions.

    A hit agrees if the positions are at most `near` metres apart. Returns a record of shares and distances.
    """
    mesh, triangle = truth.array(f"{name}_mesh"), truth.array(f"{name}_triangle")
    position = truth.array(f"{name}_position")
    both = (mesh >= 0) & (hit["mesh"] >= 0)
    same = (mesh == hit["mesh"]) & (triangle == hit["triangle"])
    apart = np.linalg.norm(position - hit["position"], axis=1)
    # On an edge that two triangles share, both are correct, so that only the positions decide.
    agree = ((mesh < 0) & (hit["mesh"] < 0)) | (both & (apart <= near))
    return {
        "rays": len(mesh),
        "agree": float(np.mean(agree)),
        "same_triangle": float(np.mean(same)),
        "apart_m_median": float(np.median(apart[both])),
        "apart_m_p99": float(np.percentile(apart[both & agree], 99)),
    }


def sensor_rays(truth):
    """Returns origins and directions of the rays of Mitsuba's own sensor through the pixels' centres, from the near plane on."""
    width, height = truth.info["width"], truth.info["height"]
    index = dr.arange(mi.UInt32, width * height)
    position = mi.Point2f((mi.Float(index % width) + 0.5) / width, (mi.Float(index // width) + 0.5) / height)
    ray, _ = truth.scene.sensors()[0].sample_ray(0.0, 0.5, position, mi.Point2f(0.5))
    return np.array(ray.o).T.astype(np.float64), np.array(ray.d).T.astype(np.float64)


def sample_reflection(truth, samples, seed, scale=1.0):
    """Samples each receiver's reflection with Mitsuba's rays and random numbers. Returns the mean of the samples, and the
    variance of a single sample. All roughness values are multiplied by `scale`."""
    position, normal = truth.array("receiver_position"), truth.array("receiver_normal")
    geometric, incoming = truth.array("receiver_geometric"), truth.array("receiver_incoming")
    roughness = truth.array("receiver_roughness") * scale
    start = truth.info["ray_start_m"]
    mirror = unit(incoming - 2 * dot(incoming, normal) * normal)
    with np.errstate(divide="ignore"):
        exponent = np.where(roughness > 0, math.log(XI) / np.log(np.cos(roughness / 2)) - 1, np.inf)
    count = len(position)
    total, squares = np.zeros((count, 3)), np.zeros((count, 3))
    # Mitsuba makes the frame around the mirror direction. NumPy computes the rest, since LLVM 15 lacks
    # an instruction that drjit.maximum needs.
    frame = mi.Frame3f(mi.Vector3f(mirror.T.astype(np.float32)))
    across, up = (np.array(axis).T.astype(np.float64) for axis in (frame.s, frame.t))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    for _ in range(samples):
        u = np.array(sampler.next_2d()).astype(np.float64)
        # 1 / (alpha + 1) is 0 for a mirror, whose cosine is then 1.
        ln_cos = np.log1p(-u[0]) / (exponent + 1)
        sine = np.sqrt(-np.expm1(2 * ln_cos))
        around = 2 * math.pi * u[1]
        local = np.stack([sine * np.cos(around), sine * np.sin(around), np.exp(ln_cos)], axis=1)
        direction = unit(local[:, :1] * across + local[:, 1:2] * up + local[:, 2:] * mirror)
        above = (dot(direction, normal) > 0) & (dot(direction, geometric) > 0)
        hit = truth.trace(position + start * direction, direction)
        color = np.where(above, truth.lit(hit, direction), 0.0)
        total += color
        squares += color * color
    mean = total / samples
    variance = np.maximum(squares - samples * mean * mean, 0) / (samples - 1)
    return mean, variance


def check_reflection(truth, samples, seed):
    """Compares the glossy reflections with the exported ones by z-tests, and returns a record of the results."""
    ours, our_error = truth.array("reflection_mean"), truth.array("reflection_error")
    glossy = truth.array("receiver_roughness") > 0
    n = truth.info["samples"]
    if not glossy.any():
        return {"pixels": 0}
    mean, variance = sample_reflection(truth, samples, seed)
    our_variance = our_error**2 * n
    deviation = np.sqrt(np.maximum(our_variance, LEAST_VARIANCE) / n + np.maximum(variance, LEAST_VARIANCE) / samples)
    z = ((mean - ours) / deviation)[glossy]
    p = np.array([math.erfc(abs(v) / math.sqrt(2)) for v in z.ravel()]).reshape(z.shape)
    alpha = 1 - (1 - SIGNIFICANCE) ** (1 / len(z))
    # The derivative of the image by the logarithm of roughness, from equal random numbers at 1.2 and 1 / 1.2 times the
    # roughness. The comparison above has other random numbers.
    few = max(samples // 2, 2)
    rougher, smoother = (sample_reflection(truth, few, seed + 1, scale)[0] for scale in (1.2, 1 / 1.2))
    slope = ((rougher - smoother) / (2 * math.log(1.2)))[glossy] / deviation[glossy]
    # The three channels of a pixel share their rays. Assuming full correlation bounds the variance.
    slope_variance = np.sum(np.sum(np.abs(slope), axis=1) ** 2)
    # For the whole-image tests there is one number per pixel, because its three channels share their rays.
    difference = (mean - ours)[glossy].mean(axis=1)
    true_deviation = np.sqrt(our_error**2 + variance / samples)[glossy].mean(axis=1)
    return {
        "pixels": int(glossy.sum()),
        "samples": samples,
        "pass_share": float(np.mean(p > alpha)),
        "fail_share": float(np.mean(p <= alpha)),
        "alpha": alpha,
        "z_mean": float(z.mean()),
        "z_rms": float(np.sqrt(np.mean(z**2))),
        "mean_difference": float(difference.mean()),
        # The channels are correlated, so their mean deviation is an upper bound of the pixel's.
        "mean_difference_in_deviations": float(difference.sum() / np.sqrt(np.sum(true_deviation**2))),
        "roughness_apart": float(np.sum(slope * z) / np.sum(slope**2)),
        "roughness_apart_in_deviations": float(np.sum(slope * z) / np.sqrt(slope_variance)),
        "mean_color": float(ours[glossy].mean()),
        "rmse": float(np.sqrt(np.mean((mean - ours)[glossy] ** 2))),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    truth = Truth(options.folder)

    origin, direction = sensor_rays(truth)
    turned = np.max(np.linalg.norm(direction - truth.array("primary_direction"), axis=1))
    primary = truth.trace(origin, direction)
    report = {"scene": truth.info["scene"], "mitsuba": mi.__version__, "variant": mi.variant()}
    report["sensor"] = {"direction_apart_max": float(turned)}
    report["primary"] = check_geometry(truth, "primary", primary, 1e-3)
    lit = np.abs(truth.lit(primary, direction) - truth.array("primary_lit")).max(axis=1)
    report["lit"] = {"median": float(np.median(lit)), "within_0.002": float(np.mean(lit <= 0.002))}

    mirror = truth.array("receiver_incoming")
    normal = truth.array("receiver_normal")
    mirror = unit(mirror - 2 * dot(mirror, normal) * normal)
    start = truth.info["ray_start_m"]
    mirrored = truth.trace(truth.array("receiver_position") + start * mirror, mirror)
    report["mirror"] = check_geometry(truth, "mirror", mirrored, 1e-3)
    above = (dot(mirror, normal) > 0) & (dot(mirror, truth.array("receiver_geometric")) > 0)
    colors = np.where(above, truth.lit(mirrored, mirror), 0.0)
    colors = np.abs(colors - truth.array("reflection_mean")).max(axis=1)
    mirrors = truth.array("receiver_roughness") <= 0
    reflection = report["reflection"] = check_reflection(truth, options.samples, options.seed)

    bars = {
        "sensor rays within 1e-5": turned <= 1e-5,
        "99.9 % of the first hits": report["primary"]["agree"] >= 0.999,
        "99 % of the lit colours within 0.002": report["lit"]["within_0.002"] >= 0.99,
        "99.8 % of the mirror rays": report["mirror"]["agree"] >= 0.998,
    }
    if mirrors.any():
        report["mirror"]["color_within_0.002"] = float(np.mean(colors[mirrors] <= 0.002))
        bars["99.5 % of the mirrors' colours within 0.002"] = report["mirror"]["color_within_0.002"] >= 0.995
    if reflection["pixels"]:
        bars["99.75 % of the z-tests"] = reflection["pass_share"] >= SHARE_TO_PASS
        bars["no bias of the image"] = abs(reflection["mean_difference_in_deviations"]) <= 4
        bars["no other roughness"] = abs(reflection["roughness_apart_in_deviations"]) <= 4
    report["bars"] = {name: bool(passed) for name, passed in bars.items()}
    text = json.dumps(report, indent=1)
    print(text)
    if options.json:
        options.json.write_text(text + "\n")
    missed = [name for name, passed in bars.items() if not passed]
    if missed:
        print(f"mitsuba_compare: missed: {'; '.join(missed)}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
