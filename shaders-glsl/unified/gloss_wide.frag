#version 460
// A ray for a cell of 2 x 2 pixels with wide lobes: thirteen directions. (A compute shader whose
// threads were ordered so that rays of one direction walk together took a fifth longer: what rays read
// of the pyramid lies together where they begin, not where they point.)

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(binding = 5) uniform sampler2D depth_buffer; // reversed

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

#include "unified/gloss_cell.glsl"

#define REACH 2 // pixels to the next cell

// How much of a pixel's lobe those of the cells beside it have in common with it, on average. (For narrow
// lobes this lowers the error, too, but not the shimmer.)
float Common(ivec2 pixel, float power) {
    vec3 unit = normalize(texelFetch(normal_buffer, pixel, 0).xyz);
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(int(i == 0) - int(i == 1), int(i == 2) - int(i == 3)) * REACH;
        ivec2 at = clamp(pixel + step, ivec2(0), unified.size - 1);
        sum += Overlap(unit, texelFetch(normal_buffer, at, 0).xyz, power);
    }
    return 0.25 * sum;
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    if (roughness > 0.0) {
        // Cells of one direction in diamonds side by side have other parities, and other places in its stratum.
        ivec2 odd = cell & 1;
        vec2 place = 0.125 + 0.25 * vec2(2 * odd.x + odd.y, 2 * (odd.x ^ odd.y) + odd.x);
        seen = Look(pixel, roughness, LatticePoint((cell.x + 5 * cell.y) % 13, 8, 13, place), 13.0, REACH,
                    Common(pixel, LobePower(roughness)));
    }
    out_place = seen.place;
    out_color = seen.color;
}
