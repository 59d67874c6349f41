// The output of the programs that resolve gloss. Over tiles, a pixel of another kind than the list's is left as it is:
// the images already hold what it shows. With WHOLE the images hold nothing, all reflecting pixels are of the list's
// kind, and the other pixels show their lit colour.

#ifndef UNIFIED_SHOWN_GLSL
#define UNIFIED_SHOWN_GLSL

layout(constant_id = 6) const bool COMPOSITE = true; // false: only the reflection is shown

#include "unified/lit_color.glsl"

struct PixelOutput {
    vec4 color;      // the composite, or the reflection
    vec4 reflection; // colour, and fade in alpha
};

// The output of a pixel with a reflection (colour, and fade in alpha) and the reflectivity of its surface.
PixelOutput CompositePixel(ivec2 pixel, vec4 reflection, float reflectivity) {
    vec4 color = ScreenColor(pixel);
    color.rgb = min(color.rgb + reflectivity * reflection.a * reflection.rgb, GREATEST_HALF);
    return PixelOutput(COMPOSITE ? color : reflection, reflection);
}

// A reflection without NaN, infinity or a fade above 1.
vec4 SoundReflection(vec4 reflection) {
    return vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0));
}

#endif
