// The reflection of each pixel with a wide lobe, from the cells around it, and the composite. Needs
// parameters.glsl.

#include "unified/normal.glsl"
#include "unified/tiles.glsl"
#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/gloss.glsl"
#include "unified/sound.glsl"
#include "unified/listed.glsl"
#include "unified/block.glsl"

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear
layout(binding = 5, rgba16f) uniform readonly image2D cell_reflection; // gloss_cells.frag
layout(binding = 6, rgba16f) uniform readonly image2D cell_surface;

#include "unified/gloss_cell.glsl"

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // where it is wanted

// Off its plane by this share of its depth, a cell has lost most of its weight: the world's tolerance
// in DEFINITIONS, "World agreement".
#define PLANE_TOLERANCE 0.02
#define REACH 4.0 // pixels along an axis from a cell's ray to where it would weigh nothing

// A wide lobe, between the four cells around the pixel, by how near their rays begin, and as far as each lies in the
// pixel's plane and its lobe is the pixel's (joint bilateral upsampling; Kopf et al. 2007).
vec4 Wide(ivec2 pixel, float depth, vec3 normal, float power) {
    ivec2 last = (unified.size - 1) >> 1;
    ivec2 cell = pixel >> 1;
    ivec2 outward = Outward(pixel);
    LookAround(cell, outward);
    // Seen `away` pixels from here, a point at view depth z' lies off the pixel's plane by a share of the tolerance
    // that is (facing + dot(turn, away)) z' / z - facing.
    float facing = dot(normal, ViewRay(vec2(pixel) + 0.5)) / PLANE_TOLERANCE;
    vec2 turn = normal.xy * unified.pixel_to_view * vec2(2.0, -2.0) / PLANE_TOLERANCE;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = clamp(cell + outward * ivec2(i & 1, i >> 1), ivec2(0), last);
        bool is_drawn = IsDrawn(at);
        vec4 surface = is_drawn ? imageLoad(cell_surface, at) : vec4(0.0);
        vec2 away = vec2(CellPixel(at) - pixel);
        vec2 near = REACH - abs(away);
        float off = (facing + dot(turn, away)) * (surface.w * (depth + unified.depth_offset)) - facing;
        float same = Overlap(normal - surface.xyz, power);
        float squared = off * off;
        float weight = surface.w > 0.0 ? near.x * near.y * max(same / (1.0 + squared * squared), LEAST_WEIGHT) : 0.0;
        vec4 reflection = is_drawn ? imageLoad(cell_reflection, at) : vec4(0.0);
        // Over another reflection, a cell shows its colour only as far as it is there.
        reflection.rgb *= OVER != 0 ? reflection.a : 1.0;
        sum += weight * reflection;
        weights += weight;
    }
    float colors = OVER != 0 ? sum.a : weights;
    return colors > 0.0 ? vec4(sum.rgb / colors, sum.a / weights) : vec4(0.0);
}

// Over tiles, what is not of the list is discarded: the images already hold what it shows. With WHOLE they
// hold nothing, all that reflects is of the list, and the other pixels show their lit colour.
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    bool reflects = Reflects(material) && depth > 0.0;
#ifndef WHOLE
    if (!reflects || ListOf(material) != WIDE_LIST)
        discard;
#endif
    vec4 reflection = vec4(0.0);
    vec3 color = texelFetch(color_buffer, pixel, 0).rgb;
    if (reflects) {
        vec3 normal = Normal(pixel);
        reflection = Wide(pixel, depth, normal, LobePower(material.g));
        reflection = vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0));
        color = min(color + material.r * reflection.a * reflection.rgb, GREATEST);
    }
    out_reflection = reflection;
    out_color = vec4(color, 1.0);
}
