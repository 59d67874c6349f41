#version 460
#pragma program(Reduce)
// Makes one level of a chain of minima or maxima of depth, for a user's shader. A texel covers 2 x 2 texels of the
// level below. If sizes are rounded down, the last texel along an odd side covers three. If sizes are rounded up to
// powers of two, texels beyond the border of the level below repeat its last texels.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D below;
layout(binding = 1) uniform writeonly image2D level;

layout(constant_id = 0) const bool MAXIMUM = false;
layout(constant_id = 1) const bool COPY = false;    // the finest level: nothing is reduced

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(level);
    if (any(greaterThanEqual(texel, size)))
        return;
    ivec2 last_below = textureSize(below, 0) - 1;
    float extreme;
    if (COPY) {
        extreme = texelFetch(below, min(texel, last_below), 0).r;
    } else {
        extreme = texelFetch(below, min(2 * texel, last_below), 0).r;
        // The last texel also covers what no other texel covers.
        ivec2 last_covered = mix(min(2 * texel + 1, last_below), last_below, equal(texel, size - 1));
        for (int y = 2 * texel.y; y <= last_covered.y; ++y) {
            for (int x = 2 * texel.x; x <= last_covered.x; ++x) {
                float depth = texelFetch(below, ivec2(x, y), 0).r;
                extreme = MAXIMUM ? max(extreme, depth) : min(extreme, depth);
            }
        }
    }
    imageStore(level, texel, vec4(extreme));
}
