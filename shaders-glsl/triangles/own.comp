#version 460
#pragma program(OwnRays, NARROW, AMONG_TRIANGLES)
#pragma program(OwnRaysQueried, NARROW, AMONG_TRIANGLES, RAY_QUERY)
// Gives rays of their own to the pixels whose neighbours' rays say little of their reflection, a thread a ray, and shows
// the mean of what these see and of what the neighbours' rays saw, by numbers of rays.

#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

#define LIST_ACCESS readonly
#include "triangles/doubt.glsl"

layout(local_size_x = OWN_GROUP) in;

layout(constant_id = 6) const bool COMPOSITE = true; // without it the reflection is all that is shown

#include "unified/gloss_trace.glsl"
#include "unified/store.glsl"

layout(binding = 4) uniform sampler2D color_buffer; // lit colour, linear

shared vec3 colors[OWN_GROUP];

// A ray's point in the pattern over the lobe. Each ray has a stratum of its own between the middle and the edge of the lobe;
// around the middle, one ray lies a golden angle behind the other. Each pixel has the pattern at another place.
vec2 OwnPoint(ivec2 pixel, int ray) {
    vec2 shift = SequencePoint(pixel.x + 3331 * pixel.y) + SequencePoint(unified.turn);
    return vec2((float(ray) + fract(shift.x)) / float(OWN_RAYS), fract(0.618034 * float(ray) + shift.y));
}

vec3 OwnColor(ivec2 pixel, int ray) {
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    Lobe lobe = LobeOf(ViewPoint(vec2(pixel) + 0.5, depth), normal, imageLoad(material_buffer, pixel).g);
    End end;
    return LookInLobe(pixel, pixel, depth, lobe, OwnPoint(pixel, ray), float(OWN_RAYS), 1.0, end).color.rgb;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint index = gl_WorkGroupID.x * PixelsToAGroup() + thread / uint(OWN_RAYS);
    int ray = int(thread % uint(OWN_RAYS));
    bool is_listed = thread < PixelsToAGroup() * uint(OWN_RAYS)
                  && index < min(lost_counts.count, uint(doubts.pixels.length()));
    Doubt doubt = UnpackDoubt(doubts.pixels[is_listed ? index : 0u]);
    colors[thread] = is_listed ? OwnColor(doubt.pixel, ray) : vec3(0.0);
    barrier();
    if (!is_listed || ray != 0)
        return;
    vec3 sum = doubt.rays * doubt.color;
    for (uint i = 0u; i < uint(OWN_RAYS); ++i)
        sum += colors[thread + i];
    vec4 reflection = vec4(min(Sound(sum / (doubt.rays + float(OWN_RAYS))), GREATEST_HALF), 1.0);
    vec4 color = texelFetch(color_buffer, doubt.pixel, 0);
    float reflectivity = imageLoad(material_buffer, doubt.pixel).r;
    color.rgb = min(color.rgb + reflectivity * reflection.rgb, GREATEST_HALF);
    Store(doubt.pixel, COMPOSITE ? color : reflection, reflection);
}
