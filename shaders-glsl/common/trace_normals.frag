#version 460
#pragma program(TraceNormals)
#pragma in_either_stage
// The normals that rays are reflected at, in place of the shading normals (thesis 4.4, after the game Thief): normals
// of the geometry, from depth, or one vector for all pixels.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"

layout(constant_id = 0) const int KIND = TRACE_GEOMETRIC; // TRACE_…

layout(binding = 1) uniform sampler2D depth_buffer; // reversed

OUTPUT(0, rgba16f, vec4, out_normal); // view space, unit

// The reversed depth of a pixel, for normal_of_depth.glsl; 0 for sky.
float Depth(ivec2 pixel) {
    return texelFetch(depth_buffer, pixel, 0).r;
}

#include "common/normal_of_depth.glsl"

SHADE(out_normal) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    float depth = Depth(pixel);
    vec3 normal = KIND == TRACE_UP ? normalize(camera.world_to_view[1].xyz) : NormalOfDepth(pixel, depth);
    out_normal = vec4(depth > 0.0 ? normal : vec3(0.0), 0.0);
}
