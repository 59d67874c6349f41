#version 460
#pragma program(Fallback)
// A reflection with another behind it: the fallback is faded in where the local reflection is faded
// out (thesis 4.2.11; Schmidt 2013, section 5.4.2). The result needs no fade of its own.

layout(binding = 0) uniform sampler2D reflection_buffer; // of the method: rgb, and the fade in a
layout(binding = 1) uniform sampler2D fallback_buffer;   // of the fallback: rgb, and 1 in a, or 0s

layout(location = 0) out vec4 out_reflection;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 reflection = texelFetch(reflection_buffer, pixel, 0);
    vec4 behind = texelFetch(fallback_buffer, pixel, 0);
    // Where nothing reflects, both are 0. A colour that is faded out wholly counts for nothing, not
    // even if it is no number.
    vec3 local = reflection.a > 0.0 ? reflection.rgb * reflection.a : vec3(0.0);
    // A fallback may leave out what is not seen of it.
    float shows = reflection.a > 0.0 ? 1.0 : behind.a;
    out_reflection = vec4(local + behind.rgb * (1.0 - reflection.a), shows);
}
