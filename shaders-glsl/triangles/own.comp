#version 460
#pragma program(OwnRays: Screen, NARROW, ON_SCREEN)
#pragma program(OwnRays: Tree, NARROW, AMONG_TRIANGLES)
#pragma program(OwnRays: Query, NARROW, AMONG_TRIANGLES, RAY_QUERY)
// Traces own rays for the pixels in doubt, a thread a ray. A pixel in doubt then shows the mean of what its own rays
// and its neighbours' rays saw, weighted by their numbers.

#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

#define LIST_ACCESS readonly
#define LOSES_NOTHING
#include "triangles/doubt.glsl"

layout(local_size_x = OWN_GROUP) in;

#ifdef ON_SCREEN
layout(constant_id = 2) const bool OVER = false; // another reflection shows where this one misses
#endif
layout(constant_id = 6) const bool COMPOSITE = true; // false: only the reflection is shown

#include "unified/trace/gloss_trace.glsl"
#include "unified/lit_color.glsl"
#include "unified/store.glsl"

shared vec4 colors[OWN_GROUP]; // what each ray saw, and its fade; negative for a miss

// The point of an own ray in the pattern over the lobe, in the unit square. Each ray has a stratum of its own from the
// middle to the edge of the lobe; around the middle, each ray is turned by the golden angle from the one before. Each
// pixel shifts the pattern in another way.
vec2 OwnRaySample(ivec2 pixel, int ray) {
    vec2 shift = SequencePoint(pixel.x + 3331 * pixel.y) + SequencePoint(unified.turn);
    return vec2((float(ray) + fract(shift.x)) / float(OWN_RAYS), fract(0.618034 * float(ray) + shift.y));
}

// Traces an own ray of a pixel, and returns the colour that it saw, with the fade in alpha; -1 in alpha for a miss.
vec4 TraceOwnRay(ivec2 pixel, int ray) {
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    Lobe lobe = MakeLobe(ViewPoint(vec2(pixel) + 0.5, depth), normal, imageLoad(material_buffer, pixel).g);
    RayEnd end;
    LobeSample lobe_sample = TraceLobeSample(pixel, pixel, depth, lobe, OwnRaySample(pixel, ray), float(OWN_RAYS), 1.0, end);
    return vec4(lobe_sample.color.rgb, lobe_sample.is_hit ? lobe_sample.color.a : -1.0);
}

// MeanWithNeighbours returns the mean of what a pixel's own rays saw, whose results begin at colors[first], and of what
// its neighbours' rays saw.
#ifdef ON_SCREEN

// A miss is black, and the fade is that of the hits, as in ReflectionFromSum (unified/resolve/gathered.glsl). Over another
// reflection a miss is not black but adds nothing, so that colours count by their fade.
vec4 MeanWithNeighbours(Doubt doubt, uint first) {
    vec4 own = vec4(0.0);
    float hits = 0.0;
    for (uint i = first; i < first + uint(OWN_RAYS); ++i) {
        vec4 color = colors[i];
        float fade = max(color.a, 0.0);
        own += vec4(OVER ? fade * color.rgb : color.rgb, fade);
        hits += color.a < 0.0 ? 0.0 : 1.0;
    }
    float rays = doubt.rays + float(OWN_RAYS);
    if (OVER) {
        vec4 whole = (doubt.rays * vec4(doubt.color.a * doubt.color.rgb, doubt.color.a) + own) / rays;
        return vec4(whole.a > 0.0 ? whole.rgb / whole.a : vec3(0.0), whole.a);
    }
    float hits_around = doubt.color.a > 0.0 ? doubt.rays : 0.0;
    return vec4((doubt.rays * doubt.color.rgb + own.rgb) / rays, (hits_around * doubt.color.a + own.a) / max(hits_around + hits, 1e-6));
}

#else

// Among triangles no ray misses, and nothing fades.
vec4 MeanWithNeighbours(Doubt doubt, uint first) {
    vec3 sum = doubt.rays * doubt.color.rgb;
    for (uint i = first; i < first + uint(OWN_RAYS); ++i)
        sum += colors[i].rgb;
    return vec4(sum / (doubt.rays + float(OWN_RAYS)), 1.0);
}

#endif

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint index = gl_WorkGroupID.x * PixelsPerGroup() + thread / uint(OWN_RAYS);
    int ray = int(thread % uint(OWN_RAYS));
    bool is_listed = thread < PixelsPerGroup() * uint(OWN_RAYS)
                  && index < min(lost_counts.count, uint(doubts.pixels.length()));
    Doubt doubt = UnpackDoubt(doubts.pixels[is_listed ? index : 0u]);
    colors[thread] = is_listed ? TraceOwnRay(doubt.pixel, ray) : vec4(0.0);
    barrier();
    if (!is_listed || ray != 0)
        return;
    vec4 mean = MeanWithNeighbours(doubt, thread);
    vec4 reflection = vec4(min(Sound(mean.rgb), GREATEST_HALF), min(Sound(mean.a), 1.0));
    vec4 color = ScreenColor(doubt.pixel);
    float reflectivity = imageLoad(material_buffer, doubt.pixel).r;
    color.rgb = min(color.rgb + reflectivity * reflection.a * reflection.rgb, GREATEST_HALF);
    StorePixel(doubt.pixel, COMPOSITE ? color : reflection, reflection);
}
