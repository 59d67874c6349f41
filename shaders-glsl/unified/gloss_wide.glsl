// A ray for a cell of 2 x 2 pixels with wide lobes: 25 directions. (A compute shader whose
// threads were ordered so that rays of one direction walk together took a fifth longer: what rays read
// of the pyramid lies together where they begin, not where they point.) Needs parameters.glsl.

#include "unified/gloss_trace.glsl"

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

#include "unified/gloss_cell.glsl"

// Footprints to a lobe: one a ray. (Smaller ones, as of 40, lower the error where a map turns the normals and raise
// it where all is flat; larger ones do the opposite.)
#define FOOTPRINTS 25.0

// A hit so near, in pixels: what a neighbour sees in this direction is more likely as near to itself than at
// this point. (A normal that a map has turned sends rays below the surface, which end in the next pixel.)
#define NEAR_HIT 8.0
#define FAR_AWAY 1e3

// The point that was hit (ViewPoint's scale), or the direction of a miss.
vec3 Place(ivec2 pixel, vec3 point, Seen seen, Hit hit) {
    vec3 there = ViewPoint(hit.position, hit.depth);
    vec2 away = abs(hit.position - vec2(pixel) - 0.5);
    bool beside = max(away.x, away.y) < NEAR_HIT;
    return seen.density > 0.0 ? beside ? point + FAR_AWAY * (there - point) : there : seen.direction;
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    out_place = vec4(0.0);
    out_color = vec4(0.0);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    vec3 normal = Normal(pixel);
    // How the normal turns from cell to cell: of the two that a device shades with this one, in step.
    vec3 unit = normal * inversesqrt(max(dot(normal, normal), 1e-30));
    vec3 turn_x = dFdxFine(unit), turn_y = dFdyFine(unit);
    if (roughness > 0.0) {
        // Cells of one direction in squares side by side have other parities, and other places in its stratum.
        ivec2 odd = cell & 1;
        vec2 stratum = 0.125 + 0.25 * vec2(2 * odd.x + odd.y, 2 * (odd.x ^ odd.y) + odd.x);
        vec2 u = LatticePoint(cell, 5, 7, stratum);
        float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        Lobe lobe = LobeOf(point, normal, roughness);
        // (For narrow lobes what they have in common lowers the error, too, but not the shimmer.)
        float common_part = 0.5 * (Overlap(turn_x, lobe.power) + Overlap(turn_y, lobe.power));
        Hit hit;
        Seen seen = Look(pixel, depth, point, lobe, u, FOOTPRINTS, common_part, hit);
        out_place = vec4(Place(pixel, point, seen, hit), seen.density);
        out_color = seen.color;
    }
}
