#!/usr/bin/env bash
# lavapipe's anisotropic filter of images that are magnified. Expected: a sampler with maxAnisotropy 16 shows a magnified image as one
# without anisotropy does, in even ramps between the texels, since a pixel's footprint is smaller than a texel and as long as wide.
# Seen, with Debian 12's lavapipe of Mesa 22.3.6: two thirds of 64 x 64 pixels that show 4 x 4 texels differ, by up to 0.17 where two
# texels differ by 1. Neighbouring pixels differ by up to 0.12 instead of 0.06, along circles around the texels: the picture of a
# texture from nearby has discs in place of ramps.
#
# Debian's libvulkan1 and mesa-vulkan-drivers are installed where they are missing (as root).
set -euo pipefail

icd=/usr/share/vulkan/icd.d/lvp_icd.$(uname -m).json
[ -s "$icd" ] || { apt-get update -q && apt-get install -y -q --no-install-recommends libvulkan1 mesa-vulkan-drivers; } >/dev/null
export VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export XDG_RUNTIME_DIR=$folder
python3 -m venv venv
venv/bin/pip install --quiet wgpu==0.32.0 numpy==2.4.6 cffi==2.1.1
cat >magnify.py <<'PY'
import sys

import numpy as np
import wgpu

use = wgpu.TextureUsage
adapter = next(a for a in wgpu.gpu.enumerate_adapters_sync() if a.info["backend_type"] == "Vulkan")
device = adapter.request_device_sync()
texels = np.zeros((4, 4, 4), np.float16)
texels[::2, ::2, 0] = 1
image = device.create_texture(size=(4, 4, 1), format="rgba16float", usage=use.TEXTURE_BINDING | use.COPY_DST)
device.queue.write_texture({"texture": image}, texels, {"bytes_per_row": 32}, (4, 4, 1))
module = device.create_shader_module(code="""
    @group(0) @binding(0) var image: texture_2d<f32>;
    @group(0) @binding(1) var filtered: sampler;
    @vertex
    fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
        return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
    }
    @fragment
    fn shade(@builtin(position) p: vec4f) -> @location(0) vec4f {
        return vec4f(textureSample(image, filtered, p.xy / 64.0).x);
    }""")
pipeline = device.create_render_pipeline(
    layout="auto", vertex={"module": module, "entry_point": "corner"}, primitive={"topology": "triangle-list"},
    fragment={"module": module, "entry_point": "shade", "targets": [{"format": "rgba32float"}]})


def drawn(anisotropy):
    """The image, magnified to 64 x 64 pixels by a sampler with so much anisotropy."""
    sampler = device.create_sampler(address_mode_u="repeat", address_mode_v="repeat", min_filter="linear",
                                    mag_filter="linear", mipmap_filter="linear", max_anisotropy=anisotropy)
    entries = [{"binding": n, "resource": r} for n, r in enumerate([image.create_view(), sampler])]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    target = device.create_texture(size=(64, 64, 1), format="rgba32float", usage=use.RENDER_ATTACHMENT | use.COPY_SRC)
    encoder = device.create_command_encoder()
    attachment = {"view": target.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
    work = encoder.begin_render_pass(color_attachments=[attachment])
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.draw(3)
    work.end()
    device.queue.submit([encoder.finish()])
    data = device.queue.read_texture({"texture": target}, {"bytes_per_row": 1024}, (64, 64, 1))
    return np.frombuffer(data, np.float32).reshape(64, 64, 4)[..., 0]


plain, anisotropic = drawn(1), drawn(16)
steps = [np.abs(np.diff(picture, axis=1)).max() for picture in (plain, anisotropic)]
difference = np.abs(plain - anisotropic)
print(f"greatest step between neighbouring pixels: {steps[0]:.3f} without anisotropy, {steps[1]:.3f} with it")
print(f"they differ in {np.mean(difference > 0.01):.0%} of the pixels, by up to {difference.max():.3f}")
if not (steps[0] < 0.07 and steps[1] > 0.1 and np.mean(difference > 0.01) > 0.5):
    sys.exit("this changed: the anisotropic filter magnified with jumps")
PY
venv/bin/python magnify.py
