// The reflection of each pixel with a narrow lobe, from the rays around it, and the composite. Needs
// parameters.glsl.
//
// A pixel gathers the rays of the 3 x 3 pixels around it. Of these, four are in its block of 2 x 2 pixels, and four
// beside that block, two of which a pixel of the block has beside it as well; the ninth is at its corner. The pixels of
// the block hand each other what they loaded (block.glsl), and load four rays instead of nine.
//
// A neighbour's ray weighs as much as its lobe has in common with this one. (A weight by where each ray went,
// lobe / density as for wide lobes, takes 1.3 times as long; the error is the same, and under a moving camera
// a tenth more changes where a map turns the normals.)

#include "unified/tiles.glsl"
#include "unified/gloss.glsl"
#include "unified/sound.glsl"
#include "unified/gloss_record.glsl"
#include "unified/block.glsl"
#include "unified/gloss_gather.glsl"

layout(binding = 1, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 2) uniform sampler2D color_buffer;    // lit colour, linear
layout(binding = 3, rgba32ui) uniform readonly uimage2D seen_image; // gloss_narrow.glsl

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // where it is wanted

// By the lobe that the ray is of.
Gathered Unpacked(uvec4 words) {
    Record r = Unpack(words);
    return Gathered(vec4(r.mirror, r.root), r.color);
}

// One outside the block. Where no tile is drawn the image holds anything; a pixel with a narrow lobe is in one.
Gathered Load(ivec2 pixel) {
    ivec2 at = clamp(pixel, ivec2(0), unified.size - 1);
    uvec4 words = imageLoad(seen_image, at);
#ifndef WHOLE
    vec2 material = imageLoad(material_buffer, at).rg;
    words = Reflects(material) && ListOf(material) == NARROW_LIST ? words : NO_RECORD;
#endif
    return Unpacked(words);
}

void Gather(inout Sum sum, Gathered own, Gathered r) {
    // The root of Overlap, for a power between the two, by mirrors instead of normals, which turn half as far:
    // Overlap itself gives the same error, and more change under a moving camera.
    float power = abs(own.key.w * r.key.w);
    vec3 chord = own.key.xyz - r.key.xyz;
    float same = exp2(-0.125 * LOG2_E * power * dot(chord, chord));
    float weight = r.key.w != 0.0 ? max(same, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    Add(sum, weight, r.key.w > 0.0, max(r.color, 0.0));
}

// Over tiles, what is not of the list is discarded: the images already hold what it shows. With WHOLE they
// hold nothing, all that reflects is of the list, and the other pixels show their lit colour.
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    // A block at the edge of an odd size reaches beyond it.
    bool inside = all(lessThan(pixel, unified.size));
    Gathered own = Unpacked(inside ? imageLoad(seen_image, pixel) : NO_RECORD);
    ivec2 outward = Outward(pixel);
    Gathered across = AcrossX(own, outward.x);
    Gathered beside = Load(pixel + ivec2(outward.x, 0));
    Gathered under = Load(pixel + ivec2(0, outward.y));
    Sum sum = Sum(vec4(0.0), 0.0, 0.0);
    Add(sum, 1.0, own.key.w > 0.0, own.color);
    Gather(sum, own, across);
    Gather(sum, own, AcrossY(own, outward.y));
    Gather(sum, own, AcrossY(across, outward.y));
    Gather(sum, own, beside);
    Gather(sum, own, AcrossY(beside, outward.y));
    Gather(sum, own, under);
    Gather(sum, own, AcrossX(under, outward.x));
    Gather(sum, own, Load(pixel + outward));
    bool shows = own.key.w != 0.0;
#ifndef WHOLE
    if (!shows)
        discard;
#endif
    vec4 reflection = vec4(0.0);
    vec3 color = texelFetch(color_buffer, pixel, 0).rgb;
    if (shows) {
        reflection = Reflection(sum);
        reflection = vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0));
        float reflectivity = imageLoad(material_buffer, pixel).r;
        color = min(color + reflectivity * reflection.a * reflection.rgb, GREATEST);
    }
    out_reflection = reflection;
    out_color = vec4(color, 1.0);
}
