// The reflection of a pixel with a narrow lobe, from the rays around it. It gathers the rays of the 3 x 3 pixels around
// it. Of these, four are in its block of 2 x 2 pixels, and four beside that block, two of which a pixel of the block has
// beside it as well; the ninth is at its corner. The pixels of the block hand each other what they loaded, and load four
// rays instead of nine. A neighbour's ray weighs as much as its lobe has in common with this one.
// CPU twin: reference::unified::gather.

#ifndef UNIFIED_RESOLVE_NARROW_GLSL
#define UNIFIED_RESOLVE_NARROW_GLSL

#define GATHERS
#include "triangles/push_doubt.glsl"
#include "unified/gathered.glsl"
#include "unified/gloss.glsl"
#include "unified/shown.glsl"

layout(binding = 5, rgba32ui) uniform readonly uimage2D seen_image; // TraceNarrow

// By the lobe that the ray is of.
NeighbourRay UnpackNeighbourRay(uvec4 words) {
    RayRecord r = UnpackRecord(words);
    return NeighbourRay(vec4(r.mirror, r.root), r.color);
}

// One outside the block. Where no tile is drawn the image holds anything; a pixel with a narrow lobe is in one.
NeighbourRay LoadNeighbourRay(ivec2 pixel) {
    ivec2 clamped_pixel = clamp(pixel, ivec2(0), unified.size - 1);
    uvec4 words = imageLoad(seen_image, clamped_pixel);
    if (!WHOLE) {
        vec2 material = imageLoad(material_buffer, clamped_pixel).rg;
        words = Reflects(material) && TileListOf(material) == NARROW_LIST ? words : NO_RECORD;
    }
    return UnpackNeighbourRay(words);
}

// What is known of the rays around a pixel, one after the other, so that none must be held.
struct RayStatistics {
    RaySum sum;
    vec3 total;   // of their colours, if pixels may get rays of their own
    vec3 squares;
    float count;  // of rays
};

void CountRay(inout RayStatistics statistics, NeighbourRay r) {
    if (OWN_RAYS > 0) {
        float counts = r.key.w != 0.0 ? 1.0 : 0.0;
        vec3 color = counts * r.color.rgb;
        statistics.total += color;
        statistics.squares += color * color;
        statistics.count += counts;
    }
}

void GatherRay(inout RayStatistics statistics, NeighbourRay own, NeighbourRay r) {
    // The root of LobeOverlap, for a power between the two, by mirrors instead of normals, which turn half as far. Of the
    // two it is the steadier one under a moving camera.
    float power = abs(own.key.w * r.key.w);
    vec3 chord = own.key.xyz - r.key.xyz;
    float same = exp2(-0.125 * LOG2_E * power * dot(chord, chord));
    float weight = r.key.w != 0.0 ? max(same, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    AddRay(statistics.sum, weight, r.key.w > 0.0, max(r.color, 0.0));
    CountRay(statistics, r);
}

// The ray of a pixel that the device shades.
NeighbourRay LoadPixelRay(ivec2 pixel);

// Gathers the rays around a pixel: the three of its block (beside it, above or below, and across the corner), the two beside the
// block, the two above or below it, and the one at its corner. The file that includes this one defines both.
void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own, ivec2 pixel);

// Whether the rays around a pixel are too few for how much their colours differ. They stand for so many rays of the pixel's own,
// by how much their weights differ (the effective size of a weighted sample; Kish 1965).
bool IsDoubtful(RayStatistics statistics, out float stand_for) {
    vec3 mean = statistics.total / statistics.count, variance = statistics.squares / statistics.count - mean * mean;
    stand_for = statistics.sum.weight * statistics.sum.weight / statistics.sum.squares;
    return dot(variance, vec3(1.0)) > stand_for * DOUBT_ABOVE * DOUBT_ABOVE * dot(mean, mean);
}

// False for a pixel that is left as it is.
bool ShadePixel(ivec2 pixel, out PixelOutput result) {
    NeighbourRay own = LoadPixelRay(pixel);
    RayStatistics statistics = RayStatistics(NO_RAYS, vec3(0.0), vec3(0.0), 0.0);
    AddRay(statistics.sum, 1.0, own.key.w > 0.0, own.color);
    CountRay(statistics, own);
    GatherNeighbours(statistics, own, pixel);
    bool shows = own.key.w != 0.0;
    if (!WHOLE && !shows)
        return false;
    vec4 reflection = vec4(0.0);
    float reflectivity = 0.0;
    if (shows) {
        reflection = SoundReflection(ReflectionFromSum(statistics.sum));
        float stand_for;
        if (OWN_RAYS > 0 && IsDoubtful(statistics, stand_for))
            PushDoubt(Doubt(pixel, reflection, stand_for));
        reflectivity = imageLoad(material_buffer, pixel).r;
    }
    result = CompositePixel(pixel, reflection, reflectivity);
    return true;
}

#endif
