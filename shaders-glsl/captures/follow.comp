#version 460
#pragma program(FollowMirrors, MIRRORS)
#pragma program(FollowNarrow, NARROW)
#pragma program(FollowWide)
// Follows lost rays through the captures, a thread a ray, and stores what they see (captures/finish.glsl).
//
// A ray goes on in the nearest capture that sees the point where the last image lost the ray. If no capture does, the
// fallback shows (`--fallback`). Without a fallback, the ray gets the colour of what hides the point from the nearest
// capture, since it most likely hits that thing. Outside the scene's bounds there is nothing left to hit.

#define LIST_ACCESS readonly
#define FACES
#include "captures/lost.glsl"

layout(local_size_x = LOST_GROUP) in;

layout(constant_id = 9) const bool OVER = false; // another reflection shows where this one misses

layout(binding = 1, rg32f) uniform readonly image2DArray pyramid;             // front and back depths, a layer a face
layout(binding = 2, rgba8_snorm) uniform readonly image2DArray normal_buffer; // view space of the face
layout(binding = 4) uniform samplerCubeArray color_cubes; // lit colour, 0 for sky; a: the part that is not sky

#include "captures/finish.glsl"
#include "captures/faces.glsl"

// How a ray ended.
struct CaptureRayEnd {
    int code;       // PATH_SKY, PATH_UNKNOWN, PATH_CAPTURE + k for capture k, or PATH_UNFINISHED, which cannot happen
    vec3 place;     // where it hit or was lost, relative to the eye, world axes
    int capture;    // the capture that shows this place; for an unknown end, the one that shows what most likely hides it
    float distance; // from the start to the place
};

// A mask with a bit for each capture.
uint AllCapturesMask() {
    return (1u << uint(captures.count)) - 1u;
}

// The capture nearest to a point (relative to the eye), of those with a bit in `candidates`; -1 if no bit is set. The
// number of turns of the loop does not depend on a uniform block, since lavapipe of Mesa 22 would then compile the
// program at each dispatch (docs/devices.md).
int NearestCapture(vec3 point, uint candidates) {
    int nearest = -1;
    float least_squared = NEVER;
    for (; candidates != 0u; candidates &= candidates - 1u) {
        int capture = findLSB(candidates);
        precise vec3 from_capture = point - captures.places[capture].xyz;
        float squared = Dot(from_capture, from_capture);
        nearest = squared < least_squared ? capture : nearest;
        least_squared = min(squared, least_squared);
    }
    return nearest;
}

// The nearest candidate that sees the point; -1 if none does.
int NearestSeeingCapture(vec3 point, uint candidates) {
    int capture = NearestCapture(point, candidates);
    while (capture >= 0 && !CaptureSees(capture, point - captures.places[capture].xyz)) {
        candidates &= ~(1u << capture);
        capture = NearestCapture(point, candidates);
    }
    return capture;
}

// Whether a point relative to the eye lies outside the scene's bounds, which a ray that begins inside leaves for good.
bool IsOutsideScene(vec3 point) {
    return any(lessThan(point, captures.least.xyz)) || any(greaterThan(point, captures.greatest.xyz));
}

// Follows a lost ray from capture to capture, until it ends or leaves the scene, until no capture sees where it is, or
// for two turns of the loop for each capture.
CaptureRayEnd TraceCaptures(LostRay ray) {
    CaptureRayEnd ray_end = CaptureRayEnd(PATH_UNKNOWN, ray.start, -1, 0.0);
    vec3 point = ray.start;
    uint candidates = AllCapturesMask();
    bool exhausted = false;
    // In each turn the ray either advances, so that every other capture becomes a candidate again, or does not, so that
    // this capture is no candidate until the ray advances.
    for (int i = 0; i < 2 * CAPTURE_SLOTS && ray_end.code == PATH_UNKNOWN; ++i) {
        if (IsOutsideScene(point)) {
            ray_end.code = PATH_SKY;
            break;
        }
        int capture = NearestSeeingCapture(point, candidates);
        if (capture < 0)
            break;
        vec3 capture_place = captures.places[capture].xyz;
        CaptureTrace traced = TraceCapture(capture, point - capture_place, ray.direction, exhausted);
        precise vec3 end_point = traced.place + capture_place;
        float distance = Dot(end_point - ray.start, ray.direction);
        precise float least_distance = Dot(point - ray.start, ray.direction) + LEAST_ADVANCE_M;
        bool has_moved = distance > least_distance;
        bool has_ended = traced.how == FOLLOW_HIT || traced.how == FOLLOW_SKY;
        candidates = (has_moved ? AllCapturesMask() : candidates) & ~(1u << capture);
        point = has_moved || has_ended ? end_point : point;
        ray_end.code = traced.how == FOLLOW_HIT ? PATH_CAPTURE + capture
                     : traced.how == FOLLOW_SKY ? PATH_SKY
                                                : PATH_UNKNOWN;
    }
    ray_end.code = exhausted ? PATH_UNFINISHED : ray_end.code;
    ray_end.place = point;
    ray_end.distance = Dot(point - ray.start, ray.direction);
    ray_end.capture = ray_end.code >= PATH_CAPTURE ? ray_end.code - PATH_CAPTURE : max(NearestCapture(point, AllCapturesMask()), 0);
    return ray_end;
}

// The colour that a ray sees: the capture's lit colour at the ray's end, over the footprint, with the sky along the ray
// where the texels show sky. All kinds of ends share one look-up, since a device may execute both sides of a branch.
vec3 CaptureColor(CaptureRayEnd ray_end, LostRay ray) {
    vec3 from_capture = ray_end.place - captures.places[ray_end.capture].xyz;
    vec3 components = abs(from_capture);
    float texel_width = 2.0 * max(max(components.x, components.y), components.z) / float(unified.size.x);
    float footprint = ray.spread * (ray.before + ray_end.distance);
    vec4 seen = textureLod(color_cubes, vec4(from_capture, float(ray_end.capture)),
                           max(log2(footprint / texel_width), 0.0));
    seen = ray_end.code == PATH_SKY ? vec4(0.0) : seen;
    return Sound(seen.rgb) + (1.0 - clamp(seen.a, 0.0, 1.0)) * SampleSkyWorld(ray.direction);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= lost_counts.count)
        return;
    LostRay ray = lost.rays[index];
    CaptureRayEnd ray_end = TraceCaptures(ray);
    bool is_known = ray_end.code == PATH_SKY || ray_end.code >= PATH_CAPTURE;
    StoreRayResult(ray, RayResult(CaptureColor(ray_end, ray), is_known || !OVER, ray_end.place, ray_end.code, NO_TRIANGLE));
}
