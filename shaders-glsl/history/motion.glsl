// Finds where moving things were in the frame before: meshes of the scene, and surfaces whose motion the caller gives.

#ifndef COMMON_HISTORY_MOTION_GLSL
#define COMMON_HISTORY_MOTION_GLSL

#include "history/guide.glsl"
#include "common/sight.glsl"

// A surface counts as at rest if it was seen no farther from where a surface at rest was seen than STILL pixels plus
// the share STILL_SHARE of its motion. 16-bit floats round motion by a quarter of that share.
#define STILL 0.05
#define STILL_SHARE (1.0 / 512.0)
// A moving thing is taken to be as far away as it was, within this share.
#define SAME_DEPTH 0.1
// The screen shows a reflected point if it shows something at this point's depth, within this share.
#define SHOWN 0.05

// The mover that a triangle belongs to; -1 for a triangle at rest.
int FindMover(uint triangle) {
    int mover = -1;
    if (!MOVERS)
        return mover;
    for (int i = 0; i < history.mover_count; ++i) {
        uvec2 range = history.movers[i].triangles.xy;
        mover = triangle >= range.x && triangle < range.y ? i : mover;
    }
    return mover;
}

// Turns a point (w = 1) or direction (w = 0) on a mover, in this frame's view space, to where it was in the view space
// of the frame before; `mover` -1 is for things at rest.
vec3 ToPreviousView(vec3 v, float w, int mover) {
    vec3 before = (history.view_to_view_before * vec4(v, w)).xyz;
    if (!MOVERS)
        return before;
    for (int i = 0; i < history.mover_count; ++i)
        before = mover == i ? (history.movers[i].to_before * vec4(v, w)).xyz : before;
    return before;
}

// Finds where a point of the surface that a pixel shows was in the view space of the frame before, by the motion that
// the caller gives. `position` is where the point is seen now, in pixels. `point_at_rest` is where the point was if its
// surface is at rest. The motion gives the earlier position on the screen but no distance. The distance is what the
// frame before showed there, if a history keeps it.
vec3 PreviousPointByMotion(vec2 position, ivec2 pixel, vec3 point_at_rest) {
    vec2 motion_px = texelFetch(motion_buffer, pixel, 0).xy * history.motion_scale + history.motion_shift;
    float off_rest_px = distance(position + motion_px, ProjectToPreviousPixels(point_at_rest));
    vec2 position_before = clamp(position + motion_px, vec2(-BEYOND), history.beyond);
    ivec2 pixel_before = ivec2(floor(position_before));
    float depth_before = IsOnScreen(pixel_before) ? LoadGuide(pixel_before).depth : 0.0;
    float z_before = depth_before > 0.0 ? Unproject(history.clip_to_view_before, position_before, depth_before).z
                                        : point_at_rest.z;
    float z_range = SAME_DEPTH * Reach(point_at_rest.z, history.clip_to_view_before);
    float z = clamp(z_before, point_at_rest.z - z_range, point_at_rest.z + z_range);
    vec4 clip = history.view_to_clip_before * vec4(point_at_rest.xy, z, 1.0);
    vec3 moved_point = Unproject(history.clip_to_view_before, position_before, clip.z / clip.w);
    // A motion that is NaN counts as none.
    bool is_moving = off_rest_px > STILL + STILL_SHARE * length(motion_px);
    return is_moving && point_at_rest.z > 0.0 ? moved_point : point_at_rest;
}

// Finds where the reflected point, which may lie on a moving thing, was in the frame before. `point_at_rest` is where
// it was if the thing is at rest. The caller gives the motion only of what the screen shows.
vec3 PreviousReflectedPoint(vec3 reflected_point, vec3 point_at_rest) {
    vec2 position = ProjectToPixels(history.view_to_clip, reflected_point);
    ivec2 pixel = ivec2(floor(position));
    ivec2 inside = clamp(pixel, ivec2(0), history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    float z = Unproject(history.clip_to_view, position, depth).z;
    bool is_shown = IsOnScreen(pixel) && depth > 0.0
                 && abs(z - reflected_point.z) < SHOWN * Reach(reflected_point.z, history.clip_to_view);
    return is_shown ? PreviousPointByMotion(position, inside, point_at_rest) : point_at_rest;
}

// The triangle that a pixel shows. If the G-buffer has no numbers, the image has one texel, with NO_TRIANGLE.
uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

#endif
