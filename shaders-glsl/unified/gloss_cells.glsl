// The reflection of each cell with a wide lobe, from the rays of the 5 x 5 cells around it. Needs parameters.glsl.

#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/normal.glsl"
#include "unified/tiles.glsl"
#include "unified/gloss.glsl"
#include "unified/sound.glsl"

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4, rgba32f) uniform readonly image2D place_image;
layout(binding = 5, rgba16f) uniform readonly image2D seen_image;

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface; // normal, and ViewPoint.z as far as 16 bits go; 0: none

#include "unified/gloss_cell.glsl"
#include "unified/gloss_gather.glsl"
#include "unified/listed.glsl"
#include "unified/block.glsl"

// What a cell's ray saw, by its place and density (gloss_wide.glsl). Where no tile is drawn the images hold anything.
Gathered Load(ivec2 cell) {
    ivec2 at = clamp(cell, ivec2(0), (unified.size - 1) >> 1);
    bool is_drawn = IsDrawn(at);
    return Gathered(is_drawn ? imageLoad(place_image, at) : vec4(0.0), is_drawn ? imageLoad(seen_image, at) : vec4(0.0));
}

struct Here {
    vec3 point;
    Lobe lobe;
    float peak; // LogDensity in the middle of the lobe
};

// Adds a ray by what is seen of it from here. Its weight is lobe / density, bounded:
// 2 f / (f + q) is f / q where they agree, and never above 2, however little a neighbour expected what matters
// here (the balance heuristic between the two pixels; Veach and Guibas 1995). Densities of different roughness
// compare as they stand. The weight alone keeps foreign surfaces apart: tests of normals and planes changed no
// figure.
void Gather(inout Sum sum, Here here, Gathered ray) {
    float density = ray.key.w;
    vec3 to = density > 0.0 ? ray.key.xyz - here.point : ray.key.xyz;
    // For wide lobes the cosine of an angle tells it well enough.
    float log_cos = LogCos(1.0 - dot(to, here.lobe.mirror) * inversesqrt(dot(to, to)));
    float weight = 2.0 / (1.0 + exp2(abs(density) - here.peak - LOG2_E * (here.lobe.power - 1.0) * log_cos));
    weight = density != 0.0 ? max(weight, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    Add(sum, weight, density > 0.0 && dot(to, here.lobe.normal) > 0.0, max(ray.color, 0.0));
}

// Five rays of a row, of every second cell and of those between, as the block has them.
Gathered[5] Row(ivec2 cell, ivec2 outward, int y) {
    Gathered inner = Load(cell + 2 * outward * ivec2(-1, y));
    Gathered middle = Load(cell + 2 * outward * ivec2(0, y));
    Gathered outer = Load(cell + 2 * outward * ivec2(1, y));
    return Gathered[5](inner, AcrossX(middle, outward.x), middle, AcrossX(inner, outward.x), outer);
}

void Gather(inout Sum sum, Here here, Gathered row[5]) {
    Gather(sum, here, row[0]);
    Gather(sum, here, row[1]);
    Gather(sum, here, row[2]);
    Gather(sum, here, row[3]);
    Gather(sum, here, row[4]);
}

Gathered[5] AcrossY(Gathered row[5], int outward) {
    return Gathered[5](AcrossY(row[0], outward), AcrossY(row[1], outward), AcrossY(row[2], outward),
                      AcrossY(row[3], outward), AcrossY(row[4], outward));
}

// A cell's square of 5 x 5 is of four kinds, as those of a block of 2 x 2 cells are: 3 x 3 lie two cells apart from
// itself, and those are loaded. The others are such cells of the three that a device shades in step with it.
void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    vec3 normal = Normal(pixel);
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = LobeOf(point, normal, roughness);
    Here here = Here(point, lobe, LogDensity(lobe.power, 0.0));
    // Of the tiles beside this one, those that a reach of two cells can touch.
    LookAround(cell, 1 - 2 * ivec2(lessThan(cell & (TILE / 2 - 1), ivec2(2))));
    ivec2 outward = Outward(cell);
    Gathered inner[5] = Row(cell, outward, -1), middle[5] = Row(cell, outward, 0);
    Sum sum = Sum(vec4(0.0), 0.0, 0.0);
    Gather(sum, here, inner);
    Gather(sum, here, AcrossY(middle, outward.y));
    Gather(sum, here, middle);
    Gather(sum, here, AcrossY(inner, outward.y));
    Gather(sum, here, Row(cell, outward, 1));
    bool shows = roughness > 0.0;
    out_reflection = shows ? Reflection(sum) : vec4(0.0);
    out_surface = shows ? vec4(normal, min(point.z, GREATEST)) : vec4(0.0);
}
