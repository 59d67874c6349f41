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
Gathered Unpacked(uvec4 words) {
    Record r = Unpack(words);
    return Gathered(vec4(r.mirror, r.root), r.color);
}

// One outside the block. Where no tile is drawn the image holds anything; a pixel with a narrow lobe is in one.
Gathered Load(ivec2 pixel) {
    ivec2 at = clamp(pixel, ivec2(0), unified.size - 1);
    uvec4 words = imageLoad(seen_image, at);
    if (!WHOLE) {
        vec2 material = imageLoad(material_buffer, at).rg;
        words = Reflects(material) && ListOf(material) == NARROW_LIST ? words : NO_RECORD;
    }
    return Unpacked(words);
}

void Gather(inout Sum sum, Gathered own, Gathered r) {
    // The root of Overlap, for a power between the two, by mirrors instead of normals, which turn half as far. Of the
    // two it is the steadier one under a moving camera.
    float power = abs(own.key.w * r.key.w);
    vec3 chord = own.key.xyz - r.key.xyz;
    float same = exp2(-0.125 * LOG2_E * power * dot(chord, chord));
    float weight = r.key.w != 0.0 ? max(same, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    Add(sum, weight, r.key.w > 0.0, max(r.color, 0.0));
}

// The rays around a pixel: its own, the three of its block (beside it, above or below, and across the corner), the two
// beside the block, the two above or below it, and the one at its corner. The file that includes this one defines it.
Gathered[9] RaysAround(ivec2 pixel);

// Whether the rays around a pixel are too few for how much their colours differ. They stand for so many rays of the pixel's own,
// by how much their weights differ (the effective size of a weighted sample; Kish 1965).
bool IsDoubtful(Gathered rays[9], Sum sum, out float stand_for) {
    vec3 total = vec3(0.0), squares = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 9; ++i) {
        float counts = rays[i].key.w != 0.0 ? 1.0 : 0.0;
        vec3 color = counts * rays[i].color.rgb;
        total += color;
        squares += color * color;
        count += counts;
    }
    vec3 mean = total / count, variance = squares / count - mean * mean;
    stand_for = sum.weight * sum.weight / sum.squares;
    return dot(variance, vec3(1.0)) > stand_for * DOUBT_ABOVE * DOUBT_ABOVE * dot(mean, mean);
}

// False for a pixel that is left as it is.
bool Show(ivec2 pixel, out Shown shown) {
    Gathered rays[9] = RaysAround(pixel);
    Gathered own = rays[0];
    Sum sum = NO_RAYS;
    Add(sum, 1.0, own.key.w > 0.0, own.color);
    Gather(sum, own, rays[1]);
    Gather(sum, own, rays[2]);
    Gather(sum, own, rays[3]);
    Gather(sum, own, rays[4]);
    Gather(sum, own, rays[5]);
    Gather(sum, own, rays[6]);
    Gather(sum, own, rays[7]);
    Gather(sum, own, rays[8]);
    bool shows = own.key.w != 0.0;
    if (!WHOLE && !shows)
        return false;
    vec4 reflection = vec4(0.0);
    float reflectivity = 0.0;
    if (shows) {
        reflection = SoundReflection(Reflection(sum));
        float stand_for;
        if (OWN_RAYS > 0 && IsDoubtful(rays, sum, stand_for))
            PushDoubt(Doubt(pixel, reflection.rgb, stand_for));
        reflectivity = imageLoad(material_buffer, pixel).r;
    }
    shown = ShownOf(pixel, reflection, reflectivity);
    return true;
}

#endif
