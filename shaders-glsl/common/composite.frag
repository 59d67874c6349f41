#version 460
#pragma program(Composite)
// Composite: lit colour + reflectivity * fade * reflection (docs/definitions.md, "Surfaces").

#include "common/constants.glsl"

layout(binding = 0) uniform sampler2D color_buffer;
layout(binding = 1) uniform sampler2D reflection_buffer; // rgb, and the fade in a
layout(binding = 2) uniform sampler2D material_buffer;   // reflectivity, roughness

layout(location = 0) out vec4 out_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 color = texelFetch(color_buffer, pixel, 0).rgb;
    float reflectivity = texelFetch(material_buffer, pixel, 0).r;
    if (reflectivity > REFLECTS_ABOVE) {
        vec4 reflection = texelFetch(reflection_buffer, pixel, 0);
        color += reflectivity * reflection.a * reflection.rgb;
    }
    out_color = vec4(color, 1.0);
}
