// The reflection of each cell with a wide lobe, from the rays of the 5 x 5 cells around it. Needs parameters.glsl.

#include "unified/ray.glsl"
#include "unified/tiles.glsl"
#include "unified/gloss.glsl"
#include "unified/sound.glsl"

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4, rgba32f) uniform readonly image2D place_image;
layout(binding = 5, rgba16f) uniform readonly image2D seen_image;

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface; // normal, and ViewPoint.z as far as 16 bits go; 0: none

#include "unified/gloss_cell.glsl"
#include "unified/gloss_gather.glsl"
#include "unified/listed.glsl"

// Adds a ray by what is seen of it along `to` from here, of any length. Its weight is lobe / density, bounded:
// 2 f / (f + q) is f / q where they agree, and never above 2, however little a neighbour expected what matters
// here (the balance heuristic between the two pixels; Veach and Guibas 1995). Densities of different roughness
// compare as they stand. The weight alone keeps foreign surfaces apart: tests of normals and planes changed no
// figure.
void Gather(inout Sum sum, Lobe lobe, float peak, vec3 to, float density, vec4 color) {
    // For wide lobes the cosine of an angle tells it well enough.
    float log_cos = LogCos(1.0 - dot(to, lobe.mirror) * inversesqrt(dot(to, to)));
    float weight = 2.0 / (1.0 + exp2(abs(density) - peak - LOG2_E * (lobe.power - 1.0) * log_cos));
    weight = density != 0.0 ? max(weight, LEAST_WEIGHT) : 0.0;
    Add(sum, weight, density > 0.0 && dot(to, lobe.normal) > 0.0, color);
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy), last = (unified.size - 1) >> 1;
    out_reflection = vec4(0.0);
    out_surface = vec4(0.0);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    if (roughness > 0.0) {
        float depth = imageLoad(pyramid, pixel).r;
        vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        Lobe lobe = LobeOf(point, normal, roughness);
        // Of the tiles beside this one, those that a reach of two cells can touch.
        LISTED_AROUND(cell, 1 - 2 * ivec2(lessThan(cell & (TILE / 2 - 1), ivec2(2))));
        float peak = LogDensity(lobe.power, 0.0);
        Sum sum = Sum(vec4(0.0), 0.0, 0.0);
        for (int y = -2; y <= 2; ++y) {
            for (int x = -2; x <= 2; ++x) {
                ivec2 at = clamp(cell + ivec2(x, y), ivec2(0), last);
                bool is_drawn = IS_DRAWN(at);
                vec4 place = is_drawn ? imageLoad(place_image, at) : vec4(0.0); // gloss_wide.frag
                vec4 color = is_drawn ? imageLoad(seen_image, at) : vec4(0.0);
                vec3 to = place.w > 0.0 ? place.xyz - point : place.xyz;
                Gather(sum, lobe, peak, to, place.w, color);
            }
        }
        out_reflection = Reflection(sum);
        out_surface = vec4(normal, min(point.z, GREATEST));
    }
}
