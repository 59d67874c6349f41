#version 460
#pragma program(Fallback)
#pragma in_either_stage
// Shows the fallback behind a method's own reflection: the fallback is faded in where this reflection is faded out
// (thesis 4.2.11; Schmidt 2013, section 5.4.2). The result fades only where the fallback shows nothing.

#include "common/either_stage.glsl"

layout(binding = 0) uniform sampler2D reflection_buffer; // of the method: rgb, and the fade in alpha
layout(binding = 1) uniform sampler2D fallback_buffer;   // of the fallback: rgb, and 1 in a; all 0 where it shows nothing

OUTPUT(0, rgba16f, vec4, out_reflection);

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    vec4 reflection = texelFetch(reflection_buffer, pixel, 0);
    vec4 fallback = texelFetch(fallback_buffer, pixel, 0);
    // A colour with a fade of 0 does not count, even if it is NaN.
    vec3 premultiplied = reflection.a > 0.0 ? reflection.rgb * reflection.a : vec3(0.0);
    float fallback_share = (1.0 - reflection.a) * fallback.a;
    float covered = reflection.a + fallback_share;
    // Where nothing reflects, the fades of both reflections are 0.
    out_reflection = covered > 0.0 ? vec4((premultiplied + fallback.rgb * fallback_share) / covered, covered)
                                   : vec4(0.0);
}
