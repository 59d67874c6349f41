// The reflection of a cell with a wide lobe, from the rays of the 5 x 5 cells around it.
// CPU twin: reference::unified::gather.

#ifndef UNIFIED_RESOLVE_CELLS_GLSL
#define UNIFIED_RESOLVE_CELLS_GLSL

#include "triangles/own_rays.glsl"
#include "unified/resolve/drawn_cells.glsl"
#include "unified/resolve/gathered.glsl"

layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space

#define GATHERS
#include "unified/gloss.glsl"

layout(binding = 5, rgba32f) uniform readonly image2D place_image; // written by TraceWide
layout(binding = 6, rgba16f) uniform readonly image2D seen_image;

struct ResolvedCell {
    vec4 reflection;
    vec4 surface; // normal; w: ViewPoint.z, bounded by 16 bits, or 1 if rays of sight are parallel; 0 for no surface.
                  // If pixels may get own rays, w is negative where no pixel can rely on what the cell gathered.
};

// The cell itself, or the nearest cell that the image has.
ivec2 ClampCell(ivec2 cell) {
    return clamp(cell, ivec2(0), (unified.size - 1) >> 1);
}

// The ray of a cell of the image. The ray's key is its place and density (TraceWide). The images are undefined for a
// cell that has not been drawn.
NeighbourRay LoadCellRay(ivec2 cell, bool is_drawn) {
    return NeighbourRay(is_drawn ? imageLoad(place_image, cell) : vec4(0.0),
                        is_drawn ? imageLoad(seen_image, cell) : vec4(0.0));
}

// The lobe for which a cell gathers rays, and the point from which the lobe leaves.
struct GatherPoint {
    vec3 point;
    Lobe lobe;
    float peak; // LogDensity in the middle of the lobe
};

// The rays that a cell gathers.
struct CellSum {
    RaySum rays;
    vec4 closest;  // sums over the 3 x 3 closest cells, weighted by closeness as well: colours, and in w the weights
    float nearest; // squared distance to the nearest hit of the closest cells, or of all if pixels may get own rays
};

// Adds a ray as a sample of the lobe `centre`. The weight is the lobe f over the ray's density q, bounded as 2 f / (f +
// q). This equals f / q where f and q agree, and is never above 2, however small q is (the balance heuristic between
// the two pixels; Veach and Guibas 1995). Densities of different roughness can be compared as they are. Only this
// weight keeps rays of other surfaces out. `closeness` is 1 for the ray of the cell itself, halved for each step along
// an axis, and 0 for cells that are two cells away.
void GatherRay(inout CellSum sum, GatherPoint centre, NeighbourRay ray, float closeness) {
    bool ended_near = ray.key.w > 0.75 * NEAR_MARK;
    float density = ray.key.w - (ended_near ? NEAR_MARK : 0.0);
    vec3 to_end = density > 0.0 ? ray.key.xyz - centre.point : ray.key.xyz;
    // For wide lobes the cosine gives the angle precisely enough.
    float log_cos = LogCos(1.0 - dot(to_end, centre.lobe.mirror) * inversesqrt(dot(to_end, to_end)));
    float weight = 2.0 / (1.0 + exp2(abs(density) - centre.peak - LOG2_E * (centre.lobe.power - 1.0) * log_cos));
    weight = density != 0.0 ? max(weight, LEAST_WEIGHT) : 0.0;
    bool hit = density > 0.0 && dot(to_end, centre.lobe.normal) > 0.0;
    // A colour that was handed on may be a last bit below 0.
    vec4 color = max(ray.color, 0.0);
    AddRay(sum.rays, weight, hit, color);
    if (closeness > 0.0)
        sum.closest += closeness * vec4((hit ? weight : 0.0) * color.rgb, weight);
    // Only own rays ask about more than the closest cells.
    if ((OWN_RAYS > 0 || closeness > 0.0) && density > 0.0)
        sum.nearest = min(sum.nearest, ended_near ? 0.0 : dot(to_end, to_end));
}

// Gathers the rays of the 5 x 5 cells around a cell. For 3 x 3 of these cells, both distances from the cell itself are
// even, and the cell loads their rays. The others lie at even distances from one of the block's three other cells,
// which a device shades in step and which hand these rays on. Each loaded ray is followed by the ray that the block's
// other cell along y has in its place, so that few rays are held at a time. The file that includes this one defines the
// function.
void GatherNeighbours(inout CellSum sum, GatherPoint centre, ivec2 cell, ivec2 outward);

// The width of a pixel at the distance of a point, in the scale of ViewPoint.
float PixelWidth(vec3 point) {
    return 2.0 * unified.pixel_to_view.y * (ORTHOGRAPHIC ? 1.0 : point.z);
}

// Whether a ray ended so near that the pixels around a point see different things. A thing that stands so near hides
// different things from each pixel, which no weight of a neighbour's ray takes into account.
bool IsContact(vec3 point, float squared_distance) {
    float pixel_width = PixelWidth(point);
    return squared_distance < CONTACT * CONTACT * pixel_width * pixel_width;
}

// The additional weight of the closest cells (CONTACT_WEIGHT), for the squared distance to the nearest hit. It falls
// with the distance, so that nothing jumps where a hit is just far enough away, and with the roughness, since a wider
// lobe needs more rays.
float ContactWeight(vec3 point, float roughness, float squared_distance) {
    float pixels = sqrt(squared_distance) / PixelWidth(point);
    float nearness = clamp((CONTACT_END - pixels) / (CONTACT_END - NEAR_HIT), 0.0, 1.0);
    return CONTACT_WEIGHT * (1.0 - roughness) * (1.0 - roughness) * nearness;
}

// The rays that a cell gathered. In their colour, the 3 x 3 closest cells count once more, `weight` times as much as by
// their own weights. The fade stays that of all 25 cells, since it hardly differs between them.
RaySum WeightedSum(CellSum sum, float weight) {
    vec4 weighted = vec4(sum.rays.color.rgb, sum.rays.weight) + weight * sum.closest;
    sum.rays.color.rgb = weighted.rgb * (sum.rays.weight / max(weighted.a, 1e-30));
    return sum.rays;
}

// Makes the reflection of a cell, and the surface that it belongs to.
ResolvedCell ResolveCell(ivec2 cell) {
    WideCell wide_cell = FindWideCell(cell);
    ivec2 pixel = wide_cell.pixel;
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = MakeLobe(point, normal, wide_cell.roughness);
    GatherPoint centre = GatherPoint(point, lobe, LogDensity(lobe.power, 0.0));
    ivec2 outward = DirectionOutOfBlock(cell);
    CellSum sum = CellSum(NO_RAYS, vec4(0.0), FAR_SKY * FAR_SKY);
    GatherNeighbours(sum, centre, cell, outward);
    bool has_wide_lobe = wide_cell.roughness > 0.0;
    float marked_z = ORTHOGRAPHIC ? 1.0 : min(point.z, GREATEST_HALF);
    marked_z = OWN_RAYS > 0 && (wide_cell.is_mixed || IsContact(point, sum.nearest)) ? -marked_z : marked_z;
    RaySum rays = WeightedSum(sum, ContactWeight(point, wide_cell.roughness, sum.nearest));
    return ResolvedCell(has_wide_lobe ? ReflectionFromSum(rays) : vec4(0.0),
                        has_wide_lobe ? vec4(normal, marked_z) : vec4(0.0));
}

#endif
