// Normals from depth alone. Needs camera.glsl, constants.glsl, and a function of the file that includes this one:
//   float Depth(ivec2 pixel)   the reversed depth of a pixel, 0 where nothing stands

#include "common/sight.glsl"

// The view-space point that a pixel shows at a reversed depth, in metres.
vec3 ViewPoint(ivec2 pixel, float depth) {
    vec2 ndc = (vec2(pixel) + 0.5) / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    return h.xyz / h.w;
}

// The change of the view-space point from a pixel to the next one along an axis. It is taken to the neighbour, of the
// two, that is nearer in depth and so more likely on the same surface. `point` is the pixel's view-space point.
vec3 StepAlong(ivec2 axis, ivec2 pixel, float depth, vec3 point) {
    ivec2 last = ivec2(camera.resolution) - 1;
    ivec2 after = min(pixel + axis, last), before = max(pixel - axis, ivec2(0));
    float depth_after = Depth(after), depth_before = Depth(before);
    float gap_after = after == pixel || depth_after == 0.0 ? NEVER : abs(depth_after - depth);
    float gap_before = before == pixel || depth_before == 0.0 ? NEVER : abs(depth_before - depth);
    return gap_after <= gap_before ? ViewPoint(after, depth_after) - point : point - ViewPoint(before, depth_before);
}

// The unit normal, towards the camera, of the surface through the points of a pixel and its neighbours.
vec3 NormalOfDepth(ivec2 pixel, float depth) {
    vec3 point = ViewPoint(pixel, depth);
    vec3 across = cross(StepAlong(ivec2(1, 0), pixel, depth, point), StepAlong(ivec2(0, 1), pixel, depth, point));
    float squared = dot(across, across);
    vec3 sight = ViewDirection(point);
    vec3 normal = squared > 0.0 ? across * inversesqrt(squared) : -normalize(sight);
    return dot(normal, sight) > 0.0 ? -normal : normal;
}
