#version 460
#pragma program(Look)
// Draws the area of the window beside its panel: one picture, two side by side, or their difference. A picture is a
// colour image, or an intermediate image whose numbers are shown as shades. The target encodes sRGB.

#include "common/constants.glsl"

layout(binding = 0) uniform sampler2D first;
layout(binding = 1) uniform sampler2D second;

layout(push_constant) uniform LookBlock {
    ivec4 area;       // left, top, width and height of the pictures on the screen, pixels
    int compare;      // COMPARE_*
    int split;        // pixels from the left of the area
    int content;      // CONTENT_*
    int channel;      // one channel as grey; -1: all
    float exposure;   // factor
    float range_low;  // shown black
    float range_high; // shown white
    float gain;       // factor of the difference
    float near_plane; // metres, for depths of a perspective
    float far_plane;
    int is_linear;    // 1: depth is linear
} look;

layout(location = 0) out vec4 out_color;

// The shade of a reversed depth, 0 to 1. Near is bright, and a logarithm spreads the depths that a perspective
// compresses: a hundred times the near plane's distance is mid-grey. Sky is black.
float DepthShade(float reversed) {
    if (reversed <= 0.0)
        return 0.0;
    if (look.is_linear != 0)
        return reversed;
    float z = look.near_plane * look.far_plane
        / (look.near_plane + reversed * (look.far_plane - look.near_plane));
    return clamp(1.0 - log(z / look.near_plane) / log(1e4), 0.0, 1.0);
}

// The colour of a share (0 to 1) in a heat map: black, blue, green, yellow, red, white.
vec3 HeatColor(float share) {
    const vec3 stops[6] = vec3[](
        vec3(0.0), vec3(0.05, 0.1, 0.6), vec3(0.0, 0.5, 0.2), vec3(0.9, 0.75, 0.0), vec3(0.8, 0.05, 0.0), vec3(1.0));
    float position = clamp(share, 0.0, 1.0) * 5.0;
    int below = min(int(position), 4);
    return mix(stops[below], stops[below + 1], position - float(below));
}

// Multiplies a value by the exposure, and maps range_low to 0 and range_high to 1.
vec3 MapToRange(vec3 value) {
    return (value * look.exposure - look.range_low) / max(look.range_high - look.range_low, 1e-6);
}

// The colour in which a texel is shown, by `look.channel` and `look.content`.
vec3 Shade(vec4 texel) {
    if (look.channel >= 0)
        return MapToRange(vec3(texel[look.channel]));
    switch (look.content) {
        case CONTENT_NORMAL: return texel.xyz == vec3(0.0) ? vec3(0.0) : MapToRange(texel.xyz * 0.5 + 0.5);
        case CONTENT_REVERSED_DEPTH: return MapToRange(vec3(DepthShade(texel.r)));
        case CONTENT_STANDARD_DEPTH: return MapToRange(vec3(DepthShade(1.0 - texel.r), DepthShade(1.0 - texel.g), 0.0));
        case CONTENT_HEAT: return HeatColor(MapToRange(texel.rrr).r);
        default: return MapToRange(texel.rgb);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - look.area.xy;
    out_color = vec4(0.01, 0.01, 0.01, 1.0);
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, look.area.zw)))
        return;
    vec4 a = texelFetch(first, pixel, 0);
    if (look.compare == COMPARE_DIFFERENCE) {
        out_color.rgb = abs(Shade(a) - Shade(texelFetch(second, pixel, 0))) * look.gain;
    } else if (look.compare == COMPARE_SPLIT && pixel.x >= look.split) {
        out_color.rgb = pixel.x == look.split ? vec3(1.0) : Shade(texelFetch(second, pixel, 0));
    } else {
        out_color.rgb = Shade(a);
    }
}
