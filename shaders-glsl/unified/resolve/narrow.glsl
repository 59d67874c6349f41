// The reflection of a pixel with a narrow lobe, from the rays of the 3 x 3 pixels around it. Four of these pixels are
// in its block of 2 x 2 pixels, four are beside this block, and the ninth is at the block's corner. The pixels of the
// block exchange what they loaded, so that each loads four rays instead of nine. The weight of a neighbour's ray is the
// overlap of its lobe with the pixel's own. CPU twin: reference::unified::gather.

#ifndef UNIFIED_RESOLVE_NARROW_GLSL
#define UNIFIED_RESOLVE_NARROW_GLSL

#define GATHERS
#define NARROW
#include "triangles/push_doubt.glsl"
#include "unified/resolve/gathered.glsl"
#include "unified/gloss.glsl"
#include "unified/resolve/shown.glsl"

layout(binding = 5, rgba32ui) uniform readonly uimage2D seen_image; // written by TraceNarrow

// Unpacks the record of a ray. The ray's key is the lobe that it belongs to.
NeighbourRay UnpackNeighbourRay(uvec4 words) {
    RayRecord record = UnpackRecord(words);
    return NeighbourRay(vec4(record.mirror, record.root), record.color);
}

// The ray of a pixel outside the block. The image is undefined where no tile is drawn; a pixel with a narrow lobe is in
// a drawn tile.
NeighbourRay LoadNeighbourRay(ivec2 pixel) {
    ivec2 clamped_pixel = clamp(pixel, ivec2(0), unified.size - 1);
    uvec4 words = imageLoad(seen_image, clamped_pixel);
    if (!WHOLE) {
        vec2 material = imageLoad(material_buffer, clamped_pixel).rg;
        words = Reflects(material) && TileListOf(material) == NARROW_LIST ? words : NO_RECORD;
    }
    return UnpackNeighbourRay(words);
}

// Sums over the rays around a pixel, to which one ray after the other is added, so that no ray must be held.
struct RayStatistics {
    RaySum sum;
    vec3 total;   // sum of the rays' colours, if pixels may get own rays
    vec3 squares; // sum of the squared colours
    float count;  // number of rays
};

// Adds a ray to the statistics that IsDoubtful reads.
void CountRay(inout RayStatistics statistics, NeighbourRay ray) {
    if (OWN_RAYS > 0) {
        float counts = ray.key.w != 0.0 ? 1.0 : 0.0;
        vec3 color = counts * ray.color.rgb;
        statistics.total += color;
        statistics.squares += color * color;
        statistics.count += counts;
    }
}

// Gathers a neighbour's ray, weighted by how alike its lobe and the pixel's own lobe are.
void GatherRay(inout RayStatistics statistics, NeighbourRay own_ray, NeighbourRay ray) {
    // `root_overlap` is the square root of LobeOverlap, for a power between those of the two lobes, from mirror
    // directions instead of normals, which turn half as far. The root is steadier than the overlap under a moving
    // camera.
    float power = abs(own_ray.key.w * ray.key.w);
    vec3 chord = own_ray.key.xyz - ray.key.xyz;
    float root_overlap = exp2(-0.125 * LOG2_E * power * dot(chord, chord));
    float weight = ray.key.w != 0.0 ? max(root_overlap, LEAST_WEIGHT) : 0.0;
    // A colour that was handed on may be a last bit below 0.
    AddRay(statistics.sum, weight, ray.key.w > 0.0, max(ray.color, 0.0));
    CountRay(statistics, ray);
}

// The ray of a pixel of the block. The file that includes this one defines the function.
NeighbourRay LoadPixelRay(ivec2 pixel);

// Gathers the rays around a pixel. Three are in its block (beside it, above or below, and across the corner), two
// beside the block, two above or below the block, and one at the block's corner. The file that includes this one
// defines the function.
void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own, ivec2 pixel);

// Whether the rays around a pixel are too few for how much their colours differ. `ray_worth` becomes the number of own
// rays that they are worth, given how much their weights differ (the effective size of a weighted sample; Kish 1965).
bool IsDoubtful(RayStatistics statistics, out float ray_worth) {
    vec3 mean = statistics.total / statistics.count, variance = statistics.squares / statistics.count - mean * mean;
    ray_worth = statistics.sum.weight * statistics.sum.weight / statistics.sum.squares;
    return dot(variance, vec3(1.0)) > ray_worth * DOUBT_ABOVE * DOUBT_ABOVE * dot(mean, mean);
}

// Shades a pixel; false for a pixel that is left as it is.
bool ShadePixel(ivec2 pixel, out PixelOutput result) {
    NeighbourRay own_ray = LoadPixelRay(pixel);
    RayStatistics statistics = RayStatistics(NO_RAYS, vec3(0.0), vec3(0.0), 0.0);
    AddRay(statistics.sum, 1.0, own_ray.key.w > 0.0, own_ray.color);
    CountRay(statistics, own_ray);
    GatherNeighbours(statistics, own_ray, pixel);
    bool has_narrow_lobe = own_ray.key.w != 0.0;
    if (!WHOLE && !has_narrow_lobe)
        return false;
    vec4 reflection = vec4(0.0);
    float reflectivity = 0.0;
    if (has_narrow_lobe) {
        reflection = SoundReflection(ReflectionFromSum(statistics.sum));
        float ray_worth;
        if (OWN_RAYS > 0 && IsDoubtful(statistics, ray_worth))
            PushDoubt(Doubt(pixel, reflection, ray_worth));
        reflectivity = imageLoad(material_buffer, pixel).r;
    }
    result = CompositePixel(pixel, reflection, reflectivity);
    return true;
}

#endif
