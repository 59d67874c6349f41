// The reflection of a pixel with a wide lobe, interpolated between the four cells around it. CPU twin:
// reference::unified::resolve.

#ifndef UNIFIED_RESOLVE_WIDE_GLSL
#define UNIFIED_RESOLVE_WIDE_GLSL

#include "triangles/push_doubt.glsl"
#include "unified/resolve/blocks.glsl"
#include "unified/resolve/drawn_cells.glsl"
#include "unified/resolve/shown.glsl"

layout(constant_id = 2) const bool OVER = false; // another reflection shows where this one misses

layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness

#define GATHERS
#include "unified/gloss.glsl"

layout(binding = 5, rgba16f) uniform readonly image2D cell_reflection; // written by Cells
layout(binding = 6, rgba16f) uniform readonly image2D cell_surface;

// A cell that lies off the pixel's plane by this share of its depth has lost most of its weight.
#define PLANE_TOLERANCE VISIBLE_WITHIN

// The distance of the pixel that stands for a cell from the plane of another pixel of a depth, in tolerances, if rays
// of sight are parallel. `across_part` is the part of this distance that comes from the offset across the view, and
// `facing` is the cosine at which the plane is seen, both over PLANE_TOLERANCE. The depth is read again, since z in 16
// bits is less precise than the tolerance, a share of the image's height.
float PlaneDistance(ivec2 cell, float depth, float across_part, float facing) {
    float cell_depth = DepthAt(min(CellPixel(cell), unified.size - 1));
    return (across_part + facing * (depth - cell_depth) / unified.depth_offset) / unified.reach;
}

// The reflection of a pixel with a wide lobe, interpolated between the four cells around it. A cell weighs more if its
// ray begins near the pixel, if it lies in the pixel's plane, and if its lobe is like the pixel's (joint bilateral
// upsampling; Kopf et al. 2007). `agreement` becomes the part of these cells that shows the pixel's surface. It is 0 if
// no pixel can rely on the pixel's own cell: at the edge of a reflector, and where something stands so near that
// neighbours see different things.
vec4 UpsampleCells(ivec2 pixel, float depth, vec3 normal, float power, out float agreement) {
    ivec2 last = (unified.size - 1) >> 1;
    ivec2 cell = pixel >> 1;
    ivec2 outward = DirectionOutOfBlock(pixel);
    LoadNeighbourTiles(cell, outward);
    // A point at view depth z' that is seen `offset` pixels from here lies off the pixel's plane, in tolerances, by
    // (facing + dot(turn, away)) z' / z - facing.
    float facing = dot(normal, ViewRay(vec2(pixel) + 0.5)) / PLANE_TOLERANCE;
    vec2 facing_change = normal.xy * unified.pixel_to_view * vec2(2.0, -2.0) / PLANE_TOLERANCE;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    float agreeing_weight = 0.0, whole_weight = 0.0;
    bool is_unreliable = false;
    for (int i = 0; i < 4; ++i) {
        ivec2 sampled_cell = clamp(cell + outward * ivec2(i & 1, i >> 1), ivec2(0), last);
        bool is_drawn = IsDrawn(sampled_cell);
        vec4 surface = is_drawn ? imageLoad(cell_surface, sampled_cell) : vec4(0.0);
        is_unreliable = is_unreliable || (i == 0 && surface.w < 0.0);
        surface.w = abs(surface.w);
        vec2 offset = vec2(CellPixel(sampled_cell) - pixel);
        vec2 nearness = CELL_REACH - abs(offset);
        float off_plane = ORTHOGRAPHIC
            ? PlaneDistance(sampled_cell, depth, dot(facing_change, offset), facing)
            : (facing + dot(facing_change, offset)) * (surface.w * (depth + unified.depth_offset)) - facing;
        float lobe_overlap = LobeOverlap(normal - surface.xyz, power);
        float squared_distance = off_plane * off_plane;
        float fit = surface.w > 0.0 ? lobe_overlap / (1.0 + squared_distance * squared_distance) : 0.0;
        float weight = surface.w > 0.0 ? nearness.x * nearness.y * max(fit, LEAST_WEIGHT) : 0.0;
        agreeing_weight += nearness.x * nearness.y * fit;
        whole_weight += nearness.x * nearness.y;
        vec4 reflection = is_drawn ? imageLoad(cell_reflection, sampled_cell) : vec4(0.0);
        // Over another reflection, the colour of a cell counts by its fade.
        reflection.rgb *= OVER ? reflection.a : 1.0;
        sum += weight * reflection;
        weights += weight;
    }
    agreement = is_unreliable ? 0.0 : agreeing_weight / whole_weight;
    float color_weight = OVER ? sum.a : weights;
    return color_weight > 0.0 ? vec4(sum.rgb / color_weight, sum.a / weights) : vec4(0.0);
}

// Shades a pixel; false for a pixel that is left as it is.
bool ShadePixel(ivec2 pixel, out PixelOutput result) {
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = DepthAt(pixel);
    bool reflects = Reflects(material) && depth > 0.0;
    if (!WHOLE && (!reflects || TileListOf(material) != WIDE_LIST))
        return false;
    vec4 reflection = vec4(0.0);
    if (reflects) {
        vec3 normal = imageLoad(normal_buffer, pixel).xyz;
        float agreement;
        reflection = SoundReflection(UpsampleCells(pixel, depth, normal, LobePower(material.g), agreement));
        if (OWN_RAYS > 0 && agreement < AGREES_ABOVE)
            PushDoubt(Doubt(pixel, reflection, AGREED_RAYS * agreement));
    }
    result = CompositePixel(pixel, reflection, reflects ? material.r : 0.0);
    return true;
}

#endif
