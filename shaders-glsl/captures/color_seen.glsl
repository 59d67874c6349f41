// The lit colour that a ray sees at a hit on the screen, with the sky along the ray where the screen shows sky. Needs the
// image `color_buffer`.

#ifndef CAPTURES_COLOR_SEEN_GLSL
#define CAPTURES_COLOR_SEEN_GLSL

#include "captures/captures.glsl"

// The sky along a ray.
vec3 SkyAlong(vec3 direction) {
    return Sky(ToWorld(direction));
}

// The lit colour of the screen at a hit, from a level of its chain. The share of it that is sky (1 - a) was seen in
// another direction than `along`, which is the sky along the ray.
vec3 ColorSeen(vec2 position, float level, vec3 along) {
    vec4 seen = textureLod(color_buffer, position * unified.pixel_to_clip, level);
    vec3 color = Sound(seen.rgb);
    if (unified.sky != 0 && seen.a < 1.0) {
        vec3 there = Sky(ToWorld(ViewRay(position)));
        color = seen.a > 0.0 ? Sound(color + (1.0 - seen.a) * (along - there)) : along;
    }
    return color;
}

// The lit colour of the screen at a hit in full resolution. Each of the four pixels around the hit is sky or not, so that those that are can be left
// out, and the sky be looked up once: a device that takes both ways of a branch pays for every look.
vec3 ColorMirrored(vec2 position, vec3 along) {
    vec2 corner = position - 0.5;
    vec2 first = floor(corner);
    vec2 part = corner - first;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        vec4 seen = texelFetch(color_buffer, clamp(ivec2(first) + next, ivec2(0), unified.size - 1), 0);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        bool shows_sky = unified.sky != 0 && seen.a == 0.0;
        sum += weight.x * weight.y * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    }
    return Sound(sum.rgb) + (1.0 - sum.a) * along;
}

#endif
