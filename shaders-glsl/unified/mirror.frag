#version 460
#pragma program(Mirror)
// What a mirror pixel shows: one ray, one sample of the lit colour at its hit, and the composite.
//
// Over tiles, what is no mirror is discarded: the images already hold what it shows. With WHOLE the images hold
// nothing, all that reflects is a mirror, and the other pixels show their lit colour.

#include "unified/parameters.glsl"

layout(constant_id = 3) const bool HITS = false;  // out_hit is wanted
layout(constant_id = 4) const bool WHOLE = false; // drawn over the whole image, not over tiles
layout(constant_id = 6) const bool COMPOSITE = true; // without it the reflection is all that is shown

layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer; // lit colour, linear

layout(location = 0) out vec4 out_color;      // lit colour + reflectivity * fade * reflection; or the reflection
layout(location = 1) out vec4 out_reflection; // where it is wanted beside it: colour, and fade in a; a miss is 0
layout(location = 2) out vec4 out_hit;        // texture coordinates, standard depth, PATH_*

#include "unified/traverse.glsl"
#include "captures/seen.glsl"

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 material = imageLoad(material_buffer, pixel).xy;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    bool traced = Reflects(material) && depth > 0.0 && normal != vec3(0.0);
    out_reflection = vec4(0.0);
    out_color = COMPOSITE ? texelFetch(color_buffer, pixel, 0) : vec4(0.0);
    if (HITS)
        out_hit = vec4(-1.0, -1.0, -1.0, float(PATH_NONE));
    if (!WHOLE && (!traced || ListOf(material) != MIRROR_LIST))
        discard;
    if (!traced)
        return;
    bool faces;
    Ray ray = MirrorRay(pixel, depth, normal, faces);
    Hit hit = Traverse(ray);
    bool is_hit = hit.code == PATH_HI_Z && faces;
    bool in_sky = faces && EndsInSky(ray, hit);
    if (is_hit || in_sky) {
        vec3 along = SkyAlong(ray.direction);
        out_reflection = in_sky ? vec4(along, 1.0)
                                : vec4(ColorMirrored(hit.position, along), Fade(hit.position * unified.pixel_to_clip));
    } else if (faces) {
        PushIfLost(uvec2(pixel), ray, hit, length(ViewPoint(ray.start, depth)) * captures.view_unit,
                   2.0 * unified.pixel_to_view.y);
    }
    if (is_hit || in_sky) {
        vec3 seen = out_color.rgb + material.x * out_reflection.a * out_reflection.rgb;
        out_color = COMPOSITE ? vec4(min(seen, GREATEST_HALF), out_color.a) : out_reflection;
    }
    if (HITS) {
        precise vec2 uv = hit.position * unified.pixel_to_clip;
        precise float hit_depth = 1.0 - hit.depth;
        vec3 place = hit.code == PATH_HI_Z ? vec3(uv, hit_depth) : vec3(-1.0);
        int code = in_sky ? PATH_SKY : hit.code == PATH_MISS ? WhyMissed(ray) : hit.code;
        out_hit = vec4(place, float(code));
    }
}
