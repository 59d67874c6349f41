// Finds where moving things were in the frame before: meshes of the scene, and surfaces whose motion the caller gives.

#ifndef COMMON_HISTORY_MOTION_GLSL
#define COMMON_HISTORY_MOTION_GLSL

#include "common/history_guide.glsl"
#include "common/sight.glsl"

// A surface counts as at rest if it was seen within STILL pixels, and STILL_SHARE of its motion, of where a surface at
// rest was seen. 16-bit floats round motion by a quarter of that share.
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

// Finds the earlier point, in the view space of the frame before, of the surface that a pixel shows, by the motion that
// the caller gives. `seen` is the position, in pixels, at which the point is seen now, and `still` the earlier point if
// the surface were at rest. The motion gives the earlier position on the screen but no distance. The distance is what
// the frame before shows there, if a history keeps it.
vec3 PreviousPointByMotion(vec2 seen, ivec2 pixel, vec3 still) {
    vec2 way = texelFetch(motion_buffer, pixel, 0).xy * history.motion_scale + history.motion_shift;
    float beside = distance(seen + way, ProjectToPreviousPixels(still));
    vec2 before = clamp(seen + way, vec2(-BEYOND), history.beyond);
    ivec2 shows = ivec2(floor(before));
    float kept = IsOnScreen(shows) ? LoadGuide(shows).depth : 0.0;
    float shown = kept > 0.0 ? Unproject(history.clip_to_view_before, before, kept).z : still.z;
    float reach = SAME_DEPTH * Reach(still.z, history.clip_to_view_before);
    float z = clamp(shown, still.z - reach, still.z + reach);
    vec4 clip = history.view_to_clip_before * vec4(still.xy, z, 1.0);
    vec3 moved = Unproject(history.clip_to_view_before, before, clip.z / clip.w);
    // This is false if the motion is NaN.
    bool moves = beside > STILL + STILL_SHARE * length(way);
    return moves && still.z > 0.0 ? moved : still;
}

// Finds the earlier place of the reflected point `end`, which may lie on a moving thing; `still` is that place for a
// thing at rest. The caller gives the motion only of what the screen shows.
vec3 PreviousReflectedPoint(vec3 end, vec3 still) {
    vec2 seen = ProjectToPixels(history.view_to_clip, end);
    ivec2 pixel = ivec2(floor(seen));
    ivec2 inside = clamp(pixel, ivec2(0), history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    float z = Unproject(history.clip_to_view, seen, depth).z;
    bool is_shown = IsOnScreen(pixel) && depth > 0.0 && abs(z - end.z) < SHOWN * Reach(end.z, history.clip_to_view);
    return is_shown ? PreviousPointByMotion(seen, inside, still) : still;
}

// The triangle that a pixel shows. If the G-buffer has no numbers, the image has one texel, with NO_TRIANGLE.
uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

#endif
