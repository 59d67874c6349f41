#version 460
// Lists the tiles of 8 x 8 pixels with a reflecting pixel. `count` becomes the number of workgroups of the next pass,
// one for each listed tile.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D material;
layout(std430, binding = 1) buffer Count { uint x, y, z; } count;
layout(std430, binding = 2) writeonly buffer Tiles { uint tiles[]; } list;

shared uint reflects;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        reflects = 0u;
        // Every workgroup writes the same two numbers, so it does not matter which of them writes last.
        count.y = 1u;
        count.z = 1u;
    }
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, textureSize(material, 0))) && texelFetch(material, pixel, 0).r > 1e-4)
        atomicOr(reflects, 1u);
    barrier();
    if (gl_LocalInvocationIndex == 0u && reflects != 0u)
        list.tiles[atomicAdd(count.x, 1u)] = gl_WorkGroupID.x | gl_WorkGroupID.y << 16;
}
