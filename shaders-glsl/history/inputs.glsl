// The inputs of a history's program, and functions that turn pixels into points and back.

#ifndef COMMON_HISTORY_INPUTS_GLSL
#define COMMON_HISTORY_INPUTS_GLSL

#include "common/constants.glsl"

// A thing that moved since the frame before: the range of its triangles, and the transform of its points from this
// frame's view space to that of the frame before.
struct MoverData {
    mat4 to_before;
    uvec4 triangles; // x: the first; y: the one behind the last
};

// Filled in by src/passes/history.rs.
layout(std140, binding = 0) uniform HistoryBlock {
    mat4 clip_to_view;        // of this frame, reversed depth
    mat4 view_to_view_before; // from this frame's view space to that of the frame before
    mat4 view_to_clip_before; // of the frame before, reversed depth
    mat4 clip_to_view_before;
    vec2 resolution;          // pixels
    ivec2 size;               // pixels
    vec2 beyond;              // BEYOND pixels outside of the last corner
    float unit;               // metres to one unit of a distance
    float frames;             // the most frames that are averaged while the camera moves
    float most;               // the most frames that are averaged now
    float deviations;         // standard deviations around the mean within which the history is kept
    int begins;               // 1: there is no frame before
    int has_ends;             // 1: `ends_image` is known
    int rests;                // 1: the frame before had this camera, perhaps with its image shifted; 2: as many frames had it as are
                              // averaged, and none was shifted
    int repeats;              // 1: the frame before also had the same directions of rays
    int mover_count;          // with MOVERS
    mat4 view_to_clip;        // of this frame, reversed depth
    vec2 motion_scale;        // factor from values of motion_buffer to pixels
    vec2 motion_shift;        // pixels that are added to the scaled motion
    MoverData movers[MOST_MOVERS];
} history;

layout(binding = 1) uniform sampler2D depth_buffer;                      // reversed; 0 is sky
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer;     // view space
layout(binding = 3, rgba16f) uniform readonly image2D reflection_buffer; // of this frame: colour, and fade in alpha
layout(binding = 4, rg16f) uniform readonly image2D material_buffer;     // reflectivity, roughness
layout(binding = 5, rgba16f) uniform readonly image2D color_before;      // AccumulatedPixel of the frame before
layout(binding = 6, rgba32ui) uniform readonly uimage2D guide_before;
layout(binding = 7, rg32ui) uniform readonly uimage2D ends_image;     // where rays ended (unified/ends.glsl)
layout(binding = 8, r32ui) uniform readonly uimage2D triangle_buffer; // the triangle of each pixel; one texel if none is known
layout(binding = 9, rgba16f) uniform readonly image2D color_buffer;      // lit colour
layout(binding = 10) uniform sampler2D motion_buffer; // with MOTION: the way, in red and green, to where a surface was seen

layout(constant_id = 0) const bool COMPOSITE = true; // the finished image is wanted
layout(constant_id = 1) const bool MOTION = false;   // motion_buffer is known
layout(constant_id = 2) const bool MOVERS = false;   // things of the scene have moved since the frame before
layout(constant_id = 3) const bool SEARCH = true;    // the camera or something else may have moved since the frame before

// The view-space point at a position in pixels and a reversed depth. `m` is the inverse of a projection; only the
// entries that such a matrix has are read.
vec3 Unproject(mat4 m, vec2 position, float depth) {
    vec2 ndc = position / history.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 h = vec3(vec2(m[0].x, m[1].y) * ndc + m[2].xy * depth + m[3].xy, m[2].z * depth + m[3].z);
    return h / (m[2].w * depth + m[3].w);
}

bool IsOnScreen(ivec2 pixel) {
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, history.size));
}

// The position at which a projection shows a point, in pixels; outside of the image for a point behind the eye.
vec2 ProjectToPixels(mat4 view_to_clip, vec3 point) {
    vec4 clip = view_to_clip * vec4(point, 1.0);
    vec2 position = (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * history.resolution;
    return clip.w > 0.0 ? clamp(position, vec2(-BEYOND), history.beyond) : vec2(-BEYOND);
}

// The position in pixels at which a point, in the view space of the frame before, was seen in that frame.
vec2 ProjectToPreviousPixels(vec3 point) {
    return ProjectToPixels(history.view_to_clip_before, point);
}

#endif
