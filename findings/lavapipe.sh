# Sourced by findings about lavapipe, Mesa's Vulkan driver for CPUs: `python` of findings/mesa.sh with wgpu 0.32.0 and numpy 2.4.6.
# Programs in $scratch may import the module `lavapipe`, which runs shaders on the driver.

. "$(dirname "$0")/mesa.sh" lvp wgpu==0.32.0 numpy==2.4.6
cat >"$scratch/lavapipe.py" <<'PY'
"""Runs shaders on lavapipe. Resources are bound in their order, from binding 0 on: array_buffer(), views and samplers."""

import numpy as np
import wgpu

adapters = wgpu.gpu.enumerate_adapters_sync()
adapter = next(a for a in adapters if a.info["backend_type"] == "Vulkan" and "llvmpipe" in a.info["device"])
device = adapter.request_device_sync()

# The vertex shader of a triangle over the whole target.
FULL_TARGET = """
@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}
"""


def array_buffer(values):
    """A storage buffer with the values of an array, whose contents can be read back."""
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    return device.create_buffer_with_data(data=values, usage=usage)


def read(buffer, kind):
    """The values of a buffer."""
    return np.frombuffer(device.queue.read_buffer(buffer), kind)


def image(texels, image_format):
    """A view of an image with an array of texels: rows, columns, channels."""
    height, width, _ = texels.shape
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    made = device.create_texture(size=(width, height, 1), format=image_format, usage=usage)
    layout = {"bytes_per_row": texels.nbytes // height}
    device.queue.write_texture({"texture": made}, np.ascontiguousarray(texels), layout, (width, height, 1))
    return made.create_view()


def bind(work, pipeline, resources):
    """Sets the pipeline of a pass, and binds its resources."""
    work.set_pipeline(pipeline)
    if resources:
        bound = [{"buffer": r, "offset": 0, "size": r.size} if isinstance(r, wgpu.GPUBuffer) else r for r in resources]
        entries = [{"binding": n, "resource": resource} for n, resource in enumerate(bound)]
        work.set_bind_group(0, device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries))


def compute(code, resources, groups=1):
    """Runs the function `main` of a compute shader, in WGSL or SPIR-V, in so many workgroups."""
    module = device.create_shader_module(code=code)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
    encoder = device.create_command_encoder()
    work = encoder.begin_compute_pass()
    bind(work, pipeline, resources)
    work.dispatch_workgroups(groups)
    work.end()
    device.queue.submit([encoder.finish()])


def draw(code, resources, image_format, size, texel_bytes):
    """Draws the function `shade` of a fragment shader over an image of a width and height. Returns the image's bytes."""
    module = device.create_shader_module(code=FULL_TARGET + code)
    pipeline = device.create_render_pipeline(
        layout="auto", vertex={"module": module, "entry_point": "corner"}, primitive={"topology": "triangle-list"},
        fragment={"module": module, "entry_point": "shade", "targets": [{"format": image_format}]})
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
    target = device.create_texture(size=(*size, 1), format=image_format, usage=usage)
    encoder = device.create_command_encoder()
    attachment = {"view": target.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
    work = encoder.begin_render_pass(color_attachments=[attachment])
    bind(work, pipeline, resources)
    work.draw(3)
    work.end()
    device.queue.submit([encoder.finish()])
    return device.queue.read_texture({"texture": target}, {"bytes_per_row": texel_bytes * size[0]}, (*size, 1))
PY
