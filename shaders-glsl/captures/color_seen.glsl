// The lit colour that a ray sees over a footprint on the screen, with the sky along the ray where the screen shows sky. Needs the
// image `color_buffer`.

#ifndef CAPTURES_COLOR_SEEN_GLSL
#define CAPTURES_COLOR_SEEN_GLSL

#include "captures/captures.glsl"

// The sky along a ray.
vec3 SkyAlong(vec3 direction) {
    return Sky(ToWorld(direction));
}

// Whether a texel of the lit colour shows nothing but sky.
bool ShowsSky(vec4 seen) {
    return unified.sky != 0 && seen.a == 0.0;
}

// The lit colour of the screen around a place, from a level of its chain. The share of it that is sky (1 - a) was seen in
// another direction than `along`, which is the sky along the ray.
vec3 ColorOver(vec2 position, float level, vec3 along) {
    vec4 seen = textureLod(color_buffer, position * unified.pixel_to_clip, level);
    vec3 color = Sound(seen.rgb);
    if (unified.sky != 0 && seen.a < 1.0) {
        vec3 there = Sky(ToWorld(ViewRay(position)));
        color = seen.a > 0.0 ? Sound(color + (1.0 - seen.a) * (along - there)) : along;
    }
    return color;
}

#endif
