#version 460
#pragma program(Composite)
#pragma in_either_stage
// Composite: lit colour + reflectivity * fade * reflection (docs/definitions.md, "Surfaces").

#include "common/either_stage.glsl"
#include "common/constants.glsl"
#include "common/sound.glsl"

layout(binding = 0) uniform sampler2D color_buffer;
layout(binding = 1) uniform sampler2D reflection_buffer; // rgb, and the fade in alpha
layout(binding = 2) uniform sampler2D material_buffer;   // reflectivity, roughness

// With LIT, the image becomes the lit colour of the next bounce. It then keeps the alpha of the lit colour.
layout(constant_id = 0) const bool LIT = false;

OUTPUT(0, rgba16f, vec4, out_color);

SHADE(out_color) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    vec4 lit = texelFetch(color_buffer, pixel, 0);
    vec3 color = lit.rgb;
    float reflectivity = texelFetch(material_buffer, pixel, 0).r;
    if (reflectivity > REFLECTS_ABOVE) {
        vec4 reflection = texelFetch(reflection_buffer, pixel, 0);
        // The sum of two 16-bit colours may exceed the greatest 16-bit float.
        color = min(color + reflectivity * reflection.a * reflection.rgb, vec3(GREATEST_HALF));
    }
    out_color = LIT ? vec4(Sound(color), lit.a) : vec4(color, 1.0);
}
