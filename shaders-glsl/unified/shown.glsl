// What the programs that resolve gloss show of a pixel. Over tiles, a pixel that is not of the list is left as it is: the
// images already hold what it shows. With WHOLE they hold nothing, all that reflects is of the list, and the other pixels
// show their lit colour.

#ifndef UNIFIED_SHOWN_GLSL
#define UNIFIED_SHOWN_GLSL

layout(constant_id = 6) const bool COMPOSITE = true; // without it the reflection is all that is shown

#include "unified/lit_color.glsl"

struct PixelOutput {
    vec4 color;      // the composite, or the reflection
    vec4 reflection; // colour, and fade in a
};

// A pixel whose reflection is that, with a colour and a fade; its surface reflects so much of it.
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
