#version 460
#pragma program(CustomReflection)
// Converts a user's reflection to the form of this project's methods: colour before fade and reflectivity, and the fade
// in a; black where nothing reflects. The sampler scales the reflection to the size of the target.

#include "common/constants.glsl"

layout(binding = 0) uniform sampler2D reflection_buffer;
layout(binding = 1) uniform sampler2D material_buffer;

layout(std140, binding = 2) uniform CustomOutputBlock {
    vec2 resolution;
    int alpha;      // ALPHA_*: what the fourth channel means
} given;

layout(location = 0) out vec4 reflection;

void main() {
    vec2 uv = gl_FragCoord.xy / given.resolution;
    vec4 value = textureLod(reflection_buffer, uv, 0.0);
    float reflectivity = texelFetch(material_buffer, ivec2(gl_FragCoord.xy), 0).r;
    if (given.alpha == ALPHA_NONE)
        value.a = 1.0;
    else if (given.alpha == ALPHA_PREMULTIPLIED)
        value.rgb = value.a > 0.0 ? value.rgb / value.a : vec3(0.0);
    reflection = reflectivity > REFLECTS_ABOVE ? value : vec4(0.0);
}
