// Where things were that moved since the frame before: meshes of the scene, and what a caller's motion says.

#ifndef COMMON_HISTORY_MOTION_GLSL
#define COMMON_HISTORY_MOTION_GLSL

#include "common/history_guide.glsl"
#include "common/sight.glsl"

// What is seen so many pixels from where a thing at rest would be seen stands still, and so much of the way farther, since
// 16-bit floats round motion by a quarter of that.
#define STILL 0.05
#define STILL_SHARE (1.0 / 512.0)
// A thing that moves is as far away as it was, within this share.
#define SAME_DEPTH 0.1
// The screen shows a reflected point where it shows something at its depth, within this share.
#define SHOWN 0.05

// The mover that a triangle is of; -1 for what stands still.
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

// Where a point (w = 1) or a direction (w = 0) that goes along with a mover was, in the view space of the frame before.
vec3 ToPreviousView(vec3 v, float w, int mover) {
    vec3 before = (history.view_to_view_before * vec4(v, w)).xyz;
    if (!MOVERS)
        return before;
    for (int i = 0; i < history.mover_count; ++i)
        before = mover == i ? (history.movers[i].to_before * vec4(v, w)).xyz : before;
    return before;
}

// Where a point of the surface that a pixel shows was in the view space of the frame before, by the motion that the caller
// knows. `seen` is where the point is seen now, `still` where it would have been at rest. The motion says where it was seen,
// but not how far away: as far as the frame before shows there, if a history of that is kept.
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
    // False for what is no number.
    bool moves = beside > STILL + STILL_SHARE * length(way);
    return moves && still.z > 0.0 ? moved : still;
}

// Where a reflected point was that may be of a thing that moves. The caller knows the motion of what the screen shows.
vec3 PreviousReflectedPoint(vec3 end, vec3 still) {
    vec2 seen = ProjectToPixels(history.view_to_clip, end);
    ivec2 pixel = ivec2(floor(seen));
    ivec2 inside = clamp(pixel, ivec2(0), history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    float z = Unproject(history.clip_to_view, seen, depth).z;
    bool is_shown = IsOnScreen(pixel) && depth > 0.0 && abs(z - end.z) < SHOWN * Reach(end.z, history.clip_to_view);
    return is_shown ? PreviousPointByMotion(seen, inside, still) : still;
}

uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

#endif
